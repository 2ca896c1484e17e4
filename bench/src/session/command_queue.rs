//! The operator's commands, and the consent with the questions that follow it before anything is driven.

use std::collections::VecDeque;

use protocols::{OperatorCommand, Person};
use tui::calibration_page::Reply;

use operator_ui::questions::Questions;

/// Commands that wait for the protocol's state machine. The consent joins them once no question is open.
pub(super) struct CommandQueue {
    commands: VecDeque<OperatorCommand>,
    questions: Questions,
    /// Operator of a recorded consent that waits for the answers to the questions.
    consent_by: Option<String>,
}

impl CommandQueue {
    /// Creates an empty queue; the consent has not been recorded yet.
    pub(super) fn new(questions: Questions) -> Self {
        Self {
            commands: VecDeque::new(),
            questions,
            consent_by: None,
        }
    }

    /// Adds a command.
    pub(super) fn push(&mut self, command: OperatorCommand) {
        self.commands.push_back(command);
    }

    /// Takes the oldest command.
    pub(super) fn pop(&mut self) -> Option<OperatorCommand> {
        self.commands.pop_front()
    }

    /// Returns whether no command waits.
    pub(super) fn is_empty(&self) -> bool {
        self.commands.is_empty()
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
            let consent = self.consent_by.take();
            let consent = consent.map(|operator| OperatorCommand::ConsentGiven { by: operator });
            self.commands.extend(consent);
        }
        Some((self.questions.current(), person))
    }
}
