//! Requests of the operator to the bench: the screen's only effects.

use serde::{Deserialize, Serialize};

use crate::calibration_page::Reply;

/// One request of the operator. The bench decides whether it is granted.
///
/// ```
/// use tui::Action;
/// use tui::calibration_page::Reply;
///
/// let typed = Action::Answer(Reply::Number(1.25));
/// assert_eq!(serde_json::to_string(&typed)?, r#"{"answer":{"number":1.25}}"#);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Start the session; in `monitor`, start the drive.
    Start,
    /// Record that the participant has given consent. Needs confirmation.
    Consent,
    /// Continue: the participant is in place. Also ends a rest, and says that a drill's fault was seen.
    Ready,
    /// Pause the session.
    Pause,
    /// Resume the paused session.
    Resume,
    /// Repeat the current trial. Needs confirmation.
    Redo,
    /// Abort the session. Needs confirmation.
    Abort,
    /// Reply to a calibration's question.
    Answer(Reply),
    /// Take the proposed carrier from the next trial on.
    TakeCarrier,
    /// Keep the present carrier.
    KeepCarrier,
    /// Stop the drive at once, without confirmation.
    EmergencyStop,
    /// Re-arm after a trip. Needs confirmation.
    Rearm,
    /// Quit. Needs confirmation while a session or a calibration runs.
    Quit,
    /// Stop in an orderly way without confirmation, as on SIGINT (Ctrl-C).
    Interrupt,
}
