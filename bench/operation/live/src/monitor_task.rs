//! The task that watches a bench for the operator, outside a session.

use std::sync::Arc;
use std::time::Duration;

use contact::plate_tracker::PlateTracking;
use crossbeam_channel::{Receiver, Sender};
use devices::DeviceReadings;
use devices::drive_control::DriveControl;
use devices::loudspeaker::Tone;
use operator_ui::console::{Front, safety_event};
use protocols::Instruction;
use recording::pipeline::{Account, Batch};
use safety::{Hold, SafetyState, Signals, Trip};
use signalgen::Program;
use tasks::{StopFlag, Task};
use tui::ScreenView;
use tui::event::{LogLevel, PhaseKind, PhaseView};

use crate::live_contact::LiveContact;
use crate::live_meter::LiveMeter;
use crate::screen_words;
use crate::visit::visit;

/// Frequency of the published modulation, Hz (Huloux 2021, section IV).
pub const MODULATION_HZ: f64 = 6.0;
/// Normal force that counts as a finger on the plate, N, as in the built-in protocols.
const CONTACT_N: f64 = 0.1;
/// Period of screen updates, ns.
const SCREEN_PERIOD_NS: u64 = 16_000_000;
/// Time between two traces of the last period, ns.
const PERIOD_EVERY_NS: u64 = 250_000_000;

/// Observer of the participant's view, button and tones: a simulated person.
pub type Watcher = Box<dyn FnMut(&ScreenView, bool, Option<Tone>) + Send>;

/// Asks the person at the dead-man switch for the action that the next drive needs.
pub struct HoldPrompt {
    watchers: Vec<Watcher>,
    plate_m: f64,
    /// The last request.
    last_request: Option<Hold>,
}

impl HoldPrompt {
    /// Creates a prompt that the `watchers` see on a plate of this length.
    #[must_use]
    pub fn new(watchers: Vec<Watcher>, plate_m: f64) -> Self {
        Self {
            watchers,
            plate_m,
            last_request: None,
        }
    }

    /// Shows the watchers a slider that comes and goes; returns its position, m.
    fn visit(&mut self, now_s: f64) -> Option<f64> {
        if self.watchers.is_empty() {
            return None;
        }
        let view = visit(now_s, self.plate_m);
        for watcher in &mut self.watchers {
            watcher(&view, false, None);
        }
        view.slider_m
    }

    /// Shows the watchers the instruction; returns the operator's message, or `None` if `hold` was already requested.
    fn ask(&mut self, hold: Option<Hold>) -> Option<&'static str> {
        if self.last_request == hold {
            return None;
        }
        self.last_request = hold;
        let (instruction, text) = match hold {
            Some(Hold::Release) => (
                Instruction::ReleaseSwitch,
                "release the dead-man switch, then hold it",
            ),
            _ => (
                Instruction::HoldSwitch,
                "press the dead-man switch and hold it",
            ),
        };
        let view = ScreenView {
            instruction,
            plate_m: self.plate_m,
            end_m: self.plate_m,
            ..ScreenView::default()
        };
        for watcher in &mut self.watchers {
            watcher(&view, false, None);
        }
        Some(text)
    }
}

/// Connections of the monitor to the bench and to its screen.
pub struct MonitorPorts {
    /// Samples.
    pub batches: Receiver<Batch>,
    /// The drive.
    pub drive: DriveControl,
    /// The operator's screen, or lines of text.
    pub front: Box<dyn Front>,
    /// Signals of the safety watch.
    pub signals: Arc<Signals>,
    /// Readings of the devices.
    pub gauges: Arc<DeviceReadings>,
    /// Ends the bench.
    pub stop: StopFlag,
    /// Receives false if the safety watch ended the monitoring, and true otherwise.
    pub ended: Sender<bool>,
}

/// Settings of the monitor.
#[derive(Debug, Clone)]
pub struct MonitorSettings {
    /// The drive; `None` to watch only.
    pub program: Option<Program>,
    /// Duration, s of audio; `None` until the operator ends it.
    pub duration_s: Option<f64>,
    /// Prints lines instead of a dashboard.
    pub headless: bool,
    /// Sample rate, Hz.
    pub rate_hz: u32,
    /// Modal mass of the plate, kg.
    pub modal_mass_kg: f64,
    /// Whether a dead-man switch must be held.
    pub needs_hold: bool,
    /// Whether a simulated finger comes and goes.
    pub has_visitor: bool,
}

/// The task that watches a bench.
pub struct MonitorTask {
    ports: MonitorPorts,
    settings: MonitorSettings,
    meter: LiveMeter,
    /// Tracks the free plate's resonance.
    contact: LiveContact,
    account: Account,
    audio_s: f64,
    line_due_s: f64,
    screen_due_ns: u64,
    period_due_ns: u64,
    safety: SafetyState,
    driven: bool,
    /// Whether the drive begins as soon as the switch is held.
    starts_on_hold: bool,
    prompt: HoldPrompt,
}

impl MonitorTask {
    /// Creates the task.
    #[must_use]
    pub fn new(settings: MonitorSettings, ports: MonitorPorts, prompt: HoldPrompt) -> Self {
        Self {
            contact: LiveContact::new(
                CONTACT_N,
                PlateTracking::new(settings.modal_mass_kg, MODULATION_HZ),
            ),
            ports,
            settings,
            meter: LiveMeter::default(),
            account: Account::default(),
            audio_s: 0.0,
            line_due_s: 1.0,
            screen_due_ns: 0,
            period_due_ns: 0,
            safety: SafetyState::default(),
            driven: false,
            starts_on_hold: false,
            prompt,
        }
    }

    /// Shows a kind of phase; without a drive, only the monitoring phase.
    fn show_phase(&mut self, kind: PhaseKind) {
        if self.settings.program.is_some() || kind == PhaseKind::Monitoring {
            let phase = PhaseView::new(kind);
            self.ports.front.show(tui::Event::Phase(phase));
        }
    }

    fn request_drive(&mut self) {
        self.starts_on_hold = self.settings.program.is_some();
        self.prompt.last_request = None;
    }

    /// Begins the wanted drive once the dead-man switch is held.
    fn drive_once_held(&mut self) {
        let (true, Some(program)) = (self.starts_on_hold, self.settings.program) else {
            return;
        };
        let hold = self.ports.signals.hold.get();
        if !self.settings.needs_hold || hold == Some(Hold::Held) {
            self.starts_on_hold = false;
            self.ports.drive.start(program);
        } else if let Some(text) = self.prompt.ask(hold) {
            self.ports.front.show(tui::Event::Log {
                level: LogLevel::Info,
                text: text.to_owned(),
            });
        }
    }

    fn show_safety(&mut self) {
        let left = self
            .ports
            .signals
            .dose
            .get()
            .filter(|_| self.settings.program.is_some());
        let event = safety_event(&self.safety, self.ports.drive.sounds(), left.as_ref());
        self.ports.front.show(event);
    }

    fn take_actions(&mut self) {
        while let Some(action) = self.ports.front.action() {
            match action {
                tui::Action::Start | tui::Action::Ready | tui::Action::Resume => {
                    self.request_drive();
                    self.show_phase(PhaseKind::Monitoring);
                }
                tui::Action::Pause | tui::Action::PauseNow(_) | tui::Action::Abort => {
                    self.starts_on_hold = false;
                    self.ports.drive.disarm();
                    self.show_phase(PhaseKind::Paused);
                }
                tui::Action::EmergencyStop => {
                    self.starts_on_hold = false;
                    self.ports.drive.trip(Trip::Operator);
                }
                tui::Action::Rearm => self.rearm(),
                tui::Action::Quit | tui::Action::Interrupt => self.ports.stop.raise(),
                tui::Action::Redo(_)
                | tui::Action::AcceptAnyway(_)
                | tui::Action::Seek { .. }
                | tui::Action::Consent
                | tui::Action::TakeCarrier
                | tui::Action::KeepCarrier
                | tui::Action::Answer(_) => {}
            }
        }
    }

    /// Re-arms, or shows what prevents it.
    fn rearm(&mut self) {
        self.ports.drive.rearm();
        if let Some(obstacle) = self.ports.drive.rearm_obstacle() {
            let text = obstacle.to_string();
            self.ports.front.show(tui::Event::Log {
                level: LogLevel::Warning,
                text: text.clone(),
            });
            self.ports.front.show(tui::Event::Answer(text));
        } else if self.settings.program.is_none() {
            self.show_phase(PhaseKind::Monitoring);
        }
    }

    /// Takes the state of the safety watch; a stop interrupts the drive until the operator re-arms and resumes.
    fn watch_safety(&mut self) {
        let safety = self.ports.signals.state.get().unwrap_or_default();
        if safety != self.safety {
            self.safety = safety;
            if let SafetyState::Tripped { trip } = &self.safety {
                self.starts_on_hold = false;
                self.ports.front.show(tui::Event::Log {
                    level: LogLevel::Error,
                    text: format!("drive stopped: {trip}"),
                });
                self.ports.front.show(tui::Event::Phase(PhaseView {
                    stopped: true,
                    ..PhaseView::new(PhaseKind::Paused)
                }));
            }
            self.show_safety();
        }
    }

    /// Prints one line a second without a dashboard.
    fn line(&mut self) {
        if !self.settings.headless || self.audio_s < self.line_due_s {
            return;
        }
        self.line_due_s += 1.0;
        let Some(live) = self.meter.live(None) else {
            return;
        };
        let impedance = |z: Option<tui::event::ComplexImpedance>| {
            z.map_or_else(
                || "masked".to_owned(),
                |z| format!("{:.3} {:+.3}i", z.re_n_s_per_m, z.im_n_s_per_m),
            )
        };
        let number = |value: Option<f64>, scale: f64, decimals: usize, unit: &str| {
            value.map_or_else(
                || "–".to_owned(),
                |value| format!("{:.decimals$} {unit}", value * scale),
            )
        };
        let text = format!(
            "{:8.3} s  Z_m {} N·s/m (plain {})  amplitude {}  drive {}  normal {}  drift {}  lost {}",
            live.t_s,
            impedance(live.z_m_n_s_per_m),
            impedance(live.z_plain_n_s_per_m),
            number(live.amplitude_m, 1e6, 3, "µm"),
            number(live.drive_v, 1.0, 1, "V"),
            number(live.normal_n, 1.0, 3, "N"),
            screen_words::drift(self.contact.drift_hz()),
            self.account.lost_frames,
        );
        self.ports.front.show(tui::Event::Log {
            level: LogLevel::Info,
            text,
        });
    }
}

impl Task for MonitorTask {
    fn name(&self) -> &'static str {
        "monitor"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        self.watch_safety();
        self.ports.drive.poll(&self.safety);
        for batch in self.ports.batches.try_iter() {
            self.audio_s = batch.audio_s;
            self.account = batch.account;
            self.meter.take(&batch);
            self.contact.take(&batch, |_| {});
            for text in batch.warnings {
                self.ports.front.show(tui::Event::Log {
                    level: LogLevel::Warning,
                    text,
                });
            }
        }
        if !self.driven && self.audio_s > 0.0 {
            self.driven = true;
            self.request_drive();
        }
        self.take_actions();
        self.drive_once_held();
        self.line();
        if now_ns >= self.screen_due_ns {
            self.screen_due_ns = now_ns + SCREEN_PERIOD_NS;
            let slider_m = self
                .settings
                .has_visitor
                .then(|| self.prompt.visit(self.audio_s))
                .flatten();
            if let Some(live) = self.meter.live(slider_m) {
                let live = screen_words::with_contact(live, &self.contact);
                self.ports.front.show(tui::Event::Live(live));
            }
            if self.screen_due_ns >= self.period_due_ns {
                self.period_due_ns = self.screen_due_ns + PERIOD_EVERY_NS;
                if let Some(period) = self.meter.period() {
                    self.ports.front.show(tui::Event::Period(period));
                }
            }
        }
        let (account, gauges) = (&self.account, &self.ports.gauges);
        let health = self
            .meter
            .health
            .read(now_ns, account, gauges, self.settings.rate_hz);
        if let Some(health) = health {
            self.ports.front.show(tui::Event::Health(health));
            self.show_safety();
        }
        let is_over = self
            .settings
            .duration_s
            .is_some_and(|duration_s| self.audio_s >= duration_s);
        let tripped = self.settings.headless && matches!(self.safety, SafetyState::Tripped { .. });
        // The lines are the only output of a headless bench.
        if is_over || tripped || self.ports.front.is_unread() {
            self.ports.stop.raise();
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.ports.drive.stop();
        self.ports.front.show(tui::Event::Close);
        let _ = self
            .ports
            .ended
            .send(!matches!(self.safety, SafetyState::Tripped { .. }));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn each_step_at_the_switch_is_requested_once() {
        let requests = Arc::new(Mutex::new(Vec::new()));
        let watcher = {
            let requests = Arc::clone(&requests);
            Box::new(move |view: &ScreenView, _, _| {
                requests.lock().unwrap().push(view.instruction);
            })
        };
        let mut prompt = HoldPrompt::new(vec![watcher], 0.1);
        assert_eq!(prompt.ask(None), None);
        for hold in [Hold::Release, Hold::Release, Hold::Press, Hold::Press] {
            let _ = prompt.ask(Some(hold));
        }
        let expected = [Instruction::ReleaseSwitch, Instruction::HoldSwitch];
        assert_eq!(*requests.lock().unwrap(), expected);
    }

    /// Front end that records the events shown and returns the actions given.
    #[derive(Clone, Default)]
    struct Screen {
        shown: Arc<Mutex<Vec<tui::Event>>>,
        actions: Arc<Mutex<Vec<tui::Action>>>,
    }

    impl Front for Screen {
        fn show(&mut self, event: tui::Event) {
            self.shown.lock().unwrap().push(event);
        }

        fn action(&mut self) -> Option<tui::Action> {
            self.actions.lock().unwrap().pop()
        }
    }

    /// Returns a monitor without samples, its screen and its watch's signals.
    fn monitor() -> (MonitorTask, Screen, Arc<Signals>) {
        let config = config::Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        let generator =
            signalgen::Generator::new(devices::drive_control::settings(&config).unwrap());
        let health = signalgen::StreamHealth::new();
        let (_, handle) = signalgen::DriveRenderer::connect(generator, 1, 0, health).unwrap();
        let (screen, signals) = (Screen::default(), Arc::new(Signals::default()));
        let ports = MonitorPorts {
            batches: crossbeam_channel::unbounded().1,
            drive: DriveControl::new(handle, tasks::Mailbox::default(), Arc::clone(&signals)),
            front: Box::new(screen.clone()),
            signals: Arc::clone(&signals),
            gauges: Arc::default(),
            stop: StopFlag::default(),
            ended: crossbeam_channel::unbounded().0,
        };
        let settings = MonitorSettings {
            program: None,
            duration_s: None,
            headless: false,
            rate_hz: 192_000,
            modal_mass_kg: 0.01,
            needs_hold: false,
            has_visitor: false,
        };
        let prompt = HoldPrompt::new(Vec::new(), 0.1);
        (MonitorTask::new(settings, ports, prompt), screen, signals)
    }

    #[test]
    fn a_stopped_monitor_is_paused_and_a_lost_device_is_not_re_armed() {
        let (mut monitor, screen, signals) = monitor();
        signals.state.set(SafetyState::Tripped {
            trip: Trip::ForceSilent,
        });
        monitor.poll(1_000_000).unwrap();
        let shown = std::mem::take(&mut *screen.shown.lock().unwrap());
        let is_stopped = |event: &tui::Event| {
            let tui::Event::Phase(phase) = event else {
                return false;
            };
            phase.kind == PhaseKind::Paused && phase.stopped
        };
        assert!(shown.iter().any(is_stopped), "{shown:?}");
        let stop = "drive stopped: the force sensor is silent";
        let is_logged =
            |event: &tui::Event| matches!(event, tui::Event::Log { text, .. } if text == stop);
        assert!(shown.iter().any(is_logged), "{shown:?}");

        signals.losses.report(safety::LostDevice::ForceSensor);
        screen.actions.lock().unwrap().push(tui::Action::Rearm);
        monitor.poll(2_000_000).unwrap();
        let shown = screen.shown.lock().unwrap();
        let is_refused = |event: &tui::Event| matches!(event, tui::Event::Answer(text) if text.contains("q, y ends it"));
        assert!(shown.iter().any(is_refused), "{shown:?}");
    }
}
