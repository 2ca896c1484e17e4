//! Who answers the questions: a person at a terminal, or nobody.

use anyhow::bail;

/// A question with the option that answers it.
pub struct Question<'a> {
    /// As it is put.
    pub text: &'a str,
    /// Such as `--rig`.
    pub option: &'a str,
}

/// Who is asked.
pub trait Ask {
    /// Returns the place of the choice that was taken.
    ///
    /// # Errors
    /// If nobody is there to choose, or leaves.
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize>;

    /// Returns a text.
    ///
    /// # Errors
    /// If nobody is there to answer, or leaves.
    fn text(&mut self, question: &Question<'_>, usual: &str) -> anyhow::Result<String>;

    /// Returns whether something is to be done now.
    ///
    /// # Errors
    /// If whoever is asked leaves.
    fn confirm(&mut self, text: &str) -> anyhow::Result<bool>;
}

/// A person at a terminal.
pub struct Terminal;

impl Ask for Terminal {
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize> {
        let chosen = inquire::Select::new(question.text, choices.to_vec()).raw_prompt()?;
        Ok(chosen.index)
    }

    fn text(&mut self, question: &Question<'_>, usual: &str) -> anyhow::Result<String> {
        let asked = inquire::Text::new(question.text).with_default(usual);
        Ok(asked.prompt()?)
    }

    fn confirm(&mut self, text: &str) -> anyhow::Result<bool> {
        Ok(inquire::Confirm::new(text).with_default(true).prompt()?)
    }
}

/// Nobody: what there is only one of is taken, and all else must have been said.
pub struct Unattended;

impl Ask for Unattended {
    fn choose(&mut self, question: &Question<'_>, choices: &[String]) -> anyhow::Result<usize> {
        match choices {
            [_] => Ok(0),
            _ => bail!(
                "{} Nobody is at a terminal to say: give {}. There is:\n  {}",
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
        Ok(true)
    }
}
