//! Contents of a drill on the dashboard: the exercise, the request to the operator, and the results so far.

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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrillView {
    /// Number of the exercise, from 1; 0 before the first.
    pub exercise: u32,
    /// Number of exercises.
    pub exercises: u32,
    /// Instruction to the operator, or the bench's current activity.
    pub instruction: String,
    /// Remark on the last key.
    pub note: Option<String>,
    /// Step requested of the operator.
    pub asked: DrillStep,
    /// Results of the finished exercises.
    pub results: Vec<DrillResult>,
}

/// Step requested of the operator in a drill.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrillStep {
    /// Watch: a fault may occur.
    #[default]
    Watch,
    /// Act at the bench.
    Act,
    /// Acknowledge the fault: [`Action::Ready`](crate::Action::Ready).
    Acknowledge,
    /// Re-arm: [`Action::Rearm`](crate::Action::Rearm).
    Rearm,
    /// Resume: [`Action::Resume`](crate::Action::Resume).
    Resume,
    /// Repeat the trial: [`Action::Redo`](crate::Action::Redo).
    Repeat,
    /// End the program: [`Action::Quit`](crate::Action::Quit).
    Quit,
}

/// Result of one exercise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrillResult {
    /// Name of the fault.
    pub fault: String,
    /// Whether bench and operator responded in time.
    pub met: bool,
    /// Its times, or the missed step.
    pub words: String,
}
