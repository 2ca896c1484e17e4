//! All that the screen knows: the fold of the events, and the operator's own view settings.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::action::Action;
use crate::calibration_page::{CalibrationPage, CalibrationReadings};
use crate::event::{
    ComplexImpedance, Crop, Event, Live, LogLevel, PhaseKind, PhaseView, SafetyState,
    SessionHeader, SystemHealth, TrialVerdict, ValueAndStd,
};
use crate::participant_screen::ParticipantView;
use crate::theme::Theme;

/// How much of the live values is kept for the strip charts.
pub const HISTORY_S: f64 = 10.0;
/// Bounds memory whatever the rate of the live values.
const HISTORY_MAX: usize = 4000;
const LOG_MAX: usize = 200;
/// Values older than this are shown as stale.
pub const STALE_AFTER_S: f64 = 1.0;

/// All that the screen knows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The screen's clock, from [`Event::Tick`].
    pub now_s: f64,
    /// When the first event was applied: ages count from here until there is something younger.
    pub began_s: Option<f64>,
    /// When the bench last said anything.
    pub heard_s: Option<f64>,
    /// When the last live values came.
    pub live_heard_s: Option<f64>,
    /// Who is measured, with what.
    pub session: SessionHeader,
    /// Where the session stands.
    pub phase: PhaseView,
    /// The normal force asked for, from and to.
    pub force_band_n: Option<(f64, f64)>,
    /// The last [`HISTORY_S`] of live values, oldest first.
    pub history: VecDeque<Live>,
    /// The trials so far, in the order in which they were begun.
    pub trials: Vec<TrialLine>,
    /// The last trial, cropped.
    pub crop: Option<Crop>,
    /// The last verdict.
    pub verdict: Option<TrialVerdict>,
    /// How the machinery does.
    pub health: Option<SystemHealth>,
    /// The safety state; `None` until the bench has said it.
    pub safety: Option<SafetyState>,
    /// Why the safety state is what it is.
    pub safety_reason: Option<String>,
    /// Lines for the operator, oldest first.
    pub log: VecDeque<LogLine>,
    /// What the participant sees.
    pub participant: Option<ParticipantView>,
    /// The calibration under way.
    pub calibration: Option<CalibrationPage>,
    /// What it reads just now.
    pub reading: Option<CalibrationReadings>,
    /// The summary of a finished session.
    pub summary: Option<Vec<String>>,
    /// The bench asked to close the screen.
    pub closed: bool,
    /// The operator's own view settings.
    pub ui: Ui,
}

/// One attempt at a trial, in the list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialLine {
    /// Number of the trial.
    pub trial: u32,
    /// A practice trial.
    pub practice: bool,
    /// Which attempt.
    pub attempt: u32,
    /// The condition.
    pub condition: Option<String>,
    /// The judgement; `None` while it runs.
    pub verdict: Option<TrialVerdict>,
}

/// A line for the operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogLine {
    /// How grave.
    pub level: LogLevel,
    /// The line.
    pub text: String,
    /// How often it came in a row.
    pub count: u32,
}

/// The operator's own view settings. They change by keys, not by events.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ui {
    /// Which page is shown.
    pub page: Page,
    /// The help lies over it.
    pub help: bool,
    /// The action that waits for a yes.
    pub confirm: Option<Action>,
    /// What the strip charts span.
    pub window: Window,
    /// What is typed, of a number that a calibration asks for.
    pub typed: String,
    /// The point of a calibration that is chosen to be measured again.
    pub chosen: Option<usize>,
    /// An answer to the last key, when it did nothing.
    pub note: Option<String>,
    /// Colours, or none.
    pub theme: Theme,
}

/// The pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Page {
    /// The operator's dashboard.
    Dashboard,
    /// What the participant sees.
    Participant,
}

/// What the strip charts span.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// One second: single periods of the modulation.
    One,
    /// Two seconds.
    Two,
    /// Five seconds.
    Five,
    /// All of [`HISTORY_S`].
    Ten,
}

impl Window {
    /// The span in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Two => 2.0,
            Self::Five => 5.0,
            Self::Ten => HISTORY_S,
        }
    }

    /// The next wider one.
    #[must_use]
    pub fn wider(self) -> Self {
        match self {
            Self::One => Self::Two,
            Self::Two => Self::Five,
            Self::Five | Self::Ten => Self::Ten,
        }
    }

    /// The next narrower one.
    #[must_use]
    pub fn narrower(self) -> Self {
        match self {
            Self::One | Self::Two => Self::One,
            Self::Five => Self::Two,
            Self::Ten => Self::Five,
        }
    }
}

impl State {
    /// Knows nothing yet.
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
            crop: None,
            verdict: None,
            health: None,
            safety: None,
            safety_reason: None,
            log: VecDeque::new(),
            participant: None,
            calibration: None,
            reading: None,
            summary: None,
            closed: false,
            ui: Ui {
                page: Page::Dashboard,
                help: false,
                confirm: None,
                window: Window::Two,
                typed: String::new(),
                chosen: None,
                note: None,
                theme,
            },
        }
    }

    /// Takes one event in.
    pub fn apply(&mut self, event: &Event) {
        if let Event::Tick { now_s } = event {
            if now_s.is_finite() {
                self.now_s = *now_s;
                self.began_s.get_or_insert(*now_s);
            }
            return;
        }
        self.heard_s = Some(self.now_s);
        match event {
            Event::Tick { .. } => {}
            Event::Session(session) => self.session = session.clone(),
            Event::Phase(phase) => self.enter(phase),
            Event::ForceBand { min_n, max_n } => {
                self.force_band_n =
                    (min_n.is_finite() && max_n.is_finite()).then_some((*min_n, *max_n));
            }
            Event::Live(live) => self.push_live(live),
            Event::Crop(crop) => self.crop = Some(crop.clone()),
            Event::Verdict(verdict) => self.judge(verdict),
            Event::Health(health) => self.health = Some(*health),
            Event::Safety { state, reason } => {
                self.safety = Some(*state);
                self.safety_reason.clone_from(reason);
            }
            Event::Log { level, text } => self.push_log(*level, text),
            Event::Participant(view) => self.participant = Some(view.clone()),
            Event::Calibration(calibration) => self.calibration = Some(calibration.clone()),
            Event::CalibrationReadings(reading) => {
                self.live_heard_s = Some(self.now_s);
                self.reading = Some(reading.finite_only());
            }
            Event::Finished { summary } => self.summary = Some(summary.clone()),
            Event::Close => self.closed = true,
        }
    }

    /// The last live values, however old.
    #[must_use]
    pub fn live(&self) -> Option<&Live> {
        self.history.back()
    }

    /// How old the live values are, once they are stale.
    #[must_use]
    pub fn live_stale_s(&self) -> Option<f64> {
        self.stale_since(self.live_heard_s)
    }

    /// How long the bench has been silent, once that is too long.
    #[must_use]
    pub fn silent_s(&self) -> Option<f64> {
        self.stale_since(self.heard_s)
    }

    /// A session or a calibration runs: leaving it wants a confirmation.
    #[must_use]
    pub fn is_running(&self) -> bool {
        if let Some(calibration) = &self.calibration {
            return !calibration.failed;
        }
        !matches!(self.phase.kind, PhaseKind::Idle | PhaseKind::Finished)
    }

    /// A participant's session runs: `monitor` and calibrations are none.
    #[must_use]
    pub fn in_session(&self) -> bool {
        let watching = self.phase.trial == 0
            && self.session.participant.is_none()
            && matches!(self.phase.kind, PhaseKind::Monitoring | PhaseKind::Paused);
        self.calibration.is_none() && self.is_running() && !watching
    }

    /// The point of a calibration that would be measured again: the chosen one, else the worst, else the last.
    #[must_use]
    pub fn chosen_point(&self) -> Option<usize> {
        let points = &self.calibration.as_ref()?.points;
        let last = points.len().checked_sub(1)?;
        let worst = points.iter().position(|point| point.worst);
        Some(self.ui.chosen.or(worst).unwrap_or(last).min(last))
    }

    fn stale_since(&self, heard_s: Option<f64>) -> Option<f64> {
        let age_s = self.now_s - heard_s.or(self.began_s)?;
        (age_s > STALE_AFTER_S).then_some(age_s)
    }

    fn enter(&mut self, phase: &PhaseView) {
        self.phase = phase.clone();
        let listed = self.trials.iter().rev().any(|line| {
            (line.trial, line.practice, line.attempt)
                == (phase.trial, phase.practice, phase.attempt)
        });
        if phase.trial > 0 && !listed {
            self.trials.push(TrialLine {
                trial: phase.trial,
                practice: phase.practice,
                attempt: phase.attempt,
                condition: phase.condition.clone(),
                verdict: None,
            });
        }
    }

    fn judge(&mut self, verdict: &TrialVerdict) {
        let same = |line: &&mut TrialLine| {
            (line.trial, line.practice, line.attempt)
                == (verdict.trial, verdict.practice, verdict.attempt)
        };
        match self.trials.iter_mut().rev().find(same) {
            Some(line) => line.verdict = Some(verdict.clone()),
            None => self.trials.push(TrialLine {
                trial: verdict.trial,
                practice: verdict.practice,
                attempt: verdict.attempt,
                condition: None,
                verdict: Some(verdict.clone()),
            }),
        }
        self.verdict = Some(verdict.clone());
    }

    fn push_live(&mut self, live: &Live) {
        if !live.t_s.is_finite() {
            return;
        }
        self.live_heard_s = Some(self.now_s);
        // A replay that starts over, or another session: the old curve has no place on the new axis.
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
    }

    fn push_log(&mut self, level: LogLevel, text: &str) {
        match self.log.back_mut() {
            Some(last) if last.level == level && last.text == text => {
                last.count = last.count.saturating_add(1);
            }
            _ => self.log.push_back(LogLine {
                level,
                text: text.to_owned(),
                count: 1,
            }),
        }
        while self.log.len() > LOG_MAX {
            self.log.pop_front();
        }
    }
}

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
        drive_v: number(live.drive_v),
    }
}
