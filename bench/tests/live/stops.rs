//! A session marks stops, pauses and repetitions in the recordings that they end and begin, and reports flags to its
//! operator (FAULTS.md, rows 16, 17, 22 and 35).

use std::sync::atomic::Ordering;

use journal::Entry;
use mock_hw::serial::ForceFault;
use mock_world::plant::LoadedAxis;
use protocols::{SessionEventKind, TrialKey, TrialOutcome, TrialRecord};
use recording::manifest::EventKind;
use safety::{SafetyState, Trip};
use tui::event::PhaseKind;

use crate::rig::Tamper;
use crate::session_rig::Rig;

/// Returns the name of an attempt at the first trial, which is practice.
fn attempt(attempt: u32) -> tui::action::AttemptName {
    tui::action::AttemptName {
        trial: 1,
        practice: true,
        attempt,
    }
}

/// Fault 35.
#[test]
fn pause_resume_and_redo_are_marked_where_they_fall() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.3);
    rig.ask(tui::Action::PauseNow(attempt(1)));
    rig.run_until(PhaseKind::Paused);
    rig.pass(0.1);
    rig.ask(tui::Action::Resume);
    rig.run_until(PhaseKind::Baseline);
    rig.pass(0.3);
    rig.ask(tui::Action::Redo(attempt(2)));
    rig.pass(0.3);
    rig.ask(tui::Action::Abort);
    let recordings = rig.recorded_events();
    let [first, second, third] = &recordings[..] else {
        panic!("{recordings:?}");
    };
    let start_event = |kind, text: &str| (kind, 0, text.to_owned());
    // 0.3 s at 192 kHz, plus some milliseconds for the tasks.
    let require_end = |events: &[(EventKind, u64, String)], kind: EventKind| {
        let last = events.last().unwrap();
        assert_eq!(last.0, kind, "{events:?}");
        assert!((57_000..60_000).contains(&last.1), "{events:?}");
    };
    assert_eq!(first.len(), 1, "{first:?}");
    require_end(first, EventKind::Pause);
    assert_eq!(
        second[..2],
        [
            start_event(EventKind::Resume, "after a pause"),
            start_event(EventKind::Redo, "attempt 2")
        ]
    );
    require_end(second, EventKind::Redo);
    assert_eq!(third[0], start_event(EventKind::Redo, "attempt 3"));
    require_end(third, EventKind::Abort);
    assert_eq!((second.len(), third.len()), (3, 2));
}

#[test]
fn a_key_that_cannot_rearm_under_a_pressed_e_stop_is_answered() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.1);
    rig.apparatus.faults().press_estop(true);
    rig.pass(0.2);
    let is_answer = |line: &String| line.contains("the e-stop is still pressed");
    assert!(!rig.warnings.iter().any(is_answer), "{:?}", rig.warnings);
    rig.ask(tui::Action::Rearm);
    rig.pass(0.1);
    assert!(rig.warnings.iter().any(is_answer), "{:?}", rig.warnings);
    rig.warnings.clear();
    rig.apparatus.faults().press_estop(false);
    rig.pass(0.2);
    rig.ask(tui::Action::Rearm);
    rig.pass(0.1);
    assert!(!rig.warnings.iter().any(is_answer), "{:?}", rig.warnings);
}

/// Fault 22.
#[test]
fn the_operator_is_told_of_a_flag_once() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.1);
    assert_eq!(rig.warnings, Vec::<String>::new());
    rig.apparatus.faults().force(ForceFault::Drop(3));
    rig.pass(0.8);
    let [line] = &rig.warnings[..] else {
        panic!("{:?}", rig.warnings);
    };
    assert!(line.starts_with("force frames lost: 3; from "), "{line}");
    rig.ask(tui::Action::Abort);
    let kinds: Vec<_> = rig.recorded_events()[0]
        .iter()
        .map(|event| event.0)
        .collect();
    assert_eq!(kinds, [EventKind::ForceLost, EventKind::Abort]);
    assert_eq!(rig.warnings.len(), 1);
}

/// Fault 27.
#[test]
fn a_stall_longer_than_the_queue_stops_the_drive_while_the_disk_still_hangs() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.2);
    let mut tasks = rig.tasks.iter();
    let index = tasks.position(|task| task.name() == "recorder").unwrap();
    let recorder_task = rig.tasks.remove(index);
    // The queue is sized for an encoder too, which this bench lacks, so it lasts longer.
    let mut waits = 0..90;
    while rig.phase != Some(PhaseKind::Paused) && waits.next().is_some() {
        rig.pass(0.5);
    }
    let overflowed = |line: &String| line.contains("queue has overflowed");
    assert!(overflowed(&rig.errors[0]), "{:?}", rig.errors);
    assert!(matches!(
        rig.signals.state.get(),
        Some(SafetyState::Tripped { .. })
    ));
    let not_saved = |entry: &Entry| match entry {
        Entry::Event(event) => match &event.kind {
            SessionEventKind::TrialSettled { record } => matches!(
                record.outcome,
                TrialOutcome::Interrupted {
                    interruption: protocols::Interruption::NotSaved { .. }
                }
            ),
            _ => false,
        },
        _ => false,
    };
    assert_eq!(rig.journal.try_iter().filter(not_saved).count(), 1);
    // The recorder's late report does not count as another fault.
    let errors = rig.errors.len();
    rig.tasks.insert(index, recorder_task);
    rig.pass(0.1);
    assert_eq!(rig.errors.len(), errors, "{:?}", rig.errors);
}

/// Fault 35.
#[test]
fn a_session_that_goes_on_after_the_programs_end_says_so() {
    let crashed = TrialRecord {
        key: TrialKey {
            number: 1,
            attempt: 1,
            practice: true,
            condition: "am-6hz-95".to_owned(),
        },
        outcome: TrialOutcome::Interrupted {
            interruption: protocols::Interruption::Crash,
        },
        analysis: None,
    };
    let mut rig = Rig::new(&[crashed]);
    rig.pass(0.1);
    rig.ask(tui::Action::Abort);
    let recordings = rig.recorded_events();
    let kinds: Vec<_> = recordings[0]
        .iter()
        .map(|event| (event.0, event.1 == 0))
        .collect();
    assert_eq!(
        kinds,
        [
            (EventKind::Resume, true),
            (EventKind::Redo, true),
            (EventKind::Abort, false)
        ]
    );
    assert_eq!(recordings[0][0].2, "after the program's end");
}

/// Puts 4 N on an axis of the force sensor, or removes them.
fn weigh(rig: &Rig, axis: LoadedAxis, is_on: bool) {
    let masses = rig.apparatus.masses();
    if is_on {
        masses.place(axis, 0.4);
    } else {
        masses.remove();
    }
}

/// Faults 16, 17, 23.
#[test]
fn a_stop_is_marked_by_its_reason() {
    let mut rig = Rig::new(&[]);
    let mut kinds = Vec::new();
    type Fault = fn(&Rig, bool);
    let faults: [(Fault, &str); 4] = [
        (
            |rig, is_on| rig.apparatus.faults().press_estop(is_on),
            "e-stop",
        ),
        (
            |rig, is_on| rig.heartbeat_cut.store(is_on, Ordering::Relaxed),
            "reads back",
        ),
        (
            |rig, is_on| weigh(rig, LoadedAxis::Normal, is_on),
            "normal force",
        ),
        (
            |rig, is_on| weigh(rig, LoadedAxis::Lateral, is_on),
            "lateral force",
        ),
    ];
    for (fault, words) in faults {
        rig.pass(0.4);
        fault(&rig, true);
        rig.run_until(PhaseKind::Paused);
        let error = rig.errors.last().unwrap();
        assert!(error.contains(words), "{error}");
        fault(&rig, false);
        rig.pass(0.5);
        rig.ask(tui::Action::Rearm);
        rig.pass(0.1);
        rig.ask(tui::Action::Resume);
        rig.run_until(PhaseKind::Baseline);
    }
    rig.ask(tui::Action::Abort);
    for recording in rig.recorded_events() {
        kinds.push(recording.iter().map(|event| event.0).collect::<Vec<_>>());
    }
    use EventKind::{Abort, EmergencyStop, ReadbackMismatch, Redo, Resume, Safe};
    assert_eq!(
        kinds,
        [
            vec![EmergencyStop, Abort],
            vec![Resume, Redo, ReadbackMismatch, Abort],
            vec![Resume, Redo, Safe, Abort],
            vec![Resume, Redo, Safe, Abort],
            vec![Resume, Redo, Abort],
        ]
    );
}

impl Rig {
    /// Returns the peak of the drive as read back now, V.
    fn volts(&self) -> f64 {
        self.signals
            .readback
            .get()
            .map_or(0.0, |reading| reading.volts)
    }

    /// Waits until the drive is at the crest of its modulation, which takes a period.
    fn run_until_crest(&mut self) {
        let mut most_v = 0.0f64;
        for _ in 0..2_000 {
            self.tick();
            most_v = most_v.max(self.volts());
        }
        let until_ns = self.apparatus.now_ns() + 1_000_000_000;
        while self.volts() < 0.97 * most_v {
            assert!(self.apparatus.now_ns() < until_ns, "{most_v} V");
            self.tick();
        }
    }

    /// Returns the time until an error is reported to the operator, s.
    fn alarm_delay_s(&mut self) -> f64 {
        let (fault_ns, errors) = (self.apparatus.now_ns(), self.errors.len());
        while self.errors.len() == errors {
            let waited_ns = self.apparatus.now_ns() - fault_ns;
            assert!(waited_ns < 1_000_000_000, "nobody was told");
            self.tick();
        }
        (self.apparatus.now_ns() - fault_ns) as f64 * 1e-9
    }

    /// Returns the reasons of the stops in the session's log so far.
    fn logged_stops(&self) -> Vec<String> {
        let entries = self.journal.try_iter();
        entries
            .filter_map(|entry| match entry {
                Entry::Event(event) => match event.kind {
                    SessionEventKind::SafetyTripped { reason } => Some(reason),
                    _ => None,
                },
                _ => None,
            })
            .collect()
    }
}

/// Fault 16.
/// Hazard 18.
#[test]
fn a_dead_amplifier_and_half_the_gain_stop_a_session_within_50_ms() {
    type Fault = (&'static str, fn(&mut Rig));
    let faults: [Fault; 2] = [
        ("dead amplifier", |rig| {
            rig.apparatus.faults().switch_off_amplifier(true);
        }),
        ("half the gain", |rig| rig.tamper = Tamper::Gain(0.5)),
    ];
    for (name, inject) in faults {
        let mut rig = Rig::new(&[]);
        rig.pass(0.4);
        rig.run_until_crest();
        assert_eq!(rig.errors, Vec::<String>::new(), "{name}");
        inject(&mut rig);
        let alarm_s = rig.alarm_delay_s();
        println!("{name}: stopped after {:.1} ms", 1e3 * alarm_s);
        assert!(alarm_s < 0.05, "{name}: {alarm_s} s");
        let state = rig.signals.state.get().unwrap();
        let readback = |trip: &Trip| matches!(trip, Trip::Readback { .. });
        assert!(
            matches!(&state, SafetyState::Tripped { trip } if readback(trip)),
            "{name}: {state:?}"
        );
        assert!(rig.errors[0].contains("reads back"), "{:?}", rig.errors);
        rig.tamper = Tamper::Nothing;
        rig.pass(0.06);
        assert!(rig.volts() < 0.1, "{name}: {} V", rig.volts());
        let kinds: Vec<_> = rig.recorded_events()[0]
            .iter()
            .map(|event| event.0)
            .collect();
        assert_eq!(
            kinds,
            [EventKind::ReadbackMismatch, EventKind::Abort],
            "{name}"
        );
    }
}

/// Fault 19.
/// Hazard 17.
#[test]
fn a_plate_that_is_alive_while_a_session_is_paused_is_an_alarm_with_what_to_do() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.3);
    rig.ask(tui::Action::PauseNow(attempt(1)));
    rig.run_until(PhaseKind::Paused);
    rig.pass(0.5);
    assert!(rig.logged_stops().is_empty() && rig.errors.is_empty());
    rig.tamper = Tamper::Alive(12.0);
    let alarm_s = rig.alarm_delay_s();
    assert!(alarm_s < 0.05, "{alarm_s} s");
    let alarm = rig.errors[0].clone();
    for word in [
        "12.0 V although nothing is played",
        "finger off the plate",
        "at the mains",
    ] {
        assert!(alarm.contains(word), "{alarm}");
    }
    assert!(alarm.ends_with(&rig.logged_stops()[0]), "{alarm}");
}

/// Fault 19.
/// Hazard 17.
#[test]
fn a_plate_that_is_alive_after_the_e_stop_is_an_alarm_of_its_own_and_cannot_be_rearmed() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.3);
    rig.apparatus.faults().press_estop(true);
    rig.run_until(PhaseKind::Paused);
    rig.tamper = Tamper::Alive(12.0);
    rig.pass(0.5);
    let [estop, alive] = &rig.logged_stops()[..] else {
        panic!("{:?}", rig.errors);
    };
    assert!(
        estop.contains("e-stop") && alive.contains("12.0 V although disarmed"),
        "{alive}"
    );
    assert!(rig.errors[1].ends_with(alive), "{:?}", rig.errors);
    // Between two trials, with the amplifier off.
    rig.apparatus.faults().press_estop(false);
    rig.ask(tui::Action::Rearm);
    rig.pass(0.2);
    let state = rig.signals.state.get().unwrap();
    let latched = |trip: &Trip| matches!(trip, Trip::AliveWhileDisarmed { .. });
    assert!(
        matches!(&state, SafetyState::Tripped { trip } if latched(trip)),
        "{state:?}"
    );
}

/// Fault 49.
#[test]
fn a_session_that_hung_for_long_says_what_it_did_not_see_and_stops() {
    let mut rig = Rig::new(&[]);
    rig.session_hangs = true;
    // Longer than the queue of batches lasts.
    rig.pass(8.5);
    rig.session_hangs = false;
    rig.pass(0.02);
    let error = rig
        .errors
        .iter()
        .find(|text| text.contains("did not reach"));
    assert!(error.is_some(), "{:?}", rig.errors);
    let state = rig.signals.state.get();
    assert!(
        matches!(state, Some(SafetyState::Tripped { .. })),
        "{state:?}"
    );
}
