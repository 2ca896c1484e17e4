//! The operator's terminal: set up, drawn to at most 30 times a second, read for keys, and restored.

use std::io::{self, Write};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use operator_terminal::{Frames, Keys, OperatorScreen, TerminalError, TerminalKeys};
use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::layout::{Position, Rect};
use ratatui::{Frame, Terminal};

use crate::action::Action;
use crate::dashboard::view;
use crate::event::{Event, SafetyState};
use crate::keyboard::key;
use crate::page_files;
use crate::state::State;
use crate::terminal_kind::{is_ascii, theme};

/// Time between two drawings.
const FRAME: Duration = Duration::from_millis(33);
/// Time between two rings of the bell while the bench is tripped and no key was pressed, s.
const BELL_S: f64 = 5.0;

/// Shows the dashboard on this process's terminal. Returns when [`Event::Close`] comes, when all senders of events are
/// gone, or when nothing receives actions. Blocks the calling thread: what drives the plate must not wait for it.
///
/// `events` should be bounded (`sync_channel` and `try_send`), so that a terminal that blocks costs no memory.
/// `NO_COLOR` is respected, then [`choose_theme`](crate::choose_theme); a locale without UTF-8 is shown ASCII alone. The terminal is restored on return, on error and when this thread panics; see
/// [`crate::install_panic_hook`] for panics elsewhere and [`crate::restore`] for signals. While the terminal stands
/// still nothing is drawn, and keys are served all the same.
///
/// # Errors
/// [`TerminalError::NoTerminal`] when standard input or output is not a terminal, [`TerminalError::Terminal`] when it fails
/// later. The caller should treat the latter as the operator's absence and stop in an orderly way.
pub fn run_operator(
    events: &Receiver<Event>,
    actions: &Sender<Action>,
) -> Result<(), TerminalError> {
    let (screen, writer) = OperatorScreen::enter()?;
    let backend = CrosstermBackend::new(writer);
    let terminal = Terminal::new(backend).map_err(TerminalError::failed("reading its size"))?;
    // Never dropped: its drop prints to standard error when the cursor cannot be shown, and panics where standard error
    // is the terminal that was closed.
    let mut terminal = ManuallyDrop::new(terminal);
    let mut state = State::new(theme());
    state.ui.ascii = is_ascii(|name| std::env::var_os(name));
    let shown = screen.frames();
    operate(
        (&mut terminal, shown),
        &mut TerminalKeys,
        state,
        events,
        actions,
    )
    .map(drop)
}

/// Applies events, draws and reads keys until the bench closes the screen or is gone; returns the last state.
///
/// # Errors
/// [`TerminalError::Terminal`] when drawing or reading keys fails.
fn operate<B: Backend<Error = io::Error> + Write>(
    (terminal, shown): (&mut Terminal<B>, &Frames),
    keys: &mut impl Keys,
    mut state: State,
    events: &Receiver<Event>,
    actions: &Sender<Action>,
) -> Result<State, TerminalError> {
    let began = Instant::now();
    let mut bench_gone = false;
    let mut anew = false;
    let mut bell = Bell::default();
    loop {
        let frame_began = Instant::now();
        state.apply(&Event::Tick {
            now_s: began.elapsed().as_secs_f64(),
        });
        // Bounded: a sender that is faster than this loop must not keep it from drawing.
        while frame_began.elapsed() < FRAME {
            match events.try_recv() {
                Ok(event) => state.apply(&event),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    bench_gone = true;
                    break;
                }
            }
        }
        if state.closed || bench_gone {
            return Ok(state);
        }
        if bell.rings(&state) {
            // With the next frame; nobody waits for it.
            let _ = terminal.backend_mut().write_all(b"\x07");
        }
        if shown.are_written() {
            if std::mem::take(&mut anew) {
                // Not `clear`, which asks the terminal where its cursor is and waits for the answer.
                let size = terminal.size();
                let size = size.map_err(TerminalError::failed("reading its size"))?;
                let area = Rect::from((Position::ORIGIN, size));
                let resized = terminal.resize(area);
                resized.map_err(TerminalError::failed("drawing"))?;
            }
            draw(terminal, &mut state)?;
        }
        // Keys are served as they come, drawing waits for its turn.
        loop {
            let left = FRAME.saturating_sub(frame_began.elapsed());
            let pressed = keys
                .next(left)
                .map_err(TerminalError::failed("reading keys"))?;
            if let Some(pressed) = pressed {
                bell.heard();
                let reaction = key(&state, pressed);
                state.ui = reaction.ui;
                anew |= reaction.redraw;
                if let Some(action) = reaction.action
                    && actions.send(action).is_err()
                {
                    return Ok(state);
                }
            }
            if left.is_zero() {
                break;
            }
        }
    }
}

/// Draws `state`, and writes the page into a file if that was asked for.
///
/// # Errors
/// [`TerminalError::Terminal`].
fn draw<B: Backend<Error = io::Error>>(
    terminal: &mut Terminal<B>,
    state: &mut State,
) -> Result<(), TerminalError> {
    let drawn = terminal
        .draw(|frame: &mut Frame| view(state, frame))
        .map_err(TerminalError::failed("drawing"))?;
    if std::mem::take(&mut state.ui.write) {
        let name = match state.guided() {
            Some(_) => "calibration",
            None => state.ui.page.name(),
        };
        let written = page_files::write(Path::new("."), name, state.ui.theme, drawn.buffer);
        state.ui.note = Some(match written {
            Ok(name) => format!("wrote {name}, and its text beside it"),
            Err(error) => format!("the page is not written: {error}"),
        });
    }
    Ok(())
}

/// The bell: at each trip, and again until somebody presses a key.
#[derive(Debug, Default)]
struct Bell {
    /// When it rings next, s; `None` while nothing is wrong.
    due_s: Option<f64>,
    heard: bool,
}

impl Bell {
    fn rings(&mut self, state: &State) -> bool {
        if state.safety != Some(SafetyState::Tripped) {
            *self = Self::default();
            return false;
        }
        let due = self
            .due_s
            .is_none_or(|due_s| !self.heard && state.now_s >= due_s);
        if due {
            self.due_s = Some(state.now_s + BELL_S);
            self.heard = false;
        }
        due
    }

    fn heard(&mut self) {
        self.heard = true;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

    use super::*;
    use crate::event::{PhaseKind, PhaseView};
    use drawing::theme::Theme;

    /// Types one key a frame, then none.
    struct Typed(std::vec::IntoIter<char>);

    impl Keys for Typed {
        fn next(&mut self, _: Duration) -> io::Result<Option<KeyEvent>> {
            std::thread::sleep(Duration::from_millis(1));
            let code = self.0.next();
            Ok(code.map(|c| KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE)))
        }
    }

    struct Gone;

    impl Keys for Gone {
        fn next(&mut self, _: Duration) -> io::Result<Option<KeyEvent>> {
            Err(io::Error::from(io::ErrorKind::BrokenPipe))
        }
    }

    fn typed(keys: &str) -> Typed {
        Typed(keys.chars().collect::<Vec<_>>().into_iter())
    }

    fn screen() -> Terminal<CrosstermBackend<Vec<u8>>> {
        Terminal::with_options(
            CrosstermBackend::new(Vec::new()),
            ratatui::TerminalOptions {
                viewport: ratatui::Viewport::Fixed(Rect::new(0, 0, 80, 24)),
            },
        )
        .unwrap()
    }

    #[test]
    fn keys_become_actions_and_close_ends_it() {
        let (bench, events) = mpsc::channel();
        let (operator, actions) = mpsc::channel();
        bench
            .send(Event::Phase(PhaseView {
                trial: 1,
                ..PhaseView::new(PhaseKind::Exploration)
            }))
            .unwrap();
        let answering = std::thread::spawn(move || {
            let asked: Vec<Action> = actions.iter().take(3).collect();
            bench.send(Event::Close).unwrap();
            asked
        });
        let state = State::new(Theme::Colour);
        let end = operate(
            (&mut screen(), &Frames::default()),
            &mut typed("pryze"),
            state,
            &events,
            &operator,
        )
        .unwrap();
        assert!(end.closed);
        let asked = answering.join().unwrap();
        let redo = Action::Redo(crate::action::AttemptName {
            trial: 1,
            practice: false,
            attempt: 1,
        });
        assert_eq!(asked, [Action::Pause, redo, Action::EmergencyStop]);
    }

    #[test]
    fn it_ends_when_the_bench_is_gone_having_taken_in_its_last_words() {
        let (bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        bench
            .send(Event::Safety {
                state: SafetyState::Disarmed,
                reason: None,
            })
            .unwrap();
        drop(bench);
        let state = State::new(Theme::Colour);
        let end = operate(
            (&mut screen(), &Frames::default()),
            &mut typed(""),
            state,
            &events,
            &operator,
        )
        .unwrap();
        assert_eq!(end.safety, Some(SafetyState::Disarmed));
    }

    #[test]
    fn it_ends_when_nobody_listens_to_actions() {
        let (_bench, events) = mpsc::channel();
        let (operator, actions) = mpsc::channel();
        drop(actions);
        let state = State::new(Theme::Colour);
        let end = operate(
            (&mut screen(), &Frames::default()),
            &mut typed("q"),
            state,
            &events,
            &operator,
        );
        assert!(end.is_ok());
    }

    #[test]
    fn a_terminal_that_goes_away_is_an_error() {
        let (_bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        let state = State::new(Theme::Colour);
        let end = operate(
            (&mut screen(), &Frames::default()),
            &mut Gone,
            state,
            &events,
            &operator,
        );
        assert!(
            matches!(
                &end,
                Err(TerminalError::Terminal { doing: "reading keys", source })
                    if source.kind() == io::ErrorKind::BrokenPipe
            ),
            "{end:?}"
        );
    }

    #[test]
    fn the_bell_rings_at_a_trip_and_until_a_key_is_pressed() {
        let mut state = State::new(Theme::Colour);
        let mut bell = Bell::default();
        let mut at = |now_s: f64, safety, heard: bool| {
            state.now_s = now_s;
            state.safety = Some(safety);
            if heard {
                bell.heard();
            }
            bell.rings(&state)
        };
        use SafetyState::{Armed, Tripped};
        assert!(!at(0.0, Armed, true));
        assert!(at(1.0, Tripped, false));
        assert!(!at(2.0, Tripped, false));
        assert!(at(6.5, Tripped, false));
        assert!(!at(20.0, Tripped, true));
        assert!(!at(21.0, Armed, false));
        assert!(at(22.0, Tripped, false));
    }
}
