//! Every command ends promptly on a signal and restores its terminal.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]
#![expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]

use std::time::{Duration, Instant};

use bench_tests::program::bench;
use bench_tests::running::{Running, wait_until};
use bench_tests::screen::{Screen, last_characters};
use bench_tests::session::{SessionFolder, VirtualParticipant, patient_config};
use rustix::process::Signal;

const MINUTE: Duration = Duration::from_secs(60);
/// Longest time from a signal to the end of a command.
const END: Duration = Duration::from_secs(1);
/// Time from a command's start to a signal during its start-up.
const EARLY: Duration = Duration::from_millis(700);
/// Time from a command's start to a signal during its work.
const LATE: Duration = Duration::from_millis(1800);

/// Runs `command` and sends `signal` some time after its start; returns the time to its end.
fn time_to_end(signal: Signal, delay: Duration, command: &str) -> Result<Duration, String> {
    let folder = tempfile::tempdir().unwrap();
    let screen = Screen::open(120, 40);
    let modes = screen.local_modes();
    let mut bench = bench();
    bench.args(command.split_whitespace());
    let mut running = Running::start_on(&screen, bench.current_dir(folder.path()));
    drop(bench);
    std::thread::sleep(delay);
    if running.exit_status().is_some() {
        return Err(format!(
            "ended by itself: {}",
            last_characters(&screen.output())
        ));
    }
    let start = Instant::now();
    running.signal(signal);
    if wait_until(MINUTE, || running.exit_status()).is_none() {
        return Err(format!("goes on: {}", last_characters(&screen.output())));
    }
    let duration = start.elapsed();
    if screen.local_modes() != modes {
        return Err("its terminal is not as before".to_owned());
    }
    let transcript = screen.read_to_end();
    if transcript.contains("panicked") {
        return Err(last_characters(&transcript));
    }
    Ok(duration)
}

/// Sends both signals to a command, in two runs.
fn check_signals(command: &str) -> Result<(), String> {
    // On simulated hardware a check ends earlier.
    let int_delay = if command.starts_with("check") {
        EARLY
    } else {
        LATE
    };
    for (signal, delay) in [(Signal::TERM, EARLY), (Signal::INT, int_delay)] {
        let duration =
            time_to_end(signal, delay, command).map_err(|error| format!("{signal:?}: {error}"))?;
        println!(
            "{command}: {signal:?} ended it in {} ms",
            duration.as_millis()
        );
        if duration >= END {
            return Err(format!("{signal:?} took {} ms", duration.as_millis()));
        }
    }
    Ok(())
}

/// Requires a signal to end each of `commands` within a second; each runs until a person or a signal ends it.
fn require_signal_ends(commands: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let config = patient_config(folder.path());
    let failures: Vec<_> = commands
        .iter()
        .filter_map(|command| {
            let command_line = command.replace("CONFIG", config.to_str().unwrap());
            Some((*command, check_signals(&command_line).err()?))
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Fault 29.
#[test]
fn a_signal_ends_a_session_and_a_monitor_within_a_second() {
    require_signal_ends(&[
        "run --mock --study new --participant sub-01 --protocol demo --consent-by T --config CONFIG",
        "monitor --mock --config CONFIG",
        "monitor --mock --headless --config CONFIG",
    ]);
}

/// Fault 29.
#[test]
fn a_signal_ends_each_calibration_within_a_second() {
    require_signal_ends(&[
        "calibrate pickup --mock bench-unknown --operator T --config CONFIG",
        "calibrate plate --mock bench-unknown --operator T --config CONFIG",
        "calibrate plate --mock bench-unknown --operator T --config CONFIG --headless",
        "calibrate force --mock bench-unknown --operator T --config CONFIG",
        "calibrate channels --mock bench-unknown --operator T --config CONFIG",
        "calibrate output --mock bench-unknown --operator T --meter M --reads peak --config CONFIG",
    ]);
}

/// Fault 29.
#[test]
fn a_signal_ends_a_drill_a_check_and_a_setup_within_a_second() {
    require_signal_ends(&[
        "drill --mock --operator T --config CONFIG",
        "check --mock --config CONFIG",
        "init",
    ]);
}

/// Fault 29.
#[test]
fn a_signal_ends_what_is_done_with_a_study_within_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let study = VirtualParticipant::run("nominal", 5, folder.path()).study;
    let recordings = SessionFolder::read(&study, "sub-01").unwrap().recordings();
    let recording = recordings[0].display();
    require_signal_ends(&[
        &format!("replay {recording}"),
        &format!("replay {recording} --headless"),
        &format!("forget {} sub-01", study.display()),
    ]);
}
