//! The participant's displays: their content, and whether the participant can see it.
//!
//! A lost display raises an alarm and pauses the session. It may reconnect automatically or when the operator resumes,
//! but only the operator resumes the session.

pub mod participant_window;

use std::path::{Path, PathBuf};

use std::time::Duration;

use anyhow::{Context, bail};
use tasks::Task;
use tui::event::LogLevel;

use journal::EntrySender;

/// Timeout for opening a participant's terminal, including the wait for the lost one. The drive is off meanwhile.
const OPENS_WITHIN: Duration = Duration::from_millis(500);

/// A display in front of the participant. No method may block: the session calls them many times a second.
pub trait ParticipantDisplay: Send {
    /// Name for the operator, such as "the participant's window".
    fn name(&self) -> String;

    /// Shows `view` as soon as possible; an older view not yet shown is dropped.
    fn show(&mut self, view: &tui::ScreenView);

    /// Takes the current time on the bench's clock, and the finger's position along the plate.
    fn beat(&mut self, _audio_s: f64, _position_m: Option<f64>) {}

    /// Returns the notices for the operator since the last call.
    fn notices(&mut self) -> Vec<(LogLevel, String)> {
        Vec::new()
    }

    /// Returns, once, the task that the display needs in addition to the session's.
    fn task(&mut self, _journal: &EntrySender) -> Option<Box<dyn Task>> {
        None
    }

    /// Returns why the participant cannot see the view; `None` while they can.
    fn loss(&mut self) -> Option<String>;

    /// Reconnects a lost display because the operator resumes. A display that reconnects automatically does nothing here.
    ///
    /// # Errors
    /// When the display cannot be reconnected, with the reason.
    fn reconnect(&mut self) -> anyhow::Result<()> {
        Ok(())
    }
}

/// All displays of a session.
#[derive(Default)]
pub struct Displays {
    displays: Vec<Box<dyn ParticipantDisplay>>,
    /// The current view.
    view: Option<tui::ScreenView>,
    /// The display that was lost at the last look, and why.
    last_loss: Option<String>,
}

impl Displays {
    /// Adds a display.
    pub fn add(&mut self, display: Box<dyn ParticipantDisplay>) {
        self.displays.push(display);
    }

    /// Shows `view` on each display.
    pub fn show(&mut self, view: &tui::ScreenView) {
        for display in &mut self.displays {
            display.show(view);
        }
        self.view = Some(view.clone());
    }

    /// Passes the time on the bench's clock and the finger's position to each display.
    pub fn beat(&mut self, audio_s: f64, position_m: Option<f64>) {
        for display in &mut self.displays {
            display.beat(audio_s, position_m);
        }
    }

    /// Returns the notices of all displays since the last call.
    pub fn notices(&mut self) -> Vec<(LogLevel, String)> {
        let displays = self.displays.iter_mut();
        displays.flat_map(|display| display.notices()).collect()
    }

    /// Returns the tasks that the displays need in addition to the session's.
    pub fn tasks(&mut self, journal: &EntrySender) -> Vec<Box<dyn Task>> {
        let displays = self.displays.iter_mut();
        displays
            .filter_map(|display| display.task(journal))
            .collect()
    }

    /// Returns whether a display was lost or all are back since the last call; once all are back, shows the current view
    /// again.
    pub fn look(&mut self) -> bool {
        let loss = self.displays.iter_mut().find_map(|display| {
            let reason = display.loss()?;
            Some(format!("{}: {reason}", display.name()))
        });
        if loss == self.last_loss {
            return false;
        }
        self.last_loss = loss;
        if self.last_loss.is_none()
            && let Some(view) = self.view.clone()
        {
            self.show(&view);
        }
        true
    }

    /// Returns which display was lost at the last [`look`](Self::look), and why.
    #[must_use]
    pub fn loss(&self) -> Option<&str> {
        self.last_loss.as_deref()
    }

    /// Reconnects lost displays because the operator resumes; returns an error for each that stays lost.
    pub fn reconnect(&mut self) -> Vec<String> {
        let errors = self.displays.iter_mut().filter_map(|display| {
            display.loss()?;
            let error = display.reconnect().err()?;
            Some(format!(
                "{}: {}",
                display.name(),
                bounded_files::cause_line(error.as_ref())
            ))
        });
        errors.collect()
    }
}

/// The participant's own terminal.
///
/// Once its window is closed, another window may get its device name, so it is reopened only when the operator resumes.
struct TerminalDisplay {
    path: PathBuf,
    terminal: Option<tui::ParticipantTerminal>,
}

/// Opens the participant's own terminal.
///
/// # Errors
/// When the device is not a terminal, is the operator's, or cannot be opened.
pub fn terminal(path: &Path) -> anyhow::Result<Box<dyn ParticipantDisplay>> {
    let mut display = TerminalDisplay {
        path: path.to_owned(),
        terminal: None,
    };
    display.reconnect()?;
    Ok(Box::new(display))
}

impl ParticipantDisplay for TerminalDisplay {
    fn name(&self) -> String {
        format!("participant's terminal {}", self.path.display())
    }

    fn show(&mut self, view: &tui::ScreenView) {
        if let Some(terminal) = &self.terminal {
            terminal.show(view.clone());
        }
    }

    fn loss(&mut self) -> Option<String> {
        let loss = match &self.terminal {
            Some(terminal) => terminal.lost()?,
            None => tui::display::DisplayLoss::Gone,
        };
        Some(loss.to_string())
    }

    fn reconnect(&mut self) -> anyhow::Result<()> {
        let (path, terminal) = (self.path.clone(), self.terminal.take());
        let (sender, receiver) = std::sync::mpsc::channel();
        // Opened on a separate thread: opening a terminal may hang, and the session must not wait.
        std::thread::Builder::new()
            .name("reconnecting".to_owned())
            .spawn(move || {
                // Drop the lost terminal first, so that it is not restored over the new one.
                drop(terminal);
                let theme = tui::chosen_theme();
                let _ = sender.send(tui::ParticipantTerminal::open(&path, theme));
            })
            .context("cannot start the thread that opens the participant's terminal")?;
        let Ok(result) = receiver.recv_timeout(OPENS_WITHIN) else {
            bail!("it does not answer: look at it, then resume again");
        };
        self.terminal = Some(result?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    #[derive(Default)]
    struct FakeState {
        loss: Option<String>,
        views: usize,
        comes_back: bool,
    }

    struct Fake(Arc<Mutex<FakeState>>);

    impl ParticipantDisplay for Fake {
        fn name(&self) -> String {
            "the window".to_owned()
        }

        fn show(&mut self, _: &tui::ScreenView) {
            self.0.lock().unwrap().views += 1;
        }

        fn loss(&mut self) -> Option<String> {
            self.0.lock().unwrap().loss.clone()
        }

        fn reconnect(&mut self) -> anyhow::Result<()> {
            let mut state = self.0.lock().unwrap();
            anyhow::ensure!(state.comes_back, "nobody there");
            state.loss = None;
            Ok(())
        }
    }

    #[test]
    fn a_lost_display_is_reported_once_and_shows_the_view_on_return() {
        let state = Arc::new(Mutex::new(FakeState::default()));
        let mut displays = Displays::default();
        assert!(!displays.look());
        displays.add(Box::new(Fake(state.clone())));
        displays.show(&view());
        assert!(!displays.look());
        state.lock().unwrap().loss = Some("closed".to_owned());
        assert!(displays.look());
        assert!(!displays.look());
        assert_eq!(displays.loss(), Some("the window: closed"));
        assert_eq!(displays.reconnect(), ["the window: nobody there"]);
        assert!(!displays.look());
        state.lock().unwrap().comes_back = true;
        assert!(displays.reconnect().is_empty());
        assert!(displays.look());
        assert_eq!(displays.loss(), None);
        assert_eq!(state.lock().unwrap().views, 2);
    }

    #[test]
    fn a_terminal_that_is_gone_is_told_without_words_of_the_system() {
        let mut displays = Displays::default();
        displays.add(Box::new(TerminalDisplay {
            path: "/dev/pts/none".into(),
            terminal: None,
        }));
        let errors = displays.reconnect();
        let [error] = errors.as_slice() else {
            panic!("{errors:?}");
        };
        assert!(
            error.contains("/dev/pts/none") && !error.contains("os error"),
            "{error}"
        );
    }

    fn view() -> tui::ScreenView {
        tui::ScreenView::default()
    }
}
