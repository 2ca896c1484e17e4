//! `monitor`: the dashboard without a protocol.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, bail};
use protocols::ParticipantId;
use signalgen::{Program, Waveform};
use tui::event::{LogLevel, PhaseKind, PhaseView};

use config::Effective;
use devices::drive_control::settings;
use devices::driving_time;
use devices::{Bench, Boot, require_armable, require_watched};
use operator_ui::console::{Dashboard, DashboardThread, Front, Headless, LineQueue, StopKeys};

use crate::apparatus::{BenchHardware, pace};
use crate::calibrate;
use crate::dates;
use drill::rehearsed;
use live::interference::Interference;
use live::monitor_task::{HoldPrompt, MODULATION_HZ, MonitorPorts, MonitorSettings, MonitorTask};

/// Index of the published modulation (Huloux 2021, section IV).
const MODULATION_INDEX: f64 = 0.95;

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
    let prompt = HoldPrompt::new(apparatus.watchers, config.plate.length_m);
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
    let ports = MonitorPorts {
        batches: bench.batches,
        drive: bench.drive,
        front,
        signals: bench.signals,
        gauges: bench.gauges,
        stop,
        ended,
    };
    let settings = MonitorSettings {
        program,
        duration_s,
        headless,
        rate_hz: config.audio.rate_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        needs_hold: config.safety.dead_man.is_some(),
        // A headless monitor reports the free plate, and `--clear-plate` promises one.
        has_visitor: !headless && !clear_plate,
    };
    let task = MonitorTask::new(settings, ports, prompt);
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
