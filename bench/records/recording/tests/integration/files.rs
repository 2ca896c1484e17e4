//! Recording folders: written data are read back, here and by independent code, even after the writer was killed.

use std::fs;
use std::path::Path;

use crate::support::{FORMAT_2, force_rows, manifest, position_rows, ramp, read_all, write_data};
use recording::DiskError;
use recording::manifest::{
    Direction, End, EventKind, ManifestError, RecordedInterval, RecordedIntervalKind, Streams,
};
use recording::reader::{ReadError, Warning};
use recording::writer::{Ending, WriteError};
use recording::{
    AudioFormat, FORCE_FILE, ForceRow, MANIFEST_FILE, POSITION_FILE, RecordingReader,
    RecordingWriter, SIGNALS_FILE,
};
use wav_files::{MAX_DATA_BYTES, WavError, WavReader, WavWarning, header};

fn finished(folder: &Path) {
    let mut writer = RecordingWriter::create(folder, manifest(), FORMAT_2).unwrap();
    write_data(&mut writer);
    writer.finish(Ending::Completed).unwrap();
}

#[test]
fn a_recording_reads_back_as_written() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("trial-003_attempt-1");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    write_data(&mut writer);
    let interval = RecordedInterval {
        kind: RecordedIntervalKind::Exploration(Direction::RightToLeft),
        start_s: 0.001,
        end_s: 0.005,
    };
    writer.add_interval(interval).unwrap();
    let on_disk = writer.finish(Ending::Completed).unwrap();
    assert_eq!(on_disk.frames, 1000);

    let (reader, samples) = read_all(&folder);
    assert_eq!(samples, ramp(0, 1000));
    assert_eq!(reader.format(), FORMAT_2);
    assert_eq!(reader.warnings(), []);
    assert_eq!(reader.manifest().intervals, [interval]);
    let trial = reader.manifest().trial.clone().unwrap();
    assert_eq!(
        (trial.end, trial.interruption),
        (Some(End::Completed), None)
    );
    let mut force = reader.force().unwrap();
    assert_eq!(force.by_ref().map(Result::unwrap).count(), 50);
    assert_eq!(force.warnings(), []);
    assert_eq!(reader.position().unwrap().count(), 5);

    let bytes: u64 = [SIGNALS_FILE, FORCE_FILE, POSITION_FILE]
        .iter()
        .map(|name| fs::metadata(folder.join(name)).unwrap().len())
        .sum();
    assert_eq!(on_disk.bytes, bytes);
}

/// Intervals are cut where the audio on disk ends.
#[test]
fn an_abandoned_recordings_intervals_end_with_its_audio() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("trial-003_attempt-1");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    write_data(&mut writer);
    let end_s = 1000.0 / 192_000.0;
    for (start_s, stated_end_s) in [(0.001, 0.002), (0.004, 0.1), (0.2, 0.3)] {
        let interval = RecordedInterval {
            kind: RecordedIntervalKind::Unloaded,
            start_s,
            end_s: stated_end_s,
        };
        writer.add_interval(interval).unwrap();
    }
    assert_eq!(writer.abandon("the disk is full".to_owned()).frames, 1000);

    let (reader, _) = read_all(&folder);
    assert_eq!(reader.warnings(), []);
    let intervals = reader.manifest().intervals.iter();
    let spans: Vec<(f64, f64)> = intervals
        .map(|interval| (interval.start_s, interval.end_s))
        .collect();
    assert_eq!(spans, [(0.001, 0.002), (0.004, end_s)]);
}

#[test]
fn the_same_input_gives_the_same_bytes_however_often_it_is_synced() {
    let temp = tempfile::tempdir().unwrap();
    let folders = ["a", "b"].map(|name| temp.path().join(name));
    for (folder, sync_each) in folders.iter().zip([false, true]) {
        let mut writer = RecordingWriter::create(folder, manifest(), FORMAT_2).unwrap();
        for n in 0..10 {
            writer.write_audio(&ramp(n * 100, 100)).unwrap();
            writer.write_force(&force_rows(n as u32 * 5, 5)).unwrap();
            writer.write_gap(3).unwrap();
            if sync_each {
                writer.sync().unwrap();
            }
        }
        writer.finish(Ending::Completed).unwrap();
    }
    for name in [MANIFEST_FILE, SIGNALS_FILE, FORCE_FILE, POSITION_FILE] {
        let [a, b] = [0, 1].map(|n| fs::read(folders[n].join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn an_independent_reader_reads_the_audio() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let mut hound = hound::WavReader::open(folder.join(SIGNALS_FILE)).unwrap();
    let spec = hound.spec();
    assert_eq!((spec.sample_rate, spec.channels), (192_000, 2));
    let samples: Vec<f32> = hound.samples().map(Result::unwrap).collect();
    assert_eq!(samples, ramp(0, 1000));
}

#[test]
fn audio_of_an_independent_writer_is_read_in_every_format() {
    let temp = tempfile::tempdir().unwrap();
    // Full scale and one step for each integer width.
    for (bits, sample_format, full, step) in [
        (16, hound::SampleFormat::Int, 32_768.0, 1),
        (24, hound::SampleFormat::Int, 8_388_608.0, 1),
        (32, hound::SampleFormat::Int, 2_147_483_648.0, 256),
    ] {
        let path = temp.path().join(format!("{bits}.wav"));
        let spec = hound::WavSpec {
            channels: 3,
            sample_rate: 100_000,
            bits_per_sample: bits,
            sample_format,
        };
        let lowest = -(full as i64) as i32;
        let mut writer = hound::WavWriter::create(&path, spec).unwrap();
        for sample in [lowest, step, -step, 0, 2 * step, step] {
            writer.write_sample(sample).unwrap();
        }
        writer.finalize().unwrap();
        let file = fs::File::open(&path).unwrap();
        let (mut reader, warnings) = WavReader::new(file).unwrap();
        assert_eq!(warnings, []);
        assert_eq!(reader.frames(), 2);
        let mut block = Vec::new();
        assert_eq!(reader.read_block(10, &mut block).unwrap(), 2);
        let unit = step as f32 / full as f32;
        assert_eq!(block, [-1.0, unit, -unit, 0.0, 2.0 * unit, unit], "{bits}");
        assert_eq!(reader.read_block(10, &mut block).unwrap(), 0);
    }
}

/// Fault 6.
#[test]
fn lost_samples_are_exactly_so_many_nan() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    writer.write_audio(&ramp(0, 100)).unwrap();
    writer.write_gap(5000).unwrap();
    writer.write_audio(&ramp(5100, 100)).unwrap();
    writer.finish(Ending::Completed).unwrap();

    let (reader, samples) = read_all(&folder);
    assert_eq!(samples[..200], ramp(0, 100));
    assert!(samples[200..10_200].iter().all(|s| s.is_nan()));
    assert_eq!(samples[10_200..], ramp(5100, 100));
    let [event] = &reader.manifest().events[..] else {
        panic!("one event expected");
    };
    assert_eq!(
        (event.kind, event.sample, event.frames),
        (EventKind::Gap, 100, Some(5000))
    );
}

/// Fault 31.
#[test]
fn nothing_is_overwritten() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let before = fs::read(folder.join(SIGNALS_FILE)).unwrap();
    let error = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap_err();
    assert!(matches!(error, WriteError::Exists { .. }), "{error}");
    assert_eq!(fs::read(folder.join(SIGNALS_FILE)).unwrap(), before);
}

#[test]
fn a_parent_that_is_not_there_is_not_made() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("gone").join("r");
    let error = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap_err();
    let WriteError::Disk(DiskError { source, .. }) = &error else {
        panic!("{error}");
    };
    assert_eq!(source.kind(), std::io::ErrorKind::NotFound);
    assert!(!temp.path().join("gone").exists());
}

/// Fault 25.
#[test]
fn a_folder_removed_during_the_trial_is_an_error_not_a_success() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    writer.write_audio(&ramp(0, 10)).unwrap();
    assert_eq!(writer.sync().unwrap().frames, 10);
    fs::remove_dir_all(&folder).unwrap();
    let unfinished = writer.finish(Ending::Completed).unwrap_err();
    assert_eq!(unfinished.saved_part.frames, 0);
}

#[test]
fn an_unreadable_recording_is_not_begun() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut invalid = manifest();
    if let Streams::Signals(signals) = &mut invalid.streams {
        signals.modulation.index = 1.5;
    }
    let error = RecordingWriter::create(&folder, invalid, FORMAT_2).unwrap_err();
    assert!(error.to_string().contains("1.5"), "{error}");
    let slow = AudioFormat {
        sample_rate_hz: 48_000,
        channels: 2,
    };
    let error = RecordingWriter::create(&folder, manifest(), slow).unwrap_err();
    assert!(
        matches!(
            error,
            WriteError::Manifest(ManifestError::Undersampled { .. })
        ),
        "{error}"
    );
    assert!(!folder.exists());
}

#[test]
fn a_block_that_would_pass_4_gib_is_refused_before_it_is_written() {
    let temp = tempfile::tempdir().unwrap();
    let wide = AudioFormat {
        sample_rate_hz: 70_013,
        channels: 15_000,
    };
    assert_eq!(wide.max_frames(), MAX_DATA_BYTES / 60_000);
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), wide).unwrap();
    let error = writer.write_gap(wide.max_frames() + 1).unwrap_err();
    assert!(matches!(error, WriteError::TooLong { .. }), "{error}");
    assert_eq!(writer.frames(), 0);
    writer.write_gap(2).unwrap();
    let error = writer.write_gap(wide.max_frames() - 1).unwrap_err();
    assert!(matches!(error, WriteError::TooLong { .. }), "{error}");
    assert_eq!(writer.finish(Ending::Completed).unwrap().frames, 2);
}

#[test]
fn the_largest_file_declares_sizes_that_fit() {
    let frames = FORMAT_2.max_frames();
    let bytes = header(FORMAT_2, frames);
    let size_at = |offset: usize| u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    assert_eq!(u64::from(size_at(54)), frames * 8);
    assert_eq!(u64::from(size_at(4)), frames * 8 + 50);
}

/// Fault 38.
#[test]
fn times_that_do_not_increase_are_marked_and_read_without() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    writer.write_force(&force_rows(0, 10)).unwrap();
    writer.write_force(&force_rows(5, 10)).unwrap();
    let missing = ForceRow {
        time_s: f64::NAN,
        normal_n: 0.0,
        lateral_n: 0.0,
    };
    let error = writer.write_force(&[missing]).unwrap_err();
    assert!(matches!(error, WriteError::Time { .. }), "{error}");
    writer.finish(Ending::Completed).unwrap();

    let reader = RecordingReader::open(&folder).unwrap();
    let kinds: Vec<_> = reader.manifest().events.iter().map(|e| e.kind).collect();
    assert_eq!(kinds, [EventKind::TimeDisorder]);
    let mut force = reader.force().unwrap();
    assert_eq!(force.by_ref().count(), 15);
    assert_eq!(
        force.warnings(),
        [Warning::TimeDisorder {
            file: FORCE_FILE,
            rows: 5,
            first_line: 12
        }]
    );
}

#[test]
fn a_dropped_writer_leaves_a_readable_recording_that_says_it_was_cut_off() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    write_data(&mut writer);
    writer.sync().unwrap();
    drop(writer);
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples.len(), 2000);
    assert_eq!(reader.warnings(), [Warning::CutOff]);
}

/// Fault 38.
#[test]
fn samples_behind_the_header_of_a_killed_writer_are_read() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let path = folder.join(SIGNALS_FILE);
    let intact = fs::read(&path).unwrap();
    for declared in [0, 999] {
        let mut bytes = intact.clone();
        bytes[..58].copy_from_slice(&header(FORMAT_2, declared));
        fs::write(&path, &bytes).unwrap();
        let (reader, samples) = read_all(&folder);
        assert_eq!(samples, ramp(0, 1000));
        let stale = WavWarning::StaleHeader {
            declared_bytes: declared * 8,
            present_bytes: 8000,
        };
        assert_eq!(reader.warnings(), [Warning::Signals(stale)]);
    }
}

#[test]
fn other_chunks_around_the_samples_are_passed_over() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let path = folder.join(SIGNALS_FILE);
    let intact = fs::read(&path).unwrap();
    let list = b"LIST\x05\0\0\0INFOx\0";
    let mut bytes = intact[..38].to_vec();
    bytes[..4].copy_from_slice(b"RIFF");
    bytes.extend(list);
    bytes.extend(&intact[38..]);
    bytes.extend(list);
    let riff_bytes = (bytes.len() - 8) as u32;
    bytes[4..8].copy_from_slice(&riff_bytes.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples, ramp(0, 1000));
    assert_eq!(reader.warnings(), []);
}

/// Fault 38.
#[test]
fn a_half_copied_file_is_named_with_its_end() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    writer.write_audio(&ramp(1, 192_000)).unwrap();
    writer.write_force(&force_rows(0, 10_000)).unwrap();
    writer.write_position(&position_rows(0, 1000)).unwrap();
    writer.finish(Ending::Completed).unwrap();
    let warnings = || {
        let reader = RecordingReader::open(&folder).unwrap();
        let mut force = reader.force().unwrap();
        let rows = force.by_ref().map(Result::unwrap).count();
        assert!(rows > 0);
        [reader.warnings(), &force.warnings()].concat()
    };
    assert_eq!(warnings(), []);

    let path = folder.join(FORCE_FILE);
    let text = fs::read(&path).unwrap();
    let part = &text[..text.len() / 2];
    fs::write(&path, part).unwrap();
    let words: Vec<String> = warnings().iter().map(ToString::to_string).collect();
    let ends = words.iter().any(|words| {
        words.contains("force.csv: it ends at 0.") && words.contains("recording at 1.000 s")
    });
    assert!(ends, "{words:?}");
    fs::write(
        &path,
        [part, &vec![0; text.len() - part.len()][..]].concat(),
    )
    .unwrap();
    let zeroed = |warning: &Warning| matches!(warning, Warning::ZeroedRows { .. });
    assert!(warnings().iter().any(zeroed), "{:?}", warnings());
    fs::write(&path, &text).unwrap();

    let path = folder.join(SIGNALS_FILE);
    let mut samples = fs::read(&path).unwrap();
    let begin = samples.len() / 8 * 6;
    samples[begin..].fill(0);
    fs::write(&path, &samples).unwrap();
    let warnings = warnings();
    let [Warning::Signals(WavWarning::ZeroTail { frames, .. })] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!(frames.abs_diff(48_000) < 10, "{frames}");
    assert!(
        warnings[0].to_string().contains("from 0.750 s on"),
        "{}",
        warnings[0]
    );
}

/// Fault 38.
#[test]
fn every_damage_of_the_audio_file_has_its_name() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let path = folder.join(SIGNALS_FILE);
    let intact = fs::read(&path).unwrap();
    let damaged = |offset: usize, new: &[u8]| {
        let mut bytes = intact.clone();
        bytes[offset..offset + new.len()].copy_from_slice(new);
        bytes
    };
    let cases: [(Vec<u8>, &str); 14] = [
        (Vec::new(), "not a WAV"),
        (intact[..11].to_vec(), "not a WAV"),
        (damaged(0, b"RIFX"), "RIFX"),
        (damaged(0, b"fLaC"), "FLAC: save"),
        (b"/annex/objects/MD5E-s8--0.wav".to_vec(), "git annex get"),
        (damaged(20, &[7]), "(µ-law), which are not read: save"),
        (damaged(12, b"tmf "), "no `fmt ` chunk"),
        (intact[..50].to_vec(), "no `data` chunk"),
        (damaged(16, &[4]), "4 bytes"),
        (damaged(20, &[85]), "MP3"),
        (damaged(34, &[64]), "bytes per frame is 8"),
        (damaged(22, &[0]), "number of channels is 0"),
        (damaged(24, &[0, 0, 0]), "sample rate is 0"),
        (damaged(32, &[7]), "bytes per frame is 7"),
    ];
    for (bytes, words) in cases {
        fs::write(&path, &bytes).unwrap();
        let error = RecordingReader::open(&folder).unwrap_err();
        assert!(
            matches!(
                error,
                ReadError::Wav {
                    reason: WavError::NotWav { .. }
                        | WavError::Elsewhere(_)
                        | WavError::OtherFormat { .. }
                        | WavError::NoChunk { .. }
                        | WavError::ShortFormat { .. }
                        | WavError::SampleFormat { .. }
                        | WavError::Field { .. },
                    ..
                }
            ),
            "{error}"
        );
        let error = error.to_string();
        assert!(
            error.contains(words) && error.contains(SIGNALS_FILE),
            "{error}"
        );
    }
}

/// Fault 38.
#[test]
fn missing_files_and_columns_are_named() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let path = folder.join(FORCE_FILE);
    fs::write(&path, "time_s,normal\n0,0.5\n").unwrap();
    let reader = RecordingReader::open(&folder).unwrap();
    let error = reader.force().unwrap_err().to_string();
    assert!(
        error.contains("`normal_n`")
            && error.contains("time_s,normal")
            && error.contains(FORCE_FILE),
        "{error}"
    );
    fs::remove_file(&path).unwrap();
    let error = reader.force().unwrap_err().to_string();
    assert!(error.contains(FORCE_FILE), "{error}");
    for name in [SIGNALS_FILE, MANIFEST_FILE] {
        fs::remove_file(folder.join(name)).unwrap();
        let error = RecordingReader::open(&folder).unwrap_err();
        // The message includes the system's reason; an additional cause would repeat it.
        assert!(std::error::Error::source(&error).is_none());
        let error = error.to_string();
        assert!(
            error.contains(name) && error.contains("does not exist"),
            "{error}"
        );
    }
}

#[test]
fn rows_are_read_by_the_names_of_their_columns_and_bad_ones_counted() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    let text = "\u{feff}lateral_n, time_s ,note,normal_n\r\n\
                -0.5, 0.0,x,0.6\r\n\
                NaN,0.1,,0.6\r\n\
                0.1,0.2\r\n\
                0.1,0.3,\"unclosed,zero\r\n\
                0.1,nan,,0.6\r\n\
                0,1,0,31,,0,6\r\n\
                -0.4,0.4,,0.7,,\r\n\
                -0.4,0.5,,0.";
    fs::write(folder.join(FORCE_FILE), text).unwrap();
    let reader = RecordingReader::open(&folder).unwrap();
    let mut force = reader.force().unwrap();
    let rows: Vec<ForceRow> = force.by_ref().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3);
    assert_eq!((rows[0].normal_n, rows[0].lateral_n), (0.6, -0.5));
    assert!(rows[1].lateral_n.is_nan());
    assert_eq!(rows[2].time_s, 0.4);
    assert_eq!(
        force.warnings(),
        [
            Warning::UnreadableRows {
                file: FORCE_FILE,
                rows: 5,
                first_line: 4,
                first: "0.1,0.2".to_owned(),
            },
            Warning::NotFinite {
                file: FORCE_FILE,
                rows: 1,
                first_line: 3
            },
        ]
    );
    fs::write(folder.join(POSITION_FILE), "time_s,position_m\n").unwrap();
    let mut position = reader.position().unwrap();
    assert!(position.next().is_none());
    let no_rows = Warning::NoRows {
        file: POSITION_FILE,
    };
    assert_eq!(position.warnings(), [no_rows]);
}

/// Rows of a `force.csv` with these bytes, and the reader's warnings.
fn rows_of_file(bytes: &[u8]) -> Result<(Vec<ForceRow>, Vec<Warning>), String> {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    finished(&folder);
    fs::write(folder.join(FORCE_FILE), bytes).unwrap();
    let reader = RecordingReader::open(&folder).unwrap();
    let mut force = reader.force().map_err(|error| error.to_string())?;
    let rows: Result<_, _> = force.by_ref().collect();
    Ok((rows.map_err(|error| error.to_string())?, force.warnings()))
}

#[test]
fn rows_of_other_programs_read_the_same() {
    let row = |time_s, normal_n, lateral_n| ForceRow {
        time_s,
        normal_n,
        lateral_n,
    };
    let expected = vec![row(0.0, 0.625, -0.5), row(0.1, 0.75, 1e-3)];
    let plain = "time_s,normal_n,lateral_n\n0,0.625,-0.5\n0.1,0.75,1e-3\n";
    let semicolons = plain.replace(',', ";").replace('.', ",");
    for text in [
        plain.to_owned(),
        plain.replace('\n', "\r"),
        semicolons.replace('\n', "\r\n"),
        format!("sep=;\r\n{}", semicolons.replace('\n', "\r\n")),
        semicolons.replace(';', "\t"),
        "\"\",\"lateral_n\",\"time_s\",\"normal_n\"\n\"1\",-0.5,0,0.625\n\"2\",0.001,0.1,0.75\n"
            .to_owned(),
        plain.replace("lateral_n\n", "lateral_n\n[s],N,newton\n"),
        semicolons.replace("0,75", "\"0,75\"") + ";;\n\n",
    ] {
        let (rows, warnings) = rows_of_file(text.as_bytes()).unwrap();
        assert_eq!((&rows, &warnings[..]), (&expected, &[][..]), "{text:?}");
    }
}

#[test]
fn rows_that_are_ambiguous_or_in_another_unit_are_refused_by_their_cause() {
    let header = "time_s,normal_n,lateral_n\n";
    for (text, words) in [
        (
            format!("{header}0,0,0\n0,1,0,625,0,5\n"),
            "line 3: 6 cells where the header has 3",
        ),
        (
            format!("{header}s,mN,mN\n0,625,-500\n"),
            "\"mN\" for the column `normal_n`",
        ),
        (
            "time_s;normal_mn;lateral_mn\n0;625;-500\n".to_owned(),
            "`normal_mn`",
        ),
        (
            "time_s,time_s,normal_n,lateral_n\n".to_owned(),
            "`time_s` is there twice",
        ),
        (String::new(), "it is empty"),
    ] {
        let error = rows_of_file(text.as_bytes()).unwrap_err();
        assert!(
            error.contains(FORCE_FILE) && error.contains(words),
            "{error}"
        );
    }
    let utf16: Vec<u8> = header.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = rows_of_file(&utf16).unwrap_err();
    assert!(error.contains("UTF-16"), "{error}");
    // A row with the other decimal sign is not read.
    let (rows, warnings) =
        rows_of_file(b"time_s;normal_n;lateral_n\n0,0;0,5;0,5\n0.1;0,5;0,5\n").unwrap();
    assert_eq!(rows.len(), 1);
    assert!(matches!(
        warnings[..],
        [Warning::UnreadableRows {
            rows: 1,
            first_line: 3,
            ..
        }]
    ));
}

#[test]
fn an_interval_beyond_the_end_is_warned_about() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut writer = RecordingWriter::create(&folder, manifest(), FORMAT_2).unwrap();
    let interval = |start_s, end_s| RecordedInterval {
        kind: RecordedIntervalKind::Unloaded,
        start_s,
        end_s,
    };
    assert!(writer.add_interval(interval(2.0, 1.0)).is_err());
    writer.add_interval(interval(0.0, 1.0)).unwrap();
    write_data(&mut writer);
    writer.finish(Ending::Completed).unwrap();
    let reader = RecordingReader::open(&folder).unwrap();
    assert!(
        matches!(
            reader.warnings(),
            [Warning::IntervalBeyondEnd { index: 0, .. }]
        ),
        "{:?}",
        reader.warnings()
    );
}
