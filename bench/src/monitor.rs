//! `monitor`: the dashboard without a protocol.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail};
use contact::plate_tracker::PlateTracking;
use crossbeam_channel::{Receiver, Sender};
use protocols::Instruction;
use protocols::ParticipantId;
use signalgen::{Program, Waveform};
use tui::ScreenView;
use tui::event::{LogLevel, PhaseKind, PhaseView};

use config::Effective;
use devices::drive_control::{DriveControl, settings};
use devices::driving_time;
use devices::{Bench, Boot, DeviceReadings, require_armable, require_watched};
use live::live_contact::LiveContact;
use operator_ui::console::{
    Dashboard, DashboardThread, Front, Headless, LineQueue, StopKeys, safety_event,
};
use recording::pipeline::{Account, Batch};
use safety::{Hold, SafetyState, Signals, Trip};
use tasks::{StopFlag, Task};

use crate::apparatus::{BenchHardware, Watcher, pace};
use crate::calibrate;
use crate::dates;
use drill::rehearsed;
use live::interference::Interference;
use live::live_meter::LiveMeter;
use live::screen_words;
use live::visit::visit;

/// The published modulation (Huloux 2021, section IV).
const MODULATION_HZ: f64 = 6.0;
const MODULATION_INDEX: f64 = 0.95;
/// Normal force that counts as a finger on the plate, N, as in the built-in protocols.
const CONTACT_N: f64 = 0.1;
/// Period of screen updates, ns.
const SCREEN_PERIOD_NS: u64 = 16_000_000;
/// Time between two traces of the last period, ns.
const PERIOD_EVERY_NS: u64 = 250_000_000;

/// Options of the monitor, checked.
pub struct MonitorPlan {
    /// The bench.
    pub bench: Effective,
    /// Safety-relevant measurements that are missing or outdated, a line each.
    unverified: Vec<String>,
    program: Option<Program>,
    duration_s: Option<f64>,
    headless: bool,
    /// Folder of the participant at the plate; `None` if no participant is named.
    participant: Option<PathBuf>,
    /// Whether the plate is clear of fingers.
    clear_plate: bool,
    /// Path of the calibration; the accounts of the driving time and the plate's warmth lie next to it.
    calibration: PathBuf,
    /// Injected faults, in the form of `--fault`.
    pub rehearsed: Vec<String>,
}

impl MonitorPlan {
    /// Checks the options.
    ///
    /// # Errors
    /// When the requested drive is not admitted.
    pub fn new(bench: Effective, options: &crate::cli::Monitor) -> anyhow::Result<Self> {
        let config = bench.config();
        let settings = settings(config)?;
        let program = options
            .drive_v
            .map(|mean_amplitude_v| -> anyhow::Result<Program> {
                require_armable(config, pace(config, &options.hardware))?;
                let waveform = Waveform::Modulated {
                    carrier_hz: config.plate.resonance_hz,
                    mean_amplitude_v,
                    modulation_hz: MODULATION_HZ,
                    modulation_index: MODULATION_INDEX,
                    start_phase_rad: 0.0,
                };
                let pace = pace(config, &options.hardware);
                require_watched(&bench, &waveform, pace, dates::now())?;
                Ok(settings.admit(waveform)?)
            })
            .transpose()
            .context("--drive-v")?;
        Ok(Self {
            unverified: dates::unverified(&bench, pace(bench.config(), &options.hardware)),
            bench,
            program,
            duration_s: options.duration_s,
            headless: options.headless,
            participant: participant_folder(options)?,
            clear_plate: options.clear_plate,
            calibration: calibrate::path(&options.hardware),
            rehearsed: Vec::new(),
        })
    }

    /// Returns whether the plate will be driven, which requires the bench to pass the preflight.
    #[must_use]
    pub fn drives(&self) -> bool {
        self.program.is_some()
    }
}

/// Returns the folder of the named participant.
fn participant_folder(options: &crate::cli::Monitor) -> anyhow::Result<Option<PathBuf>> {
    let Some((participant, study)) = options.participant.as_ref().zip(options.study.as_ref())
    else {
        return Ok(None);
    };
    let participant: ParticipantId = participant.parse()?;
    let folder = study.join(participant.as_str());
    if !folder.is_dir() {
        bail!(
            "{} does not exist: {participant} has no session yet; without --participant the time counts for everyone \
             within the hour",
            folder.display()
        );
    }
    Ok(Some(folder))
}

/// Watches until the operator or the duration ends it; returns false if the safety watch ended it.
///
/// # Errors
/// When a part of the bench is missing or fails.
pub fn run(
    plan: MonitorPlan,
    apparatus: BenchHardware,
    out: impl Write + Send + 'static,
) -> anyhow::Result<bool> {
    let MonitorPlan {
        bench: effective,
        unverified,
        program,
        duration_s,
        headless,
        participant,
        clear_plate,
        calibration,
        rehearsed,
    } = plan;
    let config = effective.config();
    let (simulated, pace) = (apparatus.hardware.simulated, apparatus.hardware.pace);
    let facts = operator_ui::bench_page::facts(config, effective.file(), &apparatus.hardware);
    let prompt = HoldPrompt {
        watchers: apparatus.watchers,
        plate_m: config.plate.length_m,
        last_request: None,
    };
    let ledger = match program {
        Some(_) => {
            let hardware = &apparatus.hardware;
            let ledger = if clear_plate {
                driving_time::clear_plate_account(&calibration, config, hardware)?
            } else {
                let folder = participant.as_deref();
                driving_time::of_monitor(folder, &calibration, config, hardware)?
            };
            let need_s = ledger.dose.need_s();
            let left = driving_time::require_left(&ledger, need_s, hardware.clock.as_ref())?;
            Some((ledger, left))
        }
        None => None,
    };
    let mut bench = Bench::open(&effective, config.plate.resonance_hz, apparatus.hardware)?;
    bench.require_calibration_holds(&effective)?;
    let stop = bench.stop().clone();
    let (mut front, dashboard): (Box<dyn Front>, Option<DashboardThread>) = if headless {
        (Box::new(Headless::new(LineQueue::start(out)?)), None)
    } else {
        let keys = StopKeys::new(bench.life.drive_stop().clone()).with_end(stop.clone());
        let (dashboard, thread) = Dashboard::open(stop.clone(), keys)?;
        (Box::new(dashboard), Some(thread))
    };
    front.show(tui::Event::Session(tui::event::SessionHeader {
        calibration_label: effective
            .calibration()
            .map(|calibration| calibration.label().to_owned()),
        uncalibrated: effective.calibration().is_none(),
        simulated,
        plate_length_m: config.plate.length_m,
        ..tui::event::SessionHeader::default()
    }));
    front.show(tui::Event::Phase(PhaseView::new(PhaseKind::Monitoring)));
    front.show(tui::Event::Bench(facts));
    let notices = config.safety_notices(config.plate.resonance_hz, pace);
    let rehearsed = rehearsed::notice(&rehearsed).into_iter();
    let forceless = config.forceless_in_words();
    for text in rehearsed.chain(notices).chain(forceless).chain(unverified) {
        front.show(tui::Event::Log {
            level: LogLevel::Warning,
            text,
        });
    }
    if let Some((ledger, left)) = ledger {
        bench.charge(ledger, Boot::now())?;
        for text in config.safety.dead_man_in_words().into_iter().chain([left]) {
            front.show(tui::Event::Log {
                level: LogLevel::Info,
                text,
            });
        }
    }
    if program.is_none() {
        front.show(tui::Event::Log {
            level: LogLevel::Info,
            text: "watching without a preflight, for nothing is driven: --drive-v drives a bench that passes it"
                .to_owned(),
        });
    }
    let (ended, outcome) = crossbeam_channel::bounded(1);
    let task = MonitorTask {
        batches: bench.batches,
        drive: bench.drive,
        front,
        signals: bench.signals,
        gauges: bench.gauges,
        stop: stop.clone(),
        program,
        duration_s,
        headless,
        rate_hz: config.audio.rate_hz,
        meter: LiveMeter::default(),
        contact: LiveContact::new(
            CONTACT_N,
            PlateTracking::new(config.plate.modal_mass_kg, MODULATION_HZ),
        ),
        account: Account::default(),
        audio_s: 0.0,
        line_due_s: 1.0,
        screen_due_ns: 0,
        period_due_ns: 0,
        safety: SafetyState::default(),
        driven: false,
        needs_hold: config.safety.dead_man.is_some(),
        starts_on_hold: false,
        prompt,
        // A headless monitor reports the free plate, and `--clear-plate` promises one.
        has_visitor: !headless && !clear_plate,
        ended,
    };
    let interference = Interference::new(bench.recording, config, config.plate.resonance_hz);
    let mut tasks = bench.first_tasks;
    tasks.push(Box::new(task));
    tasks.push(Box::new(interference));
    tasks.extend(bench.last_tasks);
    bench
        .life
        .run(tasks, || dashboard.map_or(Ok(()), DashboardThread::join))?;
    Ok(outcome.try_recv().unwrap_or(false))
}

/// Asks the person at the dead-man switch for the action that the next drive needs.
struct HoldPrompt {
    watchers: Vec<Watcher>,
    plate_m: f64,
    /// The last request.
    last_request: Option<Hold>,
}

impl HoldPrompt {
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

struct MonitorTask {
    batches: Receiver<Batch>,
    drive: DriveControl,
    front: Box<dyn Front>,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    stop: StopFlag,
    program: Option<Program>,
    duration_s: Option<f64>,
    headless: bool,
    rate_hz: u32,
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
    /// Whether a dead-man switch must be held.
    needs_hold: bool,
    /// Whether the drive begins as soon as the switch is held.
    starts_on_hold: bool,
    prompt: HoldPrompt,
    /// Whether a simulated finger comes and goes.
    has_visitor: bool,
    ended: Sender<bool>,
}

impl MonitorTask {
    /// Shows a kind of phase; without a drive, only the monitoring phase.
    fn show_phase(&mut self, kind: PhaseKind) {
        self.show(PhaseView::new(kind));
    }

    /// Shows a phase in full.
    fn show(&mut self, phase: PhaseView) {
        if self.program.is_some() || phase.kind == PhaseKind::Monitoring {
            self.front.show(tui::Event::Phase(phase));
        }
    }

    fn request_drive(&mut self) {
        self.starts_on_hold = self.program.is_some();
        self.prompt.last_request = None;
    }

    /// Begins the wanted drive once the dead-man switch is held.
    fn drive_once_held(&mut self) {
        let (true, Some(program)) = (self.starts_on_hold, self.program) else {
            return;
        };
        let hold = self.signals.hold.get();
        if !self.needs_hold || hold == Some(Hold::Held) {
            self.starts_on_hold = false;
            self.drive.start(program);
        } else if let Some(text) = self.prompt.ask(hold) {
            self.front.show(tui::Event::Log {
                level: LogLevel::Info,
                text: text.to_owned(),
            });
        }
    }

    fn show_safety(&mut self) {
        let left = self.signals.dose.get().filter(|_| self.program.is_some());
        let event = safety_event(&self.safety, self.drive.sounds(), left.as_ref());
        self.front.show(event);
    }

    fn take_actions(&mut self) {
        while let Some(action) = self.front.action() {
            match action {
                tui::Action::Start | tui::Action::Ready | tui::Action::Resume => {
                    self.request_drive();
                    self.show_phase(PhaseKind::Monitoring);
                }
                tui::Action::Pause | tui::Action::PauseNow(_) | tui::Action::Abort => {
                    self.starts_on_hold = false;
                    self.drive.disarm();
                    self.show_phase(PhaseKind::Paused);
                }
                tui::Action::EmergencyStop => {
                    self.starts_on_hold = false;
                    self.drive.trip(Trip::Operator);
                }
                tui::Action::Rearm => {
                    self.drive.rearm();
                    self.show(PhaseView {
                        stopped: true,
                        ..PhaseView::new(PhaseKind::Paused)
                    });
                }
                tui::Action::Quit | tui::Action::Interrupt => self.stop.raise(),
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

    /// Prints one line a second without a dashboard.
    fn line(&mut self) {
        if !self.headless || self.audio_s < self.line_due_s {
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
        self.front.show(tui::Event::Log {
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
        let safety = self.signals.state.get().unwrap_or_default();
        if safety != self.safety {
            self.safety = safety;
            self.starts_on_hold &= !matches!(self.safety, SafetyState::Tripped { .. });
            self.show_safety();
        }
        self.drive.poll(&self.safety);
        for batch in self.batches.try_iter() {
            self.audio_s = batch.audio_s;
            self.account = batch.account;
            self.meter.take(&batch);
            self.contact.take(&batch, |_| {});
            for text in batch.warnings {
                self.front.show(tui::Event::Log {
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
                .has_visitor
                .then(|| self.prompt.visit(self.audio_s))
                .flatten();
            if let Some(live) = self.meter.live(slider_m) {
                let live = screen_words::with_contact(live, &self.contact);
                self.front.show(tui::Event::Live(live));
            }
            if self.screen_due_ns >= self.period_due_ns {
                self.period_due_ns = self.screen_due_ns + PERIOD_EVERY_NS;
                if let Some(period) = self.meter.period() {
                    self.front.show(tui::Event::Period(period));
                }
            }
        }
        let (account, gauges) = (&self.account, &self.gauges);
        let health = self
            .meter
            .health
            .read(now_ns, account, gauges, self.rate_hz);
        if let Some(health) = health {
            self.front.show(tui::Event::Health(health));
            self.show_safety();
        }
        let is_over = self
            .duration_s
            .is_some_and(|duration_s| self.audio_s >= duration_s);
        let tripped = self.headless && matches!(self.safety, SafetyState::Tripped { .. });
        // The lines are the only output of a headless bench.
        if is_over || tripped || self.front.is_unread() {
            self.stop.raise();
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        self.front.show(tui::Event::Close);
        let _ = self
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
        let mut prompt = HoldPrompt {
            watchers: vec![watcher],
            plate_m: 0.1,
            last_request: None,
        };
        assert_eq!(prompt.ask(None), None);
        for hold in [Hold::Release, Hold::Release, Hold::Press, Hold::Press] {
            let _ = prompt.ask(Some(hold));
        }
        let expected = [Instruction::ReleaseSwitch, Instruction::HoldSwitch];
        assert_eq!(*requests.lock().unwrap(), expected);
    }
}
