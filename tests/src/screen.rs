//! A separate terminal for a program, and everything shown on it.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

/// A pseudo-terminal; its output is read until `stop_reading`.
pub struct Screen {
    controller: File,
    path: PathBuf,
    output: Arc<Mutex<Vec<u8>>>,
    is_read: Arc<AtomicBool>,
    reader: JoinHandle<()>,
}

impl Screen {
    /// Opens a terminal of `columns` and `rows`.
    ///
    /// # Panics
    /// When the system has none available.
    #[must_use]
    pub fn open(columns: u16, rows: u16) -> Self {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let controller = openpt(flags).expect("a pseudo-terminal");
        grantpt(&controller).expect("a pseudo-terminal of this user");
        unlockpt(&controller).expect("an open pseudo-terminal");
        let size = Winsize {
            ws_row: rows,
            ws_col: columns,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&controller, size).expect("a size");
        let path = ptsname(&controller, Vec::new())
            .expect("a name")
            .into_string()
            .expect("a name in UTF-8");
        let controller = File::from(controller);
        let mut source = controller.try_clone().expect("a second handle");
        let output = Arc::new(Mutex::new(Vec::new()));
        let is_read = Arc::new(AtomicBool::new(true));
        let (buffer, is_reading) = (Arc::clone(&output), Arc::clone(&is_read));
        let reader = std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while is_reading.load(Ordering::Relaxed)
                // Fails once no program has the terminal open.
                && let Ok(n @ 1..) = source.read(&mut bytes)
            {
                buffer
                    .lock()
                    .expect("no reader panics")
                    .extend_from_slice(&bytes[..n]);
            }
        });
        Self {
            controller,
            path: path.into(),
            output,
            is_read,
            reader,
        }
    }

    /// Connects `command` to the terminal.
    ///
    /// # Panics
    /// When the terminal cannot be opened.
    pub fn attach(&self, command: &mut Command) {
        let end = || self.end();
        command.stdin(end()).stdout(end()).stderr(end());
    }

    /// Types `keys`.
    ///
    /// # Panics
    /// When the terminal is gone.
    pub fn press(&mut self, keys: &str) {
        let result = self.controller.write_all(keys.as_bytes());
        result.expect("the terminal takes keys");
    }

    /// Returns everything shown so far.
    ///
    /// # Panics
    /// When the reader panicked.
    #[must_use]
    pub fn output(&self) -> String {
        String::from_utf8_lossy(&self.output.lock().expect("no reader panics")).into_owned()
    }

    /// Returns the local modes of the terminal, for lines and echo.
    ///
    /// # Panics
    /// When the terminal is gone.
    #[must_use]
    pub fn local_modes(&self) -> LocalModes {
        let modes = tcgetattr(&self.controller);
        modes.expect("a terminal has modes").local_modes
    }

    /// Stops reading, so that the terminal's buffer fills.
    pub fn stop_reading(&self) {
        self.is_read.store(false, Ordering::Relaxed);
    }

    /// Returns whether the terminal accepts more output from the program.
    ///
    /// # Panics
    /// When the terminal is gone.
    #[must_use]
    pub fn accepts_output(&self) -> bool {
        let end = self.end();
        let mut events = [PollFd::new(&end, PollFlags::OUT)];
        poll(&mut events, Some(&Timespec::default())).expect("a terminal can be asked") > 0
    }

    /// Reads to the end, once no program has the terminal open; returns everything shown.
    ///
    /// # Panics
    /// When the reader panicked.
    #[must_use]
    pub fn read_to_end(self) -> String {
        self.reader.join().expect("no reader panics");
        let output = self.output.lock().expect("no reader panics");
        String::from_utf8_lossy(&output).into_owned()
    }

    fn end(&self) -> File {
        let end = File::options().read(true).write(true).open(&self.path);
        end.expect("the terminal's other end")
    }
}

/// Returns the end of a terminal's output.
#[must_use]
pub fn last_characters(transcript: &str) -> String {
    let tail: Vec<char> = transcript.chars().rev().take(2000).collect();
    tail.into_iter().rev().collect()
}
