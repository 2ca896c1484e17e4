//! A drill in lock step: performed by a program on simulated hardware, and by an operator who is asked to act.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use config::{Config, Effective};
use devices::Hardware;
use drill::{Course, Deed, DrillFolder, DrillRecord, Scripted, WatchedHardware};
use faults::FaultKind;
use jiff::Timestamp;
use mock_hw::apparatus::{Apparatus, ApparatusClock, ApparatusConfig, RehearsalHand};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use operator_ui::console::Front;
use safety::{DriveStop, input, output};
use sources::{Lines, Place};
use tasks::{Clock, Schedule, StopFlag};
use tui::drill_view::{DrillStep, DrillView};
use tui::{Action, Event};

struct HostClock(ApparatusClock);

impl Clock for HostClock {
    fn now_ns(&self) -> u64 {
        self.0.now_ns()
    }

    fn utc(&self) -> Timestamp {
        "2026-05-04T12:00:00Z".parse().unwrap()
    }
}

fn config() -> Config {
    let text = config::rigs::MOCK_BENCH
        .replace("silence_s = 0.25", "silence_s = 0.05")
        .replace(
            "backend = \"none\"",
            "backend = \"rppal\"\nestop = 13\nheartbeat = 21",
        );
    Config::parse(&text, "mock-bench.toml").unwrap()
}

/// Returns the hardware of a new apparatus, and the hand that injects faults into it.
fn hardware() -> (Hardware, RehearsalHand) {
    let config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::Stepped);
    let mut apparatus = Apparatus::new(config).unwrap();
    let pins = apparatus.pins().unwrap();
    let hand = apparatus.rehearsal();
    let hardware = Hardware {
        cues: None,
        host: apparatus.host(),
        lines: Lines {
            counter: None,
            encoder: Some([input("A", pins.encoder_a), input("B", pins.encoder_b)]),
            estop: Some(input("e-stop", pins.estop)),
            button: Some(input("button", pins.button)),
            dead_man: None,
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(output("heartbeat", pins.heartbeat)),
        },
        force_place: Some(Place::Port(apparatus.force_port().unwrap().to_owned())),
        field_box: None,
        clock: Arc::new(HostClock(apparatus.clock())),
        schedule: Schedule::Lockstep(Box::new(move || Ok(apparatus.step()?))),
        guard: Box::new(()),
        simulated: true,
        pace: safety::Pace::Simulated,
        keeps_accounts: false,
    };
    (hardware, hand)
}

fn course(faults: &[FaultKind], simulated: bool) -> anyhow::Result<Course> {
    let bench = Effective::uncalibrated(config());
    let pace = safety::Pace::Simulated;
    Course::new(
        bench,
        faults,
        simulated,
        pace,
        Some(7),
        "A. Tester",
        simulated,
    )
}

fn run(
    course: &Course,
    parent: &Path,
    front: Box<dyn Front>,
    open: impl FnMut() -> anyhow::Result<WatchedHardware>,
) -> (DrillRecord, DrillFolder) {
    course
        .run(
            parent,
            front,
            (&StopFlag::default(), &DriveStop::default()),
            open,
        )
        .unwrap()
}

fn open_bench() -> anyhow::Result<WatchedHardware> {
    let (hardware, hand) = hardware();
    Ok(WatchedHardware {
        hardware,
        hand: Some(Box::new(move |deed| match deed {
            Deed::Begin(fault) => hand.begin(fault, None),
            Deed::End(fault) => hand.end(fault),
        })),
    })
}

fn read_record(folder: &DrillFolder) -> DrillRecord {
    toml::from_str(&std::fs::read_to_string(folder.file()).unwrap()).unwrap()
}

/// Faults 6, 17, 21.
/// Hazard 16.
#[test]
fn a_drill_of_a_stop_a_flag_and_a_loss_is_met_and_kept() {
    let temp = tempfile::tempdir().unwrap();
    let faults = [FaultKind::Estop, FaultKind::Xrun, FaultKind::ForceUnplugged];
    let course = course(&faults, true).unwrap();
    let drill = || {
        run(
            &course,
            temp.path(),
            Box::new(Scripted::new(std::io::sink())),
            open_bench,
        )
    };
    let (record, folder) = drill();
    assert!(record.passed, "{:?}", record.lines());
    assert_eq!(read_record(&folder), record);
    assert!(record.simulated && record.unattended);
    for exercise in &record.exercises {
        let times = exercise.times;
        let silent_in_time = times
            .silent_s
            .is_some_and(|silent_s| silent_s <= exercise.within_s);
        let stops = exercise.fault != FaultKind::Xrun;
        assert_eq!(silent_in_time, stops, "{exercise:?}");
        assert!(
            times.shown_s < times.seen_s && times.seen_s < times.done_s,
            "{exercise:?}"
        );
        let rearmed = exercise.fault == FaultKind::Estop;
        assert_eq!(times.rearmed_s.is_some(), rearmed, "{exercise:?}");
    }
    // The same seed draws the same drill, and the earlier record is kept.
    let (second_record, second_folder) = drill();
    assert_eq!(second_record, record);
    assert_ne!(second_folder.file(), folder.file());
}

/// A scripted operator, and the lines of the log.
struct LogFront(Scripted<std::io::Sink>, Arc<std::sync::Mutex<Vec<String>>>);

impl Front for LogFront {
    fn show(&mut self, event: Event) {
        if let Event::Log { text, .. } = &event {
            self.1.lock().unwrap().push(text.clone());
        }
        self.0.show(event);
    }

    fn action(&mut self) -> Option<Action> {
        self.0.action()
    }
}

#[test]
fn the_log_has_the_stop_and_the_result_of_each_exercise() {
    let temp = tempfile::tempdir().unwrap();
    let course = course(&[FaultKind::Estop, FaultKind::Xrun], true).unwrap();
    let log: Arc<std::sync::Mutex<Vec<String>>> = Arc::default();
    let front = LogFront(Scripted::new(std::io::sink()), Arc::clone(&log));
    let (record, _) = run(&course, temp.path(), Box::new(front), open_bench);
    assert!(record.passed, "{:?}", record.lines());
    let log = log.lock().unwrap();
    for part in [
        "drive stopped: e-stop pressed",
        "estop: met: ",
        "xrun: met: ",
    ] {
        let count = log.iter().filter(|line| line.starts_with(part)).count();
        assert_eq!(count, 1, "{part}: {log:?}");
    }
}

/// An operator who performs each request at the bench, or leaves at the first one.
struct OperatorFront {
    hand: Arc<std::sync::Mutex<Option<RehearsalHand>>>,
    view: DrillView,
    polls: u32,
    quits: bool,
    is_finished: bool,
    is_acting: Arc<AtomicBool>,
    parts: Arc<std::sync::Mutex<Vec<(String, String)>>>,
    healthy: bool,
}

impl Front for OperatorFront {
    fn show(&mut self, event: Event) {
        match event {
            Event::Drill(view) => {
                self.polls = 0;
                self.view = view;
            }
            Event::Bench(facts) => {
                let parts = facts.parts.into_iter();
                *self.parts.lock().unwrap() = parts.map(|part| (part.name, part.words)).collect();
            }
            Event::Health(health) => self.healthy |= health.frames > 0,
            Event::Finished { .. } => {
                assert!(self.healthy, "rates and losses are shown");
                self.is_finished = true;
            }
            _ => {}
        }
    }

    fn action(&mut self) -> Option<Action> {
        if self.is_finished {
            return Some(Action::Quit);
        }
        self.polls += 1;
        if self.polls != 100 {
            return None;
        }
        let hand = self.hand.lock().unwrap();
        let hand = hand.as_ref().unwrap();
        match self.view.asked {
            DrillStep::Act if self.quits => return Some(Action::Quit),
            DrillStep::Act => {
                self.is_acting.store(true, Ordering::Release);
                match self.view.instruction.as_str() {
                    "Press the e-stop now." => hand.begin(FaultKind::Estop, None),
                    "Switch the amplifier off now." => hand.begin(FaultKind::AmplifierOff, None),
                    instruction => panic!("{instruction}"),
                }
            }
            DrillStep::Acknowledge => return Some(Action::Ready),
            DrillStep::Rearm => {
                hand.end(FaultKind::Estop);
                hand.end(FaultKind::AmplifierOff);
                self.polls = 0;
                return Some(Action::Rearm);
            }
            DrillStep::Resume => return Some(Action::Resume),
            _ => {}
        }
        None
    }
}

fn drill_by_hand(faults: &[FaultKind], quits: bool) -> (DrillRecord, bool) {
    let temp = tempfile::tempdir().unwrap();
    let hand: Arc<std::sync::Mutex<Option<RehearsalHand>>> = Arc::default();
    let is_acting: Arc<AtomicBool> = Arc::default();
    let parts: Arc<std::sync::Mutex<Vec<(String, String)>>> = Arc::default();
    let front = OperatorFront {
        hand: hand.clone(),
        view: DrillView::default(),
        polls: 0,
        quits,
        is_finished: false,
        is_acting: is_acting.clone(),
        parts: parts.clone(),
        healthy: false,
    };
    let open = || {
        let (hardware, new_hand) = hardware();
        *hand.lock().unwrap() = Some(new_hand);
        Ok(WatchedHardware {
            hardware,
            hand: None,
        })
    };
    let course = course(faults, false).unwrap();
    let (record, folder) = run(&course, temp.path(), Box::new(front), open);
    assert_eq!(read_record(&folder), record);
    // The bench is shown as it is, although an exercise opens it without its button.
    for part in ["e-stop", "heartbeat", "button"] {
        let wired = (part.to_owned(), "wired".to_owned());
        assert!(parts.lock().unwrap().contains(&wired), "{part}");
    }
    (record, is_acting.load(Ordering::Acquire))
}

/// Faults 16, 17.
/// Hazards 16, 18.
#[test]
fn an_operator_is_asked_for_the_real_action_under_the_faint_tone() {
    let (record, is_acting) = drill_by_hand(&[FaultKind::Estop, FaultKind::AmplifierOff], false);
    assert!(record.passed && is_acting, "{:?}", record.lines());
    assert!(!record.simulated && !record.unattended);
    for exercise in &record.exercises {
        assert_eq!(
            exercise.times.shown_s,
            Some(0.0),
            "nobody knows when the hand moved"
        );
    }
}

#[test]
fn a_drill_that_is_left_is_not_passed() {
    let (record, is_acting) = drill_by_hand(&[FaultKind::Estop, FaultKind::AmplifierOff], true);
    assert!(!record.passed && !is_acting);
    assert_eq!(record.exercises.len(), 1);
    assert_eq!(record.exercises[0].missed.as_deref(), Some("left"));
    let lines = record.lines();
    assert!(lines.last().unwrap().contains("1 not tried"), "{lines:?}");
}

#[test]
fn a_simulated_bench_that_cannot_be_opened_again_ends_the_drill() {
    let temp = tempfile::tempdir().unwrap();
    let course = course(&[FaultKind::Estop, FaultKind::EstopCut], true).unwrap();
    let mut openings = 0;
    let open = || {
        openings += 1;
        anyhow::ensure!(openings < 2, "busy");
        open_bench()
    };
    let front = Box::new(Scripted::new(std::io::sink()));
    let result = course.run(
        temp.path(),
        front,
        (&StopFlag::default(), &DriveStop::default()),
        open,
    );
    assert!(result.is_err());
    let folder = std::fs::read_dir(temp.path())
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    let text = std::fs::read_to_string(folder.path().join("drill.toml")).unwrap();
    let record: DrillRecord = toml::from_str(&text).unwrap();
    assert_eq!((record.exercises.len(), record.passed), (1, false));
}
