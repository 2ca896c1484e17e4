//! One thread hangs in one call, and the bench is stopped: the plate is silent in time, SIGTERM ends the process, and the study
//! is free of contradictions. Without a stop, the safety watch notices a hanging thread that decides about the drive.
//!
//! Times run from the key or the signal to the last driven sample at the plate. They include the delays of the terminal, the
//! program and the buffers of the simulated card, and the lateness of a busy machine. The lateness of one of the test's threads
//! is allowed for, and a miss is measured again.

use std::fmt::Write;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::hung::{HungSession, Rig, Stop};

use super::calls::CALLS;

/// Longest time from a stop to silence, s.
const SILENT_S: f64 = 0.050;
/// Longest time from SIGTERM to the end of the process, s.
const ENDED_S: f64 = 1.0;
/// Longest time from the hang of a thread that decides about the drive to silence, s.
const MISSED_S: f64 = 1.5;
/// Number of measurements before a miss counts: a busy machine may be late, the program may not.
const TRIES: usize = 4;
/// Time within which a thread makes each of its calls.
const CALLED: Duration = Duration::from_secs(4);
/// Time from the hang to the stop, shorter than the watch's timeout for a thread.
const AFTER: Duration = Duration::from_millis(300);
/// Number of sessions measured in parallel.
const ABREAST: usize = 2;
/// Duration of an observation and of a usual hang.
const HANG: Duration = Duration::from_secs(5);

/// Threads that the safety watch, or its supervisor, must find silent during a hang.
const DECIDING: &[&str] = &["session", "safety", "acquisition", "apparatus"];
/// Thread that reads keys: while it hangs, keys have no effect.
const READER: &str = "keys";

/// A thread and the call in which it hangs.
type Place = (&'static str, &'static str);

/// Result of one hang under one stop.
enum Seen {
    /// The thread made no such call.
    NotMet,
    /// The stop worked, with a description.
    Well(String),
    /// The stop did not work, with a description.
    Badly(String),
}

fn ms(s: Option<f64>) -> String {
    s.map_or_else(|| "never".to_owned(), |s| format!("{:.0} ms", 1e3 * s))
}

/// Lets a thread hang and stops the bench.
fn stopped(rig: &Rig, (thread, call): Place, stop: Stop, hang: Duration) -> Seen {
    let mut session = HungSession::start(rig);
    let Some(held) = session.hold(thread, call, CALLED) else {
        session.end();
        return Seen::NotMet;
    };
    let begun = Instant::now();
    std::thread::sleep(AFTER);
    let asked_ns = session.ask(stop);
    let ends = stop == Stop::Terminate;
    let seen = session.watch(asked_ns, HANG.min(hang), ends);
    while begun.elapsed() < hang && !bench_tests::thread_hold::has_ended(session.pid()) {
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(held);
    session.end();
    let deaf = stop.is_typed() && thread == READER;
    let silent = deaf || seen.silent_s.is_some_and(|s| s <= SILENT_S + seen.late_s);
    let ended = !ends || seen.ended_s.is_some_and(|s| s <= ENDED_S + seen.late_s);
    let mut words = format!("{stop}: silent {}", ms(seen.silent_s));
    if ends {
        let _ = write!(words, ", ended {}", ms(seen.ended_s));
    }
    let contradictions = session.contradictions();
    if !contradictions.is_empty() {
        return Seen::Badly(format!("{words}, {}", contradictions.join("; ")));
    }
    if silent && ended {
        Seen::Well(words)
    } else {
        Seen::Badly(words)
    }
}

/// Lets a thread hang without a stop, and stops the bench afterwards.
fn unattended(rig: &Rig, (thread, call): Place) -> Seen {
    let mut session = HungSession::start(rig);
    let Some(held) = session.hold(thread, call, CALLED) else {
        session.end();
        return Seen::NotMet;
    };
    let held_ns = mock_hw::oscilloscope::monotonic_ns();
    let missed = session.watch(held_ns, Duration::from_secs(3), false);
    let asked_ns = session.ask(Stop::Terminate);
    let seen = session.watch(asked_ns, HANG, true);
    drop(held);
    session.end();
    let must = DECIDING.contains(&thread) || thread == READER;
    let words = format!(
        "unattended: silent {}, then SIGTERM: silent {}",
        ms(missed.silent_s),
        ms(seen.silent_s)
    );
    let well = !must
        || missed
            .silent_s
            .is_some_and(|s| s <= MISSED_S + missed.late_s);
    let stops = seen.silent_s.is_some_and(|s| s <= SILENT_S + seen.late_s);
    let contradictions = session.contradictions();
    if !contradictions.is_empty() {
        Seen::Badly(format!("{words}, {}", contradictions.join("; ")))
    } else if well && stops {
        Seen::Well(words)
    } else {
        Seen::Badly(words)
    }
}

/// Repeats a failed measurement, since a machine may be late; returns the last result and the number of measurements.
fn repeated(mut measure: impl FnMut() -> Seen) -> (Seen, usize) {
    let mut last = Seen::NotMet;
    for tries in 1..=TRIES {
        last = measure();
        if !matches!(last, Seen::Badly(_)) {
            return (last, tries);
        }
    }
    (last, TRIES)
}

/// Measures the hangs of one place; returns the descriptions of all, and those of the failures.
fn at_place(rig: &Rig, place: Place, stops: &[Stop], hang: Duration) -> (String, Vec<String>) {
    let (mut words, mut bad) = (Vec::new(), Vec::new());
    let mut note = |(seen, tries): (Seen, usize)| {
        let again = if tries > 1 {
            format!(" (looked {tries} times)")
        } else {
            String::new()
        };
        match seen {
            Seen::NotMet => false,
            Seen::Well(text) => {
                words.push(text + &again);
                true
            }
            Seen::Badly(text) => {
                let (thread, call) = place;
                bad.push(format!("{thread} in {call}: {text}{again}"));
                words.push(format!("BAD {text}{again}"));
                true
            }
        }
    };
    for stop in stops {
        if !note(repeated(|| stopped(rig, place, *stop, hang))) {
            return ("not met in a session".to_owned(), Vec::new());
        }
    }
    if stops.len() > 1 {
        note(repeated(|| unattended(rig, place)));
    }
    (words.join("; "), bad)
}

/// Calls that every thread makes.
const EVERYWHERE: [&str; 2] = ["clock_nanosleep", "futex"];
/// Calls that a disk or a network can block for long.
const LONG: [&str; 8] = [
    "statfs",
    "statx",
    "write",
    "fdatasync",
    "fsync",
    "openat",
    "rename",
    "read",
];

/// Returns sessions with different devices, each with the only thread to measure, or `None` for all threads.
fn rigs() -> Vec<(Rig, Option<&'static str>)> {
    let scenario = |scenario| Rig {
        scenario,
        ..Rig::default()
    };
    vec![
        (Rig::default(), None),
        (scenario("net-ft"), Some("field")),
        (scenario("field-box"), Some("field")),
    ]
}

/// Hangs of every test run, one for each kind of thread.
const SAMPLE: [(Place, Stop); 4] = [
    (("session", "clock_nanosleep"), Stop::Key),
    (("recorder", "fdatasync"), Stop::Interrupt),
    (("dashboard", "ioctl"), Stop::Terminate),
    (("signals", "recvfrom"), Stop::Terminate),
];

/// The complete test takes hours: `./dev campaign hangs`, which asks for more hangs than the sample has.
///
/// Faults 27, 29.
/// Hazard 15.
#[test]
fn every_stop_silences_the_plate_whatever_thread_hangs() {
    let places = campaign::repeats("FRICTION_BENCH_HANGS", SAMPLE.len());
    let bad = if places <= SAMPLE.len() {
        sample(&SAMPLE[..places])
    } else {
        whole(places)
    };
    assert!(bad.is_empty(), "{bad:#?}");
}

fn sample(places: &[(Place, Stop)]) -> Vec<String> {
    let mut bad = Vec::new();
    for (place, stop) in places {
        let hang = Duration::from_millis(1500);
        let (words, ill) = at_place(&Rig::default(), *place, &[*stop], hang);
        let (thread, call) = place;
        campaign::report(&format!("{thread} held in {call}"), 1, &words);
        bad.extend(ill);
    }
    bad
}

/// Measures up to `most` threads and calls of the table under all stops.
fn whole(most: usize) -> Vec<String> {
    let mut places = Vec::new();
    for (rig, only) in rigs() {
        for (thread, calls) in CALLS {
            if only.is_none_or(|only| only == *thread) {
                let calls = EVERYWHERE.iter().chain(*calls);
                places.extend(calls.map(|call| (rig.clone(), (*thread, *call))));
            }
        }
    }
    places.truncate(most);
    let (waiting, bad) = (Mutex::new(places.into_iter()), Mutex::new(Vec::new()));
    // Run in parallel, since most of the time is waiting.
    let measures = || {
        while let Some((rig, place)) = next(&waiting) {
            let ill = every_stop_at(&rig, place);
            bad.lock().unwrap().extend(ill);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..ABREAST {
            scope.spawn(measures);
        }
    });
    bad.into_inner().unwrap()
}

fn next<T>(waiting: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    waiting.lock().unwrap().next()
}

/// Measures the hangs of one place under all stops, and a hang of a minute if a disk or network can cause it; returns the
/// failures.
fn every_stop_at(rig: &Rig, place: Place) -> Vec<String> {
    let (thread, call) = place;
    let (mut words, mut bad) = at_place(rig, place, &Stop::ALL, HANG);
    if LONG.contains(&call) && !words.starts_with("not met") {
        let minute = Duration::from_secs(60);
        let (long, ill) = at_place(rig, place, &[Stop::Key], minute);
        let _ = write!(words, "; 60 s under {long}");
        bad.extend(ill);
    }
    let what = format!("{}: {thread} held in {call}", rig.scenario);
    campaign::report(&what, 1, &words);
    bad
}
