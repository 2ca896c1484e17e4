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

/// A pseudo-terminal; its output is read until `look_away`.
pub struct Screen {
    controller: File,
    path: PathBuf,
    shown: Arc<Mutex<Vec<u8>>>,
    looked_at: Arc<AtomicBool>,
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
        let mut output = controller.try_clone().expect("a second handle");
        let shown = Arc::new(Mutex::new(Vec::new()));
        let looked_at = Arc::new(AtomicBool::new(true));
        let (to, looks) = (Arc::clone(&shown), Arc::clone(&looked_at));
        let reader = std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while looks.load(Ordering::Relaxed)
                // Fails once no program has the terminal open.
                && let Ok(n @ 1..) = output.read(&mut bytes)
            {
                to.lock()
                    .expect("no reader panics")
                    .extend_from_slice(&bytes[..n]);
            }
        });
        Self {
            controller,
            path: path.into(),
            shown,
            looked_at,
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
        let typed = self.controller.write_all(keys.as_bytes());
        typed.expect("the terminal takes keys");
    }

    /// Returns everything shown so far.
    ///
    /// # Panics
    /// When the reader panicked.
    #[must_use]
    pub fn shown(&self) -> String {
        String::from_utf8_lossy(&self.shown.lock().expect("no reader panics")).into_owned()
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
    pub fn look_away(&self) {
        self.looked_at.store(false, Ordering::Relaxed);
    }

    /// Returns whether the terminal accepts more output from the program.
    ///
    /// # Panics
    /// When the terminal is gone.
    #[must_use]
    pub fn takes_more(&self) -> bool {
        let end = self.end();
        let mut polled = [PollFd::new(&end, PollFlags::OUT)];
        poll(&mut polled, Some(&Timespec::default())).expect("a terminal can be asked") > 0
    }

    /// Reads to the end, once no program has the terminal open; returns everything shown.
    ///
    /// # Panics
    /// When the reader panicked.
    #[must_use]
    pub fn to_the_end(self) -> String {
        self.reader.join().expect("no reader panics");
        let shown = self.shown.lock().expect("no reader panics");
        String::from_utf8_lossy(&shown).into_owned()
    }

    fn end(&self) -> File {
        let end = File::options().read(true).write(true).open(&self.path);
        end.expect("the terminal's other end")
    }
}
