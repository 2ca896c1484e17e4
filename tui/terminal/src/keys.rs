//! Keys from the operator's terminal.

use std::io;
use std::time::Duration;

use ratatui::crossterm::event::{self, KeyCode, KeyEvent, KeyModifiers, MouseEventKind};

/// A source of keys.
pub trait Keys {
    /// Waits for a key until `timeout`. Returns `Ok(None)` if no key came, or another event.
    ///
    /// # Errors
    /// An error if the terminal fails or is gone.
    fn next(&mut self, timeout: Duration) -> io::Result<Option<KeyEvent>>;
}

/// Timeout for a key that has arrived; crossterm does not check at all with a timeout of zero.
const GLANCE: Duration = Duration::from_millis(1);

/// Key that redraws the screen.
pub const REDRAW: KeyEvent = KeyEvent::new(KeyCode::Char('l'), KeyModifiers::CONTROL);

/// Sets the terminal to single keys again if it reads lines, and returns whether it did. A shell leaves it so that continues a program
/// after SIGSTOP, and the stop key would wait for Enter.
///
/// # Errors
/// An error if the terminal fails.
fn regain() -> io::Result<bool> {
    #[cfg(unix)]
    {
        use ratatui::crossterm::terminal;
        use rustix::process::getpgrp;
        use rustix::termios::{LocalModes, tcgetattr, tcgetpgrp};

        let stdin = io::stdin();
        let Ok(modes) = tcgetattr(&stdin) else {
            // The terminal is gone, which the wait for input reports.
            return Ok(false);
        };
        // In the background the system stops a program that sets the terminal by which it is controlled.
        let is_background = tcgetpgrp(&stdin).is_ok_and(|foreground| foreground != getpgrp());
        if modes.local_modes.contains(LocalModes::ICANON) && !is_background {
            // It would take the terminal to be set already.
            terminal::disable_raw_mode()?;
            terminal::enable_raw_mode()?;
            return Ok(true);
        }
    }
    Ok(false)
}

/// The keys of this process's terminal.
#[derive(Debug)]
pub struct TerminalKeys;

impl Keys for TerminalKeys {
    fn next(&mut self, timeout: Duration) -> io::Result<Option<KeyEvent>> {
        if regain()? {
            // The shell has written over the screen.
            return Ok(Some(REDRAW));
        }
        wait_for_input(timeout)?;
        // Checked even without new input: earlier input may contain several keys.
        if !event::poll(GLANCE)? {
            return Ok(None);
        }
        Ok(match event::read()? {
            event::Event::Key(key) => Some(key),
            event::Event::Mouse(mouse) => wheel(mouse.kind),
            // A resize is handled at the next drawing.
            _ => None,
        })
    }
}

/// Returns the key equivalent of a step of the mouse wheel.
fn wheel(kind: MouseEventKind) -> Option<KeyEvent> {
    let code = match kind {
        MouseEventKind::ScrollDown => KeyCode::Char('j'),
        MouseEventKind::ScrollUp => KeyCode::Char('k'),
        _ => return None,
    };
    Some(KeyEvent::new(code, KeyModifiers::NONE))
}

/// Waits for input or for the terminal's end, which crossterm's own wait would never notice.
///
/// # Errors
/// [`io::ErrorKind::BrokenPipe`] if the terminal is gone.
#[cfg(unix)]
fn wait_for_input(timeout: Duration) -> io::Result<()> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    let stdin = io::stdin();
    let mut polled = [PollFd::new(&stdin, PollFlags::IN)];
    let timeout = Timespec::try_from(timeout).map_err(io::Error::other)?;
    match poll(&mut polled, Some(&timeout)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => {}
        Err(error) => return Err(error.into()),
    }
    let hang_up = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    if polled[0].revents().intersects(hang_up) {
        return Err(io::Error::from(io::ErrorKind::BrokenPipe));
    }
    Ok(())
}

/// Waits for input.
///
/// # Errors
/// An error if the terminal fails.
#[cfg(not(unix))]
fn wait_for_input(timeout: Duration) -> io::Result<()> {
    event::poll(timeout).map(drop)
}
