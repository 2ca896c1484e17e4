//! Sessions in real time while another process keeps a core busy: every sample accounted for, and memory that does not grow.
//!
//! In a program of its own, so that no other test runs beside it. The bench bears with more than a real one: what stands in for the
//! force sensor's line is carried across by a worker of the kernel, which a busy machine keeps waiting.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::program::{bench, protocol};
use bench_tests::recorded::every_sample;
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, patient_config, with};
use recording::RecordingReader;

/// Length of one trial of the protocol, s.
const TRIAL_S: f64 = 11.0;
/// The log and the recording have the ends of a trial from two tasks, some of their rounds apart.
const WITHIN_FRAMES: usize = 9600;
/// Most memory that a session takes, kB: a sample of 20 s that kept all it acquires, 3 MB a second, would take more.
const MOST_KB: i64 = 192 * 1024;
/// Most memory that a long run takes more in its last part than in its middle, kB. Queues that fill once while the machine is
/// busy, and fits after the first trials, keep what they took; a leak goes on.
const GROWTH_KB: i64 = 8 * 1024;
/// Length of a run of which that can be told, s.
const LONG_S: usize = 300;
/// Parts of a run, as shares of its time, whose greatest memory is compared: it has begun, it is half done, it ends.
const PARTS: [(f64, f64); 3] = [(0.1, 0.3), (0.4, 0.6), (0.8, 1.0)];

/// What the estimate of the sensor's clock may move by within a recording while a busy machine delays what carries it, in samples
/// of the sensor: a step of the clock by 5 ms was seen in the first trial of a session, and it looks like five samples lost.
const CLOCK_MOVES: i64 = 8;

/// Usual steps of the sensor after which a recording has its first row, where nothing was lost as it began: bursts of 4 ms.
const BEGINS_LATE_STEPS: f64 = 100.0;

/// Time before the end of a recording in which a burst can begin that reaches over it, s: what a line holds while nobody reads.
const ENDS_IN_S: f64 = 0.05;

/// Greatest memory that was seen between two times, kB.
fn greatest(seen: &[(f64, i64)], from_s: f64, to_s: f64) -> Option<i64> {
    let stretch = seen
        .iter()
        .filter(|(at_s, _)| (from_s..to_s).contains(at_s));
    stretch.map(|(_, kb)| *kb).max()
}

/// Samples of the force sensor that a recording has lost, as its events say, which must be what its rows lack.
fn lost_forces(path: &Path) -> u64 {
    let reader = RecordingReader::open(path).unwrap();
    let times_s: Vec<f64> = reader
        .force()
        .unwrap()
        .map(|row| row.unwrap().time_s)
        .collect();
    let mut steps_s: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps_s.sort_by(f64::total_cmp);
    let usual_s = steps_s[steps_s.len() / 2];
    let lacking_in = |step_s: &f64| (step_s / usual_s).round() as i64 - 1;
    let lacking: i64 = steps_s.iter().map(lacking_in).sum();
    let ending = reader.frames() - (ENDS_IN_S * f64::from(reader.format().sample_rate_hz)) as u64;
    let said = |what: &str, from: u64| -> u64 {
        let events = reader.manifest().events.iter();
        let events = events.filter(|event| event.sample >= from);
        let texts = events.filter_map(|event| event.text.as_deref()?.split_once(what));
        let counts = texts.map(|(_, text)| text.split(',').next().unwrap().parse::<u64>());
        counts.map(Result::unwrap).sum()
    };
    let lost = said("force frames lost: ", 0);
    let corrupt = said("force frames corrupt: ", 0);
    let lost_at_its_end = said("force frames lost: ", ending);
    // The usual step is known to some parts in ten thousand, by which a long gap is too long or too short.
    let within = CLOCK_MOVES + (lost / 1000 + corrupt) as i64;
    let said = format!(
        "{}: {lost} said to be lost, {lacking} lacking",
        path.display()
    );
    assert!(lost as i64 >= lacking - within, "{said}");
    // A loss that reaches over an end of a recording is the recording's, and its rows lack a part of it alone.
    let begins_in_a_loss = times_s[0] > BEGINS_LATE_STEPS * usual_s;
    assert!(
        begins_in_a_loss || (lost - lost_at_its_end) as i64 <= lacking + within,
        "{said}, {lost_at_its_end} of it at the end; rows from {} s on",
        times_s[0]
    );
    lost
}

/// Faults 7, 22, 24.
#[test]
fn real_time_beside_a_busy_process_loses_no_sample() {
    let seconds = campaign::repeats("FRICTION_BENCH_SOAK_S", 20);
    let trials = (seconds as f64 / TRIAL_S).ceil() as usize;
    let folder = tempfile::tempdir().unwrap();
    let (study, path) = (folder.path().join("study"), folder.path().join("long.toml"));
    let text = std::fs::read_to_string(protocol("long.toml")).unwrap();
    // Without a rest a whole hour would be driven, which is all that a person's dose allows, and the last trial would not fit.
    let as_long = with(
        &text,
        &[
            ("per_condition = 54", &format!("per_condition = {trials}")),
            ("every_trials = 0", "every_trials = 40"),
            ("min_s = 2.0", "min_s = 10.0"),
        ],
    );
    std::fs::write(&path, as_long).unwrap();

    let mut endless = Command::new("sh");
    endless.args(["-c", "while :; do :; done"]);
    let _busy = Running::start(&mut endless, &folder.path().join("busy"));
    let mut run = bench();
    run.args(["run", "--mock", "--headless", "--participant", "sub-01"])
        .args(["--consent-by", "A. Tester"])
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(patient_config(folder.path()))
        .arg("--protocol")
        .arg(&path);
    let begin = Instant::now();
    let mut running = Running::start(&mut run, &folder.path().join("output"));
    let mut memory = Vec::new();
    let status = loop {
        if let Some(status) = running.ended() {
            break status;
        }
        let at_s = begin.elapsed().as_secs_f64();
        assert!(
            at_s < 60.0 + 2.0 * TRIAL_S * trials as f64,
            "{}",
            running.output()
        );
        memory.extend(running.resident_kb().map(|kb| (at_s, kb)));
        std::thread::sleep(Duration::from_millis(250));
    };
    let whole_s = begin.elapsed().as_secs_f64();
    let printed = running.output();
    assert!(status.success(), "{printed}");
    assert!(
        printed.contains("drop-outs         0 frames lost, 0 input and 0 output xruns"),
        "{printed}"
    );
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let recordings = every_sample(&session, WITHIN_FRAMES);
    assert!(recordings >= trials, "{recordings} of {trials}");
    let lost: u64 = session
        .recordings()
        .iter()
        .map(|path| lost_forces(path))
        .sum();

    let most = greatest(&memory, 0.0, f64::INFINITY).expect("memory is read four times a second");
    let taken = PARTS.map(|(from, to)| {
        greatest(&memory, from * whole_s, to * whole_s).expect("memory is read four times a second")
    });
    let kept_up = printed
        .lines()
        .find_map(|line| line.strip_prefix("at worst"));
    let kept_up = kept_up.expect("how well it kept up").trim();
    campaign::found(
        "trials in real time beside a busy process",
        recordings,
        &format!(
            "{whole_s:.0} s, every sample of audio there, {lost} of force lost and counted; {kept_up}; at most {} kB, early, in \
             the middle and at the end {taken:?}",
            most
        ),
    );
    assert!(most < MOST_KB, "{most} kB");
    let [_, middle, late] = taken;
    assert!(
        seconds < LONG_S || late - middle < GROWTH_KB,
        "{middle} kB, then {late} kB"
    );
}
