//! A newcomer's first hour: terminals of any size, pipes, typing errors, a bench without GPIO.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use bench_tests::program::{bench, friction_bench, workspace};
use bench_tests::running::Running;
use bench_tests::screen::Screen;
use bench_tests::session::{
    SOUND_CARD, SessionFolder, finish, headless_run, require_whole, text, write_bench_config,
    write_demo_protocol,
};
use config::Config;
use recording::RecordingReader;
use rustix::process::Signal;

use super::refusals::{assert_early_refusal, assert_refusal, room, uncalibrated};

const MINUTE: Duration = Duration::from_secs(60);

/// Runs `command` in a separate terminal; returns its exit status and everything it shows there.
fn run_in_terminal(mut command: Command, columns: u16, rows: u16) -> (ExitStatus, String) {
    let screen = Screen::open(columns, rows);
    screen.attach(&mut command);
    let mut child = command.spawn().unwrap();
    // Drop the parent's handles, so that the terminal closes with the program's own.
    drop(command);
    let status = child.wait().unwrap();
    (status, screen.read_to_end())
}

/// Fault 37.
#[test]
fn the_demo_succeeds_in_a_terminal_without_a_size() {
    let folder = tempfile::tempdir().unwrap();
    let demo = folder.path().join("a demo");
    let mut command = bench();
    command.arg("demo").arg(&demo).current_dir(&folder);
    let (status, transcript) = run_in_terminal(command, 0, 0);
    assert!(status.success(), "{transcript}");
    for file in [
        "calibration/calibration.toml",
        "study/sub-01/ses-01/events.jsonl",
        "results.json",
    ] {
        assert!(demo.join(file).is_file(), "no {file}: {transcript}");
    }
    require_whole(&demo.join("study"));
    // The last line of the output is a command that can be copied.
    let last_line = transcript.trim_end().lines().last().unwrap();
    let script = format!(
        "set -- {last_line}; while [ \"$1\" != --study ]; do shift; done; printf %s \"$2\""
    );
    let study = finish(Command::new("bash").args(["-c", &script])).stdout;
    assert_eq!(OsStr::from_bytes(&study), demo.join("study"), "{last_line}");
    // The working folder has no other new files.
    let entries: Vec<_> = fs::read_dir(&folder).unwrap().collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
}

#[test]
fn a_demo_that_is_ended_ends_its_step_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = bench();
    command.arg("demo").current_dir(&folder);
    let mut demo = Running::start(&mut command, &folder.path().join("output"));
    let children = format!("/proc/{0}/task/{0}/children", demo.pid());
    let step = demo.wait_for(MINUTE, || {
        let children = fs::read_to_string(&children).ok()?;
        Some(children.split_whitespace().next()?.to_owned())
    });
    let step = step.unwrap_or_else(|| panic!("no step: {}", demo.output()));
    demo.signal(Signal::TERM);
    let status = demo.wait(MINUTE);
    assert_eq!(status.code(), Some(128 + 15), "{}", demo.output());
    assert!(!Path::new("/proc").join(step).exists());
    assert!(!folder.path().join("demo/study").exists());
}

/// The version of a release build includes the commit; a debug build, compiled at every change, says that it is one.
#[test]
fn the_version_names_the_build() {
    let version = text(&finish(bench().arg("--version")));
    let build = version
        .strip_prefix(concat!("friction-bench ", env!("CARGO_PKG_VERSION"), " ("))
        .and_then(|rest| rest.trim_end().strip_suffix(')'))
        .unwrap_or_else(|| panic!("{version}"));
    let commit_name = std::env::var("FRICTION_BENCH_COMMIT").ok();
    if let Some(name) = commit_name.filter(|name| !name.is_empty()) {
        assert_eq!(build, format!("commit {name}"));
        return;
    }
    if friction_bench()
        .parent()
        .is_some_and(|folder| folder.ends_with("debug"))
    {
        assert_eq!(build, "debug build");
        return;
    }
    let mut git = Command::new("git");
    git.args(["rev-parse", "--short=12", "HEAD"]);
    let commit = git.current_dir(workspace()).output();
    let expected = match commit.ok().filter(|output| output.status.success()) {
        Some(output) => format!("commit {}", text(&output).trim()),
        None => "unknown commit".to_owned(),
    };
    assert_eq!(build.trim_end_matches(" and changes"), expected);
}

#[test]
fn a_check_of_simulated_hardware_passes_in_small_terminals_and_through_a_pipe() {
    let check = || {
        let mut command = bench();
        command.args(["check", "--mock", "--protocol", "demo"]);
        command
    };
    for (columns, rows) in [(0, 0), (40, 10), (78, 22)] {
        let (status, transcript) = run_in_terminal(check(), columns, rows);
        assert!(status.success(), "{columns} × {rows}: {transcript}");
        assert!(
            !transcript.contains("terminal"),
            "no dashboard is shown: {transcript}"
        );
    }
    let output = finish(&mut check());
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn a_small_terminal_for_a_dashboard_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let config = write_bench_config(
        folder.path(),
        &[
            ("\"sim\"", "\"absent\""),
            ("\"sim\"", "\"absent\""),
            SOUND_CARD,
        ],
    );
    let mut command = bench();
    command
        .current_dir(folder.path())
        .arg("check")
        .arg("--config")
        .arg(config);
    let (status, transcript) = run_in_terminal(command, 40, 10);
    assert_eq!(
        status.code(),
        Some(1),
        "there is no such card: {transcript}"
    );
    let line = |name: &str| {
        let line = transcript.lines().find(|line| line.contains(name));
        line.unwrap_or_else(|| panic!("no {name} in {transcript}"))
    };
    assert!(line("hardware").starts_with("FAILED"), "{transcript}");
    assert!(
        line("terminal").starts_with("warning terminal"),
        "{transcript}"
    );
    assert!(line("terminal").contains("40 × 10"), "{transcript}");
}

#[test]
fn a_closed_pipe_ends_a_command_in_good_order() {
    for words in [
        &["completions", "bash"][..],
        &["completions", "zsh"],
        &["manual"],
        &["schema"],
        &["schema", "bench"],
        &["devices"],
        &["devices", "--mock", "--json"],
        &["--help"],
        &["run", "--help"],
        &["run", "--mock", "--print-config"],
    ] {
        let mut child = bench()
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Close the pipe before any output.
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let transcript = text(&output);
        assert!(output.status.success(), "{words:?}: {transcript}");
        assert!(transcript.is_empty(), "{words:?}: {transcript}");
    }
}

#[test]
fn a_misspelt_name_suggests_the_right_one_first() {
    let (_folder, study) = room();
    for (words, suggestion) in [
        (&["run", "--mock", "nominl", "--headless"][..], "`nominal`"),
        (
            &[
                "run",
                "--mock",
                "--headless",
                "--participant",
                "sub-01",
                "--consent-by",
                "K",
                "--protocol",
                "huloux",
            ],
            "`huloux2021`",
        ),
        (&["check", "--mock", "--protocol", "dmeo"], "`demo`"),
        (&["analyze", "--assume", "area=3", "."], "`contact_area_m2`"),
        (&["analize", "."], "'analyze'"),
    ] {
        assert_refusal(&finish(bench().args(words)), &[suggestion]);
    }
    assert!(!study.exists());
}

#[test]
fn a_slider_that_leaves_the_plate_is_refused_with_both_numbers() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), &[("to_m = 0.095", "to_m = 0.95")]);
    let line = fs::read_to_string(&protocol)
        .unwrap()
        .lines()
        .position(|line| line.starts_with("to_m"))
        .unwrap();
    let line = format!("protocol.toml, line {}: ", line + 1);
    let words = [&line, "exploration.to_m = 0.95 m", "0.105 m"];
    let mut run = headless_run(&study, "sub-01", &protocol);
    assert_early_refusal(&mut run, &study, &words);
    let mut check = bench();
    check.args(["check", "--mock", "--protocol"]).arg(&protocol);
    assert_refusal(&finish(&mut check), &words);
}

#[test]
fn a_tone_is_reported_only_if_one_was_played() {
    let (folder, study) = room();
    let absent = [
        ("\"sim\"", "\"absent\""),
        ("\"sim\"", "\"absent\""),
        SOUND_CARD,
    ];
    let config = write_bench_config(folder.path(), &absent);
    let output = finish(&mut uncalibrated(&study, &config));
    assert_refusal(&output, &["nothing was driven"]);
    assert!(!text(&output).contains("tone"), "{}", text(&output));
}

#[test]
fn a_sensor_that_sends_lines_brings_its_configuration() {
    let check = finish(bench().args(["check", "--mock", "arduino", "--quick"]));
    assert!(check.status.success(), "{}", text(&check));
    let output = finish(bench().args(["run", "--mock", "arduino", "--print-config"]));
    let config = Config::parse(&text(&output), "printed").unwrap();
    let config::Sensor::Serial(serial) = config.force.unwrap().sensor else {
        panic!("not on a serial line");
    };
    assert_eq!(serial.protocol, config::ForceProtocol::Lines);
}

#[test]
fn a_study_lists_its_recordings_with_commands_that_a_shell_can_run() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("Ana's study");
    let protocol = workspace().join("tests/protocols/one-exploration.toml");
    let run = finish(&mut headless_run(&study, "sub-01", protocol));
    assert!(run.status.success(), "{}", text(&run));
    let run_in_shell = |command: &str| {
        let program = friction_bench().display().to_string();
        let command = command.replacen("friction-bench", &format!("'{program}'"), 1);
        finish(Command::new("sh").args(["-c", &command]))
    };
    let transcript = text(&run);
    let results = transcript
        .lines()
        .find(|line| line.starts_with("to results"));
    let analyze = &results.unwrap()["to results".len()..];
    let analyze = analyze.trim().replace("--figures figures", "");
    let output = run_in_shell(&analyze);
    assert!(output.status.success(), "{}", text(&output));

    let list = finish(bench().arg("replay").arg(&study));
    assert!(list.status.success(), "{}", text(&list));
    let recordings = SessionFolder::read(&study, "sub-01").unwrap().recordings();
    assert_eq!(text(&list).lines().count(), recordings.len());
    let command = text(&list).lines().next().unwrap().to_owned();
    let output = run_in_shell(&format!("{command} --headless --speed max"));
    assert!(output.status.success(), "{}", text(&output));

    assert_refusal(
        &finish(bench().arg("replay").arg(workspace())),
        &["neither"],
    );
}

#[test]
fn an_operator_chooses_how_much_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = folder.path().join("calibration.toml");
    let errors_of = |words: &[&str]| {
        let mut command = bench();
        command
            .args(["calibrate", "channels", "--mock", "--speed", "max"])
            .args(["--operator", "A. Tester", "--headless"])
            .args(words)
            .arg("--calibration")
            .arg(&calibration);
        let output = finish(&mut command);
        assert!(output.status.success(), "{}", text(&output));
        assert!(!output.stdout.is_empty());
        String::from_utf8(output.stderr).unwrap()
    };
    let (quiet, normal, verbose) = (
        errors_of(&["-q"]),
        errors_of(&[]),
        errors_of(&["--verbose"]),
    );
    assert_eq!(quiet, "");
    assert!(
        !normal.is_empty() && !normal.contains("configuration:"),
        "{normal}"
    );
    for word in ["configuration: ", "calibration: ", "took "] {
        assert!(verbose.contains(word), "no {word} in {verbose}");
    }
    assert!(
        verbose.lines().count() > normal.lines().count(),
        "{verbose}"
    );
}

#[test]
fn a_missing_configuration_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let output = finish(bench().args(["check", "--config", "bnech.toml"]));
    assert_refusal(&output, &["bnech.toml does not exist", "--config"]);
    assert!(!text(&output).contains("print-config"), "{}", text(&output));
    let output = finish(bench().arg("check").current_dir(&folder));
    assert_refusal(&output, &["`friction-bench init`"]);
    // The template can also be redirected by a shell, which creates the file first.
    let script = format!(
        "'{}' run --print-config > bench.toml",
        friction_bench().display()
    );
    let mut shell = Command::new("sh");
    let output = finish(shell.args(["-c", &script]).current_dir(&folder));
    assert!(output.status.success(), "{}", text(&output));
    let path = folder.path().join("bench.toml");
    assert_eq!(fs::read_to_string(&path).unwrap(), config::TEMPLATE);
    let output = finish(bench().arg("check").current_dir(&folder));
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(
        text(&output).contains("hw:CARD=Device"),
        "{}",
        text(&output)
    );
    // An edited file is printed with its effective values.
    let output = finish(bench().args(["run", "--print-config"]).current_dir(&folder));
    let config = Config::parse(&text(&output), "printed").unwrap();
    assert_eq!(config, Config::read(&path).unwrap());
}

#[test]
fn an_invalid_number_is_refused_with_the_expected_range() {
    for (words, expectation) in [
        (
            &["run", "--mock", "--seed", "-1"][..],
            "a whole number from 0",
        ),
        (&["run", "--mock", "--seed", "7.5"], "a whole number from 0"),
        (
            &["monitor", "--mock", "--duration-s", "-1"],
            "a finite number above 0",
        ),
        (&["model", "--mu0", "-1"], "a finite number above 0"),
    ] {
        assert_refusal(&finish(bench().args(words)), &[expectation]);
    }
}

/// Fault 25.
#[test]
fn a_folder_that_cannot_be_written_is_named_and_the_cause_said_once() {
    let (folder, study) = room();
    let absent = folder.path().join("absent");
    let mut calibrate = bench();
    calibrate
        .args([
            "calibrate",
            "channels",
            "--mock",
            "--operator",
            "K",
            "--headless",
        ])
        .arg("--calibration")
        .arg(absent.join("calibration.toml"));
    fs::write(&study, "a file").unwrap();
    let mut model = bench();
    model.arg("model").arg("--out").arg(study.join("model"));
    let mut session = headless_run(&study.join("study"), "sub-01", "demo");
    for (command, path) in [
        (&mut calibrate, absent.clone()),
        (&mut model, study.join("model")),
        (&mut session, study.join("study")),
    ] {
        let output = finish(command);
        assert_refusal(&output, &[&path.display().to_string()]);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(!errors.contains("os error"), "{errors}");
    }
}

fn waived_config(folder: &Path) -> std::path::PathBuf {
    let keys = "[safety]\nwaived = [\"estop\", \"heartbeat\"]\nwaived_by = \"A. Tester\"\n";
    write_bench_config(folder, &[("[safety]\n", keys)])
}

#[test]
fn waived_hardware_stops_are_shown_and_recorded() {
    let (folder, study) = room();
    let config = waived_config(folder.path());
    let protocol = workspace().join("tests/protocols/one-exploration.toml");
    let mut run = headless_run(&study, "sub-01", protocol);
    let output = finish(run.arg("--config").arg(&config));
    assert!(output.status.success(), "{}", text(&output));
    let line = "hardware stops waived by A. Tester: estop, heartbeat";
    let transcript = text(&output);
    assert!(
        transcript.contains(&format!("warning: {line}")),
        "{transcript}"
    );

    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let safety = &session.starts()[0].configuration["safety"];
    assert_eq!(safety["waived"], serde_json::json!(["estop", "heartbeat"]));
    assert_eq!(safety["waived_by"], "A. Tester");
    let copy = Config::read(&session.path.join("bench.toml")).unwrap();
    assert_eq!(copy.safety.waiver_in_words().as_deref(), Some(line));
    let recordings = session.recordings();
    assert!(!recordings.is_empty());
    for recording in &recordings {
        let reader = RecordingReader::open(recording).unwrap();
        let hardware = reader.manifest().hardware.clone().unwrap();
        assert_eq!(hardware.waived, ["estop", "heartbeat"]);
        assert_eq!(hardware.waived_by.as_deref(), Some("A. Tester"));
    }
    let mut replay = bench();
    replay.args(["replay", "--headless", "--speed", "max"]);
    let transcript = text(&finish(replay.arg(&recordings[0])));
    assert!(transcript.contains(line), "{transcript}");

    let mut check = bench();
    check.args(["check", "--mock", "--quick", "--config"]);
    let output = finish(check.arg(&config));
    assert!(output.status.success(), "{}", text(&output));
    for row in ["waived  e-stop", "waived  heartbeat"] {
        assert!(text(&output).contains(row), "{}", text(&output));
    }
}
