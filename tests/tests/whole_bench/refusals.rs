//! Refusals of the bench: a named error with the remedy, an exit status, no file made, no panic.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use bench_tests::program::bench;
use bench_tests::running::{Running, wait_until};
use bench_tests::session::{
    SOUND_CARD, SessionFolder, finish, headless_run, text, write_bench_config, write_demo_protocol,
};
use recording::RecordingReader;
use tempfile::TempDir;

pub(super) const MINUTE: Duration = Duration::from_secs(60);

/// Makes an empty folder, with no `bench.toml`; returns it with the path of a study in it.
pub fn room() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    (folder, study)
}

pub fn assert_refusal(output: &Output, words: &[&str]) {
    let transcript = text(output);
    let code = output.status.code();
    assert!(
        code.is_some_and(|code| code != 0),
        "{:?}:\n{transcript}",
        output.status
    );
    for word in ["panicked", "backtrace", "RUST_BACKTRACE", "unwrap"] {
        assert!(!transcript.contains(word), "`{word}` in:\n{transcript}");
    }
    assert!(
        output.stderr.starts_with(b"friction-bench: ") || output.stderr.starts_with(b"error: "),
        "{transcript}"
    );
    for word in words {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
}

/// Requires a refusal before the study is made.
pub fn assert_early_refusal(command: &mut Command, study: &Path, words: &[&str]) {
    assert_refusal(&finish(command), words);
    assert!(!study.exists(), "{} was made", study.display());
}

/// Returns a session on the bench of `config`, with all required options.
pub fn uncalibrated(study: &Path, config: &Path) -> Command {
    let mut run = bench();
    run.args(["run", "--headless", "--uncalibrated"])
        .args(["--participant", "sub-01", "--consent-by", "K", "--study"])
        .arg(study)
        .arg("--config")
        .arg(config);
    run
}

#[test]
fn a_missing_configuration_is_refused_with_the_remedy() {
    let (folder, study) = room();
    let mut run = bench();
    run.current_dir(folder.path())
        .args([
            "run",
            "--headless",
            "--participant",
            "sub-01",
            "--consent-by",
            "K",
            "--study",
        ])
        .arg(&study);
    let words = [
        "bench.toml does not exist in this folder",
        "friction-bench init",
    ];
    assert_early_refusal(&mut run, &study, &words);
}

/// Fault 4.
#[test]
fn without_a_sound_card() {
    let (folder, study) = room();
    let config = write_bench_config(
        folder.path(),
        &[
            ("\"sim\"", "\"hw:CARD=Absent\""),
            ("\"sim\"", "\"hw:CARD=Absent\""),
            // Each of these tests has a separate bench.
            ("/dev/ttyUSB0", "/dev/tty-absent"),
            SOUND_CARD,
        ],
    );
    let absent = folder.path().join("absent.conf");
    for alsa_configuration in [None, Some(&absent)] {
        let mut run = uncalibrated(&study, &config);
        if let Some(path) = alsa_configuration {
            run.env("ALSA_CONFIG_PATH", path);
        }
        assert_early_refusal(
            &mut run,
            &study,
            &["no output device matches", "hw:CARD=Absent"],
        );
    }
}

/// Hazard 12.
#[test]
fn without_consent() {
    let (_folder, study) = room();
    let mut run = bench();
    run.args([
        "run",
        "--mock",
        "--headless",
        "--participant",
        "sub-01",
        "--study",
    ])
    .arg(&study);
    assert_early_refusal(
        &mut run,
        &study,
        &["no consent", "sub-01", "--consent-by NAME"],
    );
    // The value of an unset shell variable.
    run.args(["--consent-by", " "]);
    assert_early_refusal(&mut run, &study, &["--consent-by is empty"]);
}

#[test]
fn a_missing_participant_is_refused() {
    let (_folder, study) = room();
    let mut run = bench();
    run.args([
        "run",
        "--mock",
        "--headless",
        "--consent-by",
        "K",
        "--study",
    ])
    .arg(&study);
    assert_early_refusal(&mut run, &study, &["--participant sub-01"]);
}

/// Fault 32.
#[test]
fn names_that_are_no_pseudonyms() {
    let (folder, study) = room();
    let long_id = format!("sub-{}", "1".repeat(300));
    let (prefix, characters) = ("does not begin with `sub-`", "letters and digits");
    for (id, message) in [
        ("../x", prefix),
        ("", prefix),
        ("süb-01", prefix),
        ("sub-01/..", characters),
        ("sub-０１", characters),
        (&long_id, "the label is too long"),
    ] {
        let mut run = headless_run(&study, id, "demo");
        let words = [message, "is not allowed", "for example `sub-01`"];
        assert_early_refusal(&mut run, &study, &words);
    }
    for id in [" sub-01", "sub-01\n", "01"] {
        let mut run = headless_run(&study, id, "demo");
        let words = ["is not allowed", "did you mean `sub-01`"];
        assert_early_refusal(&mut run, &study, &words);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_dashboard_and_the_participants_display_need_terminals() {
    let (folder, study) = room();
    let mut run = bench();
    run.args(["run", "--mock", "--participant", "sub-01", "--study"])
        .arg(&study);
    assert_early_refusal(
        &mut run,
        &study,
        &["the dashboard needs a terminal", "add --headless"],
    );
    let file = folder.path().join("a-file");
    fs::write(&file, "kept").unwrap();
    let mut run = headless_run(&study, "sub-01", "demo");
    run.arg("--participant-display").arg(&file);
    assert_early_refusal(
        &mut run,
        &study,
        &["a-file is not a terminal", "such as /dev/tty2"],
    );
    assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
}

/// Fault 33.
#[test]
fn unknown_keys_are_named_with_their_line_and_the_nearest_known_one() {
    let (folder, study) = room();
    let line_name = |path: &Path, key: &str| {
        let text = fs::read_to_string(path).unwrap();
        let index = text.lines().position(|line| line.starts_with(key)).unwrap();
        format!("line {}", index + 1)
    };

    let config = write_bench_config(folder.path(), &[("rate_hz =", "rate_hx =")]);
    let words = [
        &*line_name(&config, "rate_hx"),
        "bench.toml, line",
        "`rate_hx`",
        "`rate_hz`",
    ];
    let mut run = headless_run(&study, "sub-01", "demo");
    assert_early_refusal(run.arg("--config").arg(&config), &study, &words);

    let protocol = write_demo_protocol(folder.path(), &[("min_n =", "mim_n =")]);
    let words = [
        &*line_name(&protocol, "mim_n"),
        "protocol.toml, line",
        "`mim_n`",
        "`min_n`",
    ];
    assert_early_refusal(
        &mut headless_run(&study, "sub-01", &protocol),
        &study,
        &words,
    );

    let scenario = folder.path().join("scenario.toml");
    fs::write(
        &scenario,
        "purpose = \"a typo\"\n\n[plate]\ndampnig_n_s_per_m = 7.0\n",
    )
    .unwrap();
    let words = [
        "scenario.toml",
        "line 4",
        "`dampnig_n_s_per_m`",
        "`damping_n_s_per_m`",
    ];
    let mut run = bench();
    run.args(["run", "--headless", "--speed", "max", "--protocol", "demo"])
        .args(["--participant", "sub-01", "--consent-by", "K"])
        .arg("--mock")
        .arg(&scenario)
        .arg("--study")
        .arg(&study);
    assert_early_refusal(&mut run, &study, &words);
}

#[test]
fn an_unknown_key_of_a_recording_is_named_with_its_line_and_the_nearest_known_one() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_EXPLORATION);
    let output = finish(&mut headless_run(&study, "sub-01", &protocol));
    assert!(output.status.success(), "{}", text(&output));
    let recording = &SessionFolder::read(&study, "sub-01").unwrap().recordings()[0];
    let path = recording.join("recording.toml");
    let text = fs::read_to_string(&path).unwrap();
    RecordingReader::open(recording).unwrap();
    fs::write(&path, text.replacen("volts_per_unit", "volt_per_unit", 1)).unwrap();
    let line = 1 + text
        .lines()
        .position(|line| line.starts_with("volts_per_unit"))
        .unwrap();
    let error = RecordingReader::open(recording).unwrap_err().to_string();
    for word in [
        &*format!("recording.toml, line {line}"),
        "`volt_per_unit`",
        "`volts_per_unit`",
    ] {
        assert!(error.contains(word), "no `{word}` in: {error}");
    }
}

/// Changes that shorten the demo to one trial.
pub(super) const ONE_TRIAL: &[(&str, &str)] = &[
    ("practice = 1", "practice = 0"),
    ("per_condition = 4", "per_condition = 1"),
];

/// Changes that shorten the demo to one trial of one exploration.
pub(super) const ONE_EXPLORATION: &[(&str, &str)] = &[
    ("practice = 1", "practice = 0"),
    ("per_condition = 4", "per_condition = 1"),
    (
        "[\"left_to_right\", \"right_to_left\"]",
        "[\"left_to_right\"]",
    ),
    ("min_instances = 5", "min_instances = 1"),
];

/// Fault 3.
#[test]
fn a_rate_too_low_for_the_carrier_is_refused_with_the_arithmetic() {
    let (folder, study) = room();
    let config = write_bench_config(folder.path(), &[("rate_hz = 192000", "rate_hz = 48000")]);
    let mut run = headless_run(&study, "sub-01", "demo");
    let words = [
        "sample rate 48000 Hz is not above",
        "2 × (carrier 35000 Hz + modulation 6 Hz) = 70012 Hz",
    ];
    assert_early_refusal(run.arg("--config").arg(&config), &study, &words);
}

/// Fault 2.
#[test]
fn a_rate_that_the_card_has_not_is_refused_with_those_it_has() {
    let (folder, study) = room();
    let config = write_bench_config(folder.path(), &[("rate_hz = 192000", "rate_hz = 128000")]);
    let mut run = headless_run(&study, "sub-01", "demo");
    let words = [
        "does not offer 2 channels of i32 at 128000 Hz",
        "1–2 ch i32 96000 Hz",
        "1–2 ch i32 192000 Hz",
    ];
    assert_early_refusal(run.arg("--config").arg(&config), &study, &words);
}

/// Fault 2.
#[test]
fn channels_or_a_sample_format_that_the_card_has_not_are_refused_with_those_it_has() {
    let (folder, study) = room();
    let run_with = |changes: &[(&str, &str)]| {
        let mut run = headless_run(&study, "sub-01", "demo");
        run.arg("--config")
            .arg(write_bench_config(folder.path(), changes));
        run
    };
    let inputs = [("input_channels = 4", "input_channels = 8")];
    let words = [
        "input device custom:sim",
        "does not offer 8 channels of i32 at 192000 Hz",
        "1–4 ch i32",
    ];
    assert_early_refusal(&mut run_with(&inputs), &study, &words);
    let outputs = [("output_channels = 2", "output_channels = 6")];
    let words = [
        "output device custom:sim",
        "does not offer 6 channels of i32 at 192000 Hz",
        "1–2 ch i32",
    ];
    assert_early_refusal(&mut run_with(&outputs), &study, &words);
    let format = [("sample_format = \"i32\"", "sample_format = \"i24\"")];
    let words = [
        "does not offer 2 channels of i24 at 192000 Hz",
        "1–2 ch i32",
    ];
    assert_early_refusal(&mut run_with(&format), &study, &words);
    let format = [("sample_format = \"i32\"", "sample_format = \"i20\"")];
    let words = [
        "bench.toml, line",
        "unknown value `i20`",
        "`f32`, `i32`, `i24`, `i16`",
    ];
    assert_early_refusal(&mut run_with(&format), &study, &words);

    let scenario = folder.path().join("scenario.toml");
    let scenario_text =
        "purpose = \"a card of another kind\"\n\n[converter]\nformats = [\"u8\", \"i64\"]\n";
    fs::write(&scenario, scenario_text).unwrap();
    let words = [
        "does not offer 2 channels of i32 at 192000 Hz",
        "1–2 ch i64 96000 Hz",
        "1–2 ch u8 192000 Hz",
    ];
    let mut run = bench();
    run.args(["run", "--headless", "--speed", "max", "--protocol", "demo"])
        .args(["--participant", "sub-01", "--consent-by", "K", "--mock"])
        .arg(&scenario)
        .arg("--study")
        .arg(&study);
    assert_early_refusal(&mut run, &study, &words);
}

/// Fault 14.
/// Hazards 1, 3, 4, 6.
#[test]
fn ten_times_the_amplitude_is_refused_not_clamped() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(
        folder.path(),
        &[("mean_amplitude_v = 24.0", "mean_amplitude_v = 240.0")],
    );
    let mut run = headless_run(&study, "sub-01", &protocol);
    let words = ["protocol.toml, line", "drive.mean_amplitude_v", "240 V"];
    assert_early_refusal(&mut run, &study, &words);

    // Within the limit of any protocol, but above the configured limit at the modulation's peak.
    let protocol = write_demo_protocol(
        folder.path(),
        &[("mean_amplitude_v = 24.0", "mean_amplitude_v = 30.0")],
    );
    let mut run = headless_run(&study, "sub-01", &protocol);
    assert_early_refusal(&mut run, &study, &["am-6hz-95", "58.50 V", "55 V"]);

    let config = write_bench_config(folder.path(), &[("drive_v = 55.0", "drive_v = 550.0")]);
    let mut run = headless_run(&study, "sub-01", "demo");
    let hard_limit = signalgen::HARD_LIMIT_V.to_string();
    let words = ["limits.drive_v = 550", &hard_limit];
    assert_early_refusal(run.arg("--config").arg(&config), &study, &words);
}

#[cfg(target_os = "linux")]
/// Fault 18.
#[test]
fn without_gpio() {
    let (folder, study) = room();
    let backends = [
        ("backend = \"rppal\"", "needs a Raspberry Pi"),
        (
            "backend = \"gpiocdev\"\nchip = \"/dev/gpiochip-absent\"\nestop = 7",
            "there is no GPIO chip /dev/gpiochip-absent for the e-stop",
        ),
    ];
    for (backend, word) in backends {
        let keys = "[safety]\nwaived = [\"estop\"]\nwaived_by = \"A. Tester\"\n";
        let changes = [
            ("backend = \"none\"", backend),
            ("[safety]\n", keys),
            SOUND_CARD,
        ];
        let config = write_bench_config(folder.path(), &changes);
        let mut run = uncalibrated(&study, &config);
        assert_early_refusal(&mut run, &study, &[word]);
    }
}

/// Fault 31.
/// Hazard 14.
#[test]
fn a_session_or_a_trial_that_exists_is_never_overwritten() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_EXPLORATION);
    let output = finish(&mut headless_run(&study, "sub-01", &protocol));
    assert!(output.status.success(), "{}", text(&output));
    let session_before = SessionFolder::read(&study, "sub-01").unwrap();
    let signals = session_before.recordings()[0].join("signals.wav");
    let bytes = fs::read(&signals).unwrap();

    let output = finish(&mut headless_run(&study, "sub-01", &protocol));
    assert_refusal(
        &output,
        &["sub-01 already has", "--resume", "--new-session"],
    );
    let output = finish(headless_run(&study, "sub-01", &protocol).arg("--resume"));
    assert_refusal(&output, &["has ended", "--new-session"]);
    assert_eq!(fs::read(&signals).unwrap(), bytes);
    let session_after = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(session_after.documents, session_before.documents);

    // A new session adds a folder; an existing folder in place of a trial's is left unchanged.
    let mut run = Running::start(
        headless_run(&study, "sub-01", &protocol).arg("--new-session"),
        &folder.path().join("output"),
    );
    let second_session = study.join("sub-01/ses-02");
    let result = run.wait_for(MINUTE, || {
        fs::create_dir(second_session.join("trial-001_attempt-1")).ok()
    });
    assert_eq!(result, Some(()), "{}", run.output());
    let status = run.wait(MINUTE);
    assert!(!status.success());
    let transcript = run.output();
    assert!(
        transcript.contains("trial-001_attempt-1 exists already and is never overwritten"),
        "{transcript}"
    );
    assert!(!transcript.contains("panicked"), "{transcript}");
    assert_eq!(
        fs::read_dir(second_session.join("trial-001_attempt-1"))
            .unwrap()
            .count(),
        0
    );
    assert_eq!(fs::read(&signals).unwrap(), bytes);
}

#[test]
fn a_monitor_with_a_closed_pipe_ends() {
    let mut monitor = bench();
    monitor
        .args(["monitor", "--mock", "--headless", "--drive-v", "20"])
        .args(["--speed", "max"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null());
    let mut watch = monitor.spawn().unwrap();
    let mut lines = std::io::BufReader::new(watch.stdout.take().unwrap()).lines();
    lines.next().unwrap().unwrap();
    drop(lines);
    let status = wait_until(MINUTE, || watch.try_wait().unwrap());
    if status.is_none() {
        watch.kill().unwrap();
    }
    assert!(status.expect("it drives on").success());
}

#[test]
fn an_unwritable_calibration_is_refused_before_measuring() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("not there/calibration.toml");
    let mut calibrate = bench();
    calibrate
        .args([
            "calibrate",
            "plate",
            "--mock",
            "--speed",
            "max",
            "--operator",
            "T",
        ])
        .arg("--calibration")
        .arg(&path);
    assert_refusal(
        &finish(&mut calibrate),
        &["cannot write into", "not there", "--calibration"],
    );
}

#[test]
fn monitor_drives_only_a_bench_that_passes_the_preflight() {
    let folder = tempfile::tempdir().unwrap();
    let monitor = |changes: &[(&str, &str)], drive: &[&str]| {
        let config = write_bench_config(folder.path(), changes);
        let mut monitor = bench();
        monitor
            .args(["monitor", "--mock", "--headless", "--speed", "max"])
            .args(["--duration-s", "2", "--config"])
            .arg(config)
            .args(drive);
        finish(&mut monitor)
    };
    let drive = ["--drive-v", "20"];
    // The sensor's data cannot be decoded, as at a wrong baud rate.
    let wrong_protocol = [("protocol = \"frames\"", "protocol = \"lines\"")];
    let output = monitor(&wrong_protocol, &drive);
    let words = ["FAILED  force sensor", "baud", "nothing was driven but"];
    assert_refusal(&output, &words);
    assert_eq!(output.status.code(), Some(2), "as `run`");
    let transcript = text(&output);
    assert!(!transcript.contains("N·s/m"), "it watched:\n{transcript}");
    // Without a drive `monitor` shows the same bench, and prints that it has not been checked.
    let output = monitor(&wrong_protocol, &[]);
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    let words = ["without a preflight", "drive 0.0 V", "normal –"];
    for word in words {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
    let transcript = text(&monitor(&[], &drive));
    assert!(!transcript.contains("preflight"), "{transcript}");
}

#[test]
fn a_folder_without_a_study_is_refused() {
    let (_folder, study) = room();
    fs::create_dir(&study).unwrap();
    fs::write(study.join("thesis.tex"), "kept").unwrap();
    let output = finish(&mut headless_run(&study, "sub-01", "demo"));
    assert_refusal(&output, &["is not a study", "--study"]);
    assert_eq!(fs::read_dir(&study).unwrap().count(), 1);
}
