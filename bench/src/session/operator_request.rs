//! Requests from keys of the dashboard to a session.

use live::attempt_name::label;
use protocols::OperatorCommand;
use tui::Action;
use tui::action::AttemptName;
use tui::calibration_page::Reply;

/// Request of the operator.
pub enum OperatorRequest {
    /// A command to the protocol's state machine.
    Command(OperatorCommand),
    /// The participant has given consent.
    Consent,
    /// A reply to a question.
    Reply(Reply),
    /// Whether the proposed carrier is accepted.
    Carrier(bool),
    /// Stop the drive at once.
    Stop,
    /// Re-arm after a stop.
    Rearm,
    /// End the program.
    End,
    /// No request: the action is for replays.
    Nothing,
}

impl OperatorRequest {
    /// Returns the request of `action` to a session that begins with `practices` practice trials.
    pub fn from_action(action: Action, practices: u32) -> Self {
        let numbers = |name: AttemptName| {
            let number = label(name).number_in_session(practices);
            (number, name.attempt)
        };
        Self::Command(match action {
            Action::Start | Action::Ready => OperatorCommand::Continue,
            Action::Pause => OperatorCommand::Pause,
            Action::PauseNow(name) => {
                let (number, attempt) = numbers(name);
                OperatorCommand::PauseNow { number, attempt }
            }
            Action::Resume => OperatorCommand::Resume,
            Action::Redo(name) => {
                let (number, attempt) = numbers(name);
                OperatorCommand::Redo { number, attempt }
            }
            Action::AcceptAnyway(name) => {
                let (number, attempt) = numbers(name);
                OperatorCommand::AcceptAnyway { number, attempt }
            }
            Action::Abort => OperatorCommand::Abort,
            Action::Consent => return Self::Consent,
            Action::TakeCarrier => return Self::Carrier(true),
            Action::KeepCarrier => return Self::Carrier(false),
            Action::EmergencyStop => return Self::Stop,
            Action::Rearm => return Self::Rearm,
            Action::Quit | Action::Interrupt => return Self::End,
            Action::Answer(reply) => return Self::Reply(reply),
            Action::Seek { .. } => return Self::Nothing,
        })
    }
}
