use super::observation::PATIENCE_S;
use super::*;
use crate::is_sign;
use safety::{SafetyState, Trip};
use tui::Action;
use tui::action::AttemptName;
use tui::drill_view::DrillStep;

/// A bench and its clock, for exercises with the fault after 1 s of driving and a `silence_s` of 0.05 s.
struct Bench {
    exercise: Exercise,
    now_s: f64,
    safety: SafetyState,
    sounds: bool,
    flag: Option<String>,
    orders: Vec<Order>,
}

impl Bench {
    fn new(fault: FaultKind, is_manual: bool) -> Self {
        let mut bench = Self {
            exercise: Exercise::new(fault, is_manual, 1.0, 0.05),
            now_s: 100.0,
            safety: SafetyState::Disarmed,
            sounds: false,
            flag: None,
            orders: Vec::new(),
        };
        bench.pass(0.01);
        assert_eq!(bench.take_orders(), [Order::Drive]);
        (bench.safety, bench.sounds) = (SafetyState::Armed, true);
        bench.pass(1.1);
        bench
    }

    fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds / 0.001).round() as usize {
            self.now_s += 0.001;
            let sight = Sight {
                now_s: self.now_s,
                safety: &self.safety,
                sounds: self.sounds,
                flag: self.flag.as_deref(),
            };
            self.orders.extend(self.exercise.poll(sight));
        }
    }

    fn act(&mut self, action: Action) {
        self.orders.extend(self.exercise.act(action, self.now_s));
    }

    fn take_orders(&mut self) -> Vec<Order> {
        std::mem::take(&mut self.orders)
    }

    fn trip(&mut self, trip: Trip) {
        self.safety = SafetyState::Tripped { trip };
    }

    fn miss_reason(&self) -> &str {
        match self.exercise.outcome() {
            Some(ExerciseOutcome::Missed(reason)) => reason,
            outcome => panic!("{outcome:?}"),
        }
    }

    /// A pressed e-stop, detected after 2 ms, silent after another 3 ms, acknowledged 1 s later.
    fn stopped() -> Self {
        let mut bench = Self::new(FaultKind::Estop, false);
        assert_eq!(bench.take_orders(), [Order::Begin]);
        bench.pass(0.002 - 0.1 + 0.1);
        bench.trip(Trip::EmergencyStop);
        bench.pass(0.003);
        bench.sounds = false;
        bench.pass(1.0);
        bench
    }
}

fn is_near(time_s: Option<f64>, expected_s: f64) -> bool {
    // The fault comes up to 0.1 s before `Bench::new` returns.
    time_s.is_some_and(|time_s| (time_s - expected_s).abs() < 0.11)
}

#[test]
fn a_stop_is_acknowledged_re_armed_and_resumed() {
    let mut bench = Bench::stopped();
    assert_eq!(bench.exercise.current_step(), DrillStep::Acknowledge);
    bench.act(Action::Ready);
    assert_eq!(bench.take_orders(), [Order::End]);
    assert_eq!(bench.exercise.current_step(), DrillStep::Rearm);
    bench.act(Action::Rearm);
    assert_eq!(bench.take_orders(), [Order::Rearm]);
    bench.safety = SafetyState::Disarmed;
    bench.pass(0.01);
    assert_eq!(bench.exercise.current_step(), DrillStep::Resume);
    bench.act(Action::Resume);
    assert_eq!(bench.take_orders(), [Order::Drive]);
    (bench.safety, bench.sounds) = (SafetyState::Armed, true);
    bench.pass(0.4);
    let times = bench.exercise.times();
    assert!(
        is_near(times.silent_s, 0.005) && is_near(times.seen_s, 1.0),
        "{times:?}"
    );
    assert!(
        times.shown_s < times.silent_s && times.seen_s < times.rearmed_s,
        "{times:?}"
    );
    assert!(times.rearmed_s < times.done_s, "{times:?}");
}

#[test]
fn re_arming_before_acknowledging_removes_the_cause_and_is_asked_for_again() {
    let mut bench = Bench::stopped();
    bench.act(Action::Rearm);
    assert_eq!(bench.take_orders(), [Order::End]);
    assert!(bench.exercise.note().is_some());
    assert_eq!(bench.exercise.current_step(), DrillStep::Rearm);
    bench.act(Action::Rearm);
    assert_eq!(bench.take_orders(), [Order::Rearm]);
    // Without effect: the e-stop is held.
    bench.pass(1.0);
    assert_eq!(bench.exercise.current_step(), DrillStep::Rearm);
    assert_eq!(bench.exercise.note(), Some("The cause is still there."));
}

#[test]
fn a_drive_that_resumes_and_stops_again_is_to_be_re_armed_again() {
    let mut bench = Bench::stopped();
    bench.act(Action::Ready);
    bench.act(Action::Rearm);
    bench.safety = SafetyState::Disarmed;
    bench.pass(0.01);
    bench.act(Action::Resume);
    (bench.safety, bench.sounds) = (SafetyState::Armed, true);
    bench.pass(0.1);
    bench.trip(Trip::EmergencyStop);
    bench.pass(0.01);
    assert_eq!(bench.exercise.current_step(), DrillStep::Rearm);
    assert!(bench.exercise.outcome().is_none());
}

#[test]
fn a_late_silence_is_missed_regardless_of_the_operator() {
    let mut bench = Bench::new(FaultKind::AmplifierOff, false);
    bench.pass(0.02);
    bench.trip(typical_trip(FaultKind::AmplifierOff));
    bench.pass(0.2);
    bench.sounds = false;
    bench.pass(0.1);
    for action in [Action::Ready, Action::Rearm] {
        bench.act(action);
    }
    bench.safety = SafetyState::Disarmed;
    bench.pass(0.01);
    bench.act(Action::Resume);
    (bench.safety, bench.sounds) = (SafetyState::Armed, true);
    bench.pass(0.5);
    assert!(
        bench.miss_reason().contains("silent only after"),
        "{}",
        bench.miss_reason()
    );
}

#[test]
fn a_bench_that_does_not_stop_and_one_that_flags_nothing_are_missed() {
    let mut bench = Bench::new(FaultKind::Estop, false);
    bench.pass(2.5);
    assert_eq!(bench.miss_reason(), "the bench did not stop");
    let mut bench = Bench::new(FaultKind::Xrun, false);
    bench.pass(2.5);
    assert_eq!(bench.miss_reason(), "the bench flagged nothing");
    let mut bench = Bench::new(FaultKind::Xrun, false);
    bench.trip(Trip::AudioSilent);
    bench.pass(0.01);
    assert!(bench.miss_reason().contains("should have gone on"));
    let mut bench = Bench::new(FaultKind::Estop, false);
    bench.exercise.stage = Stage::Settling {
        sounding_s: None,
        paused: false,
    };
    bench.trip(Trip::AudioSilent);
    bench.pass(0.01);
    assert!(bench.miss_reason().contains("before the fault"));
}

#[test]
fn a_flag_is_answered_by_repeating_at_once_or_after_a_word() {
    for first in [None, Some(Action::Ready)] {
        let mut bench = Bench::new(FaultKind::Xrun, false);
        bench.flag = Some("input xruns: 1".to_owned());
        bench.pass(0.5);
        for action in first
            .into_iter()
            .chain([Action::Redo(AttemptName::default())])
        {
            bench.act(action);
        }
        assert_eq!(bench.exercise.outcome(), Some(&ExerciseOutcome::Met));
        assert_eq!(bench.exercise.sign(), "input xruns: 1");
        assert!(bench.exercise.times().silent_s.is_none(), "it goes on");
    }
}

#[test]
fn a_stop_after_a_flag_is_missed_regardless_of_the_operator() {
    for trip in [Trip::AudioSilent, Trip::Operator] {
        for is_acknowledged in [false, true] {
            let mut bench = Bench::new(FaultKind::Xrun, false);
            bench.flag = Some("input xruns: 1".to_owned());
            bench.pass(0.5);
            if is_acknowledged {
                bench.act(Action::Ready);
                bench.pass(0.5);
            }
            bench.trip(trip.clone());
            bench.sounds = false;
            bench.pass(0.01);
            bench.act(Action::Redo(AttemptName::default()));
            assert!(
                bench.miss_reason().contains("should have gone on"),
                "{}",
                bench.miss_reason()
            );
        }
    }
}

#[test]
fn a_fault_without_re_arming_ends_also_after_the_bench_has_ended() {
    let mut bench = Bench::new(FaultKind::CardLostOutput, false);
    bench.trip(Trip::AudioLost);
    // The card renders no samples, and so never reports silence.
    bench.pass(0.05);
    assert!(bench.exercise.times().silent_s.is_some());
    bench.exercise.bench_ended("nothing for 10 s");
    bench.act(Action::Ready);
    assert_eq!(bench.exercise.current_step(), DrillStep::Quit);
    bench.act(Action::Rearm);
    assert!(bench.exercise.outcome().is_none());
    bench.act(Action::Quit);
    // The first 0.1 s passed before the trip.
    assert!(bench.exercise.times().done_s.is_some());

    let mut bench = Bench::stopped();
    bench.exercise.bench_ended("the disk is gone");
    assert!(bench.miss_reason().contains("the disk is gone"));
}

#[test]
fn manual_time_counts_from_when_the_bench_saw_it() {
    let mut bench = Bench::new(FaultKind::Estop, true);
    assert_eq!(bench.take_orders(), [], "nobody injects it");
    assert_eq!(bench.exercise.current_step(), DrillStep::Act);
    assert_eq!(bench.exercise.instruction(), "Press the e-stop now.");
    bench.pass(20.0);
    bench.trip(Trip::EmergencyStop);
    bench.pass(0.003);
    bench.sounds = false;
    bench.pass(1.0);
    bench.act(Action::Rearm);
    assert_eq!(
        bench.take_orders(),
        [Order::Rearm],
        "the operator has released it"
    );
    bench.safety = SafetyState::Disarmed;
    bench.pass(0.01);
    bench.act(Action::Resume);
    (bench.safety, bench.sounds) = (SafetyState::Armed, true);
    bench.pass(0.5);
    assert_eq!(bench.exercise.outcome(), Some(&ExerciseOutcome::Met));
    let times = bench.exercise.times();
    assert!(
        times.silent_s.is_some_and(|silent_s| silent_s < 0.01),
        "{times:?}"
    );

    let mut bench = Bench::new(FaultKind::Estop, true);
    bench.pass(PATIENCE_S + 1.0);
    assert!(bench.miss_reason().contains("nothing was done"));
}

#[test]
fn keys_at_the_wrong_moment_change_nothing() {
    let all = [
        Action::Start,
        Action::Consent,
        Action::Ready,
        Action::Redo(AttemptName::default()),
        Action::Abort,
        Action::Answer(tui::calibration_page::Reply::Ready),
    ];
    let mut bench = Bench::new(FaultKind::Estop, true);
    for action in all
        .into_iter()
        .chain([Action::Rearm, Action::Resume, Action::Pause])
    {
        bench.act(action);
    }
    assert_eq!(
        (bench.take_orders(), bench.exercise.current_step()),
        (vec![], DrillStep::Act)
    );
    let mut bench = Bench::stopped();
    bench.act(Action::Ready);
    bench.take_orders();
    for action in all
        .into_iter()
        .chain([Action::Resume, Action::Pause, Action::Quit])
    {
        bench.act(action);
    }
    assert_eq!(
        (bench.take_orders(), bench.exercise.current_step()),
        (vec![], DrillStep::Rearm)
    );
    assert!(bench.exercise.outcome().is_none());
}

#[test]
fn an_operator_may_pause_or_stop_before_the_fault_and_it_waits() {
    let mut bench = Bench::new(FaultKind::Estop, false);
    bench.exercise.stage = Stage::Settling {
        sounding_s: None,
        paused: false,
    };
    bench.take_orders();
    bench.act(Action::EmergencyStop);
    assert_eq!(bench.take_orders(), [Order::Stop]);
    assert!(bench.exercise.is_paused(), "p resumes");
    bench.trip(Trip::Operator);
    bench.sounds = false;
    bench.pass(3.0);
    assert_eq!(bench.take_orders(), []);
    bench.act(Action::Rearm);
    bench.act(Action::Resume);
    assert_eq!(bench.take_orders(), [Order::Rearm, Order::Drive]);
    assert!(!bench.exercise.is_paused());
    (bench.safety, bench.sounds) = (SafetyState::Armed, true);
    bench.pass(1.1);
    assert_eq!(bench.take_orders(), [Order::Begin]);
}

#[test]
fn an_operator_who_does_nothing_misses() {
    let mut bench = Bench::stopped();
    bench.pass(PATIENCE_S + 1.0);
    assert_eq!(bench.miss_reason(), "nobody acknowledged it");
    let mut bench = Bench::stopped();
    bench.act(Action::Ready);
    bench.pass(PATIENCE_S + 1.0);
    assert_eq!(
        bench.miss_reason(),
        "the right action was not taken in time"
    );
}

/// Returns a trip caused by the fault.
fn typical_trip(fault: FaultKind) -> Trip {
    let readback = Trip::Readback {
        measured_v: 0.0,
        commanded_v: (1.0, 2.0),
    };
    let gpio = Trip::Gpio {
        message: "gone".to_owned(),
    };
    let force = Trip::ForceLimit {
        normal_n: 3.1,
        limit_n: 3.0,
    };
    let trips = [
        Trip::EmergencyStop,
        Trip::AudioLost,
        Trip::ForceSilent,
        readback,
        gpio,
        force,
    ];
    let trip = trips.into_iter().find(|trip| is_sign(fault, trip));
    trip.unwrap_or_else(|| panic!("no trip tells of {fault}"))
}

#[test]
fn a_bench_that_stops_for_another_reason_has_not_seen_the_fault() {
    for (fault, trip) in [
        (FaultKind::ForceSilent, Trip::EmergencyStop),
        (FaultKind::Estop, Trip::AudioSilent),
    ] {
        for is_manual in [false, true] {
            let mut bench = Bench::new(fault, is_manual);
            bench.trip(trip.clone());
            bench.pass(0.1);
            assert!(
                bench.miss_reason().contains("another reason"),
                "{}",
                bench.miss_reason()
            );
        }
    }
}

#[test]
fn every_drilled_fault_has_words_for_each_step() {
    for &fault in FaultKind::ALL.iter().filter(|fault| fault.is_drilled()) {
        let mut bench = Bench::new(fault, false);
        bench.flag = Some("flag".to_owned());
        if fault.row().required != Required::Flag {
            bench.trip(typical_trip(fault));
        }
        bench.pass(0.1);
        assert_eq!(
            bench.exercise.current_step(),
            DrillStep::Acknowledge,
            "{fault}"
        );
        bench.act(Action::Ready);
        assert!(
            bench.exercise.instruction().contains(fault.row().words),
            "{fault}"
        );
    }
}

#[test]
fn a_drive_that_is_ramping_down_for_a_pause_gets_no_fault() {
    let mut bench = Bench::new(FaultKind::Estop, false);
    bench.exercise.stage = Stage::Settling {
        sounding_s: Some(bench.now_s - 0.98),
        paused: false,
    };
    bench.take_orders();
    bench.act(Action::Pause);
    bench.pass(0.05);
    assert_eq!(bench.take_orders(), [Order::Pause]);
}
