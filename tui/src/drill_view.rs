//! What a drill shows on the dashboard: the exercise, what is asked of the operator, and how those before were met.

use serde::{Deserialize, Serialize};

/// A drill's progress. The rest of the dashboard shows the bench as in a session.
///
/// ```
/// use tui::drill_view::{DrillStep, DrillView};
/// use tui::{Event, State, Theme};
///
/// let mut state = State::new(Theme::Mono);
/// let instruction = "Watch the bench.".to_owned();
/// state.apply(&Event::Drill(DrillView { exercise: 1, exercises: 3, instruction, ..DrillView::default() }));
/// assert_eq!(state.drill.map(|drill| drill.asked), Some(DrillStep::Watch));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DrillView {
    /// Number of the exercise, from 1; 0 before the first.
    pub exercise: u32,
    /// Number of exercises.
    pub exercises: u32,
    /// What the operator should do now, or what the bench is doing.
    pub instruction: String,
    /// Remark on the last key.
    pub note: Option<String>,
    /// What the operator is asked for.
    pub asked: DrillStep,
    /// Exercises that are over.
    pub results: Vec<DrillResult>,
}

/// What the operator of a drill is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrillStep {
    /// To watch: a fault may come.
    #[default]
    Watch,
    /// To do something at the bench.
    Act,
    /// To say that the fault was seen: [`Action::Ready`](crate::Action::Ready).
    Acknowledge,
    /// To re-arm: [`Action::Rearm`](crate::Action::Rearm).
    Rearm,
    /// To resume: [`Action::Resume`](crate::Action::Resume).
    Resume,
    /// To repeat the trial: [`Action::Redo`](crate::Action::Redo).
    Repeat,
    /// To end the program: [`Action::Quit`](crate::Action::Quit).
    Quit,
}

/// How one exercise was met.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DrillResult {
    /// Name of the fault.
    pub fault: String,
    /// Whether bench and operator met it in time.
    pub met: bool,
    /// Its times, or what was missed.
    pub words: String,
}
