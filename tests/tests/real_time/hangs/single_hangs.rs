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
const CALL_TIMEOUT: Duration = Duration::from_secs(4);
/// Time from the hang to the stop, shorter than the watch's timeout for a thread.
const STOP_DELAY: Duration = Duration::from_millis(300);
/// Number of sessions measured in parallel.
const PARALLEL: usize = 2;
/// Duration of an observation and of a usual hang.
const HANG: Duration = Duration::from_secs(5);

/// Threads that the safety watch, or its supervisor, must find silent during a hang.
const DECIDING: &[&str] = &["session", "safety", "acquisition", "apparatus"];
/// Thread that reads keys: while it hangs, keys have no effect.
const READER: &str = "keys";

/// A thread and the call in which it hangs.
type HangPoint = (&'static str, &'static str);

/// Result of one hang under one stop.
enum HangResult {
    /// The thread made no such call.
    Unmet,
    /// The stop worked, with a description.
    Pass(String),
    /// The stop did not work, with a description.
    Failure(String),
}

fn ms(s: Option<f64>) -> String {
    s.map_or_else(|| "never".to_owned(), |s| format!("{:.0} ms", 1e3 * s))
}

/// Lets a thread hang and stops the bench.
fn measure_stop(rig: &Rig, (thread, call): HangPoint, stop: Stop, hang: Duration) -> HangResult {
    let mut session = HungSession::start(rig);
    let Some(hold) = session.hold(thread, call, CALL_TIMEOUT) else {
        session.end();
        return HangResult::Unmet;
    };
    let start = Instant::now();
    std::thread::sleep(STOP_DELAY);
    let asked_ns = session.ask(stop);
    let awaits_end = stop == Stop::Terminate;
    let effect = session.watch(asked_ns, HANG.min(hang), awaits_end);
    while start.elapsed() < hang && !bench_tests::thread_hold::has_ended(session.pid()) {
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(hold);
    session.end();
    let is_deaf = stop.is_typed() && thread == READER;
    let is_silent = is_deaf
        || effect
            .silent_s
            .is_some_and(|s| s <= SILENT_S + effect.late_s);
    let has_ended = !awaits_end || effect.ended_s.is_some_and(|s| s <= ENDED_S + effect.late_s);
    let mut text = format!("{stop}: silent {}", ms(effect.silent_s));
    if awaits_end {
        let _ = write!(text, ", ended {}", ms(effect.ended_s));
    }
    let contradictions = session.contradictions();
    if !contradictions.is_empty() {
        return HangResult::Failure(format!("{text}, {}", contradictions.join("; ")));
    }
    if is_silent && has_ended {
        HangResult::Pass(text)
    } else {
        HangResult::Failure(text)
    }
}

/// Lets a thread hang without a stop, and stops the bench afterwards.
fn measure_unstopped(rig: &Rig, (thread, call): HangPoint) -> HangResult {
    let mut session = HungSession::start(rig);
    let Some(hold) = session.hold(thread, call, CALL_TIMEOUT) else {
        session.end();
        return HangResult::Unmet;
    };
    let hang_ns = mock_hw::oscilloscope::monotonic_ns();
    let watch_effect = session.watch(hang_ns, Duration::from_secs(3), false);
    let asked_ns = session.ask(Stop::Terminate);
    let stop_effect = session.watch(asked_ns, HANG, true);
    drop(hold);
    session.end();
    let is_required = DECIDING.contains(&thread) || thread == READER;
    let text = format!(
        "unattended: silent {}, then SIGTERM: silent {}",
        ms(watch_effect.silent_s),
        ms(stop_effect.silent_s)
    );
    let is_watched = !is_required
        || watch_effect
            .silent_s
            .is_some_and(|s| s <= MISSED_S + watch_effect.late_s);
    let is_stopped = stop_effect
        .silent_s
        .is_some_and(|s| s <= SILENT_S + stop_effect.late_s);
    let contradictions = session.contradictions();
    if !contradictions.is_empty() {
        HangResult::Failure(format!("{text}, {}", contradictions.join("; ")))
    } else if is_watched && is_stopped {
        HangResult::Pass(text)
    } else {
        HangResult::Failure(text)
    }
}

/// Repeats a failed measurement, since a machine may be late; returns the last result and the number of measurements.
fn repeat(mut measure: impl FnMut() -> HangResult) -> (HangResult, usize) {
    let mut result = HangResult::Unmet;
    for attempts in 1..=TRIES {
        result = measure();
        if !matches!(result, HangResult::Failure(_)) {
            return (result, attempts);
        }
    }
    (result, TRIES)
}

/// Measures the hangs of one place; returns the descriptions of all, and those of the failures.
fn measure_point(
    rig: &Rig,
    point: HangPoint,
    stops: &[Stop],
    hang: Duration,
) -> (String, Vec<String>) {
    let (mut texts, mut failures) = (Vec::new(), Vec::new());
    let mut record = |(result, attempts): (HangResult, usize)| {
        let suffix = if attempts > 1 {
            format!(" (looked {attempts} times)")
        } else {
            String::new()
        };
        match result {
            HangResult::Unmet => false,
            HangResult::Pass(text) => {
                texts.push(text + &suffix);
                true
            }
            HangResult::Failure(text) => {
                let (thread, call) = point;
                failures.push(format!("{thread} in {call}: {text}{suffix}"));
                texts.push(format!("BAD {text}{suffix}"));
                true
            }
        }
    };
    for stop in stops {
        if !record(repeat(|| measure_stop(rig, point, *stop, hang))) {
            return ("not met in a session".to_owned(), Vec::new());
        }
    }
    if stops.len() > 1 {
        record(repeat(|| measure_unstopped(rig, point)));
    }
    (texts.join("; "), failures)
}

/// Calls that every thread makes.
const COMMON_CALLS: [&str; 2] = ["clock_nanosleep", "futex"];
/// Calls that a disk or a network can block for long.
const BLOCKING_CALLS: [&str; 8] = [
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
const SAMPLE: [(HangPoint, Stop); 4] = [
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
    let count = campaign::repeats("FRICTION_BENCH_HANGS", SAMPLE.len());
    let failures = if count <= SAMPLE.len() {
        sample(&SAMPLE[..count])
    } else {
        measure_table(count)
    };
    assert!(failures.is_empty(), "{failures:#?}");
}

fn sample(points: &[(HangPoint, Stop)]) -> Vec<String> {
    let mut failures = Vec::new();
    for (point, stop) in points {
        let hang = Duration::from_millis(1500);
        let (text, point_failures) = measure_point(&Rig::default(), *point, &[*stop], hang);
        let (thread, call) = point;
        campaign::report(&format!("{thread} held in {call}"), 1, &text);
        failures.extend(point_failures);
    }
    failures
}

/// Measures up to `count` threads and calls of the table under all stops.
fn measure_table(count: usize) -> Vec<String> {
    let mut points = Vec::new();
    for (rig, thread_filter) in rigs() {
        for (thread, calls) in CALLS {
            if thread_filter.is_none_or(|thread_filter| thread_filter == *thread) {
                let calls = COMMON_CALLS.iter().chain(*calls);
                points.extend(calls.map(|call| (rig.clone(), (*thread, *call))));
            }
        }
    }
    points.truncate(count);
    let (queue, failures) = (Mutex::new(points.into_iter()), Mutex::new(Vec::new()));
    // Run in parallel, since most of the time is waiting.
    let worker = || {
        while let Some((rig, point)) = next_point(&queue) {
            let point_failures = measure_all_stops(&rig, point);
            failures.lock().unwrap().extend(point_failures);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..PARALLEL {
            scope.spawn(worker);
        }
    });
    failures.into_inner().unwrap()
}

fn next_point<T>(queue: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    queue.lock().unwrap().next()
}

/// Measures the hangs of one place under all stops, and a hang of a minute if a disk or network can cause it; returns the
/// failures.
fn measure_all_stops(rig: &Rig, point: HangPoint) -> Vec<String> {
    let (thread, call) = point;
    let (mut text, mut failures) = measure_point(rig, point, &Stop::ALL, HANG);
    if BLOCKING_CALLS.contains(&call) && !text.starts_with("not met") {
        let minute = Duration::from_secs(60);
        let (minute_text, minute_failures) = measure_point(rig, point, &[Stop::Key], minute);
        let _ = write!(text, "; 60 s under {minute_text}");
        failures.extend(minute_failures);
    }
    let name = format!("{}: {thread} held in {call}", rig.scenario);
    campaign::report(&name, 1, &text);
    failures
}
