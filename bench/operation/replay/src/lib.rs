//! `replay`: passes a recording through the live pipeline and the dashboard, at its own speed or as fast as possible. The
//! recording includes all the configuration that this needs.

mod explored;
mod film;
mod free_clock;
mod initial;
mod listing;
mod opening;
mod options;
mod pace;
mod past_crops;
mod report;
mod source;
mod unloaded;

use std::collections::VecDeque;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use contact::AssumedConstants;
use crossbeam_channel::{Receiver, Sender};
use protocols::selection::analyse_exploration;
use protocols::{Direction, SelectionRules, Stretch, TrialLabel};
use tui::event::{LogLevel, PhaseKind, PhaseView, SafetyView, SystemHealth};

use analysis::Settings;
use analysis::amplitude_profile::AmplitudeProfile;
use analysis::flaw::Flaw;
use analysis::force_zero::ForceZero;
use analysis::measurements::Measurements;
use analysis::recording_analysis::selection_rules;
use devices::DeviceReadings;
use live::attempt_name::attempt_name;
use live::exploration_crop::{ExplorationName, crop};
use live::fit_report::FitReport;
use live::live_contact::LiveContact;
use live::trial_fit::FitRequest;
use operator_ui::console::{Dashboard, Front, Headless, StopKeys};
use recording::manifest::{self, Manifest, RecordedInterval, RecordedIntervalKind, RecordedRoom};
use recording::pipeline::{Account, Batch};
use study::provenance::Provenance;
use study::sessions;
use tasks::{Clock, Schedule, StopFlag, SystemClock, Task};

use explored::Explored;
use free_clock::{FreeClock, Ticks};
use live::live_meter::LiveMeter;
use live::participant_skin::ParticipantSkin;
use live::refit::Refit;
use live::screen_words;
use pace::Pace;
use source::Source;
use unloaded::Unloaded;

pub use listing::list_recordings;
pub use options::{ReplayOptions, Speed};
pub use past_crops::past_crops;
pub use report::ReplayReport;

/// Period of screen updates, s of the recording.
const SCREEN_PERIOD_S: f64 = 0.016;
/// Data that the analysis filters need on either side of an interval, s; live data arrive in less.
const MARGIN_S: f64 = 0.1;
/// Length of one read while seeking, s of the recording; keys are polled between reads.
const SEEK_CHUNK_S: f64 = 0.1;

/// A recording opened for replay.
pub struct ReplayPlan {
    source: Source,
    folder: PathBuf,
    name: String,
    speed: Speed,
    headless: bool,
    rules: SelectionRules,
    protocol_flaw: Option<Flaw>,
    assumed: AssumedConstants,
    /// Whether the session's log says that the bench was simulated.
    simulated: bool,
}

impl ReplayPlan {
    /// Opens the recording.
    ///
    /// # Errors
    /// If a file is missing or violates the format, or the audio cannot be demodulated.
    pub fn new(options: &ReplayOptions) -> anyhow::Result<Self> {
        let folder: &Path = &options.recording;
        let source = Source::open(folder)?;
        let settings = Settings::default();
        let room = source.manifest().room;
        let measured_pa = room.map(RecordedRoom::ambient_pressure_pa);
        let real_folder = folder.canonicalize().ok();
        let name = real_folder.as_deref().unwrap_or(folder).file_name();
        let (rules, protocol_flaw) = selection_rules(folder, source.manifest(), &settings);
        let session_folder = real_folder.as_deref().and_then(Path::parent);
        let session = session_folder.and_then(|folder| sessions::read(folder).ok());
        let provenance = Provenance::new(source.manifest(), session.as_ref());
        Ok(Self {
            rules,
            protocol_flaw,
            assumed: settings.assumed().with_measured_pressure(measured_pa),
            name: name.map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            source,
            folder: folder.to_owned(),
            speed: options.speed,
            headless: options.headless,
            simulated: provenance.simulated,
        })
    }
}

/// Replays on the operator's dashboard, or as lines to `out`.
///
/// # Errors
/// If a file cannot be read, or the terminal fails.
pub fn run(plan: ReplayPlan, out: impl Write + Send + 'static) -> anyhow::Result<ReplayReport> {
    let stop = StopFlag::default();
    let _listening = devices::stop_on_signals(&stop)?;
    if plan.headless {
        return replay(plan, Box::new(Headless::new(out)), &stop);
    }
    let (dashboard, thread) =
        Dashboard::open(stop.clone(), StopKeys::default().with_end(stop.clone()))?;
    let report = replay(plan, Box::new(dashboard), &stop);
    thread.join()?;
    report
}

/// Replays to `front` until the recording ends or `stop` is raised; on a dashboard, until the operator quits.
///
/// # Errors
/// If a file cannot be read.
pub fn replay(
    plan: ReplayPlan,
    mut front: Box<dyn Front>,
    stop: &StopFlag,
) -> anyhow::Result<ReplayReport> {
    let (refits, fits, refit) = {
        let profile = AmplitudeProfile::from(&plan.source.vibration().plate);
        Refit::new(plan.assumed, profile, ParticipantSkin::default())
    };
    let (reports, report) = crossbeam_channel::bounded(1);
    for event in opening::events(&plan.source, &plan.rules, &plan.name, plan.simulated) {
        front.show(event);
    }
    let (clock, schedule): (Arc<dyn Clock>, _) = match plan.speed {
        Speed::Real => (Arc::new(SystemClock::start()), Schedule::Threads),
        Speed::Max => {
            let clock = Arc::new(FreeClock::default());
            (clock.clone(), Schedule::Lockstep(Box::new(Ticks(clock))))
        }
    };
    let task = Replay::new(plan, front, refits, fits, stop.clone(), reports);
    let refit = refit.for_single_trial();
    schedule.run(vec![Box::new(task), Box::new(refit)], &clock, stop)?;
    report
        .try_recv()
        .context("the replay ended without a report")
}

/// Task that replays the recording.
struct Replay {
    source: Source,
    front: Box<dyn Front>,
    refits: Sender<FitRequest>,
    fits: Receiver<FitReport>,
    stop: StopFlag,
    report: Sender<ReplayReport>,
    rules: SelectionRules,
    protocol_flaw: Option<Flaw>,
    unattended: bool,
    /// Length played, s of the recording; pauses excluded, as real speed can be paused.
    played_s: f64,
    /// Target of a seek: the recording is read fast up to it, s.
    seeking_s: f64,
    /// Folder of the recording, to reopen it when seeking back.
    folder: PathBuf,
    /// Number of fits requested before the replay moved back.
    outdated_fits: usize,
    polled_ns: Option<u64>,
    paused: bool,
    began: Instant,
    pace: Pace,
    meter: LiveMeter,
    contact: LiveContact,
    account: Account,
    frames: u64,
    audio_s: f64,
    screen_due_s: f64,
    phase: Option<PhaseView>,
    /// Intervals that are open or still to come, in time order.
    intervals: VecDeque<RecordedInterval>,
    record: Measurements,
    unloaded: Unloaded,
    planned: u32,
    explored: Explored,
    instances: usize,
    fits_requested: usize,
    fits_received: usize,
    fitted: usize,
    friction: (f64, u64),
    finished: bool,
}

impl Replay {
    fn new(
        plan: ReplayPlan,
        front: Box<dyn Front>,
        refits: Sender<FitRequest>,
        fits: Receiver<FitReport>,
        stop: StopFlag,
        report: Sender<ReplayReport>,
    ) -> Self {
        let intervals = in_order(plan.source.manifest());
        let record = Measurements::from_faults(plan.source.manifest(), plan.source.event_rate_hz());
        let explorations = intervals
            .iter()
            .filter(|interval| matches!(interval.kind, RecordedIntervalKind::Exploration(_)));
        let planned = explorations.count() as u32;
        let meter = initial::meter(plan.source.vibration());
        Self {
            planned,
            contact: initial::contact(plan.source.vibration(), &plan.rules),
            source: plan.source,
            front,
            refits,
            fits,
            stop,
            report,
            rules: plan.rules,
            protocol_flaw: plan.protocol_flaw,
            unattended: plan.headless,
            played_s: 0.0,
            seeking_s: 0.0,
            folder: plan.folder,
            outdated_fits: 0,
            polled_ns: None,
            paused: false,
            began: Instant::now(),
            pace: Pace::default(),
            meter,
            account: Account::default(),
            frames: 0,
            audio_s: 0.0,
            screen_due_s: 0.0,
            phase: None,
            intervals,
            record,
            unloaded: Unloaded::default(),
            explored: Explored::default(),
            instances: 0,
            fits_requested: 0,
            fits_received: 0,
            fitted: 0,
            friction: (0.0, 0),
            finished: false,
        }
    }

    fn log(&mut self, level: LogLevel, text: String) {
        self.front.show(tui::Event::Log { level, text });
    }

    fn take(&mut self, batch: Batch) {
        self.pace.read_s += batch.audio_s - self.audio_s;
        self.audio_s = batch.audio_s;
        self.account = batch.account;
        self.frames += batch.frames.len() as u64;
        self.meter.take(&batch);
        let exploring = self
            .open()
            .is_some_and(|interval| matches!(interval.kind, RecordedIntervalKind::Exploration(_)));
        let central = self
            .meter
            .position_m()
            .is_some_and(|at_m| (at_m - self.rules.centre_m).abs() <= self.rules.central_m / 2.0);
        let (squares, count) = &mut self.friction;
        self.contact.take(&batch, |reading| {
            if exploring && central {
                *squares += (reading.mu.value - reading.measured_mu).powi(2);
                *count += 1;
            }
        });
        self.record.frames.extend(batch.frames);
        self.record.force.extend(batch.force);
        self.record.position.extend(batch.position);
    }

    /// Returns the interval at the current position.
    fn open(&self) -> Option<&RecordedInterval> {
        self.intervals
            .iter()
            .find(|interval| (interval.start_s..interval.end_s).contains(&self.audio_s))
    }

    /// Evaluates the intervals with complete data, and drops the data after the last interval: an exploration is fitted together
    /// with the earlier ones, and the zero of the forces is read from all data before its end.
    fn close_intervals(&mut self) {
        while let Some(interval) = self
            .intervals
            .front()
            .copied()
            .filter(|interval| self.source.ended() || self.audio_s >= interval.end_s + MARGIN_S)
        {
            self.intervals.pop_front();
            match interval.kind {
                RecordedIntervalKind::Unloaded => self.read_plate(&interval),
                RecordedIntervalKind::Exploration(direction) => {
                    self.evaluate_exploration(&interval, direction)
                }
            }
        }
        if self.intervals.is_empty() {
            self.record.drop_before(self.audio_s - MARGIN_S);
        }
    }

    /// Returns the record with its forces against their zero in the data before `end_s`, and the zero.
    fn tare(&self, end_s: f64) -> (Measurements, ForceZero) {
        let unloaded_s = self.source.manifest().unloaded_s();
        ForceZero::tare(&self.record, &unloaded_s, end_s)
    }

    fn read_plate(&mut self, interval: &RecordedInterval) {
        let (vibration, off_n) = (self.source.vibration(), self.rules.contact_n / 2.0);
        let (record, _) = self.tare(interval.end_s);
        self.unloaded = Unloaded::read(&record, interval, vibration, off_n);
        match &self.unloaded.plate {
            Ok(plate) => {
                let z = plate.corrected_n_s_per_m;
                self.log(
                    LogLevel::Info,
                    format!("Z_p {:.2} {:+.2}i N·s/m", z.re, z.im),
                );
            }
            Err(error) => {
                let text = error.to_string();
                self.log(LogLevel::Warning, text);
            }
        }
    }

    fn evaluate_exploration(&mut self, interval: &RecordedInterval, direction: Direction) {
        let (record, zero) = self.tare(interval.end_s);
        let series = record.series(interval.start_s, interval.end_s);
        // The frames come from one demodulator, so the series is one; without frames there is no measurement.
        let (stretches, mean_n) =
            match analyse_exploration(&series.exploration(direction), &self.rules) {
                Ok(analysis) => (analysis.stretches, analysis.mean_normal_n),
                Err(_) => (Vec::new(), None),
            };
        let instances = stretches.iter().filter_map(Stretch::instance).count();
        self.instances += instances;
        let force = mean_n.map_or(String::new(), |n| format!(", mean force {n:.2} N"));
        let span_s = (interval.start_s, interval.end_s);
        self.explored.add(span_s, stretches.clone());
        self.log(
            LogLevel::Info,
            format!(
                "exploration {} of {}, {direction}: {instances} instances in {} rising stretches{force}",
                self.explored.count(),
                self.planned,
                stretches.len(),
            ),
        );
        let crop = crop(self.name(), direction, span_s, &series, &stretches);
        self.front.show(tui::Event::Crop(crop));
        self.fits_requested += 1;
        let (manifest, vibration) = (self.source.manifest(), self.source.vibration());
        let record = self.unloaded.corrected(&record, vibration);
        let request = self.explored.request(
            (manifest, vibration),
            &self.unloaded,
            (record, &zero),
            self.rules,
        );
        // The fitting task ends earlier only if it fails, and that stops the replay.
        let _ = self.refits.send(request);
    }

    /// Returns the name of the latest finished exploration.
    fn name(&self) -> ExplorationName {
        let trial = self.source.manifest().trial.as_ref();
        ExplorationName {
            attempt: trial.map_or(TrialLabel::of_block(false, 1, 1), manifest::Trial::label),
            exploration: self.explored.count(),
        }
    }

    fn take_fits(&mut self) {
        while let Ok(report) = self.fits.try_recv() {
            self.fits_received += 1;
            if self.outdated_fits > 0 {
                self.outdated_fits -= 1;
                continue;
            }
            if let Ok(fit) = &report.fit {
                self.fitted += 1;
                self.contact.refit(fit);
            }
            let attempt = attempt_name(self.name().attempt);
            let view = report.view(attempt, self.contact.drift_hz());
            self.front.show(tui::Event::Fit(view));
        }
    }

    fn take_actions(&mut self) -> anyhow::Result<()> {
        while let Some(action) = self.front.action() {
            match action {
                tui::Action::Pause => self.paused = true,
                tui::Action::Resume | tui::Action::Start | tui::Action::Ready => {
                    self.paused = false;
                }
                tui::Action::Seek { by_s } => self.seek(by_s)?,
                tui::Action::Quit | tui::Action::Interrupt | tui::Action::Abort => {
                    self.stop.raise();
                }
                // A replay drives no plate and has no participant.
                tui::Action::EmergencyStop
                | tui::Action::Rearm
                | tui::Action::Redo(_)
                | tui::Action::PauseNow(_)
                | tui::Action::AcceptAnyway(_)
                | tui::Action::Consent
                | tui::Action::TakeCarrier
                | tui::Action::KeepCarrier
                | tui::Action::Answer(_) => {}
            }
        }
        Ok(())
    }

    /// Seeks by `step_s`: forward by reading fast, back by reading fast from the start, so that the screen reflects all earlier
    /// data.
    fn seek(&mut self, step_s: f64) -> anyhow::Result<()> {
        let to_s = (self.audio_s.max(self.seeking_s) + step_s).clamp(0.0, self.source.duration_s());
        if to_s < self.audio_s {
            self.source = Source::open(&self.folder)?;
            self.intervals = in_order(self.source.manifest());
            self.record =
                Measurements::from_faults(self.source.manifest(), self.source.event_rate_hz());
            self.contact = initial::contact(self.source.vibration(), &self.rules);
            self.meter = initial::meter(self.source.vibration());
            self.account = Account::default();
            self.unloaded = Unloaded::default();
            (self.audio_s, self.played_s, self.screen_due_s) = (0.0, 0.0, 0.0);
            (self.frames, self.instances) = (0, 0);
            self.explored.clear();
            (self.fitted, self.friction) = (0, (0.0, 0));
            self.outdated_fits = self.fits_requested - self.fits_received;
            self.finished = false;
        }
        self.seeking_s = to_s;
        Ok(())
    }

    /// Returns the time up to which to read the recording, s.
    fn read_to_s(&mut self, since_ns: u64) -> Option<f64> {
        if self.played_s < self.seeking_s {
            self.played_s = self.seeking_s.min(self.played_s + SEEK_CHUNK_S);
            return Some(self.played_s);
        }
        if self.paused {
            return None;
        }
        self.played_s += since_ns as f64 * 1e-9;
        Some(self.played_s)
    }

    /// Whether the replay advances: neither paused nor waiting at the end.
    fn is_reading(&self) -> bool {
        !self.finished && (!self.paused || self.played_s < self.seeking_s)
    }

    fn phase(&self) -> PhaseView {
        let kind = match self.open().map(|interval| interval.kind) {
            _ if self.finished => PhaseKind::Finished,
            _ if self.paused => PhaseKind::Paused,
            Some(RecordedIntervalKind::Unloaded) => PhaseKind::Baseline,
            Some(RecordedIntervalKind::Exploration(_)) => PhaseKind::Exploration,
            None => PhaseKind::Monitoring,
        };
        let exploring = u32::from(kind == PhaseKind::Exploration);
        PhaseView {
            exploration: (self.explored.count() + exploring).min(self.planned),
            explorations: self.planned,
            message: Some("replay".to_owned()),
            ..PhaseView::new(kind)
        }
    }

    fn feed_screen(&mut self) {
        let phase = self.phase();
        if self.phase.as_ref() != Some(&phase) {
            self.front.show(tui::Event::Phase(phase.clone()));
            self.phase = Some(phase);
        }
        if self.audio_s >= self.screen_due_s {
            self.screen_due_s = self.audio_s + SCREEN_PERIOD_S;
            if let Some(live) = self.meter.live(None) {
                let live = screen_words::with_contact(live, &self.contact);
                self.front.show(tui::Event::Live(live));
            }
            if let Some(period) = self.meter.period() {
                self.front.show(tui::Event::Period(period));
            }
        }
        let wall_ns = u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(u64::MAX);
        let (gauges, rate_hz) = (DeviceReadings::default(), self.source.whole_rate_hz());
        let meter = &mut self.meter.health;
        if let Some(health) = meter.read(wall_ns, &self.account, &gauges, rate_hz) {
            self.front.show(tui::Event::Health(SystemHealth {
                force_rate_hz: None,
                ..health
            }));
            self.front.show(tui::Event::Safety {
                state: SafetyView::Disarmed,
                reason: Some("replay: nothing is driven".to_owned()),
            });
        }
    }

    fn end(&mut self) {
        let is_over = self.source.ended() && self.intervals.is_empty();
        if self.finished || !is_over || self.fits_received < self.fits_requested {
            return;
        }
        self.finished = true;
        self.front.show(tui::Event::Finished {
            summary: self.summary().lines(),
        });
        if self.unattended {
            self.stop.raise();
        }
    }

    fn summary(&self) -> ReplayReport {
        let (squares, count) = self.friction;
        ReplayReport {
            audio_s: self.audio_s,
            read_s: self.pace.read_s,
            took_s: self.pace.took_s(),
            rate_hz: self.source.whole_rate_hz(),
            account: self.account,
            frames: self.frames,
            explorations: self.explored.count() as usize,
            instances: self.instances,
            fits: self.fitted,
            friction: (count > 0).then(|| ((squares / count as f64).sqrt(), count)),
            warnings: self
                .source
                .warnings()
                .iter()
                .map(ToString::to_string)
                .chain(self.protocol_flaw.iter().map(ToString::to_string))
                .collect(),
            completed: self.finished,
        }
    }
}

fn in_order(manifest: &Manifest) -> VecDeque<RecordedInterval> {
    let mut intervals = manifest.intervals.clone();
    intervals.sort_by(|a, b| a.end_s.total_cmp(&b.end_s));
    intervals.into()
}

impl Task for Replay {
    fn name(&self) -> &'static str {
        "replay"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let since_ns = now_ns - self.polled_ns.replace(now_ns).unwrap_or(now_ns);
        let reading = self.is_reading();
        self.pace.pass(reading);
        if self.finished {
            // The operator is the only thing to wait for, even on a free-running clock.
            std::thread::sleep(self.period());
        } else if let Some(to_s) = self.read_to_s(since_ns) {
            let batch = self.source.read_until(to_s)?;
            self.take(batch);
            self.close_intervals();
        }
        self.take_fits();
        self.take_actions()?;
        self.feed_screen();
        self.end();
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.front.show(tui::Event::Close);
        // `replay` keeps the receiver until the tasks have ended.
        let _ = self.report.send(self.summary());
        Ok(())
    }
}
