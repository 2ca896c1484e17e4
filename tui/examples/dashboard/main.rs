//! Plays a synthetic session to the operator's dashboard, in real time.
//!
//! `cargo run -p tui --example dashboard [PARTICIPANT_TERMINAL]`; `tty` in that terminal prints its path. `q` quits.

use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use tui::{Action, Event, ParticipantTerminal, Theme};

mod synthetic;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    tui::install_panic_hook(|info| info.to_string());
    let (to_screen, events) = mpsc::sync_channel(1024);
    let (from_operator, actions) = mpsc::channel();
    let display = match std::env::args_os().nth(1) {
        Some(path) => Some(ParticipantTerminal::open(path.as_ref(), Theme::Colour)?),
        None => None,
    };
    let player = thread::spawn(move || play(&to_screen, &actions, display.as_ref()));
    tui::run_operator(&events, from_operator, |_| ())?;
    drop(events);
    player.join().map_err(|_| "the player panicked")?;
    Ok(())
}

/// Sends each event at its time, until the session or the operator ends the example.
fn play(
    screen: &mpsc::SyncSender<Event>,
    actions: &mpsc::Receiver<Action>,
    display: Option<&ParticipantTerminal>,
) {
    let began = Instant::now();
    let end = synthetic::finish().into_iter().map(|event| (60.0, event));
    for (at_s, event) in synthetic::session().into_iter().chain(end) {
        if let (Event::Participant(view), Some(display)) = (&event, display) {
            display.show(view.clone());
        }
        let wait = Duration::from_secs_f64(at_s).saturating_sub(began.elapsed());
        if wants_to_leave(actions.recv_timeout(wait)) || screen.send(event).is_err() {
            let _ = screen.send(Event::Close);
            return;
        }
    }
    while !wants_to_leave(
        actions
            .recv()
            .map_err(|_| mpsc::RecvTimeoutError::Disconnected),
    ) {}
    let _ = screen.send(Event::Close);
}

/// Whether the operator quits or aborts, or the dashboard has closed.
fn wants_to_leave(result: Result<Action, mpsc::RecvTimeoutError>) -> bool {
    match result {
        Ok(action) => matches!(action, Action::Quit | Action::Abort | Action::Interrupt),
        Err(error) => error == mpsc::RecvTimeoutError::Disconnected,
    }
}
