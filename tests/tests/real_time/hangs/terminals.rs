//! A terminal with unread output, and a participant's window that stops reading and writing.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bench_tests::hung::{HungSession, Rig, Stop, StopEffect};
use bench_tests::running::wait_until;
use participant_window::message::{FromWindow, ToWindow};
use participant_window::{LineConnection, place};

use crate::simulated_window;

const MINUTE: Duration = Duration::from_secs(60);
/// Time without output after which a terminal counts as full.
const FULL: Duration = Duration::from_millis(500);

/// Requires the plate to be silent in time, allowing for the machine's lateness.
fn require_in_time(effect: StopEffect) {
    let is_in_time = effect.silent_s.is_some_and(|s| s <= 0.050 + effect.late_s);
    assert!(is_in_time, "silent too late: {effect:?}");
}

fn fill(session: &HungSession) {
    session.screen.stop_reading();
    let mut output_time = Instant::now();
    let is_full = || {
        if session.screen.accepts_output() {
            output_time = Instant::now();
        }
        (output_time.elapsed() > FULL).then_some(())
    };
    wait_until(MINUTE, is_full).unwrap();
}

/// Hazard 15.
#[test]
fn a_terminal_that_nobody_reads_takes_each_stop_key() {
    let mut session = HungSession::start(&Rig::default());
    fill(&session);
    let asked_ns = session.ask(Stop::Interrupt);
    let effect = session.watch(asked_ns, Duration::from_secs(3), false);
    session.end();
    assert_eq!(session.contradictions(), Vec::<String>::new());
    require_in_time(effect);
}

/// Plays a window that answers the session until it hangs, and then keeps its end of the socket open.
fn window(socket: PathBuf, hangs: Arc<AtomicBool>) {
    let Some(stream) = wait_until(MINUTE, || place::connect(&socket).ok()?) else {
        return;
    };
    let mut lines = LineConnection::new(stream).unwrap();
    let mut message = FromWindow::Ready(simulated_window::display());
    while lines.send(&message).is_ok() && lines.receive::<ToWindow>(1000).is_ok() {
        message = FromWindow::Alive;
        let hang = wait_until(Duration::from_millis(100), || {
            hangs.load(Ordering::Relaxed).then_some(())
        });
        if hang.is_some() {
            std::thread::sleep(Duration::from_secs(10));
            return;
        }
    }
}

#[test]
fn a_window_that_hangs_delays_no_stop() {
    let hangs = Arc::new(AtomicBool::new(false));
    let rig = Rig {
        options: vec!["--participant-window=meeting"],
        ..Rig::default()
    };
    let mut session = HungSession::start_prepared(&rig, |folder| {
        let (socket, hangs) = (folder.join("meeting"), Arc::clone(&hangs));
        std::thread::spawn(move || window(socket, hangs));
    });
    hangs.store(true, Ordering::Relaxed);
    std::thread::sleep(Duration::from_millis(200));
    let asked_ns = session.ask(Stop::Key);
    let effect = session.watch(asked_ns, Duration::from_secs(3), false);
    session.end();
    assert_eq!(session.contradictions(), Vec::<String>::new());
    require_in_time(effect);
}
