//! The operator's terminal: set up, drawn to at most 30 times a second, read for keys, and restored.

use std::io::{self, IsTerminal, Write};
use std::mem::ManuallyDrop;
use std::panic::PanicHookInfo;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::crossterm::style::Print;
use ratatui::crossterm::{cursor, execute, terminal};
use ratatui::layout::{Position, Rect};
use ratatui::{Frame, Terminal};

use crate::action::Action;
use crate::dashboard::view;
use crate::event::{Event, SafetyState};
use crate::frame_writer::FrameWriter;
use crate::keyboard::key;
use crate::page_files;
use crate::state::State;
use crate::terminal_keys::{Keys, TerminalKeys};
use crate::terminal_kind::{is_ascii, theme};

/// Time between two drawings.
const FRAME: Duration = Duration::from_millis(33);
/// Time between two rings of the bell while the bench is tripped and no key was pressed, s.
const BELL_S: f64 = 5.0;
/// Asks the terminal for presses of the mouse's buttons, of which the wheel is two; nothing on its movements.
const MOUSE_ON: &str = "\x1b[?1000h\x1b[?1006h";
const MOUSE_OFF: &str = "\x1b[?1006l\x1b[?1000l";

/// Why the operator's screen could not go on.
#[derive(Debug, thiserror::Error)]
pub enum ShellError {
    /// Standard input or output is not a terminal.
    #[error("no terminal for the dashboard ({0}); run in a terminal, or with --headless")]
    NoTerminal(#[source] io::Error),
    /// The terminal failed while it was used, for example because its window was closed.
    #[error("the terminal failed while {doing}: {source}")]
    Terminal {
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        #[source]
        source: io::Error,
    },
}

fn failed(doing: &'static str) -> impl FnOnce(io::Error) -> ShellError {
    move |source| ShellError::Terminal { doing, source }
}

/// Shows the dashboard on this process's terminal. Returns when [`Event::Close`] comes, when all senders of events are
/// gone, or when nothing receives actions. Blocks the calling thread: what drives the plate must not wait for it.
///
/// `events` should be bounded (`sync_channel` and `try_send`), so that a terminal that blocks costs no memory.
/// `NO_COLOR` is respected, then [`choose_theme`](crate::choose_theme); a locale without UTF-8 is shown ASCII alone. The terminal is restored on return, on error and when this thread panics; see
/// [`install_panic_hook`] for panics elsewhere and [`restore`] for signals.
///
/// # Errors
/// [`ShellError::NoTerminal`] when standard input or output is not a terminal, [`ShellError::Terminal`] when it fails
/// later. The caller should treat the latter as the operator's absence and stop in an orderly way.
pub fn run_operator(events: &Receiver<Event>, actions: &Sender<Action>) -> Result<(), ShellError> {
    let _screen = OperatorScreen::enter()?;
    let backend = CrosstermBackend::new(FrameWriter::new(io::stdout()));
    let terminal = Terminal::new(backend).map_err(failed("reading its size"))?;
    // Never dropped: its drop prints to standard error when the cursor cannot be shown, and panics where standard error
    // is the terminal that was closed.
    let mut terminal = ManuallyDrop::new(terminal);
    let mut state = State::new(theme());
    state.ui.ascii = is_ascii(|name| std::env::var_os(name));
    operate(&mut terminal, &mut TerminalKeys, state, events, actions).map(drop)
}

/// Returns columns and rows of the terminal on standard output; `None` when standard output is not a terminal.
#[must_use]
pub fn size() -> Option<(u16, u16)> {
    #[cfg(unix)]
    {
        let size = rustix::termios::tcgetwinsize(io::stdout()).ok()?;
        Some((size.ws_col, size.ws_row))
    }
    #[cfg(not(unix))]
    {
        let shown = io::stdout().is_terminal();
        shown.then(|| terminal::size().ok()).flatten()
    }
}

/// Restores the operator's terminal, and says what waited for it. Harmless when called twice, from any thread, or
/// when the dashboard was never shown. Errors are ignored: the terminal is the only place to report them.
pub fn restore() {
    if SHOWN.swap(false, Ordering::SeqCst) {
        let _ = terminal::disable_raw_mode();
        let _ = execute!(
            io::stdout(),
            Print(MOUSE_OFF),
            terminal::LeaveAlternateScreen,
            cursor::Show
        );
    }
    let unsaid = std::mem::take(&mut *UNSAID.lock().unwrap_or_else(PoisonError::into_inner));
    unsaid.iter().for_each(|line| say(line));
}

/// Reports a panic in any thread in `words`, in place of the hook installed before. While the dashboard is shown, the
/// report waits for [`restore`]: the terminal is put back last, by the dashboard's end, after whatever ends the bench
/// in good order. Only a panic of the main thread, which waits for the dashboard, puts it back at once.
///
/// Call it once, early. Hooks that make a bench safe are installed after it and so come before it: writing to a
/// terminal can block.
pub fn install_panic_hook(words: impl Fn(&PanicHookInfo<'_>) -> String + Send + Sync + 'static) {
    std::panic::set_hook(Box::new(move |info| {
        let line = words(info);
        let is_main = std::thread::current().name() == Some("main");
        if SHOWN.load(Ordering::SeqCst) && !is_main {
            UNSAID
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(line);
        } else {
            restore();
            say(&line);
        }
    }));
}

/// Reports of panics that wait until the terminal is restored.
static UNSAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn say(line: &str) {
    // Nothing is left to report it to.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Whether the dashboard has the terminal in raw mode and on the alternate screen.
static SHOWN: AtomicBool = AtomicBool::new(false);

/// The terminal while the dashboard is shown on it; restored when dropped.
struct OperatorScreen;

impl OperatorScreen {
    fn enter() -> Result<Self, ShellError> {
        if !io::stdin().is_terminal() || !io::stdout().is_terminal() {
            return Err(ShellError::NoTerminal(io::Error::from(
                io::ErrorKind::NotFound,
            )));
        }
        terminal::enable_raw_mode().map_err(ShellError::NoTerminal)?;
        SHOWN.store(true, Ordering::SeqCst);
        let screen = Self;
        execute!(
            io::stdout(),
            terminal::EnterAlternateScreen,
            terminal::Clear(terminal::ClearType::All),
            cursor::Hide,
            Print(MOUSE_ON)
        )
        .map_err(failed("setting it up"))?;
        Ok(screen)
    }
}

impl Drop for OperatorScreen {
    fn drop(&mut self) {
        restore();
    }
}

/// Applies events, draws and reads keys until the bench closes the screen or is gone; returns the last state.
///
/// # Errors
/// [`ShellError::Terminal`] when drawing or reading keys fails.
fn operate<B: Backend<Error = io::Error> + Write>(
    terminal: &mut Terminal<B>,
    keys: &mut impl Keys,
    mut state: State,
    events: &Receiver<Event>,
    actions: &Sender<Action>,
) -> Result<State, ShellError> {
    let began = Instant::now();
    let mut bench_gone = false;
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
        let drawn = terminal
            .draw(|frame: &mut Frame| view(&state, frame))
            .map_err(failed("drawing"))?;
        if std::mem::take(&mut state.ui.write) {
            let ui = &state.ui;
            let written = page_files::write(Path::new("."), ui.page, ui.theme, drawn.buffer);
            state.ui.note = Some(match written {
                Ok(name) => format!("wrote {name}, and its text beside it"),
                Err(error) => format!("the page is not written: {error}"),
            });
        }
        // Keys are served as they come, drawing waits for its turn.
        loop {
            let left = FRAME.saturating_sub(frame_began.elapsed());
            let pressed = keys.next(left).map_err(failed("reading keys"))?;
            if let Some(pressed) = pressed {
                bell.heard();
                let reaction = key(&state, pressed);
                state.ui = reaction.ui;
                if reaction.redraw {
                    // Not `clear`, which asks the terminal where its cursor is and waits for the answer.
                    let size = terminal.size().map_err(failed("reading its size"))?;
                    let area = Rect::from((Position::ORIGIN, size));
                    terminal.resize(area).map_err(failed("drawing"))?;
                }
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
            &mut screen(),
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
        let end = operate(&mut screen(), &mut typed(""), state, &events, &operator).unwrap();
        assert_eq!(end.safety, Some(SafetyState::Disarmed));
    }

    #[test]
    fn it_ends_when_nobody_listens_to_actions() {
        let (_bench, events) = mpsc::channel();
        let (operator, actions) = mpsc::channel();
        drop(actions);
        let state = State::new(Theme::Colour);
        let end = operate(&mut screen(), &mut typed("q"), state, &events, &operator);
        assert!(end.is_ok());
    }

    #[test]
    fn a_terminal_that_goes_away_is_an_error() {
        let (_bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        let state = State::new(Theme::Colour);
        let end = operate(&mut screen(), &mut Gone, state, &events, &operator);
        assert!(
            matches!(
                &end,
                Err(ShellError::Terminal { doing: "reading keys", source })
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

    #[test]
    fn restoring_what_was_never_shown_does_nothing() {
        restore();
        restore();
    }
}
