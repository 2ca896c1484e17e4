//! What is left of a session, and what comes next.

use serde::{Deserialize, Serialize};

/// What is left of a session.
///
/// ```
/// use tui::event::Outlook;
/// use tui::{Event, State, Theme};
///
/// let mut state = State::new(Theme::Mono);
/// state.apply(&Event::Outlook(Outlook { left_s: 720.0, trials_left: 7, ..Outlook::default() }));
/// assert_eq!(state.outlook.map(|outlook| outlook.trials_left), Some(7));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// Time until the session's end, if nothing is repeated, s.
    pub left_s: f64,
    /// Number of trials that are not settled, practice included.
    pub trials_left: u32,
    /// Repetitions that a verdict may still ask for of the present trial.
    pub repetitions_of_trial: u32,
    /// Repetitions that verdicts may still ask for in the session.
    pub repetitions_in_session: u32,
    /// What follows the present step.
    pub next: Option<String>,
    /// What follows that.
    pub then: Option<String>,
}
