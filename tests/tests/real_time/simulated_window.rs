//! A simulated participant's window: it connects to the session's socket and sends the messages a test chooses.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use bench_tests::running::wait_until;
use participant_window::message::{Display, FORMAT, FromWindow, ToWindow};
use participant_window::{LineConnection, place};

/// Time between two looks at the socket.
const PERIOD: Duration = Duration::from_millis(100);

/// A window at a session's socket, until it is closed.
pub struct Window {
    messages: Sender<FromWindow>,
    thread: JoinHandle<()>,
}

impl Window {
    /// Connects to the session that opens a socket.
    pub fn connect(socket: PathBuf) -> Self {
        let (sender, receiver) = channel();
        let thread = std::thread::spawn(move || run(&socket, &receiver));
        Self {
            messages: sender,
            thread,
        }
    }

    pub fn say(&self, message: FromWindow) {
        let _result = self.messages.send(message);
    }

    /// Closes the window.
    pub fn close(self) {
        drop(self.messages);
        let _result = self.thread.join();
    }
}

/// Returns the display of a simulated window.
pub(super) fn display() -> Display {
    Display {
        format: FORMAT,
        monitor: "HDMI-1".to_owned(),
        width_px: 1920,
        height_px: 1080,
        pixel_m: 2.5e-4,
        refresh_s: 1.0 / 60.0,
        virtual_display: false,
    }
}

fn run(socket: &Path, messages: &Receiver<FromWindow>) {
    let Some(stream) = wait_until(Duration::from_secs(60), || place::connect(socket).ok()?) else {
        return;
    };
    let Ok(mut lines) = LineConnection::new(stream) else {
        return;
    };
    let mut message = FromWindow::Ready(display());
    while lines.send(&message).is_ok() && lines.receive::<ToWindow>(1000).is_ok() {
        message = match messages.recv_timeout(PERIOD) {
            Ok(message) => message,
            Err(RecvTimeoutError::Timeout) => FromWindow::Alive,
            Err(RecvTimeoutError::Disconnected) => return,
        };
    }
}
