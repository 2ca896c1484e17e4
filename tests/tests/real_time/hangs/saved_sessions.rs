//! Random sequences of hangs, stops, kills and resumed sessions: after each, log, recordings, `verify` and analysis agree, and
//! the sequence completes.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::hung::contradictions;
use bench_tests::running::{Running, wait_until};
use bench_tests::session::{headless_run, write_demo_protocol};
use bench_tests::thread_hold::{ThreadHold, has_ended, numbers, threads};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;
use tempfile::TempDir;

/// Number of sequences in every test run; `FRICTION_BENCH_SEQUENCES` asks for more.
const SEQUENCES: usize = 6;
/// Runs of a sequence before its last, complete one.
const RUNS: usize = 3;
const MINUTE: Duration = Duration::from_secs(60);

/// Threads of a session in lock step that access the disk.
const THREADS: [&str; 2] = ["recorder", "friction-bench"];
/// Their calls.
const CALLS: [&str; 6] = ["write", "fdatasync", "fsync", "openat", "rename", "statx"];

/// A study to be recorded by one short session.
struct StudyFolder {
    folder: TempDir,
    study: PathBuf,
    protocol: PathBuf,
}

impl StudyFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let changes = [
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 2"),
            (
                "[\"left_to_right\", \"right_to_left\"]",
                "[\"left_to_right\"]",
            ),
            ("speed_m_per_s = 0.050", "speed_m_per_s = 0.080"),
            ("baseline_s = 0.8", "baseline_s = 0.3"),
            ("countdown_s = 1.0", "countdown_s = 0.2"),
            ("feedback_s = 1.0", "feedback_s = 0.1"),
            ("verdict_s = 0.5", "verdict_s = 0.1"),
            ("every_trials = 2", "every_trials = 0"),
            ("min_instances = 5", "min_instances = 1"),
        ];
        Self {
            study: folder.path().join("study"),
            protocol: write_demo_protocol(folder.path(), &changes),
            folder,
        }
    }

    fn start(&self) -> Running {
        let mut run = headless_run(&self.study, "sub-01", &self.protocol);
        if self.study.join("sub-01/ses-01/events.jsonl").exists() {
            run.arg("--resume");
        }
        Running::start(&mut run, &self.folder.path().join("output"))
    }
}

/// A disturbance of a run.
#[derive(Debug)]
struct Event {
    delay: Duration,
    hang: Option<(&'static str, &'static str, Duration)>,
    signal: Option<Signal>,
}

impl Event {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let thread = THREADS[rng.random_range(0..THREADS.len())];
        let call = CALLS[rng.random_range(0..CALLS.len())];
        // The longest hang overflows the recorder's queue at the pace of these sessions.
        let duration = Duration::from_millis(rng.random_range(20..3000));
        Self {
            delay: Duration::from_millis(rng.random_range(0..1500)),
            hang: rng.random_bool(0.7).then_some((thread, call, duration)),
            signal: match rng.random_range(0..5) {
                0 => Some(Signal::TERM),
                1 => Some(Signal::INT),
                2 | 3 => Some(Signal::KILL),
                _ => None,
            },
        }
    }

    /// Disturbs a run and waits for its end.
    fn disturb(&self, mut running: Running) {
        let pid = running.pid();
        let start = Instant::now();
        let _end = wait_until(self.delay, || {
            (has_ended(pid) || start.elapsed() >= self.delay).then_some(())
        });
        let hold = self.hang.and_then(|(name, call, duration)| {
            let thread = threads(pid)
                .into_iter()
                .find(|thread| thread.name == name)?;
            let timeout = Duration::from_secs(1);
            Some((
                ThreadHold::begin(pid, thread.id, &numbers(call), timeout)?,
                duration,
            ))
        });
        if let Some((hold, duration)) = hold {
            let start = Instant::now();
            if let Some(signal) = self.signal {
                std::thread::sleep(duration / 2);
                running.signal(signal);
            }
            let _end = wait_until(duration, || {
                (has_ended(pid) || start.elapsed() >= duration).then_some(())
            });
            drop(hold);
        } else if let Some(signal) = self.signal {
            running.signal(signal);
        }
        running.wait(MINUTE);
    }
}

/// Completes one sequence; returns the number of its hangs.
fn sequence(seed: u64) -> Result<usize, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let folder = StudyFolder::new();
    let (mut hangs, mut events) = (0, Vec::new());
    for _ in 0..RUNS {
        let event = Event::random(&mut rng);
        hangs += usize::from(event.hang.is_some());
        event.disturb(folder.start());
        events.push(event);
        if !folder.study.join("sub-01/ses-01/events.jsonl").exists() {
            continue;
        }
        let conflicts = contradictions(&folder.study);
        if !conflicts.is_empty() {
            return Err(format!("seed {seed}: after {events:?}: {conflicts:?}"));
        }
    }
    let mut last_run = folder.start();
    last_run.wait(MINUTE);
    let conflicts = contradictions(&folder.study);
    if conflicts.is_empty() {
        Ok(hangs)
    } else {
        Err(format!(
            "seed {seed}: resumed after {events:?}: {conflicts:?}"
        ))
    }
}

/// Faults 27, 28.
/// Hazard 14.
#[test]
fn after_hangs_stops_and_kills_in_any_order_nothing_contradicts_anything() {
    let start = Instant::now();
    let count = campaign::repeats("FRICTION_BENCH_SEQUENCES", SEQUENCES);
    let (next_seed, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let cores = std::thread::available_parallelism().unwrap().get();
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let seed = next_seed.fetch_add(1, Ordering::Relaxed);
                    if seed >= count {
                        break;
                    }
                    results.lock().unwrap().push(sequence(seed as u64));
                }
            });
        }
    });
    let results = results.into_inner().unwrap();
    let hangs: usize = results.iter().flatten().sum();
    let failures: Vec<_> = results
        .iter()
        .filter_map(|result| result.as_ref().err())
        .collect();
    campaign::report(
        "sequences of hang, stop, kill and resume",
        results.len(),
        &format!(
            "{} with a contradiction, {hangs} hangs, in {:.0} s",
            failures.len(),
            start.elapsed().as_secs_f64()
        ),
    );
    assert!(failures.is_empty(), "{failures:#?}");
}
