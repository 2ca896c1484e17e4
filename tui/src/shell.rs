//! The operator's terminal: set up, drawn at most 30 times a second, read for keys, and restored.
//!
//! One thread draws and another reads the keys. Neither waits for the terminal, for a file, or for the other longer
//! than an access to the state takes: a stop key acts on the thread that read it.

use std::io::{self, Write};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use drawing::chosen_theme::chosen_theme;
use drawing::page_files;
use drawing::theme::Theme;
use operator_terminal::{Frames, Keys, OperatorScreen, TerminalError, TerminalKeys};
use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::KeyEvent;
use ratatui::layout::Rect;
use ratatui::{Frame, Terminal, TerminalOptions, Viewport};

use crate::action::Action;
use crate::dashboard::view;
use crate::event::{Event, SafetyView};
use crate::keyboard::{at_once, key};
use crate::state::{ENDING, State};

/// Time between two frames.
const FRAME: Duration = Duration::from_millis(33);
/// Longest wait for a key before the reader checks whether the screen is still shown.
const KEY_POLL: Duration = Duration::from_millis(33);
/// Longest wait for the key reader at the end: it may be blocked by the terminal.
const LAST_KEY: Duration = Duration::from_millis(100);
/// Time between two rings of the bell while the bench is tripped and no key was pressed, s.
const BELL_S: f64 = 5.0;

/// Shows the dashboard on this process's terminal. Returns at [`Event::Close`], or when all senders of events or the
/// receiver of actions are dropped. Blocks the calling thread, which must not be the one that drives the plate.
///
/// A separate thread reads the keys and calls `act` with each action before it sends it to `actions`: a stop in `act`
/// waits for no screen, file or bench. If no key comes, it calls `act` with `None`, at least every 33 ms, as a sign
/// that keys are read. A closed terminal is treated as [`Action::Interrupt`].
///
/// `events` should be bounded (`sync_channel` and `try_send`), so that a terminal that blocks costs no memory.
/// `NO_COLOR` takes precedence over [`choose_theme`](crate::choose_theme); a locale without UTF-8 is shown in ASCII. The
/// terminal is restored on return, on error and when this thread panics; see [`crate::install_panic_hook`] for panics
/// elsewhere and [`crate::restore`] for signals. While the terminal blocks, nothing is drawn, but keys are still handled.
///
/// # Errors
/// [`TerminalError::NoTerminal`] if standard input or output is not a terminal, [`TerminalError::Terminal`] if it fails
/// later. The caller should treat the latter as the operator's absence and stop in an orderly way.
pub fn run_operator(
    events: &Receiver<Event>,
    actions: Sender<Action>,
    act: impl Fn(Option<&Action>) + Send + 'static,
) -> Result<(), TerminalError> {
    let (screen, writer) = OperatorScreen::enter()?;
    // Fixed, and resized by this code: a full-screen viewport opens the terminal for its size at every frame.
    let viewport = Viewport::Fixed(Rect::ZERO);
    let terminal =
        Terminal::with_options(CrosstermBackend::new(writer), TerminalOptions { viewport });
    let terminal = terminal.map_err(TerminalError::while_doing("reading its size"))?;
    // Never dropped: its drop prints to standard error if the cursor cannot be shown, and panics if standard error is
    // the closed terminal.
    let mut terminal = ManuallyDrop::new(terminal);
    let mut state = State::new(chosen_theme());
    state.ui.ascii = standard_streams::is_ascii();
    let desk = Arc::new(Desk::new(state));
    let reader = read_keys(TerminalKeys, &desk, actions, act)?;
    let result = operate(
        (&mut terminal, operator_terminal::size),
        screen.frames(),
        &desk,
        events,
    );
    leave(&desk, &reader)?;
    result
}

/// Leaves the screen after a last check for keys.
///
/// # Errors
/// [`TerminalError::Terminal`] if the terminal is already gone.
fn leave(desk: &Desk, reader: &thread::JoinHandle<()>) -> Result<(), TerminalError> {
    desk.leave();
    let start = Instant::now();
    while !reader.is_finished() && start.elapsed() < LAST_KEY {
        thread::sleep(Duration::from_millis(1));
    }
    desk.take_error().map_or(Ok(()), Err)
}

/// State of the screen, shared by the drawing thread and the thread that reads keys. Its lock is held while a key or an
/// event is applied or a frame is laid out, never across a call that can block.
struct Desk {
    state: Mutex<State>,
    /// Whether the whole screen must be redrawn.
    redraw: AtomicBool,
    /// Whether a key was pressed since the bell rang.
    key_pressed: AtomicBool,
    /// Whether the screen was closed.
    is_over: AtomicBool,
    /// Whether a page is being written.
    is_writing: AtomicBool,
    /// Error that ended the reading of keys.
    key_error: Mutex<Option<TerminalError>>,
}

impl Desk {
    fn new(state: State) -> Self {
        Self {
            state: Mutex::new(state),
            redraw: AtomicBool::new(false),
            key_pressed: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
            is_writing: AtomicBool::new(false),
            key_error: Mutex::new(None),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic elsewhere ends the bench; until then the screen goes on with the state as it is.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn leave(&self) {
        self.is_over.store(true, Ordering::Release);
    }

    fn is_closed(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }

    fn set_error(&self, error: TerminalError) {
        *self
            .key_error
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = Some(error);
    }

    fn take_error(&self) -> Option<TerminalError> {
        self.key_error
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
    }

    /// Applies `key_event`, and returns its action.
    fn press(&self, key_event: KeyEvent) -> Option<Action> {
        self.key_pressed.store(true, Ordering::Relaxed);
        let mut state = self.state();
        let reaction = key(&state, key_event);
        state.ui = reaction.ui;
        if reaction.redraw {
            self.redraw.store(true, Ordering::Relaxed);
        }
        if matches!(reaction.action, Some(Action::Quit | Action::Interrupt))
            && state.drill.is_none()
            && !state.session.replayed
        {
            state.ui.note = Some(ENDING.to_owned());
        }
        reaction.action
    }
}

/// Starts the thread that reads `keys` until the screen is left or the terminal is gone.
///
/// # Errors
/// [`TerminalError::Terminal`] when the system refuses a thread.
fn read_keys(
    mut keys: impl Keys + Send + 'static,
    desk: &Arc<Desk>,
    actions: Sender<Action>,
    act: impl Fn(Option<&Action>) + Send + 'static,
) -> Result<thread::JoinHandle<()>, TerminalError> {
    let desk = Arc::clone(desk);
    let reader = thread::Builder::new().name("keys".to_owned());
    let result = reader.spawn(move || {
        loop {
            // One more check after the screen is left: a closed terminal's signal may have ended the bench first.
            let is_last = desk.is_closed();
            let press = match keys.next(KEY_POLL) {
                Ok(press) if is_last => return act(press.and_then(at_once).as_ref()),
                Ok(Some(press)) => press,
                Ok(None) => {
                    act(None);
                    continue;
                }
                Err(error) => {
                    act(Some(&Action::Interrupt));
                    return desk.set_error(TerminalError::while_doing("reading keys")(error));
                }
            };
            // Before access to the state, since the drawing thread may hold its lock.
            let urgent_action = at_once(press);
            if let Some(action) = &urgent_action {
                act(Some(action));
            }
            let Some(action) = desk.press(press) else {
                continue;
            };
            if urgent_action.is_none() {
                act(Some(&action));
            }
            if actions.send(action).is_err() {
                return desk.leave();
            }
        }
    });
    result.map_err(TerminalError::while_doing(
        "starting the thread that reads keys",
    ))
}

/// Applies events and draws until the bench closes the screen or is gone, or the receiver of actions is dropped.
///
/// # Errors
/// [`TerminalError::Terminal`] when drawing or reading keys fails.
fn operate<B: Backend<Error = io::Error> + Write>(
    (terminal, size): (&mut Terminal<B>, impl Fn() -> Option<(u16, u16)>),
    frames: &Frames,
    desk: &Arc<Desk>,
    events: &Receiver<Event>,
) -> Result<(), TerminalError> {
    let mut area = Rect::ZERO;
    let began = Instant::now();
    let mut bell = Bell::default();
    loop {
        let frame_began = Instant::now();
        let rings = {
            let mut state = desk.state();
            state.apply(&Event::Tick {
                now_s: began.elapsed().as_secs_f64(),
            });
            let bench_gone = apply(&mut state, events, frame_began);
            if state.closed || bench_gone {
                return Ok(());
            }
            if desk.key_pressed.swap(false, Ordering::Relaxed) {
                bell.silence();
            }
            bell.rings(&state)
        };
        if let Some(error) = desk.take_error() {
            return Err(error);
        }
        if desk.is_closed() {
            return Ok(());
        }
        if rings {
            // Sent with the next frame.
            let _ = terminal.backend_mut().write_all(b"\x07");
        }
        if frames.are_written() {
            let new_area = size().map_or(area, |(width, height)| Rect::new(0, 0, width, height));
            if desk.redraw.swap(false, Ordering::Relaxed) || new_area != area {
                area = new_area;
                // Not `clear`, which queries the terminal for its cursor and waits for the answer.
                let result = terminal.resize(area);
                result.map_err(TerminalError::while_doing("drawing"))?;
            }
            draw(terminal, desk)?;
        }
        thread::sleep(FRAME.saturating_sub(frame_began.elapsed()));
    }
}

/// Applies the events that have arrived, and returns whether their senders are dropped. Bounded in time: a fast sender
/// must not keep the screen from being drawn.
fn apply(state: &mut State, events: &Receiver<Event>, from: Instant) -> bool {
    while from.elapsed() < FRAME / 2 {
        match events.try_recv() {
            Ok(event) => state.apply(&event),
            Err(TryRecvError::Empty) => return false,
            Err(TryRecvError::Disconnected) => return true,
        }
    }
    false
}

/// Draws the state, and writes the page to files if that was requested.
///
/// # Errors
/// [`TerminalError::Terminal`].
fn draw<B: Backend<Error = io::Error>>(
    terminal: &mut Terminal<B>,
    desk: &Arc<Desk>,
) -> Result<(), TerminalError> {
    let mut page = None;
    let last_frame = terminal
        .draw(|frame: &mut Frame| {
            let mut state = desk.state();
            view(&state, frame);
            if std::mem::take(&mut state.ui.write) {
                let name = match state.shown_calibration() {
                    Some(_) => "calibration",
                    None => state.ui.page.name(),
                };
                page = Some((name, state.ui.theme));
            }
        })
        .map_err(TerminalError::while_doing("drawing"))?;
    if let Some((name, theme)) = page {
        write_page(desk, name, theme, last_frame.buffer.clone());
    }
    Ok(())
}

/// Writes a page on a separate thread, since a disk may hang, and reports the result in a remark.
fn write_page(desk: &Arc<Desk>, name: &'static str, theme: Theme, screen: Buffer) {
    let note = |desk: &Desk, text| desk.state().ui.note = Some(text);
    if desk.is_writing.swap(true, Ordering::AcqRel) {
        return note(desk, "the previous page is still being written".to_owned());
    }
    let writer = Arc::clone(desk);
    let result = thread::Builder::new()
        .name("page".to_owned())
        .spawn(move || {
            let text = match page_files::write(Path::new("."), name, theme, &screen) {
                Ok(name) => format!("wrote {name} and its text file"),
                Err(error) => format!(
                    "the page is not written here: {}",
                    bounded_files::cause(&error)
                ),
            };
            writer.is_writing.store(false, Ordering::Release);
            note(&writer, text);
        });
    if let Err(error) = result {
        desk.is_writing.store(false, Ordering::Release);
        let cause = bounded_files::cause(&error);
        note(desk, format!("the page is not written: {cause}"));
    }
}

/// The bell, which rings at each trip and again until a key is pressed.
#[derive(Debug, Default)]
struct Bell {
    /// Time of the next ring, s; `None` without a trip.
    due_s: Option<f64>,
    is_silenced: bool,
}

impl Bell {
    fn rings(&mut self, state: &State) -> bool {
        if state.safety != Some(SafetyView::Tripped) {
            *self = Self::default();
            return false;
        }
        let due = self
            .due_s
            .is_none_or(|due_s| !self.is_silenced && state.now_s >= due_s);
        if due {
            self.due_s = Some(state.now_s + BELL_S);
            self.is_silenced = false;
        }
        due
    }

    fn silence(&mut self) {
        self.is_silenced = true;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use ratatui::crossterm::event::{KeyCode, KeyModifiers};

    use super::*;
    use crate::event::{PhaseKind, PhaseView};

    /// A source of keys that types one after the other, then none.
    struct Typed(std::vec::IntoIter<char>);

    impl Keys for Typed {
        fn next(&mut self, _: Duration) -> io::Result<Option<KeyEvent>> {
            thread::sleep(Duration::from_millis(1));
            let code = self.0.next();
            Ok(code.map(key_event))
        }
    }

    struct Gone;

    impl Keys for Gone {
        fn next(&mut self, _: Duration) -> io::Result<Option<KeyEvent>> {
            Err(io::Error::from(io::ErrorKind::BrokenPipe))
        }
    }

    fn key_event(code: char) -> KeyEvent {
        KeyEvent::new(KeyCode::Char(code), KeyModifiers::NONE)
    }

    fn typed_keys(keys: &str) -> Typed {
        Typed(keys.chars().collect::<Vec<_>>().into_iter())
    }

    fn screen() -> Terminal<CrosstermBackend<Vec<u8>>> {
        Terminal::with_options(
            CrosstermBackend::new(Vec::new()),
            TerminalOptions {
                viewport: Viewport::Fixed(Rect::ZERO),
            },
        )
        .unwrap()
    }

    /// Shows a screen, presses `keys` until it ends, and returns its last state.
    fn final_state(
        keys: impl Keys + Send + 'static,
        events: &Receiver<Event>,
        actions: Sender<Action>,
        act: impl Fn(Option<&Action>) + Send + 'static,
    ) -> Result<State, TerminalError> {
        let desk = Arc::new(Desk::new(State::new(Theme::Colour)));
        let reader = read_keys(keys, &desk, actions, act)?;
        let end = operate(
            (&mut screen(), || Some((80, 24))),
            &Frames::default(),
            &desk,
            events,
        );
        leave(&desk, &reader)?;
        end.map(|()| desk.state().clone())
    }

    #[test]
    fn keys_become_actions_and_close_ends_it() {
        let (bench, events) = mpsc::channel();
        let (operator, actions) = mpsc::channel();
        let phase = Event::Phase(PhaseView {
            trial: 1,
            ..PhaseView::new(PhaseKind::Exploration)
        });
        let mut state = State::new(Theme::Colour);
        state.apply(&phase);
        let desk = Arc::new(Desk::new(state));
        let log: Arc<Mutex<Vec<Action>>> = Arc::default();
        let shared_log = Arc::clone(&log);
        let act = move |action: Option<&Action>| shared_log.lock().unwrap().extend(action);
        let reader = read_keys(typed_keys("pryze"), &desk, operator, act).unwrap();
        let answer_thread = thread::spawn(move || {
            let requests: Vec<Action> = actions.iter().take(3).collect();
            bench.send(Event::Close).unwrap();
            requests
        });
        operate(
            (&mut screen(), || Some((80, 24))),
            &Frames::default(),
            &desk,
            &events,
        )
        .unwrap();
        assert!(desk.state().closed);
        desk.leave();
        reader.join().unwrap();
        let requests = answer_thread.join().unwrap();
        let redo = Action::Redo(crate::action::AttemptName {
            trial: 1,
            practice: false,
            attempt: 1,
        });
        assert_eq!(requests, [Action::Pause, redo, Action::EmergencyStop]);
        assert_eq!(*log.lock().unwrap(), requests);
    }

    /// Fault 49.
    /// Hazard 15.
    #[test]
    fn the_stop_key_and_a_confirmed_quit_act_while_nothing_is_drawn_and_nobody_takes_actions() {
        let desk = Arc::new(Desk::new(State::new(Theme::Colour)));
        let (operator, actions) = mpsc::channel();
        let (act_sender, acts) = mpsc::channel();
        let lock = desk.state();
        let act = move |action: Option<&Action>| {
            action
                .iter()
                .for_each(|action| act_sender.send(**action).unwrap());
        };
        let reader = read_keys(typed_keys("e"), &desk, operator, act).unwrap();
        let patience = Duration::from_secs(60);
        let action = acts.recv_timeout(patience).expect("the lock is held");
        assert_eq!(action, Action::EmergencyStop);
        drop(lock);
        assert_eq!(actions.recv_timeout(patience), Ok(Action::EmergencyStop));
        desk.leave();
        reader.join().unwrap();

        let desk = Arc::new(Desk::new(State::new(Theme::Colour)));
        desk.state().apply(&Event::Phase(PhaseView {
            trial: 1,
            ..PhaseView::new(PhaseKind::Exploration)
        }));
        let (operator, _actions) = mpsc::channel();
        let (act_sender, acts) = mpsc::channel();
        let act = move |action: Option<&Action>| {
            action
                .iter()
                .for_each(|action| act_sender.send(**action).unwrap());
        };
        let reader = read_keys(typed_keys("qy"), &desk, operator, act).unwrap();
        assert_eq!(acts.recv_timeout(patience), Ok(Action::Quit));
        desk.leave();
        reader.join().unwrap();
    }

    #[test]
    fn the_screen_ends_with_the_bench_after_its_last_events() {
        let (bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        bench
            .send(Event::Safety {
                state: SafetyView::Disarmed,
                reason: None,
            })
            .unwrap();
        drop(bench);
        let end = final_state(typed_keys(""), &events, operator, |_| ()).unwrap();
        assert_eq!(end.safety, Some(SafetyView::Disarmed));
    }

    #[test]
    fn the_screen_ends_without_a_receiver_of_actions() {
        let (_bench, events) = mpsc::channel();
        let (operator, actions) = mpsc::channel();
        drop(actions);
        assert!(final_state(typed_keys("q"), &events, operator, |_| ()).is_ok());
    }

    #[test]
    fn a_terminal_that_goes_away_is_an_error_and_an_interruption() {
        let (_bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        let (act_sender, acts) = mpsc::channel();
        let act = move |action: Option<&Action>| {
            action
                .iter()
                .for_each(|action| act_sender.send(**action).unwrap());
        };
        let end = final_state(Gone, &events, operator, act);
        assert!(
            matches!(
                &end,
                Err(TerminalError::Terminal { operation: "reading keys", source })
                    if source.kind() == io::ErrorKind::BrokenPipe
            ),
            "{end:?}"
        );
        assert_eq!(acts.try_recv(), Ok(Action::Interrupt));
    }

    /// A signal from the closed terminal ends the bench before the reader notices that the terminal is gone.
    #[test]
    fn a_terminal_that_goes_away_as_the_bench_closes_is_an_error_too() {
        struct GoneAfter(Sender<Event>);

        impl Keys for GoneAfter {
            fn next(&mut self, _: Duration) -> io::Result<Option<KeyEvent>> {
                match self.0.send(Event::Close) {
                    Ok(()) => Ok(None),
                    Err(_) => Err(io::Error::from(io::ErrorKind::BrokenPipe)),
                }
            }
        }

        for _ in 0..20 {
            let (bench, events) = mpsc::channel();
            let (operator, _actions) = mpsc::channel();
            let desk = Arc::new(Desk::new(State::new(Theme::Colour)));
            let reader = read_keys(GoneAfter(bench), &desk, operator, |_| ()).unwrap();
            let terminal = (&mut screen(), || Some((80, 24)));
            operate(terminal, &Frames::default(), &desk, &events).unwrap();
            drop(events);
            assert!(leave(&desk, &reader).is_err());
        }
    }

    #[test]
    fn the_bell_rings_at_a_trip_and_until_a_key_is_pressed() {
        let mut state = State::new(Theme::Colour);
        let mut bell = Bell::default();
        let mut at = |now_s: f64, safety, key_pressed: bool| {
            state.now_s = now_s;
            state.safety = Some(safety);
            if key_pressed {
                bell.silence();
            }
            bell.rings(&state)
        };
        use SafetyView::{Armed, Tripped};
        assert!(!at(0.0, Armed, true));
        assert!(at(1.0, Tripped, false));
        assert!(!at(2.0, Tripped, false));
        assert!(at(6.5, Tripped, false));
        assert!(!at(20.0, Tripped, true));
        assert!(!at(21.0, Armed, false));
        assert!(at(22.0, Tripped, false));
    }
}
