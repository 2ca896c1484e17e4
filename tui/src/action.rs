//! What the operator asks of the bench: the screen's only effects.

use serde::{Deserialize, Serialize};

use crate::calibration_page::Reply;

/// One wish of the operator. The bench decides what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Start the session, or the drive in `monitor`.
    Start,
    /// The participant's consent is given and may be recorded. Confirmed.
    Consent,
    /// The participant is in place: go on. Also ends a rest.
    Ready,
    /// Pause.
    Pause,
    /// Resume.
    Resume,
    /// Do the present trial again. Confirmed.
    Redo,
    /// Abort the session. Confirmed.
    Abort,
    /// Answer what a calibration asks.
    Answer(Reply),
    /// Stop the drive at once. Never asks for confirmation.
    EmergencyStop,
    /// Re-arm after a trip. Confirmed.
    Rearm,
    /// Leave; confirmed while a session or a calibration runs.
    Quit,
    /// Ctrl-C: what SIGINT would ask, an orderly stop without further questions.
    Interrupt,
}
