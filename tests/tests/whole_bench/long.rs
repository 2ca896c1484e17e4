//! A long free-running session at 192 kHz with 4 channels: no sample lost, and memory does not grow with its length.
//!
//! `docs/performance.md` reports ten minutes of the same, run by hand.

use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::program::protocol;
use bench_tests::recorded::require_every_sample;
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, headless_run};

/// Number of trials of 11 s: nearly two minutes. `FRICTION_BENCH_SOAK_TRIALS` asks for more.
const TRIALS: usize = 10;
/// Moment at which everything that a session needs is in memory, s of simulated time.
const EARLY_S: f64 = 30.0;
/// Simulated time on either side of a moment over which the greatest memory is taken, s.
const STRETCH_S: f64 = 15.0;
/// Greatest growth, kB, while over 180 MB are recorded in more than a minute.
const GROWTH_KB: i64 = 8 * 1024;

#[cfg(target_os = "linux")]
#[test]
fn minutes_lose_no_sample_and_take_no_more_memory_than_one() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let trials = campaign::repeats("FRICTION_BENCH_SOAK_TRIALS", TRIALS).max(TRIALS);
    let text = std::fs::read_to_string(protocol("long.toml")).unwrap();
    let protocol_text = text.replace("per_condition = 54", &format!("per_condition = {trials}"));
    assert!(trials == 54 || protocol_text != text);
    let path = folder.path().join("long.toml");
    std::fs::write(&path, protocol_text).unwrap();

    let start = Instant::now();
    let mut running = Running::start(
        &mut headless_run(&study, "sub-01", &path),
        &folder.path().join("output"),
    );
    let mut memory: Vec<(f64, i64)> = Vec::new();
    let status = loop {
        if let Some(status) = running.exit_status() {
            break status;
        }
        assert!(
            start.elapsed() < Duration::from_secs(34 * trials as u64),
            "{}",
            running.output()
        );
        let session = SessionFolder::read(&study, "sub-01");
        let now_s = session.and_then(|session| Some(session.events().last()?.audio_s));
        memory.extend(now_s.zip(running.resident_kb()));
        std::thread::sleep(Duration::from_millis(100));
    };
    let wall_s = start.elapsed().as_secs_f64();
    let transcript = running.output();
    assert!(status.success(), "{transcript}");
    assert!(
        transcript.contains("drop-outs         0 audio frames lost, 0 input and 0 output xruns"),
        "{transcript}"
    );

    let simulated_s = memory.last().unwrap().0;
    assert!(simulated_s > 3.5 * EARLY_S, "{simulated_s} s");
    let greatest_kb = |centre_s: f64| {
        let readings = memory
            .iter()
            .filter(|(time_s, _)| (time_s - centre_s).abs() < STRETCH_S);
        readings
            .map(|(_, kb)| *kb)
            .max()
            .expect("memory was looked at often enough")
    };
    let (early_kb, late_kb) = (greatest_kb(EARLY_S), greatest_kb(simulated_s - STRETCH_S));
    let speed = simulated_s / wall_s;
    campaign::report(
        "trials of one long session",
        trials,
        &format!(
            "{simulated_s:.0} s in {wall_s:.1} s, {speed:.1} times real time; {early_kb} kB after {EARLY_S} s, {late_kb} kB at the end"
        ),
    );
    assert!(
        late_kb - early_kb < GROWTH_KB,
        "{early_kb} kB after {EARLY_S} s, {late_kb} kB at the end"
    );

    let session = SessionFolder::read(&study, "sub-01").unwrap();
    assert!(require_every_sample(&session, 0) >= trials);
}
