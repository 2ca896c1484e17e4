//! Time and trials left in a session, and the next steps.

/// Time and trials left in a session, and the next steps.
///
/// ```
/// use tui::event::Outlook;
/// use tui::{Event, State, Theme};
///
/// let mut state = State::new(Theme::Mono);
/// state.apply(&Event::Outlook(Outlook { left_s: 720.0, trials_left: 7, ..Outlook::default() }));
/// assert_eq!(state.outlook.map(|outlook| outlook.trials_left), Some(7));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outlook {
    /// Time until the session's end, if nothing is repeated, s.
    pub left_s: f64,
    /// Number of trials that are not settled, practice included.
    pub trials_left: u32,
    /// Repetitions by verdicts left for the present trial.
    pub repetitions_of_trial: u32,
    /// Repetitions by verdicts left in the session.
    pub repetitions_in_session: u32,
    /// Step after the present one.
    pub next: Option<String>,
    /// Step after that.
    pub then: Option<String>,
}
