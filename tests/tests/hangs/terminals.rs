//! Terminals that hang: one that nobody reads, one that is closed while a thread hangs, and a participant's window that says
//! nothing more.

use std::time::{Duration, Instant};

use bench_tests::hung::{Hung, Rig, Stop};
use bench_tests::running::until;

const MINUTE: Duration = Duration::from_secs(60);
/// A terminal that took nothing for so long is full.
const FULL: Duration = Duration::from_millis(500);
/// Tries at what a busy machine may spoil.
const TRIES: usize = 3;

/// Lets `measure` say how long the plate was driven after a stop, s, until it was short enough.
fn in_time(mut measure: impl FnMut() -> Option<f64>) {
    let mut seen = Vec::new();
    for _ in 0..TRIES {
        seen.push(measure());
        if seen.last().is_some_and(|s| s.is_some_and(|s| s <= 0.050)) {
            return;
        }
    }
    panic!("silent only after {seen:?} s");
}

fn fill(session: &Hung) {
    session.screen.look_away();
    let mut taken = Instant::now();
    let full = || {
        if session.screen.takes_more() {
            taken = Instant::now();
        }
        (taken.elapsed() > FULL).then_some(())
    };
    until(MINUTE, full).unwrap();
}

/// Hazard 15.
#[test]
fn a_terminal_that_nobody_reads_takes_each_stop_key() {
    in_time(|| {
        let mut session = Hung::driving(&Rig::default());
        fill(&session);
        let asked_ns = session.ask(Stop::Interrupt);
        let seen = session.watch(asked_ns, Duration::from_secs(3), false);
        session.end();
        assert_eq!(session.contradictions(), Vec::<String>::new());
        seen.silent_s
    });
}
