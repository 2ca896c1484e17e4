//! Recordings and files from an attacker or a damaged disk: each is refused at once by name, or read as a stream in little
//! memory.
#![cfg(target_os = "linux")]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bench_tests::program::bench;
use bench_tests::run_cost::RunCost;
use bench_tests::session::{finish, text, write_bench_config};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use tempfile::TempDir;

use super::refusals::assert_refusal;

/// Greatest time and memory of a refusal.
const TIME: Duration = Duration::from_secs(10);
const MEMORY_KB: u64 = 200 * 1024;

const MANIFEST: &str = "format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
channels.drive = { index = 0, volts_per_unit = 20.0 }
channels.pickup = { index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }
plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.0525 }
";
const INTERVALS: &str = "
[[intervals]]
kind = \"unloaded\"
start_s = 0.1
end_s = 0.2

[[intervals]]
kind = \"exploration\"
direction = \"left_to_right\"
start_s = 0.3
end_s = 0.5
";
const FILES: [&str; 4] = ["recording.toml", "signals.wav", "force.csv", "position.csv"];

/// Runs a command and watches its memory.
fn measure(command: &mut Command) -> RunCost {
    RunCost::measure(command, 6 * TIME)
}

/// Requirements of a command on damaged files.
trait Requirements {
    /// Requires an orderly refusal with these words, within the limits.
    fn require_refusal(&self, words: &[&str]);
    /// Requires that the recording was read and found silent, so that nothing could be estimated.
    fn require_silence(&self);
    /// Requires that the command took little time and memory, and did not panic.
    fn require_limits(&self);
}

impl Requirements for RunCost {
    fn require_refusal(&self, words: &[&str]) {
        assert!(
            self.code.is_some_and(|code| code != 0),
            "{}",
            self.transcript
        );
        self.require_limits();
        for word in words {
            assert!(
                self.transcript.contains(word),
                "no `{word}` in:\n{}",
                self.transcript
            );
        }
        assert!(self.transcript.len() < 2000, "{}", self.transcript.len());
    }

    fn require_silence(&self) {
        assert_eq!(self.code, Some(1), "{:.2000}", self.transcript);
        let words = "nothing could be estimated";
        assert!(self.transcript.contains(words), "{:.2000}", self.transcript);
    }

    fn require_limits(&self) {
        let Self { time, peak_kb, .. } = self;
        assert!(
            *time < TIME && *peak_kb < MEMORY_KB,
            "{time:?}, {peak_kb} kB"
        );
        assert!(!self.transcript.contains("panicked"), "{}", self.transcript);
    }
}

/// Makes a valid, silent recording of one second in a folder.
fn recording() -> (TempDir, PathBuf) {
    let room = tempfile::tempdir().unwrap();
    let folder = room.path().join("recording");
    fs::create_dir(&folder).unwrap();
    fs::write(
        folder.join("recording.toml"),
        format!("{MANIFEST}{INTERVALS}"),
    )
    .unwrap();
    signals(&folder, 96_000 * 8, 96_000 * 8);
    let rows = |row: &dyn Fn(u32) -> String| (0..1000).map(row).collect::<String>();
    let force = rows(&|i| format!("{}e-3,0.5,0.1\n", i));
    let position = rows(&|i| format!("{}e-3,0.05\n", i));
    fs::write(
        folder.join("force.csv"),
        format!("time_s,normal_n,lateral_n\n{force}"),
    )
    .unwrap();
    fs::write(
        folder.join("position.csv"),
        format!("time_s,position_m\n{position}"),
    )
    .unwrap();
    (room, folder)
}

/// Writes a `signals.wav` of two channels with `declared_bytes` of samples according to its header, and `bytes` zeros.
fn signals(folder: &Path, declared_bytes: u32, bytes: u64) {
    let mut file = File::create(folder.join("signals.wav")).unwrap();
    let number = |value: u32| value.to_le_bytes();
    let half = |value: u16| value.to_le_bytes();
    let parts: [&[u8]; 12] = [
        b"RIFF",
        &number(declared_bytes.saturating_add(36)),
        b"WAVEfmt ",
        &number(16),
        &half(3),
        &half(2),
        &number(96_000),
        &number(96_000 * 8),
        &half(8),
        &half(32),
        b"data",
        &number(declared_bytes),
    ];
    file.write_all(&parts.concat()).unwrap();
    file.set_len(44 + bytes).unwrap();
}

fn analyze(folder: &Path) -> RunCost {
    measure(bench().arg("analyze").arg(folder))
}

fn replay(folder: &Path) -> RunCost {
    let mut command = bench();
    measure(
        command
            .args(["replay", "--headless", "--speed", "max"])
            .arg(folder),
    )
}

fn pipe(path: &Path) {
    mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
}

#[test]
fn a_sound_recording_is_read() {
    let (_room, folder) = recording();
    let cost = analyze(&folder);
    cost.require_silence();
    cost.require_limits();
}

/// Fault 44.
#[test]
fn what_is_no_file_in_a_recording_is_refused_by_its_name() {
    for name in FILES {
        let (_room, folder) = recording();
        let path = folder.join(name);
        let mut listeners = Vec::new();
        let replacements: [(&str, &mut dyn FnMut()); 4] = [
            ("a named pipe", &mut || pipe(&path)),
            ("a device", &mut || symlink("/dev/zero", &path).unwrap()),
            ("a folder", &mut || fs::create_dir(&path).unwrap()),
            ("a socket", &mut || {
                listeners.push(UnixListener::bind(&path).unwrap())
            }),
        ];
        for (kind, replace) in replacements {
            if path.is_dir() {
                fs::remove_dir(&path).unwrap();
            } else {
                fs::remove_file(&path).unwrap();
            }
            replace();
            let words = [name, kind, "not a regular file"];
            analyze(&folder).require_refusal(&words);
            replay(&folder).require_refusal(&words);
        }
    }
}

/// Fault 44.
#[test]
fn what_is_no_file_beside_the_bench_is_refused_by_its_name() {
    let room = tempfile::tempdir().unwrap();
    let fifo = room.path().join("fifo.toml");
    pipe(&fifo);
    let config = write_bench_config(room.path(), &[]);
    let study = room.path().join("study");
    for (file, kind) in [
        (fifo.as_path(), "a named pipe"),
        (Path::new("/dev/zero"), "a device"),
        (room.path(), "a folder"),
    ] {
        let words = [kind, file.to_str().unwrap()];
        let mut config_command = bench();
        config_command
            .args(["check", "--quick", "--config"])
            .arg(file);
        let mut calibration_command = bench();
        calibration_command.args(["monitor", "--mock", "--headless", "--duration-s", "1"]);
        calibration_command
            .arg("--config")
            .arg(&config)
            .arg("--calibration")
            .arg(file);
        let mut protocol_command = bench();
        protocol_command.args(["run", "--mock", "--headless", "--participant", "sub-01"]);
        protocol_command
            .args(["--consent-by", "K", "--study"])
            .arg(&study);
        protocol_command.arg("--protocol").arg(file);
        let mut scenario_command = bench();
        scenario_command
            .args(["monitor", "--headless", "--duration-s", "1", "--mock"])
            .arg(file);
        for mut command in [
            config_command,
            calibration_command,
            protocol_command,
            scenario_command,
        ] {
            measure(&mut command).require_refusal(&words);
        }
    }
    assert!(!study.exists());
}

/// Fault 44.
#[test]
fn a_log_that_is_no_file_stops_a_resumption() {
    let room = tempfile::tempdir().unwrap();
    let study = room.path().join("study");
    let session = study.join("sub-01/ses-01");
    fs::create_dir_all(&session).unwrap();
    let description = r#"{"Name": "s", "DatasetType": "raw", "GeneratedBy": []}"#;
    fs::write(study.join("dataset_description.json"), description).unwrap();
    let resume = || {
        let mut run = bench();
        run.args(["run", "--mock", "--headless", "--resume", "--speed", "max"]);
        run.args(["--participant", "sub-01", "--consent-by", "K", "--study"]);
        measure(run.arg(&study))
    };
    let log = session.join("events.jsonl");
    pipe(&log);
    resume().require_refusal(&["events.jsonl", "a named pipe"]);
    fs::remove_file(&log).unwrap();
    File::create(&log).unwrap().set_len(5 << 30).unwrap();
    resume().require_refusal(&["events.jsonl", "longer than 67108864 bytes"]);
}

/// Fault 44.
#[test]
fn rows_without_end_are_refused() {
    for name in ["force.csv", "position.csv"] {
        let (_room, folder) = recording();
        let file = File::options()
            .append(true)
            .open(folder.join(name))
            .unwrap();
        file.set_len(5 << 30).unwrap();
        analyze(&folder).require_refusal(&[name, "more than", "bytes in a recording of 1.000 s"]);
    }
    let (_room, folder) = recording();
    let mut file = File::options()
        .append(true)
        .open(folder.join("force.csv"))
        .unwrap();
    file.write_all("0.9,0.5,0.1\n".repeat(400_000).as_bytes())
        .unwrap();
    analyze(&folder).require_refusal(&["force.csv", "more than 300000 rows", "100000 a second"]);
}

/// Fault 44.
#[test]
fn a_hundred_thousand_chunks_are_refused() {
    let (_room, folder) = recording();
    let path = folder.join("signals.wav");
    let file = fs::read(&path).unwrap();
    let chunks = b"LIST\0\0\0\0".repeat(200_000);
    fs::write(&path, [&file[..36], &chunks, &file[36..]].concat()).unwrap();
    analyze(&folder).require_refusal(&["signals.wav", "number of chunks", "at most 1000"]);
}

/// Fault 44.
#[test]
fn a_hundred_thousand_intervals_and_events_are_refused() {
    let event = "\n[[events]]\nkind = \"note\"\nsample = 3\n";
    let interval = "\n[[intervals]]\nkind = \"unloaded\"\nstart_s = 0.1\nend_s = 0.100001\n";
    for (entry, count, word) in [
        (event, 200_000, "longer than 2097152 bytes"),
        (interval, 200_000, "longer than 2097152 bytes"),
        (event, 20_000, "`events` has 20000 entries"),
        (interval, 20_000, "`intervals` has 20002 entries"),
        // Each entry is allowed, but together they would be analysed ten thousand times.
        (INTERVALS, 4_000, "together"),
    ] {
        let (_room, folder) = recording();
        let manifest = format!("{MANIFEST}{INTERVALS}{}", entry.repeat(count));
        fs::write(folder.join("recording.toml"), manifest).unwrap();
        analyze(&folder).require_refusal(&["recording.toml", word]);
    }
}

#[test]
fn the_largest_allowed_manifest_is_read_in_time() {
    let (_room, folder) = recording();
    let event = "\n[[events]]\nkind = \"force_over_range\"\nsample = 30000\nframes = 7\n";
    let interval = |i: usize| {
        let (start_s, end_s) = (0.1 + 5e-5 * i as f64, 0.1 + 5e-5 * (i + 1) as f64);
        let kind = "kind = \"exploration\"\ndirection = \"left_to_right\"";
        format!("\n[[intervals]]\n{kind}\nstart_s = {start_s}\nend_s = {end_s}\n")
    };
    let intervals: String = (0..9_998).map(interval).collect();
    let manifest = format!("{MANIFEST}{INTERVALS}{intervals}{}", event.repeat(9_999));
    fs::write(folder.join("recording.toml"), manifest).unwrap();
    let cost = analyze(&folder);
    cost.require_silence();
    cost.require_limits();
}

#[test]
fn gigabytes_of_audio_are_streamed() {
    let (_room, folder) = recording();
    // Five gigabytes would be the same to the reader and take longer.
    const BYTES: u32 = 800_000_000;
    signals(&folder, BYTES, BYTES.into());
    let cost = analyze(&folder);
    cost.require_silence();
    assert!(cost.peak_kb < 60 * 1024, "{} kB", cost.peak_kb);
}

/// Fault 44.
#[test]
fn a_header_is_judged_before_gigabytes_are_read() {
    let (_room, folder) = recording();
    let mut file = File::options()
        .write(true)
        .open(folder.join("signals.wav"))
        .unwrap();
    file.seek(SeekFrom::Start(20)).unwrap();
    // An unknown sample format: the file is refused before its samples are read.
    file.write_all(&[0x55, 0]).unwrap();
    file.set_len(5 << 30).unwrap();
    analyze(&folder).require_refusal(&["signals.wav", "MP3"]);
}

/// Fault 44.
#[test]
fn an_absurd_time_costs_one_row() {
    let (_room, folder) = recording();
    let path = folder.join("force.csv");
    let rows = fs::read_to_string(&path).unwrap();
    fs::write(
        &path,
        rows.replace("\n500e-3,", "\n1e300,")
            .replace("\n400e-3,", "\n0.9995,"),
    )
    .unwrap();
    let output = finish(bench().arg("analyze").arg(&folder));
    let transcript = text(&output);
    assert_eq!(output.status.code(), Some(1), "{transcript}");
    for word in [
        "nothing could be estimated",
        "force.csv: 1 rows are left out because their time is more than 2 s outside",
        "force.csv: 1 rows are left out because their time leaps ahead",
    ] {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
}

#[test]
fn a_recording_that_is_no_folder_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("pipe");
    pipe(&path);
    assert_refusal(&finish(bench().arg("analyze").arg(&path)), &["pipe"]);
    assert_refusal(
        &finish(bench().args(["replay", "--headless"]).arg(&path)),
        &["pipe"],
    );
}

/// Requires the output to be free of characters that a terminal would obey; returns it.
fn require_harmless(output: &std::process::Output) -> String {
    for (name, bytes) in [("output", &output.stdout), ("errors", &output.stderr)] {
        let transcript = std::str::from_utf8(bytes).unwrap();
        let is_control = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!transcript.contains(is_control), "{name}: {transcript:?}");
    }
    text(output)
}

/// Fault 44.
#[test]
fn control_characters_of_a_recording_are_shown_and_not_obeyed() {
    const HOSTILE: &str = "\u{1b}]0;owned\u{7}\u{9b}2J\u{202e}";
    const ESCAPED: &str = r"\u001b]0;owned\u0007\u009b2J\u202e";
    let (room, folder) = recording();
    let hostile_path = room.path().join(format!("trial{HOSTILE}"));
    fs::rename(&folder, &hostile_path).unwrap();
    let command = |words: &[&str]| {
        let mut command = bench();
        require_harmless(&finish(command.args(words).arg(&hostile_path)))
    };
    for words in [
        &["analyze"][..],
        &["analyze", "--table"],
        &["analyze", "--json", "-"],
        &["replay", "--headless", "--speed", "max", "--verbose"],
    ] {
        let transcript = command(words);
        assert!(
            words.contains(&"--table") || transcript.contains(ESCAPED),
            "{words:?}: {transcript}"
        );
    }
    let json = finish(bench().args(["analyze", "--json", "-"]).arg(&hostile_path));
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let path = json["recordings"][0]["path"].as_str().unwrap();
    assert_eq!(Path::new(path), hostile_path);

    // Text within the files, which errors quote.
    fs::write(hostile_path.join("force.csv"), "time_s,\u{9b}2J\n").unwrap();
    assert!(command(&["analyze"]).contains("force.csv"));
    let escape = r"\u001b]0;owned\u0007\u009b2J\u202e";
    for line in [
        format!("\"{escape}\" = 1\n"),
        format!("participant = {{ id = \"a\", session = 1, \"{escape}\" = 1 }}\n"),
        format!("events = [{{ kind = \"{escape}\", sample = 1 }}]\n"),
    ] {
        fs::write(
            hostile_path.join("recording.toml"),
            format!("{MANIFEST}{line}{INTERVALS}"),
        )
        .unwrap();
        for words in [&["analyze"][..], &["replay", "--headless"]] {
            let transcript = command(words);
            assert!(transcript.contains("recording.toml"), "{transcript}");
        }
    }
    let study = hostile_path.parent().unwrap();
    let list = require_harmless(&finish(bench().arg("replay").arg(study)));
    assert!(list.contains("friction-bench replay"), "{list}");
}

/// Fault 44.
#[test]
fn control_characters_of_a_protocol_are_shown_and_not_obeyed() {
    let room = tempfile::tempdir().unwrap();
    let protocol = room.path().join("protocol\u{1b}[2J.toml");
    fs::write(&protocol, "name = \"a\\u001b[2J\"\nfriends\u{9b} = 1\n").unwrap();
    let mut run = bench();
    run.args([
        "run",
        "--mock",
        "--headless",
        "--verbose",
        "--participant",
        "sub-01",
    ]);
    run.args(["--consent-by", "K\u{1b}[2J", "--protocol"])
        .arg(&protocol);
    let output = finish(run.arg("--study").arg(room.path().join("study")));
    assert!(require_harmless(&output).contains(r"protocol\u001b[2J.toml"));
}
