//! The participant's screen on a system without Unix terminal devices: opening it always fails.

use std::convert::Infallible;
use std::path::Path;

use super::error::DisplayError;
use super::loss::DisplayLoss;
use crate::participant_screen::ScreenView;
use drawing::theme::Theme;

/// The participant's screen on a separate terminal; on this system none can be opened.
#[derive(Debug)]
pub struct ParticipantTerminal(Infallible);

impl ParticipantTerminal {
    /// Always fails: a second terminal needs Unix.
    ///
    /// # Errors
    /// Always [`DisplayError::NeedsUnix`].
    pub fn open(path: &Path, _: Theme) -> Result<Self, DisplayError> {
        Err(DisplayError::NeedsUnix {
            path: path.to_owned(),
        })
    }

    /// Shows `view`.
    pub fn show(&self, _: ScreenView) {
        match self.0 {}
    }

    /// Returns why the participant cannot see the screen.
    #[must_use]
    pub fn lost(&self) -> Option<DisplayLoss> {
        match self.0 {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_terminal_can_be_opened_and_the_error_names_it() {
        let result = ParticipantTerminal::open(Path::new("COM7"), Theme::Mono);
        assert!(
            matches!(&result, Err(DisplayError::NeedsUnix { path }) if path == Path::new("COM7"))
        );
    }
}
