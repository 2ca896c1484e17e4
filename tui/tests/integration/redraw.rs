//! Cost of the dashboard during a session at its largest size: bytes to the terminal, and time to draw.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use crate::synthetic;
use std::cell::Cell;
use std::io;
use std::rc::Rc;
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};
use tui::{Event, Page, State, Theme, view};

/// Frame rate, Hz.
const FRAME_HZ: f64 = 30.0;
/// Duration of the part of the session that is played, s; it includes a rejected trial's crops.
const PLAYED_S: f64 = 24.0;
/// Data rate that a terminal over ssh can follow, bytes per second.
const MOST_BYTES_PER_S: f64 = 300e3;

/// A terminal that counts the bytes written.
struct Counted(Rc<Cell<usize>>);

impl io::Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.set(self.0.get() + bytes.len());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Plays the synthetic session; returns bytes and time to draw, each per second of the session.
fn cost(page: Page) -> (f64, f64) {
    let options = TerminalOptions {
        viewport: Viewport::Fixed(Rect::new(0, 0, 200, 60)),
    };
    let bytes = Rc::new(Cell::new(0));
    let backend = CrosstermBackend::new(Counted(bytes.clone()));
    let mut terminal = Terminal::with_options(backend, options).unwrap();
    let mut state = State::new(Theme::Colour);
    state.ui.page = page;
    let mut due_s = 0.0;
    let (mut frames, mut took) = (0u32, Duration::ZERO);
    for (at_s, event) in synthetic::session() {
        if at_s > PLAYED_S {
            break;
        }
        while at_s >= due_s {
            state.apply(&Event::Tick { now_s: due_s });
            let began = Instant::now();
            terminal.draw(|frame| view(&state, frame)).unwrap();
            took += began.elapsed();
            frames += 1;
            due_s += 1.0 / FRAME_HZ;
        }
        state.apply(&event);
    }
    let seconds = f64::from(frames) / FRAME_HZ;
    (bytes.get() as f64 / seconds, took.as_secs_f64() / seconds)
}

#[test]
fn the_pages_that_move_fit_a_slow_line() {
    for page in [Page::Run, Page::Impedance, Page::Trials] {
        let (bytes_per_s, part) = cost(page);
        println!(
            "{page:?}: {:.0} kB/s, {:.1} % of a core",
            bytes_per_s / 1e3,
            100.0 * part
        );
        assert!(
            bytes_per_s < MOST_BYTES_PER_S,
            "{page:?}: {bytes_per_s} B/s"
        );
    }
}
