//! The participant's screen on a separate terminal.

#![cfg(unix)]

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use crate::pty::{PATIENCE, Screen};
use participant_texts::Instruction;
use tui::display::{DisplayError, DisplayLoss};
use tui::{ParticipantTerminal, ScreenView, Theme};

fn view(instruction: Instruction) -> ScreenView {
    ScreenView {
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
        ..ScreenView::default()
    }
}

/// Fault 37.
#[test]
fn it_draws_on_its_terminal_follows_its_size_and_puts_it_back() {
    let mut screen = Screen::new(60, 20);
    let display = ParticipantTerminal::open(&screen.path, Theme::Mono).unwrap();
    screen.wait_for("\x1b[?1049h");
    display.show(view(Instruction::Wait));
    // Centred in 60 columns, then in 100.
    screen.wait_for(&(" ".repeat(24) + "Please wait"));
    screen.resize(100, 30);
    screen.wait_for(&(" ".repeat(44) + "Please wait"));
    assert_eq!(display.lost(), None);
    drop(display);
    screen.wait_for("\x1b[?1049l");
}

#[test]
fn a_terminal_that_stands_still_never_holds_the_caller() {
    let screen = Screen::new(200, 60);
    let display = ParticipantTerminal::open(&screen.path, Theme::Colour).unwrap();
    rustix::termios::tcflow(
        File::options().write(true).open(&screen.path).unwrap(),
        rustix::termios::Action::OOff,
    )
    .unwrap();
    for _ in 0..10_000 {
        display.show(view(Instruction::Wait));
        display.show(view(Instruction::Finished));
    }
    let deadline = Instant::now() + PATIENCE;
    while display.lost() != Some(DisplayLoss::Stuck) {
        assert!(Instant::now() < deadline, "nobody noticed");
        display.show(view(Instruction::Rest));
        thread::sleep(Duration::from_millis(20));
    }
    // The test is that this returns: the thread may be blocked forever.
    drop(display);
}

#[test]
fn a_terminal_that_goes_away_is_noticed() {
    let mut screen = Screen::new(60, 20);
    let display = ParticipantTerminal::open(&screen.path, Theme::Colour).unwrap();
    display.show(view(Instruction::Wait));
    screen.wait_for("Please wait");
    let Screen {
        controller, output, ..
    } = screen;
    drop(controller);
    drop(output);
    let deadline = Instant::now() + PATIENCE;
    while display.lost() != Some(DisplayLoss::Gone) {
        assert!(Instant::now() < deadline, "still thought alive");
        display.show(view(Instruction::Rest));
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_file_without_a_terminal_is_rejected_by_name() {
    let missing_path = Path::new("/dev/no-such-terminal");
    let result = ParticipantTerminal::open(missing_path, Theme::Colour);
    assert!(
        matches!(&result, Err(DisplayError::Open { path, source })
            if path == missing_path && source.kind() == ErrorKind::NotFound),
        "{result:?}"
    );
    let file = ParticipantTerminal::open(Path::new("/dev/null"), Theme::Colour);
    assert!(matches!(file, Err(DisplayError::NotATerminal { .. })));
}

/// A pipe without a reader would block a plain `open` forever.
#[test]
fn a_pipe_is_rejected_at_once() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};

    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    let (sender, outcome) = std::sync::mpsc::channel();
    thread::spawn(move || {
        let result = ParticipantTerminal::open(&pipe, Theme::Mono);
        let _ = sender.send(result.is_err());
    });
    assert_eq!(outcome.recv_timeout(PATIENCE), Ok(true));
}
