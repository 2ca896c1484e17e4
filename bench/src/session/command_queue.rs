//! The operator's commands, and the consent with the questions that follow it before anything is driven.

use std::collections::VecDeque;

use protocols::{OperatorCommand, Person, Phase};
use tui::calibration_page::Reply;

use operator_ui::questions::Questions;

/// Commands that wait for the protocol's state machine. The consent joins them once no question is open.
pub(super) struct CommandQueue {
    commands: VecDeque<OperatorCommand>,
    questions: Questions,
    /// Operator of a recorded consent that waits for the answers to the questions.
    consent_by: Option<String>,
    /// Consent with its answers, which a stop during the questions may defer.
    consent: Option<OperatorCommand>,
}

impl CommandQueue {
    /// Creates an empty queue; the consent has not been recorded yet.
    pub(super) fn new(questions: Questions) -> Self {
        Self {
            commands: VecDeque::new(),
            questions,
            consent_by: None,
            consent: None,
        }
    }

    /// Adds a command.
    pub(super) fn push(&mut self, command: OperatorCommand) {
        self.commands.push_back(command);
    }

    /// Takes the oldest command; a consent after its questions in `phase` of consent alone.
    pub(super) fn pop(&mut self, phase: Phase) -> Option<OperatorCommand> {
        let consent = || self.consent.take_if(|_| phase == Phase::Consent);
        self.commands.pop_front().or_else(consent)
    }

    /// Returns whether no command waits.
    pub(super) fn is_empty(&self) -> bool {
        self.commands.is_empty() && self.consent.is_none()
    }

    /// Takes the consent; returns the first open question for the screen, if there is one.
    pub(super) fn consent(&mut self, operator: String) -> Option<tui::Event> {
        if self.questions.are_open() {
            self.consent_by = Some(operator);
            return Some(self.questions.current());
        }
        self.push(OperatorCommand::ConsentGiven { by: operator });
        None
    }

    /// Takes a reply to the current question; ignores a reply without a question. Returns the screen's new content, and
    /// the details stated about the participant once no question is open.
    pub(super) fn reply(&mut self, reply: Reply) -> Option<(tui::Event, Option<Person>)> {
        self.consent_by.as_ref()?;
        let person = self.questions.reply(reply);
        if !self.questions.are_open() {
            let operator = self.consent_by.take();
            self.consent = operator.map(|by| OperatorCommand::ConsentGiven { by });
        }
        Some((self.questions.current(), person))
    }
}

#[cfg(test)]
mod tests {
    use protocols::PersonDetail;

    use super::*;

    /// Regression test: answers that were given while the drive was stopped lost the consent.
    #[test]
    fn a_consent_with_its_answers_waits_until_it_is_awaited() {
        let mut queue = CommandQueue::new(Questions::new(vec![PersonDetail::Age]));
        assert!(queue.consent("A. Tester".to_owned()).is_some());
        assert!(queue.reply(Reply::Number(31.0)).is_some());
        assert!(!queue.is_empty());
        queue.push(OperatorCommand::Resume);
        assert_eq!(queue.pop(Phase::Fault), Some(OperatorCommand::Resume));
        assert_eq!(queue.pop(Phase::Fault), None);
        let consent = OperatorCommand::ConsentGiven {
            by: "A. Tester".to_owned(),
        };
        assert_eq!(queue.pop(Phase::Consent), Some(consent));
        assert!(queue.is_empty());
    }
}
