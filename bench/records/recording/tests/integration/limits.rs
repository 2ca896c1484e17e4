//! Limits of the readers: each refusal names its limit, and only a wrong row is dropped.

use std::fs;
use std::path::Path;

use crate::support::{FORMAT_2, manifest, ramp};
use bounded_files::{FileKind, Refusal, refusal};
use recording::manifest::{
    EventKind, MAX_ENTRIES, ManifestError, ManifestReadError, RecordedInterval,
    RecordedIntervalKind, RecordingEvent,
};
use recording::reader::{ReadError, Warning};
use recording::writer::Ending;
use recording::{
    AudioFormat, FORCE_FILE, MANIFEST_FILE, Manifest, POSITION_FILE, RecordingReader,
    RecordingWriter, SIGNALS_FILE,
};
use wav_files::{WavError, WavReader, header};

/// Length of the recordings in these tests, s.
const LENGTH_S: f64 = 0.5;

fn recording(folder: &Path) {
    let mut writer = RecordingWriter::create(folder, manifest(), FORMAT_2).unwrap();
    let frames = LENGTH_S * f64::from(FORMAT_2.sample_rate_hz);
    writer.write_audio(&ramp(0, frames as usize)).unwrap();
    writer.finish(Ending::Completed).unwrap();
}

/// Reads a `force.csv` with one row per time, from line 2 on; returns the times read and the warnings.
fn read_force(times: &[&str]) -> (Vec<f64>, Vec<Warning>) {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    recording(&folder);
    let rows: String = times
        .iter()
        .map(|time| format!("{time},0.6,0.1\n"))
        .collect();
    fs::write(
        folder.join(FORCE_FILE),
        format!("time_s,normal_n,lateral_n\n{rows}"),
    )
    .unwrap();
    let mut force = RecordingReader::open(&folder).unwrap().force().unwrap();
    let times_s = force.by_ref().map(|row| row.unwrap().time_s).collect();
    let mut warnings = force.warnings();
    // The rows of these tests end where their fault is shown.
    warnings.retain(|warning| !matches!(warning, Warning::EndsEarly { .. }));
    (times_s, warnings)
}

/// Fault 44.
#[test]
fn an_absurd_time_costs_its_row_alone() {
    let (times_s, warnings) = read_force(&["0.0", "1e300", "0.1", "-1e300", "0.2"]);
    assert_eq!(times_s, [0.0, 0.1, 0.2]);
    assert_eq!(
        warnings,
        [Warning::OutsideRecording {
            file: FORCE_FILE,
            rows: 2,
            first_line: 3,
            from_s: -1e300,
            to_s: 1e300,
            duration_s: LENGTH_S,
        }]
    );
}

#[test]
fn a_leap_ahead_within_the_recording_costs_the_rows_that_leapt() {
    let leap = |rows, first_line| {
        [Warning::TimeLeap {
            file: FORCE_FILE,
            rows,
            first_line,
        }]
    };
    let (times_s, warnings) = read_force(&["0.0", "0.001", "0.45", "0.002", "0.003"]);
    assert_eq!(times_s, [0.0, 0.001, 0.002, 0.003]);
    assert_eq!(warnings, leap(1, 4));
    // Two bad rows together, the first one in the first line.
    let (times_s, warnings) = read_force(&["0.4", "0.45", "0.0", "0.001"]);
    assert_eq!(times_s, [0.0, 0.001]);
    assert_eq!(warnings, leap(2, 2));
}

#[test]
fn a_gap_in_time_is_no_leap() {
    let (times_s, warnings) = read_force(&["0.0", "0.3", "0.301", "0.301", "0.4"]);
    assert_eq!(times_s, [0.0, 0.3, 0.301, 0.4]);
    let disorder = Warning::TimeDisorder {
        file: FORCE_FILE,
        rows: 1,
        first_line: 5,
    };
    assert_eq!(warnings, [disorder]);
    // Enough rows to confirm a leap, then one that falls back in time.
    let late: Vec<String> = (0..200)
        .map(|i| format!("{}", 0.3 + f64::from(i) * 1e-4))
        .collect();
    let mut times = vec!["0.0"];
    times.extend(late.iter().map(String::as_str));
    times.push("0.1");
    let (times_s, warnings) = read_force(&times);
    assert_eq!(times_s.len(), 201);
    assert!(matches!(
        warnings[..],
        [Warning::TimeDisorder {
            rows: 1,
            first_line: 203,
            ..
        }]
    ));
}

#[test]
fn a_line_that_is_too_long_is_an_unreadable_row() {
    let long = format!("0.1{}", " ".repeat(5000));
    let (times_s, warnings) = read_force(&["0.0", &long, "0.2"]);
    assert_eq!(times_s, [0.0, 0.2]);
    assert!(matches!(
        warnings[..],
        [Warning::UnreadableRows {
            rows: 1,
            first_line: 3,
            ..
        }]
    ));
}

/// Fault 44.
#[test]
fn more_rows_than_a_sensor_gives_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    recording(&folder);
    let path = folder.join(FORCE_FILE);
    let last = |rows: String| {
        fs::write(&path, format!("time_s,normal_n,lateral_n\n{rows}")).unwrap();
        let force = RecordingReader::open(&folder).unwrap().force().unwrap();
        force.last().unwrap()
    };
    // 100 kHz over the recording and two further seconds.
    let error = last("0.1,0.6,0.1\n".repeat(300_000)).unwrap_err();
    assert!(
        matches!(
            error,
            ReadError::TooManyRows {
                limit_rows: 250_000,
                ..
            }
        ),
        "{error}"
    );
    let file = fs::File::options().append(true).open(&path).unwrap();
    file.set_len(1 << 33).unwrap();
    fs::write(&path, "time_s,normal_n,lateral_n\n0.1,0.6,0.1\n").unwrap();
    file.set_len(1 << 33).unwrap();
    let force = RecordingReader::open(&folder).unwrap().force().unwrap();
    let error = force.last().unwrap().unwrap_err();
    assert!(
        matches!(
            error,
            ReadError::RowsTooLong {
                limit_bytes: 64_000_000,
                ..
            }
        ),
        "{error}"
    );
}

/// Fault 44.
#[test]
fn a_file_that_is_none_is_refused_by_its_kind() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    recording(&folder);
    for name in [SIGNALS_FILE, MANIFEST_FILE] {
        let path = folder.join(name);
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        let ReadError::Io {
            reason,
            path: error_path,
        } = RecordingReader::open(&folder).unwrap_err()
        else {
            panic!("another error for {name}");
        };
        assert_eq!(error_path, path);
        let kind = Refusal::NotRegular(FileKind::Folder);
        assert_eq!(refusal(&reason), Some(&kind));
    }
}

#[test]
fn a_missing_file_of_rows_is_named_with_the_source_of_its_rows() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    recording(&folder);
    for (name, words) in [
        (POSITION_FILE, "without an encoder, write the positions"),
        (FORCE_FILE, "write the forces of the finger there"),
    ] {
        fs::remove_file(folder.join(name)).unwrap();
        let reader = RecordingReader::open(&folder).unwrap();
        let error = match name {
            FORCE_FILE => reader.force().err(),
            _ => reader.position().err(),
        };
        let message = error.unwrap().to_string();
        assert!(
            message.contains(&format!("{name} does not exist: {words}")),
            "{message}"
        );
    }
}

/// Fault 44.
#[test]
fn a_header_beyond_its_limits_is_refused() {
    let excess = |bytes: Vec<u8>| match WavReader::new(std::io::Cursor::new(bytes)) {
        Err(WavError::OverLimit { value, limit, .. }) => (value, limit),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("read"),
    };
    let mut chunks = header(FORMAT_2, 0)[..38].to_vec();
    chunks.extend(b"LIST\0\0\0\0".repeat(2000));
    assert_eq!(excess(chunks), (1001, 1000));
    let header_bytes = |sample_rate_hz, channels| {
        let format = AudioFormat {
            sample_rate_hz,
            channels,
        };
        header(format, 0).to_vec()
    };
    assert_eq!(excess(header_bytes(96_000, 300)), (300, 256));
    assert_eq!(excess(header_bytes(4_000_000, 2)), (4_000_000, 2_000_000));
}

/// Fault 44.
#[test]
fn a_manifest_beyond_its_limits_is_refused() {
    let text = |entry: &str, count: usize| manifest().to_toml().unwrap() + &entry.repeat(count);
    let note = "\n[[events]]\nkind = \"note\"\nsample = 3\n";
    let read = |text: &str| Manifest::parse(text, MANIFEST_FILE);
    assert_eq!(
        read(&text(note, MAX_ENTRIES)).unwrap().events.len(),
        MAX_ENTRIES
    );
    let error = read(&text(note, MAX_ENTRIES + 1)).unwrap_err();
    let ManifestReadError::Rule { rule, .. } = error else {
        panic!("{error}");
    };
    let count = MAX_ENTRIES + 1;
    let key = "events";
    assert_eq!(rule, ManifestError::TooMany { key, count });

    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    recording(&folder);
    let path = folder.join(MANIFEST_FILE);
    let interval = "\n[[intervals]]\nkind = \"unloaded\"\nstart_s = 0.1\nend_s = 0.4\n";
    fs::write(&path, text(interval, 6)).unwrap();
    RecordingReader::open(&folder).unwrap();
    fs::write(&path, text(interval, 7)).unwrap();
    let error = RecordingReader::open(&folder).unwrap_err();
    let ReadError::Manifest(ManifestReadError::Rule { rule, line, .. }) = error else {
        panic!("{error}");
    };
    assert!(matches!(rule, ManifestError::IntervalTime { .. }), "{rule}");
    assert!(line.is_some());

    fs::write(&path, "#".repeat(3 << 20)).unwrap();
    let error = RecordingReader::open(&folder).unwrap_err();
    let ReadError::Io { reason, .. } = error else {
        panic!("{error}");
    };
    let limit_bytes = 2 << 20;
    assert_eq!(refusal(&reason), Some(&Refusal::TooLong { limit_bytes }));
}

#[test]
fn a_writer_lists_no_more_events_than_can_be_read() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    let event = |sample| RecordingEvent {
        kind: EventKind::InputXrun,
        sample,
        frames: None,
        text: None,
    };
    writer.renew_event(0, event(0));
    for sample in 1..MAX_ENTRIES as u64 {
        writer.add_event(event(sample));
    }
    writer.renew_event(1, event(MAX_ENTRIES as u64));
    let known = RecordingEvent {
        frames: Some(7),
        ..event(0)
    };
    writer.renew_event(0, known.clone());
    writer.finish(Ending::Completed).unwrap();
    let reader = RecordingReader::open(&folder).unwrap();
    let events = &reader.manifest().events;
    assert_eq!(events.len(), MAX_ENTRIES);
    assert_eq!(events[0], known);
    let last = events.last().unwrap();
    assert_eq!(last.kind, EventKind::Note);
    assert!(last.text.is_some());
}

#[test]
fn saturated_spans_are_in_order_and_apart() {
    let mut manifest = manifest();
    let saturated = |sample, frames| RecordingEvent {
        kind: EventKind::ForceOverRange,
        sample,
        frames,
        text: None,
    };
    manifest.events = vec![
        saturated(500, Some(100)),
        saturated(100, Some(200)),
        saturated(200, Some(50)),
        saturated(u64::MAX, Some(u64::MAX)),
    ];
    let spans = manifest.saturated_s(100.0);
    assert_eq!(spans[..2], [(1.0, 3.0), (5.0, 6.0)]);
    assert_eq!(spans.len(), 3);
    manifest.intervals = vec![RecordedInterval {
        kind: RecordedIntervalKind::Unloaded,
        start_s: 0.0,
        end_s: 1e9,
    }];
    // Only the part within the recording counts, up to half an hour.
    assert_eq!(manifest.validate_length(1800.0), Ok(()));
    let too_long = manifest.validate_length(1801.0);
    assert!(matches!(too_long, Err(ManifestError::IntervalTime { .. })));
}
