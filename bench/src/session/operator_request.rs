//! What a key of the dashboard asks of a session.

use protocols::OperatorCommand;
use tui::Action;
use tui::calibration_page::Reply;

/// Request of the operator.
pub enum OperatorRequest {
    /// A command to the protocol's state machine.
    Command(OperatorCommand),
    /// The participant has given consent.
    Consent,
    /// A reply to a question.
    Reply(Reply),
    /// Whether the proposed carrier is taken.
    Carrier(bool),
    /// Stop the drive at once.
    Stop,
    /// Re-arm after a stop.
    Rearm,
    /// End the program.
    End,
}

impl From<Action> for OperatorRequest {
    fn from(action: Action) -> Self {
        match action {
            Action::Start | Action::Ready => Self::Command(OperatorCommand::Continue),
            Action::Consent => Self::Consent,
            Action::Pause => Self::Command(OperatorCommand::Pause),
            Action::Resume => Self::Command(OperatorCommand::Resume),
            Action::Redo => Self::Command(OperatorCommand::Redo),
            Action::Abort => Self::Command(OperatorCommand::Abort),
            Action::TakeCarrier => Self::Carrier(true),
            Action::KeepCarrier => Self::Carrier(false),
            Action::EmergencyStop => Self::Stop,
            Action::Rearm => Self::Rearm,
            Action::Quit | Action::Interrupt => Self::End,
            Action::Answer(reply) => Self::Reply(reply),
        }
    }
}
