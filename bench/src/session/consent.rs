//! The participant's consent, and the questions that follow it before anything is driven.

use protocols::{OperatorCommand, Person};
use tui::calibration_page::Reply;

use super::questions::Questions;

/// Consent and its questions.
pub(super) struct Consent {
    questions: Questions,
    /// Operator of a recorded consent that waits for the answers to the questions.
    operator: Option<String>,
}

/// Effects of an answer.
#[derive(Debug, Default)]
pub(super) struct AnswerEffects {
    /// New content of the screen.
    pub(super) event: Option<tui::Event>,
    /// Details stated about the participant.
    pub(super) person: Option<Person>,
    /// The consent, once no question is open.
    pub(super) command: Option<OperatorCommand>,
}

impl Consent {
    /// Creates a consent that has not been recorded yet.
    pub(super) fn new(questions: Questions) -> Self {
        Self {
            questions,
            operator: None,
        }
    }

    /// Takes the consent; it is passed on once the questions about the participant are answered.
    pub(super) fn give(&mut self, operator: String) -> AnswerEffects {
        if self.questions.are_open() {
            self.operator = Some(operator);
            return AnswerEffects {
                event: Some(self.questions.current()),
                ..AnswerEffects::default()
            };
        }
        AnswerEffects {
            command: Some(OperatorCommand::ConsentGiven { by: operator }),
            ..AnswerEffects::default()
        }
    }

    /// Takes a reply to the current question; ignores a reply without a question.
    pub(super) fn reply(&mut self, reply: Reply) -> AnswerEffects {
        if self.operator.is_none() {
            return AnswerEffects::default();
        }
        let person = self.questions.reply(reply);
        let operator = self.operator.take_if(|_| !self.questions.are_open());
        AnswerEffects {
            event: Some(self.questions.current()),
            person,
            command: operator.map(|operator| OperatorCommand::ConsentGiven { by: operator }),
        }
    }
}
