//! Recordings of processes that are killed or reach a file size limit. Each test runs itself once more as the victim.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::support::{FORMAT_2, force_rows, manifest, ramp, read_all};
use recording::manifest::End;
use recording::study::EventLog;
use recording::study::event_log::{self, ExitStatus};
use recording::writer::{Ending, WriteError};
use recording::{AudioFormat, RecordingReader, RecordingWriter};
use serde_json::{Map, Value};

const FOLDER: &str = "FRICTION_BENCH_TEST_FOLDER";

fn victim_folder() -> Option<PathBuf> {
    std::env::var_os(FOLDER).map(PathBuf::from)
}

/// Runs one test of this binary in a child process, through a shell that first executes `setup`.
fn victim(test: &str, setup: &str, folder: &Path) -> Child {
    Command::new("sh")
        .arg("-c")
        .arg(format!(
            "{setup} exec \"$0\" --exact process::{test} --nocapture"
        ))
        .arg(std::env::current_exe().unwrap())
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Returns the number of frames that the victim reports as saved.
fn saved(line: &str) -> Option<u64> {
    line.rsplit_once("saved ")?.1.parse().ok()
}

/// Fault 28.
#[test]
fn sigkill_loses_nothing_that_was_saved() {
    const BLOCK: usize = 1920;
    if let Some(folder) = victim_folder() {
        let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
        for n in 0.. {
            writer.write_audio(&ramp(n * BLOCK, BLOCK)).unwrap();
            writer
                .write_force(&force_rows(n as u32 * 100, 100))
                .unwrap();
            if n % 3 == 2 {
                println!("saved {}", writer.sync().unwrap().frames);
                std::io::stdout().flush().unwrap();
            }
        }
    }
    let temp = tempfile::tempdir().unwrap();
    for after_syncs in 1..=8 {
        let folder = temp.path().join(after_syncs.to_string());
        let mut child = victim("sigkill_loses_nothing_that_was_saved", "", &folder);
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut numbers = lines.map_while(Result::ok).filter_map(|l| saved(&l));
        let mut last = numbers.nth(after_syncs - 1).unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
        last = numbers.last().unwrap_or(last);

        let (reader, samples) = read_all(&folder);
        assert!(samples.len() as u64 / 2 >= last, "{last} frames were saved");
        assert!(samples == ramp(0, samples.len() / 2));
        assert_eq!(reader.manifest().trial.as_ref().unwrap().end, None);
        let rows = reader.force().unwrap().map(Result::unwrap).count() as u64;
        assert!(rows >= last / BLOCK as u64 * 100);
    }
}

/// Fault 25.
#[test]
fn a_full_disk_or_file_size_limit_is_an_error_and_the_rest_is_kept() {
    const WIDE: AudioFormat = AudioFormat {
        sample_rate_hz: 192_000,
        channels: 3,
    };
    if let Some(folder) = victim_folder() {
        let mut writer = RecordingWriter::create(&folder, manifest(), WIDE).unwrap();
        let block = vec![0.5; 3 * 1000];
        let error: WriteError = loop {
            if let Err(error) = writer.write_audio(&block) {
                break error;
            }
            writer
                .write_force(&force_rows(writer.frames() as u32 / 20, 10))
                .unwrap();
        };
        let text = error.to_string();
        assert!(text.contains("limit on file sizes"), "{text}");
        println!("saved {}", writer.abandon(text).frames);
        std::process::exit(0);
    }
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    // POSIX: `ulimit -f` counts units of 512 bytes. The signal is ignored, so that the write itself fails.
    let mut child = victim(
        "a_full_disk_or_file_size_limit_is_an_error_and_the_rest_is_kept",
        "trap '' XFSZ; ulimit -f 2001;",
        &folder,
    );
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let frames = lines.map_while(Result::ok).find_map(|l| saved(&l)).unwrap();
    assert!(child.wait().unwrap().success());

    // Frames of 12 bytes do not divide the limit: the file is cut to whole frames, and its header has their number.
    assert_eq!(frames, (2001 * 512 - 58) / 12);
    let reader = RecordingReader::open(&folder).unwrap();
    assert_eq!(reader.frames(), frames);
    assert_eq!(reader.warnings(), []);
    let trial = reader.manifest().trial.as_ref().unwrap();
    assert_eq!(trial.end, Some(End::Interrupted));
    let mut force = reader.force().unwrap();
    assert!(force.by_ref().count() > 0);
    assert_eq!(force.warnings(), []);
}

/// Fault 26.
#[test]
fn a_log_line_that_a_limit_tears_is_taken_back() {
    if let Some(folder) = victim_folder() {
        let mut log = EventLog::create(folder).unwrap();
        let event = |text: String| Map::from_iter([("text".to_owned(), Value::String(text))]);
        let time = || "2026-11-21T07:00:00Z".to_owned();
        log.event("session", time(), 0.0, event("kept".to_owned()))
            .unwrap();
        let long = event("x".repeat(4096));
        log.event("session", time(), 1.0, long).unwrap_err();
        // A shorter line still fits within the limit.
        log.event("session", time(), 2.0, event("fits".to_owned()))
            .unwrap();
        log.stop(time(), ExitStatus::Fail, None).unwrap();
        std::process::exit(0);
    }
    let temp = tempfile::tempdir().unwrap();
    let path = temp.path().join("events.jsonl");
    let mut child = victim(
        "a_log_line_that_a_limit_tears_is_taken_back",
        "trap '' XFSZ; ulimit -f 4;",
        &path,
    );
    assert!(child.wait().unwrap().success());
    let content = event_log::read(&path).unwrap();
    assert!(content.torn_lines.is_empty());
    assert_eq!(content.stop().unwrap().num_events, 2);
    assert_eq!(content.documents.len(), 3);
}

/// Fault 26.
#[test]
fn a_limit_met_at_the_very_end_is_not_called_saved() {
    if let Some(folder) = victim_folder() {
        let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
        writer.write_audio(&ramp(0, 20_000)).unwrap();
        let unfinished = writer.finish(Ending::Completed).unwrap_err();
        println!("saved {}", unfinished.saved_part.frames);
        std::process::exit(0);
    }
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut child = victim(
        "a_limit_met_at_the_very_end_is_not_called_saved",
        "trap '' XFSZ; ulimit -f 200;",
        &folder,
    );
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let frames = lines.map_while(Result::ok).find_map(|l| saved(&l)).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(frames, (200 * 512 - 58) / 8);
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples, ramp(0, frames as usize));
    assert_eq!(reader.warnings(), []);
}
