//! A pseudo-terminal, read from its other end.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// Closed on exec from the start if the system supports it: another test may start a process at any time.
#[cfg(target_os = "linux")]
const FLAGS: OpenptFlags = OpenptFlags::RDWR
    .union(OpenptFlags::NOCTTY)
    .union(OpenptFlags::CLOEXEC);
#[cfg(not(target_os = "linux"))]
const FLAGS: OpenptFlags = OpenptFlags::RDWR.union(OpenptFlags::NOCTTY);

/// Timeout far above the duration of any step here, reached only by a failure.
pub const PATIENCE: Duration = Duration::from_secs(20);

pub struct Screen {
    pub path: PathBuf,
    pub controller: File,
    pub output: Receiver<Vec<u8>>,
    unread: String,
}

impl Screen {
    pub fn new(columns: u16, rows: u16) -> Self {
        let controller = openpt(FLAGS).unwrap();
        fcntl_setfd(&controller, FdFlags::CLOEXEC).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let name = ptsname(&controller, Vec::new()).unwrap();
        let controller = File::from(controller);
        let mut reader = controller.try_clone().unwrap();
        let (writer, output) = mpsc::channel();
        thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(n @ 1..) = reader.read(&mut bytes) {
                if writer.send(bytes[..n].to_vec()).is_err() {
                    break;
                }
            }
        });
        let screen = Self {
            path: Path::new(OsStr::from_bytes(name.as_bytes())).to_owned(),
            controller,
            output,
            unread: String::new(),
        };
        screen.resize(columns, rows);
        screen
    }

    pub fn resize(&self, columns: u16, rows: u16) {
        let size = Winsize {
            ws_row: rows,
            ws_col: columns,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&self.controller, size).unwrap();
    }

    /// Waits until `words` have been written, and drops all output up to them.
    pub fn wait_for(&mut self, words: &str) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(start) = self.unread.find(words) {
                self.unread.drain(..start + words.len());
                return;
            }
            let timeout = deadline.saturating_duration_since(Instant::now());
            let bytes = self.output.recv_timeout(timeout);
            let bytes = bytes.unwrap_or_else(|_| panic!("{words:?} never came: {:?}", self.unread));
            self.unread.push_str(&String::from_utf8_lossy(&bytes));
        }
    }
}
