//! Whatever the program does, a signal ends it at once, and its terminal is as it was before.
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
use bench_tests::running::{Running, until};
use bench_tests::screen::Screen;
use bench_tests::session::{SessionFolder, VirtualParticipant, patient_config};
use rustix::process::Signal;

const MINUTE: Duration = Duration::from_secs(60);
/// Longest time that a signal takes to end a command.
const END: Duration = Duration::from_secs(1);
/// Tries at what a busy machine may spoil.
const TRIES: usize = 3;
/// From a command's start to the signal: while it begins.
const EARLY: Duration = Duration::from_millis(700);
/// While it is at work.
const LATE: Duration = Duration::from_millis(1800);

/// Commands that run until a person or a signal ends them.
const COMMANDS: &[&str] = &[
    "run --mock --study new --participant sub-01 --protocol demo --consent-by T --config CONFIG",
    "monitor --mock --config CONFIG",
    "monitor --mock --headless --config CONFIG",
    "calibrate pickup --mock bench-unknown --operator T --config CONFIG",
    "calibrate plate --mock bench-unknown --operator T --config CONFIG",
    "calibrate plate --mock bench-unknown --operator T --config CONFIG --headless",
    "calibrate force --mock bench-unknown --operator T --config CONFIG",
    "calibrate channels --mock bench-unknown --operator T --config CONFIG",
    "calibrate output --mock bench-unknown --operator T --meter M --reads peak --config CONFIG",
    "drill --mock --operator T --config CONFIG",
    "check --mock --config CONFIG",
    "replay RECORDING",
    "replay RECORDING --headless",
    "init",
    "forget STUDY sub-01",
];

fn end(shown: &str) -> String {
    let last: Vec<char> = shown.chars().rev().take(2000).collect();
    last.into_iter().rev().collect()
}

/// Runs `command` and sends `signal` some time after its start; how long the end took.
fn ended_by(signal: Signal, after: Duration, command: &str) -> Result<Duration, String> {
    let folder = tempfile::tempdir().unwrap();
    let screen = Screen::open(120, 40);
    let before = screen.local_modes();
    let mut bench = bench();
    bench.args(command.split_whitespace());
    let mut running = Running::on(&screen, bench.current_dir(folder.path()));
    drop(bench);
    std::thread::sleep(after);
    if running.ended().is_some() {
        return Err(format!("ended by itself: {}", end(&screen.shown())));
    }
    let sent = Instant::now();
    running.signal(signal);
    if until(MINUTE, || running.ended()).is_none() {
        return Err(format!("goes on: {}", end(&screen.shown())));
    }
    let took = sent.elapsed();
    if screen.local_modes() != before {
        return Err("its terminal is not as before".to_owned());
    }
    let shown = screen.to_the_end();
    if shown.contains("panicked") {
        return Err(end(&shown));
    }
    Ok(took)
}

/// Sends both signals to a command in turn, and again where a busy machine was late.
fn judged(command: &str) -> Result<(), String> {
    // On simulated hardware a check is over sooner.
    let late = if command.starts_with("check") {
        EARLY
    } else {
        LATE
    };
    for (signal, after) in [(Signal::TERM, EARLY), (Signal::INT, late)] {
        let mut least = Duration::MAX;
        for _ in 0..TRIES {
            least = least
                .min(ended_by(signal, after, command).map_err(|why| format!("{signal:?}: {why}"))?);
            if least < END {
                break;
            }
        }
        println!("{command}: {signal:?} ended it in {} ms", least.as_millis());
        if least >= END {
            return Err(format!("{signal:?} took {} ms", least.as_millis()));
        }
    }
    Ok(())
}

/// Fault 29.
#[test]
fn ends_within_a_second_of_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    let config = patient_config(folder.path());
    let virtual_participant = VirtualParticipant::run("nominal", 5, folder.path());
    let study = virtual_participant.study;
    let recordings = SessionFolder::read(&study, "sub-01").unwrap().recordings();
    let failed: Vec<_> = COMMANDS
        .iter()
        .filter_map(|command| {
            let placed = command
                .replace("CONFIG", config.to_str().unwrap())
                .replace("RECORDING", recordings[0].to_str().unwrap())
                .replace("STUDY", study.to_str().unwrap());
            Some((*command, judged(&placed).err()?))
        })
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
