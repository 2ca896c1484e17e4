//! Studies of thousands of recordings, made of one by other participants' names: parts and memory of their analysis.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bench_tests::campaign;
use bench_tests::program::{bench, protocol};
use bench_tests::run_cost::RunCost;
use bench_tests::session::{finish, headless_run, text};

/// Number of recordings in every test run; `FRICTION_BENCH_RECORDINGS` asks for more.
const RECORDINGS: usize = 10;
const TRIALS_PER_PERSON: usize = 10;
/// Memory of the program with one recording, kB: 25 MB measured.
const PROGRAM_KB: u64 = 40_000;
/// Memory of each further recording with two instances, kB: 20 kB measured. Ten thousand recordings so take less than 300 MB.
const RECORDING_KB: u64 = 26;
const DAY: Duration = Duration::from_secs(24 * 3600);

/// Makes recordings out of one: their signals are its own, their participants and trials are others.
fn repeat(recording: &Path, study: &Path, count: usize) {
    let description = fs::read_to_string(recording.join("recording.toml")).unwrap();
    let line = |start: &str| {
        let mut lines = description.lines();
        lines.find(|line| line.starts_with(start)).unwrap()
    };
    let (id, number, file) = (line("id = "), line("number = "), line("protocol_file = "));
    let signals: Vec<PathBuf> = fs::read_dir(recording)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| !path.ends_with("recording.toml"))
        .collect();
    for index in 0..count {
        let (person, trial) = (index / TRIALS_PER_PERSON + 1, index % TRIALS_PER_PERSON + 1);
        let folder = study.join(format!("person-{person:04}/trial-{trial:02}"));
        fs::create_dir_all(&folder).unwrap();
        for path in &signals {
            fs::hard_link(path, folder.join(path.file_name().unwrap())).unwrap();
        }
        let text = description
            .replace(id, &format!("id = \"sub-{person:04}\""))
            .replace(number, &format!("number = {trial}"))
            .replace(file, "");
        fs::write(folder.join("recording.toml"), text).unwrap();
    }
}

fn cost(command: &mut Command) -> RunCost {
    let cost = RunCost::measure(command, DAY);
    assert_eq!(cost.code, Some(0), "{:.2000}", cost.transcript);
    cost
}

#[test]
fn many_recordings_take_little_memory_and_a_second_run_leaves_their_parts() {
    let room = tempfile::tempdir().unwrap();
    let path = |name: &str| room.path().join(name);
    let session = path("session");
    let mut run = headless_run(&session, "sub-01", protocol("half-a-second.toml"));
    let output = finish(run.args(["--seed", "5"]));
    assert!(output.status.success(), "{}", text(&output));
    let count = campaign::repeats("FRICTION_BENCH_RECORDINGS", RECORDINGS);
    let recording = session.join("sub-01/ses-01/trial-001_attempt-1");
    repeat(&recording, &path("study"), count);

    let parts = || {
        let mut analyze = bench();
        analyze.args(["analyze", "--each"]).arg(path("study"));
        analyze.arg("--out").arg(path("parts"));
        cost(&mut analyze)
    };
    let lines = |cost: &RunCost, word: &str| {
        let lines = cost.transcript.lines();
        lines.filter(|line| line.starts_with(word)).count()
    };
    let first = parts();
    assert_eq!(lines(&first, "done"), count, "{:.2000}", first.transcript);
    let second = parts();
    assert_eq!(lines(&second, "kept"), count, "{:.2000}", second.transcript);

    let mut from = bench();
    from.args(["analyze", "--from"]).arg(path("parts"));
    let whole = cost(from.arg("--json").arg(path("results.json")));
    let limit_kb = PROGRAM_KB + RECORDING_KB * count as u64;
    assert!(
        whole.peak_kb < limit_kb,
        "{} kB of {limit_kb}",
        whole.peak_kb
    );
    let results = fs::read_to_string(path("results.json")).unwrap();
    assert_eq!(results.matches("\"model_check\": ").count(), count);
    campaign::report(
        "parts of small recordings",
        count,
        &format!(
            "written in {:.0} s, left in {:.1} s; put together in {:.0} s and {:.0} MB; results.json of {:.0} MB",
            first.time.as_secs_f64(),
            second.time.as_secs_f64(),
            whole.time.as_secs_f64(),
            whole.peak_kb as f64 * 1e-3,
            results.len() as f64 * 1e-6,
        ),
    );
}
