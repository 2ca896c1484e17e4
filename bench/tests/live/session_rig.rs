//! A session on the simulated apparatus, with its tasks polled by the test.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use analysis::amplitude_profile::AmplitudeProfile;
use config::Effective;
use contact::AssumedConstants;
use crossbeam_channel::{Receiver, Sender};
use devices::drive_control::{settings, waveform};
use devices::room::Room;
use devices::{Bench, Life};
use friction_bench::run::ProtocolFile;
use friction_bench::session::{Questions, SessionTask, Wiring};
use journal::{Entry, entry_queue};
use live::carrier_decision::CarrierDecision;
use live::live_side::LiveSide;
use live::participant_screen::ParticipantScreen;
use live::participant_skin::ParticipantSkin;
use live::readiness::Readiness;
use live::refit::Refit;
use mock_hw::apparatus::Apparatus;
use mock_world::scenario::Scenario;
use operator_ui::console::Front;
use protocols::{Session, TrialKey, TrialRecord};
use recording::manifest::EventKind;
use safety::{GpioError, OutputLine, Signals, input, output};
use sources::Lines;
use tasks::Task;
use tui::event::{LogLevel, PhaseKind};

use crate::rig::{CHANNELS, RATE_HZ, Tamper, apparatus, begin, config, events, open};

/// A heartbeat with a wire that can be cut.
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

/// The operator's events and actions.
struct Operator {
    events: Sender<tui::Event>,
    actions: Receiver<tui::Action>,
}

impl Front for Operator {
    fn show(&mut self, event: tui::Event) {
        let _ = self.events.send(event);
    }

    fn action(&mut self) -> Option<tui::Action> {
        self.actions.try_recv().ok()
    }
}

/// A session with an idle participant: each trial waits for the finger.
pub(crate) struct Rig {
    pub(crate) apparatus: Apparatus,
    pub(crate) tasks: Vec<Box<dyn Task>>,
    pub(crate) heartbeat_cut: Arc<AtomicBool>,
    pub(crate) ask: Sender<tui::Action>,
    pub(crate) events: Receiver<tui::Event>,
    pub(crate) phase: Option<PhaseKind>,
    pub(crate) warnings: Vec<String>,
    pub(crate) errors: Vec<String>,
    pub(crate) folders: Arc<Mutex<Vec<PathBuf>>>,
    pub(crate) signals: Arc<Signals>,
    pub(crate) tamper: Tamper,
    pub(crate) tampered: u64,
    /// Whether the session's task is not polled.
    pub(crate) session_hangs: bool,
    pub(crate) journal: Receiver<Entry>,
    _life: Life,
    _temp: tempfile::TempDir,
}

impl Rig {
    pub(crate) fn new(records: &[TrialRecord]) -> Self {
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
            first_tasks,
            last_tasks,
            ..
        } = bench;

        let temp = tempfile::tempdir().unwrap();
        let folders: Arc<Mutex<Vec<PathBuf>>> = Arc::default();
        let begin = {
            let (folder, folders) = (temp.path().to_owned(), folders.clone());
            Box::new(move |key: &TrialKey, _: &protocols::Drive, _: &Effective| {
                let path = folder.join(format!("{}-{}", key.number, key.attempt));
                folders.lock().unwrap().push(path.clone());
                Ok(begin(&path, RATE_HZ, CHANNELS))
            })
        };
        let admit = {
            let (config, settings) = (config.clone(), settings(&config).unwrap());
            Box::new(move |drive: &protocols::Drive, _: &Effective| {
                Ok(settings.admit(waveform(drive, &config))?)
            })
        };
        let (ask, actions) = crossbeam_channel::unbounded();
        let (show, events) = crossbeam_channel::unbounded();
        let (entries, journal) = entry_queue();
        let watched = signals.clone();
        let (refits, fits, refit) = Refit::new(
            AssumedConstants::ESTIMATION,
            AmplitudeProfile::default(),
            ParticipantSkin::default(),
        );
        let protocol = ProtocolFile::read("demo").unwrap().protocol;
        let wiring = Wiring {
            begin,
            admit,
            batches,
            recording,
            notices,
            gauge,
            room: Room::default(),
            session_bytes: 1_000_000_000,
            drive,
            screen: ParticipantScreen::new(&protocol, config.plate.length_m, button.is_none()),
            readiness: Readiness::new(button),
            front: Box::new(Operator {
                events: show,
                actions,
            }),
            watchers: Vec::new(),
            displays: participant_displays::Displays::default(),
            sound: None,
            journal: entries,
            live: LiveSide::new(0.1, config.plate.modal_mass_kg, (refits, fits)),
            carrier: CarrierDecision::new(
                &protocol,
                &Effective::uncalibrated(config.clone()),
                Box::new(|_| Ok(())),
                true,
            ),
            carrier_hz: Arc::default(),
            signals,
            gauges,
            stop: life.stop().clone(),
            report: crossbeam_channel::unbounded().0,
        };
        let machine = Session::resume(protocol, "sub-01".parse().unwrap(), 1, records).unwrap();
        let session = SessionTask::new(
            machine,
            Arc::new(Effective::uncalibrated(config)),
            wiring,
            Some("A. Tester".to_owned()),
            Questions::default(),
            false,
        );
        let mut tasks = first_tasks;
        tasks.push(Box::new(session));
        tasks.push(Box::new(refit));
        tasks.extend(last_tasks);
        let mut rig = Self {
            apparatus,
            tasks,
            heartbeat_cut,
            ask,
            events,
            phase: None,
            warnings: Vec::new(),
            errors: Vec::new(),
            folders,
            signals: watched,
            tamper: Tamper::Nothing,
            tampered: 0,
            session_hangs: false,
            journal: journal.entries,
            _life: life,
            _temp: temp,
        };
        rig.run_until(PhaseKind::Idle);
        rig.ask(tui::Action::Start);
        rig.run_until(PhaseKind::Baseline);
        rig
    }

    pub(crate) fn ask(&self, action: tui::Action) {
        self.ask.send(action).unwrap();
    }

    pub(crate) fn tick(&mut self) {
        self.apparatus.step().unwrap();
        let now_ns = self.apparatus.now_ns();
        for task in &mut self.tasks {
            if !self.session_hangs || task.name() != "session" {
                task.poll(now_ns).unwrap();
            }
        }
        self.tamper.apply(&self.signals, &mut self.tampered);
        for event in self.events.try_iter() {
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

    pub(crate) fn pass(&mut self, seconds: f64) {
        let until_ns = self.apparatus.now_ns() + (seconds * 1e9) as u64;
        while self.apparatus.now_ns() < until_ns {
            self.tick();
        }
    }

    pub(crate) fn run_until(&mut self, phase: PhaseKind) {
        let until_ns = self.apparatus.now_ns() + 3_000_000_000;
        while self.phase != Some(phase) {
            assert!(self.apparatus.now_ns() < until_ns, "{:?}", self.phase);
            self.tick();
        }
    }

    /// Returns the kinds and texts of the events of each recording, in order.
    pub(crate) fn recorded_events(&mut self) -> Vec<Vec<(EventKind, u64, String)>> {
        self.pass(0.05);
        let folders = self.folders.lock().unwrap();
        folders
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
