//! The participant's screen on a terminal of its own, for example a second monitor's `/dev/tty2`.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::{cursor, execute, terminal};
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};
use rustix::fs::OFlags;

use crate::participant_screen::{self, ParticipantView};
use crate::theme::Theme;

const FRAME: Duration = Duration::from_millis(16);
/// A resize is noticed after this long even when nothing new is shown.
const LOOK_AGAIN: Duration = Duration::from_millis(250);
/// How long `drop` waits for the terminal to be put back; one that stands still must not hold the bench.
const FAREWELL: Duration = Duration::from_millis(200);

/// Why the participant's screen could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The device could not be opened.
    #[error(
        "participant screen {path}: {source}; give a terminal device that this user may write to"
    )]
    Open {
        /// The device.
        path: PathBuf,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
    /// The device is not a terminal.
    #[error(
        "participant screen {path} is not a terminal; give one such as /dev/tty2 or /dev/pts/7"
    )]
    NotATerminal {
        /// The device.
        path: PathBuf,
    },
    /// The system would not start a thread.
    #[error("participant screen: no thread: {0}")]
    Thread(#[source] io::Error),
}

/// The participant's screen on a terminal of its own. It reads no keys.
///
/// A thread of its own draws the latest view; [`show`](Self::show) only leaves it there and never blocks. When the
/// terminal goes away the thread ends, and [`is_alive`](Self::is_alive) tells so.
#[derive(Debug)]
pub struct ParticipantDisplay {
    slot: Arc<Slot>,
    ended: Receiver<()>,
    alive: std::cell::Cell<bool>,
}

#[derive(Debug, Default)]
struct Slot {
    latest: Mutex<Latest>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Latest {
    view: Option<ParticipantView>,
    closed: bool,
}

impl ParticipantDisplay {
    /// Opens the terminal device at `path` and starts drawing on it.
    ///
    /// # Errors
    /// When the device cannot be opened or is not a terminal.
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
        let slot = Arc::new(Slot::default());
        let (ending, ended) = mpsc::sync_channel(1);
        let shown = Arc::clone(&slot);
        thread::Builder::new()
            .name("participant-screen".to_owned())
            .spawn(move || {
                // A terminal that is gone shows nothing more; the operator sees it by `is_alive`.
                let _ = draw_until_closed(device, &shown, theme);
                let _ = ending.try_send(());
            })
            .map_err(DisplayError::Thread)?;
        Ok(Self {
            slot,
            ended,
            alive: std::cell::Cell::new(true),
        })
    }

    /// Shows `view` as soon as the terminal takes it; an older one not yet drawn is forgotten.
    pub fn show(&self, view: ParticipantView) {
        self.slot.update(|latest| latest.view = Some(view));
    }

    /// The terminal still takes what is drawn.
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
        self.slot.update(|latest| latest.closed = true);
        if self.alive.get() {
            let _ = self.ended.recv_timeout(FAREWELL);
        }
    }
}

impl Slot {
    fn update(&self, change: impl FnOnce(&mut Latest)) {
        // Nothing is left half-done under this lock, so a poisoned one is as good as any.
        change(&mut self.latest.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
    }

    /// Waits a while for news; the newest view if there is one, and whether to close.
    fn take(&self, timeout: Duration) -> (Option<ParticipantView>, bool) {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut latest, _) = self
            .changed
            .wait_timeout_while(latest, timeout, |l| l.view.is_none() && !l.closed)
            .unwrap_or_else(PoisonError::into_inner);
        (latest.view.take(), latest.closed)
    }
}

fn draw_until_closed(device: File, slot: &Slot, theme: Theme) -> io::Result<()> {
    let mut farewell = Farewell(device.try_clone()?);
    execute!(farewell.0, terminal::EnterAlternateScreen, cursor::Hide)?;
    let mut area = size(&device)?;
    let mut terminal = blank(&device, area)?;
    let mut shown: Option<ParticipantView> = None;
    loop {
        let (news, closed) = slot.take(LOOK_AGAIN);
        if closed {
            return Ok(());
        }
        let now = size(&device)?;
        let resized = now != area;
        if resized {
            area = now;
            terminal = blank(&device, area)?;
        }
        let fresh = news.is_some();
        shown = news.or(shown);
        if let (true, Some(view)) = (fresh || resized, &shown) {
            terminal.draw(|frame| {
                participant_screen::view(view, theme, frame.area(), frame.buffer_mut());
            })?;
        }
        thread::sleep(FRAME);
    }
}

/// Clears the screen for a fresh start. A fixed viewport, and a new one for each size, because ratatui would ask for
/// the size and the cursor of the operator's terminal instead.
fn blank(device: &File, area: Rect) -> io::Result<Terminal<CrosstermBackend<File>>> {
    let mut device = device.try_clone()?;
    execute!(device, terminal::Clear(terminal::ClearType::All))?;
    let viewport = Viewport::Fixed(area);
    Terminal::with_options(CrosstermBackend::new(device), TerminalOptions { viewport })
}

fn size(device: &File) -> io::Result<Rect> {
    let size = rustix::termios::tcgetwinsize(device)?;
    // A line without a known size, such as a serial terminal, says 0 × 0.
    if size.ws_col == 0 || size.ws_row == 0 {
        return Ok(Rect::new(0, 0, 80, 24));
    }
    Ok(Rect::new(0, 0, size.ws_col, size.ws_row))
}

struct Farewell(File);

impl Drop for Farewell {
    fn drop(&mut self) {
        let _ = execute!(self.0, terminal::LeaveAlternateScreen, cursor::Show);
        let _ = self.0.flush();
    }
}
