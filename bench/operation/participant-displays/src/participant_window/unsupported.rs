//! The participant's window on a system without Unix sockets: opening it always fails.

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::time::Duration;

use protocols::Texts;
use tasks::Task;

use crate::ParticipantDisplay;
use journal::EntrySender;

/// The participant's window, which does not exist on this system.
pub struct WindowDisplay(Infallible);

/// Returns the socket's name, which no program opens on this system.
#[must_use]
pub fn default_socket() -> PathBuf {
    "participant.sock".into()
}

impl WindowDisplay {
    /// Fails: this system has no Unix sockets.
    ///
    /// # Errors
    /// Always.
    pub fn open(
        _: &Path,
        _: &Texts,
        _: Duration,
        _: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<Self> {
        anyhow::bail!(
            "the participant's window needs Linux or macOS; run without --participant-window"
        )
    }
}

impl ParticipantDisplay for WindowDisplay {
    fn name(&self) -> String {
        match self.0 {}
    }

    fn show(&mut self, _: &tui::ScreenView) {
        match self.0 {}
    }

    fn loss(&mut self) -> Option<String> {
        match self.0 {}
    }

    fn task(&mut self, _: &EntrySender) -> Option<Box<dyn Task>> {
        match self.0 {}
    }
}
