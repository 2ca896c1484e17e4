//! The participant's screen on a Unix terminal device.

use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::crossterm::{cursor, execute, queue, terminal};
use ratatui::layout::Rect;
use rustix::fs::OFlags;

use super::error::DisplayError;
use super::loss::DisplayLoss;
use crate::participant_screen::{self, ScreenView};
use drawing::escape::clean;
use drawing::theme::Theme;

/// Minimum time between two frames.
const FRAME: Duration = Duration::from_millis(16);
/// Longest time until a resize is noticed without a new view.
const SIZE_CHECK: Duration = Duration::from_millis(250);
/// Longest time that `drop` waits for the terminal to be restored; a blocked terminal must not stop the bench.
const RESTORE_WAIT: Duration = Duration::from_millis(200);
/// Duration of a drawing after which the participant cannot see it.
const STUCK: Duration = Duration::from_secs(2);

/// The participant's screen on a separate terminal. It reads no keys.
///
/// A separate thread draws the latest view; [`show`](Self::show) hands the view over and never blocks. When the
/// terminal is closed the thread ends, and [`lost`](Self::lost) reports it. Dropping the display restores the terminal.
#[derive(Debug)]
pub struct ParticipantTerminal {
    latest: Arc<LatestView>,
    end: Receiver<()>,
    alive: Cell<bool>,
}

/// The newest view, handed from the bench to the drawing thread.
#[derive(Debug, Default)]
struct LatestView {
    pending: Mutex<Pending>,
    change: Condvar,
}

#[derive(Debug, Default)]
struct Pending {
    view: Option<ScreenView>,
    is_closed: bool,
    /// Start of the drawing in progress.
    drawing_since: Option<Instant>,
}

impl ParticipantTerminal {
    /// Opens the terminal device at `path` and starts drawing on it.
    ///
    /// # Errors
    /// [`DisplayError::Open`] if the device cannot be opened, [`DisplayError::NotATerminal`] if it is not a terminal,
    /// [`DisplayError::Own`] if it is the terminal of this process's output, [`DisplayError::Thread`] if the system cannot
    /// start a thread.
    pub fn open(path: &Path, theme: Theme) -> Result<Self, DisplayError> {
        // A device that is not a terminal, such as a pipe without a reader, must not block the caller.
        let flags = i32::try_from((OFlags::NOCTTY | OFlags::NONBLOCK).bits()).unwrap_or_default();
        let device = OpenOptions::new()
            .write(true)
            .custom_flags(flags)
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
        if is_own(path, &device) {
            return Err(DisplayError::Own {
                path: path.to_owned(),
            });
        }
        rustix::fs::fcntl_setfl(&device, OFlags::empty()).map_err(|error| DisplayError::Open {
            path: path.to_owned(),
            source: error.into(),
        })?;
        let latest = Arc::new(LatestView::default());
        let (end_sender, end) = mpsc::sync_channel(1);
        let shared = Arc::clone(&latest);
        thread::Builder::new()
            .name("participant-screen".to_owned())
            .spawn(move || {
                // The terminal is gone: `lost` reports it to the operator.
                let _ = draw_until_closed(device, &shared, theme);
                let _ = end_sender.try_send(());
            })
            .map_err(DisplayError::Thread)?;
        Ok(Self {
            latest,
            end,
            alive: Cell::new(true),
        })
    }

    /// Shows `view` as soon as the terminal accepts it; an older view not yet drawn is dropped.
    pub fn show(&self, view: ScreenView) {
        self.latest.update(|pending| pending.view = Some(view));
    }

    /// Returns why the participant cannot see the screen; `None` while the terminal works.
    #[must_use]
    pub fn lost(&self) -> Option<DisplayLoss> {
        if self.alive.get() && !matches!(self.end.try_recv(), Err(mpsc::TryRecvError::Empty)) {
            self.alive.set(false);
        }
        if !self.alive.get() {
            return Some(DisplayLoss::Gone);
        }
        let start = self.latest.lock().drawing_since;
        let stuck = start.is_some_and(|start| start.elapsed() > STUCK);
        stuck.then_some(DisplayLoss::Stuck)
    }
}

impl Drop for ParticipantTerminal {
    fn drop(&mut self) {
        self.latest.update(|pending| pending.is_closed = true);
        if self.alive.get() {
            let _ = self.end.recv_timeout(RESTORE_WAIT);
        }
    }
}

impl LatestView {
    fn update(&self, change: impl FnOnce(&mut Pending)) {
        // No panic can leave this lock's content half-changed, so a poisoned one is valid.
        change(&mut self.lock());
        self.change.notify_one();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Pending> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits up to `timeout` for a change. Returns the newest view if it has not been taken, and whether to close.
    fn take(&self, timeout: Duration) -> (Option<ScreenView>, bool) {
        let (mut pending, _) = self
            .change
            .wait_timeout_while(self.lock(), timeout, |p| p.view.is_none() && !p.is_closed)
            .unwrap_or_else(PoisonError::into_inner);
        (pending.view.take(), pending.is_closed)
    }
}

/// Draws each new view, and the last one again at each new size, until closed. Restores the terminal at the end.
///
/// # Errors
/// An error if the terminal cannot be written to, usually because it is gone.
fn draw_until_closed(device: File, latest: &LatestView, theme: Theme) -> io::Result<()> {
    latest.lock().drawing_since = Some(Instant::now());
    let mut guard = RestoreOnDrop(device.try_clone()?);
    execute!(guard.0, terminal::EnterAlternateScreen, cursor::Hide)?;
    let mut screen = Screen::new(&device)?;
    let mut current: Option<ScreenView> = None;
    loop {
        let (new, is_closed) = latest.take(SIZE_CHECK);
        if is_closed {
            return Ok(());
        }
        latest.lock().drawing_since = Some(Instant::now());
        let is_resized = screen.follow(size(&device)?)?;
        let is_changed = is_resized || new.is_some();
        current = new.or(current);
        if let (true, Some(view)) = (is_changed, &current) {
            screen.draw(view, theme)?;
        }
        latest.lock().drawing_since = None;
        thread::sleep(FRAME);
    }
}

/// The terminal's contents. Not a [`ratatui::Terminal`], which queries the operator's terminal for its size and cursor,
/// and prints errors there when the participant's terminal is gone.
struct Screen {
    out: CrosstermBackend<BufWriter<File>>,
    buffer: Buffer,
}

impl Screen {
    /// Returns a screen that still has to be cleared.
    fn new(device: &File) -> io::Result<Self> {
        Ok(Self {
            out: CrosstermBackend::new(BufWriter::with_capacity(1 << 16, device.try_clone()?)),
            buffer: Buffer::default(),
        })
    }

    /// Clears the screen if `area` has changed, and returns whether it has.
    fn follow(&mut self, area: Rect) -> io::Result<bool> {
        let is_resized = area != self.buffer.area;
        if is_resized {
            self.buffer = Buffer::empty(area);
            execute!(self.out, terminal::Clear(terminal::ClearType::All))?;
        }
        Ok(is_resized)
    }

    /// Writes the changes as one update of the screen.
    fn draw(&mut self, view: &ScreenView, theme: Theme) -> io::Result<()> {
        let mut next = Buffer::empty(self.buffer.area);
        participant_screen::view(view, theme, next.area, &mut next);
        clean(&mut next);
        queue!(self.out, terminal::BeginSynchronizedUpdate)?;
        self.out.draw(self.buffer.diff(&next).into_iter())?;
        queue!(self.out, terminal::EndSynchronizedUpdate)?;
        Backend::flush(&mut self.out)?;
        self.buffer = next;
        Ok(())
    }
}

/// Whether `device` is this process's own terminal.
fn is_own(path: &Path, device: &File) -> bool {
    let stdout = io::stdout();
    if !rustix::termios::isatty(&stdout) {
        return false;
    }
    let number = |stat: rustix::io::Result<rustix::fs::Stat>| stat.ok().map(|stat| stat.st_rdev);
    path == Path::new("/dev/tty")
        || number(rustix::fs::fstat(device)) == number(rustix::fs::fstat(&stdout))
}

/// Returns the terminal's size, or 80 × 24 if it is not known.
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
