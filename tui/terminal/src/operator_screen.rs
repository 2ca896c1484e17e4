//! Set-up of the terminal for the dashboard, and its restoration.

use std::io::{self, IsTerminal, Write};
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use ratatui::crossterm::style::Print;
use ratatui::crossterm::{cursor, execute, terminal};

use crate::error::TerminalError;
use crate::frames::{FrameWriter, Frames};

/// Requests reports of mouse buttons, which include the wheel, but not of mouse movements.
const MOUSE_ON: &str = "\x1b[?1000h\x1b[?1006h";
const MOUSE_OFF: &str = "\x1b[?1006l\x1b[?1000l";

/// Returns columns and rows of the terminal on standard output; `None` if standard output is not a terminal.
#[must_use]
pub fn size() -> Option<(u16, u16)> {
    #[cfg(unix)]
    {
        let size = rustix::termios::tcgetwinsize(io::stdout()).ok()?;
        Some((size.ws_col, size.ws_row))
    }
    #[cfg(not(unix))]
    {
        let is_terminal = io::stdout().is_terminal();
        is_terminal.then(|| terminal::size().ok()).flatten()
    }
}

/// Returns whether the terminal only prints lines, by the variable `TERM`.
#[must_use]
pub fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|kind| kind == "dumb")
}

/// Restores the operator's terminal and prints the reports that waited for it. Harmless if called twice, from any
/// thread, or if the dashboard was never shown. Errors are ignored: the terminal is the only place to report them.
pub fn restore() {
    if IS_ON_SCREEN.swap(false, Ordering::SeqCst) {
        let _ = terminal::disable_raw_mode();
        let _ = execute!(
            io::stdout(),
            Print(MOUSE_OFF),
            terminal::LeaveAlternateScreen,
            cursor::Show
        );
    }
    let reports = std::mem::take(
        &mut *WAITING_REPORTS
            .lock()
            .unwrap_or_else(PoisonError::into_inner),
    );
    reports.iter().for_each(|line| say(line));
}

/// Reports a panic in any thread in `words`, in place of the hook installed before. While the dashboard is shown, the
/// report waits for [`restore`]: the terminal is restored last, at the end of the dashboard, after an orderly end of
/// the bench. Only a panic of the main thread, which waits for the dashboard, restores it at once.
///
/// Call it once, early. Hooks that make a bench safe are installed after it and so run before it: writing to a terminal
/// can block.
pub fn install_panic_hook(words: impl Fn(&PanicHookInfo<'_>) -> String + Send + Sync + 'static) {
    std::panic::set_hook(Box::new(move |info| {
        let line = words(info);
        let is_main = std::thread::current().name() == Some("main");
        if IS_ON_SCREEN.load(Ordering::SeqCst) && !is_main {
            WAITING_REPORTS
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(line);
        } else {
            restore();
            say(&line);
        }
    }));
}

/// Panic reports to print after the terminal is restored.
static WAITING_REPORTS: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn say(line: &str) {
    // An error of standard error itself is ignored.
    let _ = writeln!(standard_streams::stderr(), "{line}");
}

/// Whether the dashboard has the terminal in raw mode and on the alternate screen.
static IS_ON_SCREEN: AtomicBool = AtomicBool::new(false);

/// Longest wait for a blocked terminal at the end.
const PATIENCE: Duration = Duration::from_millis(250);

/// The terminal while the dashboard is shown on it; restored when dropped.
#[derive(Debug)]
pub struct OperatorScreen {
    frames: Frames,
}

impl OperatorScreen {
    /// Sets up this process's terminal; the writer takes its frames.
    ///
    /// # Errors
    /// [`TerminalError::NoTerminal`] if standard input or output is not a terminal, [`TerminalError::Dumb`] if it understands
    /// no commands, [`TerminalError::Terminal`] if it fails.
    pub fn enter() -> Result<(Self, FrameWriter), TerminalError> {
        if !io::stdin().is_terminal() || !io::stdout().is_terminal() {
            return Err(TerminalError::NoTerminal(io::Error::from(
                io::ErrorKind::NotFound,
            )));
        }
        if is_dumb() {
            return Err(TerminalError::Dumb);
        }
        let failure = || TerminalError::while_doing("setting it up");
        let mut writer = FrameWriter::start(output().map_err(failure())?).map_err(failure())?;
        terminal::enable_raw_mode().map_err(TerminalError::NoTerminal)?;
        IS_ON_SCREEN.store(true, Ordering::SeqCst);
        let frames = writer.frames();
        let screen = Self { frames };
        execute!(
            writer,
            terminal::EnterAlternateScreen,
            terminal::Clear(terminal::ClearType::All),
            cursor::Hide,
            Print(MOUSE_ON)
        )
        .map_err(failure())?;
        Ok((screen, writer))
    }

    /// Returns the status of the frames, which says whether the terminal blocks.
    #[must_use]
    pub fn frames(&self) -> &Frames {
        &self.frames
    }
}

impl Drop for OperatorScreen {
    fn drop(&mut self) {
        if !self.frames.wait(PATIENCE) {
            // The terminal must be restored, and the program's last messages printed, even if it blocked.
            discard();
            self.frames.wait(PATIENCE);
        }
        restore();
    }
}

/// Returns this process's standard output, for a thread that may block in it: no other thread should wait for its lock.
///
/// # Errors
/// The system's error.
fn output() -> io::Result<impl Write + Send + 'static> {
    #[cfg(unix)]
    return Ok(std::fs::File::from(rustix::io::dup(io::stdout())?));
    #[cfg(not(unix))]
    return Ok(io::stdout());
}

/// Discards output that the terminal has not accepted, and resumes it.
fn discard() {
    #[cfg(unix)]
    {
        use rustix::termios::{Action, QueueSelector, tcflow, tcflush};
        // A terminal that is gone has nothing to discard.
        let _ = tcflow(io::stdout(), Action::OOn);
        let _ = tcflush(io::stdout(), QueueSelector::OFlush);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restoring_an_unused_terminal_does_nothing() {
        restore();
        restore();
    }
}
