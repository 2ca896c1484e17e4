//! The participant's screen on a terminal of its own: a pseudo-terminal, read from its other end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ffi::OsStr;
use std::fs::File;
use std::io::Read;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use tui::display::DisplayError;
use tui::{Instruction, ParticipantDisplay, ParticipantView, Theme};

/// Far longer than anything here takes; reached only by a failure.
const PATIENCE: Duration = Duration::from_secs(20);

struct Screen {
    path: PathBuf,
    controller: File,
    written: Receiver<Vec<u8>>,
    seen: String,
}

impl Screen {
    fn new(columns: u16, rows: u16) -> Self {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let name = ptsname(&controller, Vec::new()).unwrap();
        let controller = File::from(controller);
        let mut reader = controller.try_clone().unwrap();
        let (writer, written) = mpsc::channel();
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
            written,
            seen: String::new(),
        };
        screen.resize(columns, rows);
        screen
    }

    fn resize(&self, columns: u16, rows: u16) {
        let size = Winsize {
            ws_row: rows,
            ws_col: columns,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&self.controller, size).unwrap();
    }

    /// Waits until `words` have been written, and forgets all before them.
    fn wait_for(&mut self, words: &str) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(at) = self.seen.find(words) {
                self.seen.drain(..at + words.len());
                return;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            let bytes = self.written.recv_timeout(left);
            let bytes = bytes.unwrap_or_else(|_| panic!("{words:?} never came: {:?}", self.seen));
            self.seen.push_str(&String::from_utf8_lossy(&bytes));
        }
    }
}

fn shown(instruction: Instruction) -> ParticipantView {
    ParticipantView {
        instruction,
        slider_m: None,
        plate_m: 0.105,
        start_m: 0.0,
        end_m: 0.105,
        countdown: None,
        mean_force_n: None,
        force_band_n: None,
        trial: 0,
        trials: 0,
        rest_s: None,
    }
}

#[test]
fn it_draws_on_its_terminal_follows_its_size_and_puts_it_back() {
    let mut screen = Screen::new(60, 20);
    let display = ParticipantDisplay::open(&screen.path, Theme::Mono).unwrap();
    screen.wait_for("\x1b[?1049h");
    display.show(shown(Instruction::Wait));
    // In the middle of 60 columns, then of 100.
    screen.wait_for(&(" ".repeat(24) + "Please wait"));
    screen.resize(100, 30);
    screen.wait_for(&(" ".repeat(44) + "Please wait"));
    assert!(display.is_alive());
    drop(display);
    screen.wait_for("\x1b[?1049l");
}

#[test]
fn a_terminal_that_stands_still_never_holds_the_caller() {
    let screen = Screen::new(200, 60);
    let display = ParticipantDisplay::open(&screen.path, Theme::Colour).unwrap();
    rustix::termios::tcflow(
        File::options().write(true).open(&screen.path).unwrap(),
        rustix::termios::Action::OOff,
    )
    .unwrap();
    for _ in 0..10_000 {
        display.show(shown(Instruction::Wait));
        display.show(shown(Instruction::Finished));
    }
    // Returning at all is the test: the thread behind may be held for ever.
    drop(display);
}

#[test]
fn a_terminal_that_goes_away_is_noticed() {
    let mut screen = Screen::new(60, 20);
    let display = ParticipantDisplay::open(&screen.path, Theme::Colour).unwrap();
    display.show(shown(Instruction::Wait));
    screen.wait_for("Please wait");
    let Screen {
        controller,
        written,
        ..
    } = screen;
    drop(controller);
    drop(written);
    let deadline = Instant::now() + PATIENCE;
    while display.is_alive() {
        assert!(Instant::now() < deadline, "still thought alive");
        display.show(shown(Instruction::Rest));
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn what_is_no_terminal_is_refused_by_name() {
    let absent = ParticipantDisplay::open(Path::new("/dev/no-such-terminal"), Theme::Colour);
    let told = absent.unwrap_err().to_string();
    assert!(told.contains("/dev/no-such-terminal"), "{told}");
    let file = ParticipantDisplay::open(Path::new("/dev/null"), Theme::Colour);
    assert!(matches!(file, Err(DisplayError::NotATerminal { .. })));
}
