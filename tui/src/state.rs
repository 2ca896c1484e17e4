//! The state of the screen: the fold of the events, and the operator's view settings.

use std::collections::VecDeque;

use crate::action::{Action, AttemptName};
use crate::calibration_page::{CalibrationPage, CalibrationReadings};
use crate::drill_view::DrillView;
use crate::event::{
    AskedDetail, BenchFacts, CarrierProposal, ComplexImpedance, Crop, Event, FitView, Live,
    LogLevel, Outlook, PeriodTrace, PhaseKind, PhaseView, SafetyView, SessionHeader, SystemHealth,
    TrialVerdict, ValueAndStd,
};
use crate::frozen::Frozen;
use crate::page::{HISTORY_S, Page, Window};
use crate::participant_screen::ScreenView;
use crate::strip::{STRIPS, Strip};
use drawing::theme::Theme;
use drawing::value_axis::ValueAxis;
use escaping::escaped_line;

/// Maximum number of live values kept: bounds memory at any rate.
const HISTORY_MAX: usize = 4000;
/// Maximum number of log lines kept.
const LOG_MAX: usize = 2000;
/// Maximum number of crops kept: enough for a long session.
const CROPS_MAX: usize = 400;
/// Remark shown after the key that ends the bench, until it has ended.
pub(crate) const ENDING: &str =
    "ending: waiting until all data are on the disk; Ctrl-C again ends at once";
/// Time for which a remark on a key is shown, s.
const NOTE_S: f64 = 8.0;
/// Time between two updates of the strips' axes, s.
const AXES_EVERY_S: f64 = 0.25;
/// Age above which live values are shown as stale, s.
pub const STALE_AFTER_S: f64 = 1.0;

/// The state of the screen: the fold of the events, and the operator's view settings.
///
/// ```
/// use tui::event::{Live, SafetyView};
/// use tui::{Event, State, Theme};
///
/// let mut state = State::new(Theme::Mono);
/// state.apply(&Event::Tick { now_s: 10.0 });
/// state.apply(&Event::Safety { state: SafetyView::Armed, reason: None });
/// state.apply(&Event::Live(Live { t_s: 0.2, normal_n: Some(0.65), ..Live::default() }));
/// assert_eq!(state.safety, Some(SafetyView::Armed));
/// assert_eq!(state.live().and_then(|live| live.normal_n), Some(0.65));
///
/// // Nothing for 2.5 s: the values are stale.
/// state.apply(&Event::Tick { now_s: 12.5 });
/// assert_eq!(state.live_stale_s(), Some(2.5));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time on the screen's clock, from [`Event::Tick`], s.
    pub now_s: f64,
    /// Time of the first tick, s: reference for ages until an event arrives.
    pub began_s: Option<f64>,
    /// Time of the last event of any kind, s.
    pub heard_s: Option<f64>,
    /// Time of the last live values, s.
    pub live_heard_s: Option<f64>,
    /// The participant, the protocol and the bench.
    pub session: SessionHeader,
    /// The current phase of the session.
    pub phase: PhaseView,
    /// Band of the normal force for the participant, N.
    pub force_band_n: Option<(f64, f64)>,
    /// Live values of the last [`HISTORY_S`], oldest first.
    pub history: VecDeque<Live>,
    /// Attempts at trials so far, in order of their start.
    pub trials: Vec<TrialLine>,
    /// Crops of the explorations, oldest first.
    pub crops: VecDeque<Crop>,
    /// Results of the fits, oldest first.
    pub fits: Vec<FitView>,
    /// Time and trials left in the session.
    pub outlook: Option<Outlook>,
    /// The impedance over the last period.
    pub period: Option<PeriodTrace>,
    /// Facts about the bench.
    pub bench: Option<BenchFacts>,
    /// Axes of the strips, kept while they are suitable.
    pub axes: [Option<ValueAxis>; STRIPS],
    /// Time of the last update of the axes, on the audio clock, s.
    axes_s: Option<f64>,
    /// Verdict on the last trial.
    pub verdict: Option<TrialVerdict>,
    /// Health of the system.
    pub health: Option<SystemHealth>,
    /// State of the safety watch; `None` until its first event.
    pub safety: Option<SafetyView>,
    /// Cause of the safety state.
    pub safety_reason: Option<String>,
    /// Log lines, oldest first.
    pub log: VecDeque<LogLine>,
    /// Contents of the participant's screen.
    pub participant: Option<ScreenView>,
    /// The lost display of the participant and the cause.
    pub display_lost: Option<String>,
    /// Page of the running calibration.
    pub calibration: Option<CalibrationPage>,
    /// Current readings of the calibration.
    pub readings: Option<CalibrationReadings>,
    /// Progress of the running drill.
    pub drill: Option<DrillView>,
    /// Question about the participant that waits for an answer.
    pub asked: Option<AskedDetail>,
    /// New carrier that waits for a decision.
    pub new_carrier: Option<CarrierProposal>,
    /// Summary of the finished session.
    pub summary: Option<Vec<String>>,
    /// Whether the bench has closed the screen.
    pub closed: bool,
    /// Remark on a key, and the time since which it is shown, s.
    dated_note: Option<(String, f64)>,
    /// The operator's view settings.
    pub ui: Ui,
}

/// One attempt at a trial, as a line of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialLine {
    /// Number of the trial, from 1.
    pub trial: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// Condition under test.
    pub condition: Option<String>,
    /// Verdict; `None` until the trial is judged.
    pub verdict: Option<TrialVerdict>,
}

impl TrialLine {
    /// Returns the name of the attempt.
    #[must_use]
    pub fn name(&self) -> AttemptName {
        AttemptName {
            trial: self.trial,
            practice: self.practice,
            attempt: self.attempt,
        }
    }
}

/// A line of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLine {
    /// Severity.
    pub level: LogLevel,
    /// Text of the line.
    pub text: String,
    /// Number of consecutive occurrences of the line.
    pub count: u32,
}

/// The operator's view settings. Keys change them; the only events that do are a calibration's requests to the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Ui {
    /// Page shown.
    pub page: Page,
    /// Whether the help covers the page.
    pub help: bool,
    /// Action that waits for confirmation.
    pub confirm: Option<Action>,
    /// Time span of the strip charts.
    pub window: Window,
    /// Digits typed so far.
    pub typed: String,
    /// Selected point of a calibration, counted from 0.
    pub chosen: Option<usize>,
    /// Remark on the last key, such as why it had no effect.
    pub note: Option<String>,
    /// Colour theme.
    pub theme: Theme,
    /// Whether the terminal shows only ASCII.
    pub ascii: bool,
    /// Enlarged panel, from 1; 0 for the whole page.
    pub zoom: u8,
    /// Rows by which a list is scrolled.
    pub scroll: u16,
    /// Selected attempt, counted from 0; `None` follows the newest.
    pub trial: Option<usize>,
    /// The strips while they are frozen.
    pub frozen: Option<Box<Frozen>>,
    /// Whether the page is to be written to files.
    pub write: bool,
}

impl Ui {
    /// Turns to a page, not enlarged and not scrolled.
    pub(crate) fn turn_to(&mut self, page: Page) {
        (self.page, self.zoom, self.scroll) = (page, 0, 0);
    }

    /// Turns to the first page and closes the help.
    fn uncover(&mut self) {
        self.turn_to(Page::Run);
        self.help = false;
    }
}

impl State {
    /// Returns the state before the first event.
    #[must_use]
    pub fn new(theme: Theme) -> Self {
        Self {
            now_s: 0.0,
            began_s: None,
            heard_s: None,
            live_heard_s: None,
            session: SessionHeader::default(),
            phase: PhaseView::new(PhaseKind::Idle),
            force_band_n: None,
            history: VecDeque::new(),
            trials: Vec::new(),
            crops: VecDeque::new(),
            fits: Vec::new(),
            outlook: None,
            period: None,
            bench: None,
            axes: [None; STRIPS],
            axes_s: None,
            verdict: None,
            health: None,
            safety: None,
            safety_reason: None,
            log: VecDeque::new(),
            participant: None,
            display_lost: None,
            calibration: None,
            readings: None,
            drill: None,
            asked: None,
            new_carrier: None,
            summary: None,
            closed: false,
            dated_note: None,
            ui: Ui {
                page: Page::Run,
                help: false,
                confirm: None,
                window: Window::Two,
                typed: String::new(),
                chosen: None,
                note: None,
                theme,
                ascii: false,
                zoom: 0,
                scroll: 0,
                trial: None,
                frozen: None,
                write: false,
            },
        }
    }

    /// Applies one event.
    pub fn apply(&mut self, event: &Event) {
        if let Event::Tick { now_s } = event {
            if now_s.is_finite() {
                self.now_s = *now_s;
                self.began_s.get_or_insert(*now_s);
                self.let_note_go();
            }
            return;
        }
        self.heard_s = Some(self.now_s);
        match event {
            Event::Tick { .. } => {}
            Event::Session(session) => self.session = session.clone(),
            Event::Phase(phase) => self.enter(phase),
            Event::Answer(text) => self.ui.note = Some(text.clone()),
            Event::ForceBand { min_n, max_n } => {
                self.force_band_n =
                    (min_n.is_finite() && max_n.is_finite()).then_some((*min_n, *max_n));
            }
            Event::Live(live) => self.push_live(live),
            Event::Crop(crop) => self.push_crop(crop),
            Event::Outlook(outlook) => self.outlook = Some(outlook.clone()),
            Event::Fit(fit) => {
                // A replay that was moved back fits an attempt again.
                self.fits.retain(|old| old.name() != fit.name());
                self.fits.push(fit.clone());
            }
            Event::Period(period) => self.period = Some(period.clone()),
            Event::Bench(bench) => self.bench = Some(bench.clone()),
            Event::Verdict(verdict) => self.judge(verdict),
            Event::Health(health) => self.take_health(health),
            Event::Safety { state, reason } => {
                let trips = *state == SafetyView::Tripped && self.safety != Some(*state);
                if trips && self.calibration.is_some() {
                    self.ui.uncover();
                }
                self.safety = Some(*state);
                self.safety_reason.clone_from(reason);
            }
            Event::Log { level, text } => self.push_log(*level, text),
            Event::Participant(view) => self.participant = Some(view.clone()),
            Event::ParticipantDisplay { lost } => self.display_lost.clone_from(lost),
            Event::Calibration(calibration) => {
                if calibration.calls(self.calibration.as_ref()) {
                    self.ui.uncover();
                    // A remark on the last key belongs to the question before.
                    self.ui.note = None;
                }
                self.calibration = Some(calibration.clone());
            }
            Event::CalibrationReadings(readings) => {
                self.live_heard_s = Some(self.now_s);
                self.readings = Some(readings.finite_only());
            }
            Event::Drill(drill) => self.drill = Some(drill.clone()),
            // A finished session asks nothing more.
            Event::Asked { detail } => {
                let is_open = self.phase.kind != PhaseKind::Finished;
                self.asked = detail.clone().filter(|_| is_open);
            }
            Event::NewCarrier { proposal } => self.new_carrier = *proposal,
            Event::Finished { summary } => self.summary = Some(summary.clone()),
            Event::Close => self.closed = true,
        }
    }

    /// Takes the health; the values of a lost sound card end with a gap.
    fn take_health(&mut self, health: &SystemHealth) {
        if health.lost.sound_card
            && let Some(last) = self.history.back_mut()
        {
            *last = Live {
                t_s: last.t_s,
                ..Live::default()
            };
        }
        self.health = Some(*health);
    }

    /// Returns whether a device is lost, so that the bench cannot be re-armed.
    #[must_use]
    pub(crate) fn is_device_lost(&self) -> bool {
        self.health.is_some_and(|health| health.lost.any())
    }

    /// Returns the last live values, of any age.
    #[must_use]
    pub fn live(&self) -> Option<&Live> {
        self.history.back()
    }

    /// Returns the age of the live values in s if it is above [`STALE_AFTER_S`].
    #[must_use]
    pub fn live_stale_s(&self) -> Option<f64> {
        let is_still = matches!(self.phase.kind, PhaseKind::Paused | PhaseKind::Finished);
        if self.session.replayed && is_still {
            return None;
        }
        self.stale_since(self.live_heard_s)
    }

    /// Returns the time since the last event in s if it is above [`STALE_AFTER_S`].
    #[must_use]
    pub fn silent_s(&self) -> Option<f64> {
        self.stale_since(self.heard_s)
    }

    /// Whether a session or a calibration runs, so that quitting needs confirmation.
    #[must_use]
    pub fn is_running(&self) -> bool {
        if let Some(calibration) = &self.calibration {
            return !calibration.failed;
        }
        !matches!(self.phase.kind, PhaseKind::Idle | PhaseKind::Finished)
    }

    /// Whether a participant's session runs, as opposed to `monitor`, drills and calibrations.
    #[must_use]
    pub fn in_session(&self) -> bool {
        let is_watching = self.phase.trial == 0
            && self.session.participant.is_none()
            && matches!(self.phase.kind, PhaseKind::Monitoring | PhaseKind::Paused);
        let taking_part = self.calibration.is_none() && !self.session.replayed;
        taking_part && self.drill.is_none() && self.is_running() && !is_watching
    }

    /// Returns the calibration while its own page is shown.
    pub(crate) fn shown_calibration(&self) -> Option<&CalibrationPage> {
        let calibration = self.calibration.as_ref();
        calibration.filter(|_| self.ui.page == Page::Run)
    }

    /// Returns the point of a calibration to remeasure, counted from 0: the selected one, else the one with the largest
    /// residual, else the last.
    #[must_use]
    pub fn chosen_point(&self) -> Option<usize> {
        let points = &self.calibration.as_ref()?.points;
        let last = points.len().checked_sub(1)?;
        let worst = points.iter().position(|point| point.worst);
        Some(self.ui.chosen.or(worst).unwrap_or(last).min(last))
    }

    /// Returns the time since `heard_s` if it is stale.
    fn stale_since(&self, heard_s: Option<f64>) -> Option<f64> {
        let age_s = self.now_s - heard_s.or(self.began_s)?;
        (age_s > STALE_AFTER_S).then_some(age_s)
    }

    /// Removes the remark on a key once it has been read.
    fn let_note_go(&mut self) {
        let note = self.ui.note.clone().filter(|note| note != ENDING);
        match (note, &self.dated_note) {
            (Some(note), Some((dated, since_s))) if note == *dated => {
                if self.now_s - since_s > NOTE_S {
                    self.ui.note = None;
                }
            }
            (note, _) => self.dated_note = note.map(|note| (note, self.now_s)),
        }
    }

    /// Enters a phase, and lists its attempt if it is new.
    fn enter(&mut self, phase: &PhaseView) {
        if phase.kind != self.phase.kind {
            // A remark on a key belongs to the phase in which it was pressed.
            self.ui.note.take_if(|note| note != ENDING);
        }
        let is_over = |name: &AttemptName| {
            *name != phase.name() || matches!(phase.kind, PhaseKind::Verdict | PhaseKind::Finished)
        };
        // A question about the running attempt ends with it.
        self.ui.confirm.take_if(
            |action| matches!(action, Action::Redo(name) | Action::PauseNow(name) if is_over(name)),
        );
        self.phase = phase.clone();
        if phase.kind == PhaseKind::Finished {
            self.asked = None;
        }
        if phase.kind != PhaseKind::Finished {
            // A replay was moved back from its end.
            self.summary = None;
        }
        if phase.trial > 0 {
            let condition = phase.condition.clone();
            self.list(phase.name(), condition);
        }
    }

    /// Adds an attempt to the list unless it is there.
    fn list(&mut self, name: AttemptName, condition: Option<String>) {
        let is_listed = self.trials.iter().rev().any(|line| line.name() == name);
        if !is_listed {
            self.trials.push(TrialLine {
                trial: name.trial,
                practice: name.practice,
                attempt: name.attempt,
                condition,
                verdict: None,
            });
        }
    }

    /// Attaches a verdict to its attempt, which is listed if it was never announced.
    fn judge(&mut self, verdict: &TrialVerdict) {
        // Verdicts of earlier parts of the session, and those that a person has overruled, are not news.
        if verdict.name() == self.phase.name() && verdict.settled.is_none() {
            self.log_verdict(verdict);
        }
        let is_line = |line: &&mut TrialLine| line.name() == verdict.name();
        match self.trials.iter_mut().rev().find(is_line) {
            Some(line) => {
                line.verdict = Some(verdict.clone());
                if line.condition.is_none() {
                    line.condition.clone_from(&verdict.condition);
                }
            }
            None => self.trials.push(TrialLine {
                trial: verdict.trial,
                practice: verdict.practice,
                attempt: verdict.attempt,
                condition: verdict.condition.clone(),
                verdict: Some(verdict.clone()),
            }),
        }
        if !verdict.interrupted {
            self.verdict = Some(verdict.clone());
        }
    }

    /// Adds a verdict to the log, in the operator's words.
    fn log_verdict(&mut self, verdict: &TrialVerdict) {
        let name = verdict.name();
        if verdict.accepted {
            let force = verdict.mean_normal_n.map(|n| format!(", force {n:.2} N"));
            let text = format!("{name} accepted{}", force.unwrap_or_default());
            self.push_log(LogLevel::Info, &text);
        } else {
            let reasons = verdict.brief.iter().map(|parts| parts.join(", "));
            let reasons = reasons.collect::<Vec<_>>().join("; ");
            self.push_log(LogLevel::Warning, &format!("{name} rejected: {reasons}"));
        }
    }

    fn push_live(&mut self, live: &Live) {
        let is_card_lost = self.health.is_some_and(|health| health.lost.sound_card);
        if !live.t_s.is_finite() || is_card_lost {
            return;
        }
        self.live_heard_s = Some(self.now_s);
        // After a restart of a replay or a new session, the old curve does not belong on the new axis.
        if self.history.back().is_some_and(|last| last.t_s > live.t_s) {
            self.history.clear();
        }
        self.history.push_back(finite_only(live));
        while self
            .history
            .front()
            .is_some_and(|first| first.t_s < live.t_s - HISTORY_S)
            || self.history.len() > HISTORY_MAX
        {
            self.history.pop_front();
        }
        let is_due = self
            .axes_s
            .is_none_or(|at_s| !(at_s..at_s + AXES_EVERY_S).contains(&live.t_s));
        if is_due {
            self.axes_s = Some(live.t_s);
            let band = self.force_band_n;
            for (strip, axis) in Strip::ALL.into_iter().zip(&mut self.axes) {
                *axis = strip.axis(&self.history, band, *axis);
            }
        }
    }

    /// Stores a crop; replaces an earlier one of the same exploration.
    fn push_crop(&mut self, crop: &Crop) {
        let key = |crop: &Crop| (crop.name(), crop.exploration);
        match self
            .crops
            .iter_mut()
            .rev()
            .find(|old| key(old) == key(crop))
        {
            Some(old) => *old = crop.clone(),
            None => self.crops.push_back(crop.clone()),
        }
        self.list(crop.name(), None);
        while self.crops.len() > CROPS_MAX {
            self.crops.pop_front();
        }
    }

    /// Returns the live values of the strips: the frozen ones, or the newest.
    #[must_use]
    pub fn shown_history(&self) -> &VecDeque<Live> {
        self.ui
            .frozen
            .as_ref()
            .map_or(&self.history, |frozen| &frozen.history)
    }

    /// Returns the selected attempt, or the newest with a verdict or a crop.
    #[must_use]
    pub fn chosen_trial(&self) -> Option<&TrialLine> {
        let has_result =
            |line: &TrialLine| line.verdict.is_some() || self.crops_of(line).next().is_some();
        match self.ui.trial {
            Some(index) => self.trials.get(index),
            None => self.trials.iter().rev().find(|line| has_result(line)),
        }
        .or_else(|| self.trials.last())
    }

    /// Returns the crops of an attempt.
    pub fn crops_of(&self, line: &TrialLine) -> impl Iterator<Item = &Crop> {
        let name = line.name();
        self.crops.iter().filter(move |crop| crop.name() == name)
    }

    /// Returns the fit of an attempt.
    #[must_use]
    pub fn fit_of(&self, line: &TrialLine) -> Option<&FitView> {
        let name = line.name();
        self.fits.iter().rev().find(|fit| fit.name() == name)
    }

    fn push_log(&mut self, level: LogLevel, text: &str) {
        let text = escaped_line(text);
        match self.log.back_mut() {
            Some(last) if last.level == level && last.text == text => {
                last.count = last.count.saturating_add(1);
            }
            _ => self.log.push_back(LogLine {
                level,
                text: text.into_owned(),
                count: 1,
            }),
        }
        while self.log.len() > LOG_MAX {
            self.log.pop_front();
        }
    }
}

/// Returns `live` with `None` for each value that is not finite.
fn finite_only(live: &Live) -> Live {
    let number = |value: Option<f64>| value.filter(|v| v.is_finite());
    let complex = |value: Option<ComplexImpedance>| {
        value.filter(|z| z.re_n_s_per_m.is_finite() && z.im_n_s_per_m.is_finite())
    };
    let estimate =
        |value: Option<ValueAndStd>| value.filter(|e| e.value.is_finite() && e.std.is_finite());
    Live {
        t_s: live.t_s,
        z_m_n_s_per_m: complex(live.z_m_n_s_per_m),
        z_plain_n_s_per_m: complex(live.z_plain_n_s_per_m),
        amplitude_m: number(live.amplitude_m),
        normal_n: number(live.normal_n),
        lateral_n: number(live.lateral_n),
        position_m: number(live.position_m),
        velocity_m_per_s: number(live.velocity_m_per_s),
        slider_m: number(live.slider_m),
        gap_m: estimate(live.gap_m),
        mu: estimate(live.mu),
        sensed_normal_n: estimate(live.sensed_normal_n),
        plate_drift_hz: estimate(live.plate_drift_hz),
        drive_v: number(live.drive_v),
        measured_mu: number(live.measured_mu),
        z_m_std_n_s_per_m: number(live.z_m_std_n_s_per_m),
        z_p_n_s_per_m: complex(live.z_p_n_s_per_m),
        masked: live.masked,
        no_estimate: live.no_estimate,
    }
}
