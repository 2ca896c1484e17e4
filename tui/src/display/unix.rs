//! The participant's screen on a Unix terminal device.

use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::{cursor, execute, terminal};
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};
use rustix::fs::OFlags;

use super::error::DisplayError;
use crate::escape::clean;
use crate::participant_screen::{self, ParticipantView};
use crate::theme::Theme;

/// Shortest time between two drawings.
const FRAME: Duration = Duration::from_millis(16);
/// Longest time until a new size of the terminal is noticed while no new view comes.
const SIZE_CHECK: Duration = Duration::from_millis(250);
/// Longest time that `drop` waits for the terminal to be restored; a blocked one must not hold the bench.
const RESTORE_WAIT: Duration = Duration::from_millis(200);

/// The participant's screen on a terminal of its own. It reads no keys.
///
/// A thread of its own draws the latest view; [`show`](Self::show) hands the view over and never blocks. When the
/// terminal goes away the thread ends, and [`is_alive`](Self::is_alive) returns `false`. Dropping the display restores
/// the terminal.
#[derive(Debug)]
pub struct ParticipantDisplay {
    latest: Arc<LatestView>,
    ended: Receiver<()>,
    alive: Cell<bool>,
}

/// The newest view, handed from the bench to the thread that draws.
#[derive(Debug, Default)]
struct LatestView {
    pending: Mutex<Pending>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Pending {
    view: Option<ParticipantView>,
    closed: bool,
}

impl ParticipantDisplay {
    /// Opens the terminal device at `path` and starts drawing on it.
    ///
    /// # Errors
    /// [`DisplayError::Open`] when the device cannot be opened, [`DisplayError::NotATerminal`] when it is not a terminal,
    /// [`DisplayError::Thread`] when the system refuses a thread.
    pub fn open(path: &Path, theme: Theme) -> Result<Self, DisplayError> {
        let noctty = i32::try_from(OFlags::NOCTTY.bits()).unwrap_or_default();
        let device = OpenOptions::new()
            .write(true)
            .custom_flags(noctty)
            .open(path)
            .map_err(|source| DisplayError::Open {
                path: path.to_owned(),
                source,
            })?;
        if !rustix::termios::isatty(&device) {
            return Err(DisplayError::NotATerminal {
                path: path.to_owned(),
            });
        }
        let latest = Arc::new(LatestView::default());
        let (ending, ended) = mpsc::sync_channel(1);
        let shown = Arc::clone(&latest);
        thread::Builder::new()
            .name("participant-screen".to_owned())
            .spawn(move || {
                // The terminal is gone: the operator is told by `is_alive`.
                let _ = draw_until_closed(device, &shown, theme);
                let _ = ending.try_send(());
            })
            .map_err(DisplayError::Thread)?;
        Ok(Self {
            latest,
            ended,
            alive: Cell::new(true),
        })
    }

    /// Shows `view` as soon as the terminal takes it; an older view not yet drawn is dropped.
    pub fn show(&self, view: ParticipantView) {
        self.latest.update(|pending| pending.view = Some(view));
    }

    /// Whether the terminal still takes what is drawn.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        if self.alive.get() && !matches!(self.ended.try_recv(), Err(mpsc::TryRecvError::Empty)) {
            self.alive.set(false);
        }
        self.alive.get()
    }
}

impl Drop for ParticipantDisplay {
    fn drop(&mut self) {
        self.latest.update(|pending| pending.closed = true);
        if self.alive.get() {
            let _ = self.ended.recv_timeout(RESTORE_WAIT);
        }
    }
}

impl LatestView {
    fn update(&self, change: impl FnOnce(&mut Pending)) {
        // No panic can leave this lock's content half-changed, so a poisoned one is valid.
        change(&mut self.pending.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
    }

    /// Waits up to `timeout` for a change. Returns the newest view, if one was not yet taken, and whether to close.
    fn take(&self, timeout: Duration) -> (Option<ParticipantView>, bool) {
        let pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut pending, _) = self
            .changed
            .wait_timeout_while(pending, timeout, |p| p.view.is_none() && !p.closed)
            .unwrap_or_else(PoisonError::into_inner);
        (pending.view.take(), pending.closed)
    }
}

/// Draws each new view, and the last one again at each new size, until closed. Restores the terminal at the end.
///
/// # Errors
/// When the terminal cannot be written to, usually because it is gone.
fn draw_until_closed(device: File, latest: &LatestView, theme: Theme) -> io::Result<()> {
    let mut restored = RestoreOnDrop(device.try_clone()?);
    execute!(restored.0, terminal::EnterAlternateScreen, cursor::Hide)?;
    let mut area = size(&device)?;
    let mut terminal = blank(&device, area)?;
    let mut shown: Option<ParticipantView> = None;
    loop {
        let (new, closed) = latest.take(SIZE_CHECK);
        if closed {
            return Ok(());
        }
        let now = size(&device)?;
        let resized = now != area;
        if resized {
            area = now;
            terminal = blank(&device, area)?;
        }
        let changed = resized || new.is_some();
        shown = new.or(shown);
        if let (true, Some(view)) = (changed, &shown) {
            terminal.draw(|frame| {
                participant_screen::view(view, theme, frame.area(), frame.buffer_mut());
                clean(frame.buffer_mut());
            })?;
        }
        thread::sleep(FRAME);
    }
}

/// Clears the screen and returns a terminal of that size. Its viewport is fixed, and made anew for each size, because
/// ratatui would otherwise ask for the size and the cursor of the operator's terminal.
fn blank(device: &File, area: Rect) -> io::Result<Terminal<CrosstermBackend<File>>> {
    let mut device = device.try_clone()?;
    execute!(device, terminal::Clear(terminal::ClearType::All))?;
    let viewport = Viewport::Fixed(area);
    Terminal::with_options(CrosstermBackend::new(device), TerminalOptions { viewport })
}

/// Returns the terminal's size, or 80 × 24 where it is not known.
fn size(device: &File) -> io::Result<Rect> {
    let size = rustix::termios::tcgetwinsize(device)?;
    // A terminal that does not know its size, such as a serial one, reports 0 × 0.
    if size.ws_col == 0 || size.ws_row == 0 {
        return Ok(Rect::new(0, 0, 80, 24));
    }
    Ok(Rect::new(0, 0, size.ws_col, size.ws_row))
}

/// Leaves the alternate screen and shows the cursor when dropped.
struct RestoreOnDrop(File);

impl Drop for RestoreOnDrop {
    fn drop(&mut self) {
        let _ = execute!(self.0, terminal::LeaveAlternateScreen, cursor::Show);
        let _ = self.0.flush();
    }
}
