//! A terminal that stops accepting output, as after Ctrl-S, with Scroll Lock, or behind a stalled connection.

use std::time::{Duration, Instant};

use bench_tests::program::bench;
use bench_tests::running::{Running, wait_until};
use bench_tests::screen::Screen;
use bench_tests::session::patient_config;
use rustix::process::Signal;

const MINUTE: Duration = Duration::from_secs(60);
/// Longest time from a signal to the end; about half a second on an idle machine.
const END: Duration = Duration::from_secs(5);
/// Time without output after which a terminal counts as full.
const FULL: Duration = Duration::from_millis(500);

/// Fault 29.
/// Hazard 15.
#[test]
fn its_stop_key_stops_the_drive_and_a_signal_ends_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let config = patient_config(folder.path());
    let mut screen = Screen::open(200, 60);
    let mut run = bench();
    run.args(["run", "--mock", "--protocol", "demo"])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(&config);
    let mut session = Running::start_on(&screen, &mut run);
    let log = study.join("sub-01/ses-01/events.jsonl");
    let log_with = |words: &str| {
        let log = std::fs::read_to_string(&log).ok()?;
        log.contains(words).then_some(())
    };
    wait_until(MINUTE, || log_with("\"trial_began\"")).unwrap();
    screen.stop_reading();
    let mut output_time = Instant::now();
    let is_full = || {
        if screen.accepts_output() {
            output_time = Instant::now();
        }
        (output_time.elapsed() > FULL).then_some(())
    };
    wait_until(MINUTE, is_full).unwrap();

    screen.press("e");
    wait_until(MINUTE, || log_with("stopped by the operator")).unwrap();
    assert!(!screen.accepts_output());
    session.signal(Signal::TERM);
    session.wait(END);
    assert!(log_with("\"document\":\"stop\"").is_some());
}
