//! The participant's consent, and the questions that follow it before anything is driven.

use protocols::{OperatorCommand, Person};
use tui::calibration_page::Reply;

use super::questions::Questions;

/// Consent with its questions.
pub(super) struct Consent {
    questions: Questions,
    /// Who recorded the consent that waits for the answers to the questions.
    by: Option<String>,
}

/// What follows an answer.
#[derive(Debug, Default)]
pub(super) struct Answered {
    /// What the screen shows from now on.
    pub(super) shown: Option<tui::Event>,
    /// What was stated about the participant.
    pub(super) person: Option<Person>,
    /// The consent, once no question is open.
    pub(super) command: Option<OperatorCommand>,
}

impl Consent {
    /// Makes a consent that nobody has recorded yet.
    pub(super) fn new(questions: Questions) -> Self {
        Self {
            questions,
            by: None,
        }
    }

    /// Takes the consent, which is passed on once the questions about the participant are answered.
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

    /// Takes a reply to the current question; one without a question does nothing.
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
