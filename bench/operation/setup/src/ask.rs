//! Sources of answers to the questions of `init`: a person at a terminal, or the options alone.

use std::io::{self, Write};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};
use crossterm::style::Print;
use crossterm::{cursor, execute};
use inquire::error::InquireResult;
use inquire::list_option::ListOption;
use inquire::{Confirm, Select, Text};
use standard_streams::transcribe;

/// Interval at which a waiting question checks for a signal.
const GLANCE: Duration = Duration::from_millis(50);

/// Columns of the mark before a choice, and one that stays free.
const MARK_COLUMNS: usize = 3;
/// Columns of the mark before a question and of the blank after it, and one that stays free.
const QUESTION_COLUMNS: usize = 4;
/// Fewest columns of a terminal whose choices are cut: on a narrower one they would all look alike.
const LEAST_COLUMNS: usize = 40;

/// A question with the option that answers it.
pub struct Question<'a> {
    /// Text of the question.
    pub text: &'a str,
    /// Option, such as `--rig`.
    pub option: &'a str,
}

/// A source of answers.
pub trait Ask {
    /// Returns the index of the chosen entry.
    ///
    /// # Errors
    /// If no operator is present to choose, or the operator quits.
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize>;

    /// Returns a text answer.
    ///
    /// # Errors
    /// If no operator is present to answer, or the operator quits.
    fn text(&mut self, question: &Question<'_>, usual: &str) -> anyhow::Result<String>;

    /// Returns whether the operator confirms an action now; `false` if no operator is present.
    ///
    /// # Errors
    /// If the operator quits.
    fn confirm(&mut self, text: &str) -> anyhow::Result<bool>;
}

/// A person at a terminal.
pub struct Terminal {
    is_ended: Box<dyn Fn() -> bool>,
}

impl Terminal {
    /// Creates a terminal that asks until `is_ended` returns true, such as after a signal.
    pub fn new(is_ended: impl Fn() -> bool + 'static) -> Self {
        let is_ended = Box::new(is_ended);
        Self { is_ended }
    }

    /// Waits for the answer. The prompt runs on a separate thread because it waits for keys only.
    ///
    /// # Errors
    /// If the prompt fails, or a signal comes first; the terminal is then restored.
    fn answer<T: Send + 'static>(
        &self,
        prompt: impl FnOnce() -> InquireResult<T> + Send + 'static,
    ) -> anyhow::Result<T> {
        let (sender, receiver) = mpsc::sync_channel(1);
        thread::Builder::new()
            .name("prompt".to_owned())
            .spawn(move || sender.send(prompt()))
            .context("cannot ask")?;
        loop {
            match receiver.recv_timeout(GLANCE) {
                Ok(answer) => return Ok(answer?),
                Err(RecvTimeoutError::Disconnected) => bail!("the question failed"),
                Err(RecvTimeoutError::Timeout) if (self.is_ended)() => {
                    // The terminal may have closed.
                    let _ = crossterm::terminal::disable_raw_mode();
                    let _ = execute!(io::stderr(), cursor::Show, Print("\n"));
                    bail!("ended by a signal");
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }
}

impl Ask for Terminal {
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize> {
        let text = transcribe(question.text).into_owned();
        let columns = crossterm::terminal::size().map_or(usize::MAX, |(columns, _)| columns.into());
        let is_wide = columns >= LEAST_COLUMNS;
        let fit = move |text: &str, taken: usize| match is_wide {
            true => shortened(text, columns.saturating_sub(taken)),
            false => text.to_owned(),
        };
        let choices = choices.iter().map(|choice| transcribe(choice));
        let choices: Vec<String> = choices.map(|choice| fit(&choice, MARK_COLUMNS)).collect();
        let question_columns = QUESTION_COLUMNS + text.chars().count();
        let keys = transcribe("↑↓ to move, Enter to choose").into_owned();
        let choice = self.answer(move || {
            // The name alone is repeated beside the question.
            let name = |choice: ListOption<&String>| {
                let name = choice.value.split(": ").next();
                fit(name.unwrap_or_default(), question_columns)
            };
            // A letter that fits no choice would empty the list.
            Select::new(&text, choices)
                .without_filtering()
                .with_help_message(&keys)
                .with_formatter(&name)
                .raw_prompt()
        })?;
        Ok(choice.index)
    }

    fn text(&mut self, question: &Question<'_>, usual: &str) -> anyhow::Result<String> {
        let (text, usual) = (transcribe(question.text).into_owned(), usual.to_owned());
        self.answer(move || Text::new(&text).with_default(&usual).prompt())
    }

    fn confirm(&mut self, text: &str) -> anyhow::Result<bool> {
        // The prompt would break within words.
        let (reason, question) = text.rsplit_once(". ").unwrap_or(("", text));
        if !reason.is_empty() {
            writeln!(standard_streams::stderr(), "{reason}.")?;
        }
        let question = transcribe(question).into_owned();
        self.answer(move || Confirm::new(&question).with_default(true).prompt())
    }
}

/// Returns a choice that fits into one line of `columns`, with an ellipsis where it is cut.
fn shortened(choice: &str, columns: usize) -> String {
    if choice.chars().count() <= columns {
        return choice.to_owned();
    }
    let kept: String = choice.chars().take(columns.saturating_sub(3)).collect();
    format!("{}...", kept.trim_end())
}

/// No operator: a choice with only one entry is taken; options must answer everything else.
pub struct NoOperator;

impl Ask for NoOperator {
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize> {
        match choices {
            [_] => Ok(0),
            _ => bail!(
                "{} No terminal to ask on: give {}. Choices:\n  {}",
                question.text,
                question.option,
                choices.join("\n  ")
            ),
        }
    }

    fn text(&mut self, _: &Question<'_>, usual: &str) -> anyhow::Result<String> {
        Ok(usual.to_owned())
    }

    fn confirm(&mut self, _: &str) -> anyhow::Result<bool> {
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_takes_one_line() {
        assert_eq!(
            shortened("field-box: sound card", 21),
            "field-box: sound card"
        );
        assert_eq!(
            shortened("field-box: sound card", 20),
            "field-box: sound..."
        );
        assert_eq!(shortened("µm", 0), "...");
    }

    /// Hazard 1.
    #[test]
    fn where_nobody_is_at_a_terminal_nobody_permits_a_tone() {
        assert!(!NoOperator.confirm("Drive a tone?").unwrap());
    }
}
