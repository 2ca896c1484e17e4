//! The participant's consent, and the questions that follow it before anything is driven.

use protocols::{OperatorCommand, Person};
use tui::calibration_page::Reply;

use super::questions::Questions;

/// Consent and its questions.
pub(super) struct Consent {
    questions: Questions,
    /// Operator of a recorded consent that waits for the answers to the questions.
    by: Option<String>,
}

/// Effects of an answer.
#[derive(Debug, Default)]
pub(super) struct Answered {
    /// New content of the screen.
    pub(super) shown: Option<tui::Event>,
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
            by: None,
        }
    }

    /// Takes the consent; it is passed on once the questions about the participant are answered.
    pub(super) fn given(&mut self, by: String) -> Answered {
        if self.questions.are_open() {
            self.by = Some(by);
            return Answered {
                shown: Some(self.questions.current()),
                ..Answered::default()
            };
        }
        Answered {
            command: Some(OperatorCommand::ConsentGiven { by }),
            ..Answered::default()
        }
    }

    /// Takes a reply to the current question; ignores a reply without a question.
    pub(super) fn replied(&mut self, reply: Reply) -> Answered {
        if self.by.is_none() {
            return Answered::default();
        }
        let person = self.questions.reply(reply);
        let by = self.by.take_if(|_| !self.questions.are_open());
        Answered {
            shown: Some(self.questions.current()),
            person,
            command: by.map(|by| OperatorCommand::ConsentGiven { by }),
        }
    }
}
