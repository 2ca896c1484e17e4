//! A session marks stops, pauses and repetitions in the recordings that they end and begin, and tells its operator of flags
//! (FAULTS.md, rows 16, 17, 22 and 35).

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use config::Effective;
use console::Front;
use contact::AssumedConstants;
use crossbeam_channel::{Receiver, Sender};
use devices::drive_control::{settings, waveform};
use devices::{Bench, Life, Lines};
use friction_bench::readiness::Readiness;
use friction_bench::refit::Refit;
use friction_bench::run::ProtocolFile;
use friction_bench::session::{SessionTask, Wiring};
use mock_hw::apparatus::Apparatus;
use mock_hw::serial::ForceFault;
use mock_world::plant::Axis;
use mock_world::scenario::Scenario;
use protocols::{Session, TrialKey, TrialOutcome, TrialRecord};
use recording::manifest::EventKind;
use safety::{GpioError, OutputLine, input, output};
use tasks::Task;
use tui::event::{LogLevel, PhaseKind};

use crate::rig::{RATE_HZ, apparatus, begin, config, events, open};

/// A heartbeat whose wire can be cut.
struct Cuttable {
    line: Box<dyn OutputLine>,
    cut: Arc<AtomicBool>,
}

impl OutputLine for Cuttable {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        if self.cut.load(Ordering::Relaxed) {
            return Ok(());
        }
        self.line.set(high)
    }
}

/// What the operator sees and asks for.
struct Operator {
    seen: Sender<tui::Event>,
    asked: Receiver<tui::Action>,
}

impl Front for Operator {
    fn show(&mut self, event: tui::Event) {
        let _ = self.seen.send(event);
    }

    fn action(&mut self) -> Option<tui::Action> {
        self.asked.try_recv().ok()
    }
}

/// A session with a participant who does nothing: each trial waits for the finger.
struct Rig {
    apparatus: Apparatus,
    tasks: Vec<Box<dyn Task>>,
    heartbeat_cut: Arc<AtomicBool>,
    ask: Sender<tui::Action>,
    seen: Receiver<tui::Event>,
    phase: Option<PhaseKind>,
    warnings: Vec<String>,
    errors: Vec<String>,
    begun: Arc<Mutex<Vec<PathBuf>>>,
    _life: Life,
    _temp: tempfile::TempDir,
}

impl Rig {
    fn new(records: &[TrialRecord]) -> Self {
        let config = config(&[]);
        let mut apparatus = apparatus(Scenario::default());
        let pins = apparatus.pins().unwrap();
        let heartbeat_cut = Arc::new(AtomicBool::new(false));
        let heartbeat = Cuttable {
            line: output("heartbeat", pins.heartbeat),
            cut: heartbeat_cut.clone(),
        };
        let lines = Lines {
            estop: Some(input("e-stop", pins.estop)),
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(Box::new(heartbeat)),
            ..Lines::default()
        };
        let bench = open(&apparatus, config.clone(), lines);
        let Bench {
            life,
            drive,
            batches,
            recording,
            notices,
            gauge,
            button,
            signals,
            gauges,
            before,
            after,
            ..
        } = bench;

        let temp = tempfile::tempdir().unwrap();
        let begun: Arc<Mutex<Vec<PathBuf>>> = Arc::default();
        let begin = {
            let (folder, begun) = (temp.path().to_owned(), begun.clone());
            Box::new(move |key: &TrialKey, _: &protocols::Drive| {
                let path = folder.join(format!("{}-{}", key.number, key.attempt));
                begun.lock().unwrap().push(path.clone());
                Ok(begin(&path, RATE_HZ))
            })
        };
        let admit = {
            let (config, settings) = (config.clone(), settings(&config).unwrap());
            Box::new(move |drive: &protocols::Drive| Ok(settings.admit(waveform(drive, &config))?))
        };
        let (ask, asked) = crossbeam_channel::unbounded();
        let (show, seen) = crossbeam_channel::unbounded();
        let (refits, fits, refit) = Refit::new(35_000.0, AssumedConstants::ESTIMATION);
        let wiring = Wiring {
            batches,
            recording,
            notices,
            gauge,
            study_folder: temp.path().to_owned(),
            drive,
            readiness: Readiness::new(button),
            front: Box::new(Operator { seen: show, asked }),
            watchers: Vec::new(),
            sound: None,
            journal: crossbeam_channel::unbounded().0,
            refits,
            fits,
            signals,
            gauges,
            stop: life.stop().clone(),
        };
        let protocol = ProtocolFile::read("demo").unwrap().protocol;
        let machine = Session::resume(protocol, "sub-01".parse().unwrap(), 1, records).unwrap();
        let session = SessionTask::new(
            machine,
            Arc::new(Effective::uncalibrated(config)),
            admit,
            begin,
            wiring,
            Some("A. Tester".to_owned()),
            false,
            crossbeam_channel::unbounded().0,
        );
        let mut tasks = before;
        tasks.push(Box::new(session));
        tasks.push(Box::new(refit));
        tasks.extend(after);
        let mut rig = Self {
            apparatus,
            tasks,
            heartbeat_cut,
            ask,
            seen,
            phase: None,
            warnings: Vec::new(),
            errors: Vec::new(),
            begun,
            _life: life,
            _temp: temp,
        };
        rig.until(PhaseKind::Idle);
        rig.ask(tui::Action::Start);
        rig.until(PhaseKind::Baseline);
        rig
    }

    fn ask(&self, action: tui::Action) {
        self.ask.send(action).unwrap();
    }

    fn tick(&mut self) {
        self.apparatus.step().unwrap();
        let now_ns = self.apparatus.now_ns();
        for task in &mut self.tasks {
            task.poll(now_ns).unwrap();
        }
        for event in self.seen.try_iter() {
            match event {
                tui::Event::Phase(phase) => self.phase = Some(phase.kind),
                tui::Event::Log { level, text } => match level {
                    LogLevel::Info => {}
                    LogLevel::Warning => self.warnings.push(text),
                    LogLevel::Error => self.errors.push(text),
                },
                _ => {}
            }
        }
    }

    fn pass(&mut self, seconds: f64) {
        let until_ns = self.apparatus.now_ns() + (seconds * 1e9) as u64;
        while self.apparatus.now_ns() < until_ns {
            self.tick();
        }
    }

    fn until(&mut self, phase: PhaseKind) {
        let until_ns = self.apparatus.now_ns() + 3_000_000_000;
        while self.phase != Some(phase) {
            assert!(self.apparatus.now_ns() < until_ns, "{:?}", self.phase);
            self.tick();
        }
    }

    /// Kinds and texts of the events of each recording, in order.
    fn told(&mut self) -> Vec<Vec<(EventKind, u64, String)>> {
        self.pass(0.05);
        let begun = self.begun.lock().unwrap();
        begun
            .iter()
            .map(|folder| {
                let events = events(folder).into_iter();
                events
                    .map(|(kind, sample, _, text)| (kind, sample, text))
                    .collect()
            })
            .collect()
    }
}

/// Fault 35.
#[test]
fn pause_resume_and_redo_are_marked_where_they_fall() {
    let mut rig = Rig::new(&[]);
    rig.pass(0.3);
    rig.ask(tui::Action::Pause);
    rig.until(PhaseKind::Paused);
    rig.pass(0.1);
    rig.ask(tui::Action::Resume);
    rig.until(PhaseKind::Baseline);
    rig.pass(0.3);
    rig.ask(tui::Action::Redo);
    rig.pass(0.3);
    rig.ask(tui::Action::Abort);
    let told = rig.told();
    let [first, second, third] = &told[..] else {
        panic!("{told:?}");
    };
    let begins = |kind, text: &str| (kind, 0, text.to_owned());
    // 0.3 s at 192 kHz, and the milliseconds of the tasks between.
    let ends = |events: &[(EventKind, u64, String)], kind: EventKind| {
        let last = events.last().unwrap();
        assert_eq!(last.0, kind, "{events:?}");
        assert!((57_000..60_000).contains(&last.1), "{events:?}");
    };
    assert_eq!(first.len(), 1, "{first:?}");
    ends(first, EventKind::Pause);
    assert_eq!(
        second[..2],
        [
            begins(EventKind::Resume, "after a pause"),
            begins(EventKind::Redo, "attempt 2")
        ]
    );
    ends(second, EventKind::Redo);
    assert_eq!(third[0], begins(EventKind::Redo, "attempt 3"));
    ends(third, EventKind::Abort);
    assert_eq!((second.len(), third.len()), (3, 2));
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
    let kinds: Vec<_> = rig.told()[0].iter().map(|event| event.0).collect();
    assert_eq!(kinds, [EventKind::ForceLost, EventKind::Abort]);
    assert_eq!(rig.warnings.len(), 1);
}

/// Fault 35.
#[test]
fn a_session_that_goes_on_after_the_programs_end_says_so() {
    let lost = TrialRecord {
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
    let mut rig = Rig::new(&[lost]);
    rig.pass(0.1);
    rig.ask(tui::Action::Abort);
    let told = rig.told();
    let kinds: Vec<_> = told[0]
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
    assert_eq!(told[0][0].2, "after the program's end");
}

/// Puts 4 N on an axis of the force sensor, or takes them away.
fn weigh(rig: &Rig, axis: Axis, on: bool) {
    let masses = rig.apparatus.masses();
    if on {
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
        (|rig, on| rig.apparatus.faults().press_estop(on), "e-stop"),
        (
            |rig, on| rig.heartbeat_cut.store(on, Ordering::Relaxed),
            "reads back",
        ),
        (|rig, on| weigh(rig, Axis::Normal, on), "normal force"),
        (|rig, on| weigh(rig, Axis::Lateral, on), "lateral force"),
    ];
    for (fault, words) in faults {
        rig.pass(0.4);
        fault(&rig, true);
        rig.until(PhaseKind::Paused);
        let said = rig.errors.last().unwrap();
        assert!(said.contains(words), "{said}");
        fault(&rig, false);
        rig.pass(0.5);
        rig.ask(tui::Action::Rearm);
        rig.pass(0.1);
        rig.ask(tui::Action::Resume);
        rig.until(PhaseKind::Baseline);
    }
    rig.ask(tui::Action::Abort);
    for recording in rig.told() {
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
