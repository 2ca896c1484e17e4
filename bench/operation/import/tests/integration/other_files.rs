//! Files of other people, other days and other recordings in the place of those that are meant.

use std::fmt::Write as _;
use std::fs;

use import::{Outcome, Plan};

use crate::laboratory::{Laboratory, SIGNALS_MAP, split_wav};
use crate::{import_all, recorded, refusal, value};

/// Adds the files of a second participant, with other bytes.
fn add_participant(laboratory: &Laboratory) {
    let folder = laboratory.folder();
    let mut signals = fs::read(folder.join("rec_7.wav")).unwrap();
    *signals.last_mut().unwrap() ^= 1;
    fs::write(folder.join("rec_8.wav"), signals).unwrap();
    for stream in ["force", "position"] {
        let text = fs::read_to_string(folder.join(format!("{stream}_7.csv"))).unwrap();
        let (rows, _) = text.trim_end().rsplit_once('\n').unwrap();
        fs::write(folder.join(format!("{stream}_8.csv")), rows).unwrap();
    }
}

#[test]
fn one_file_for_two_participants_is_refused_by_name() {
    let laboratory = Laboratory::with_reference();
    add_participant(&laboratory);
    let reports = import_all(&laboratory, SIGNALS_MAP);
    assert!(
        reports.iter().all(|report| report.outcome.is_ok()),
        "{reports:?}"
    );
    let map = SIGNALS_MAP.replace("force_{participant}.csv", "force_7.csv");
    let reports = import_all(&laboratory, &map);
    assert_eq!(reports.len(), 2);
    for report in reports {
        let refusal = report.outcome.unwrap_err().to_string();
        assert!(
            refusal.contains("force_7.csv is read for sub-"),
            "{refusal}"
        );
    }
}

#[test]
fn files_of_one_trial_and_names_in_another_case_are_remarked_on() {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    for name in ["rec_7_t1.wav", "tue_rec_7_t1.wav", "REC_8_T1.WAV"] {
        fs::copy(folder.join("rec_7.wav"), folder.join(name)).unwrap();
    }
    let notes = |files: &str| {
        let map = SIGNALS_MAP.replace(
            r"files = 'rec_(?<participant>\d+)\.wav'",
            &format!("files = '{files}'"),
        );
        assert_ne!(map, SIGNALS_MAP);
        let plan = Plan::read(&laboratory.write_map(&map)).unwrap();
        plan.notes().join("\n")
    };
    let found = notes(r"(?:tue_)?rec_(?<participant>\d)_t(?<trial>\d)\.wav");
    for words in [
        "rec_7_t1.wav and tue_rec_7_t1.wav are one trial by their names, and become its attempts 1 and 2",
        "REC_8_T1.WAV is left out: `files` matches it in small letters only",
    ] {
        assert!(found.contains(words), "{found}");
    }
    let captured = notes(r"(?i)(?<condition>tue_)?rec_(?<participant>\d)_t(?<trial>\d)\.wav");
    assert!(captured.contains("are one trial"), "{captured}");
    let found = notes(r"(?i)rec_(?<participant>\d)_t(?<trial>\d)\.wav");
    assert!(
        !found.contains("one trial") && !found.contains("left out"),
        "{found}"
    );
}

#[test]
fn another_session_under_the_same_names_replaces_nothing() {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    assert!(import_all(&laboratory, SIGNALS_MAP)[0].outcome.is_ok());
    add_participant(&laboratory);
    for (from, to) in [
        ("rec_8.wav", "rec_7.wav"),
        ("force_8.csv", "force_7.csv"),
        ("position_8.csv", "position_7.csv"),
    ] {
        fs::rename(folder.join(from), folder.join(to)).unwrap();
    }
    // The same map takes its files anew; another one has other files of the same names.
    let other = format!("# Tuesday\n{}", SIGNALS_MAP.trim_start());
    let text = refusal(&laboratory, &other);
    assert!(text.contains("did not come from this map"), "{text}");
    let reports = import_all(&laboratory, SIGNALS_MAP);
    assert!(
        matches!(reports[0].outcome, Ok(Outcome::Replaced)),
        "{reports:?}"
    );
    let reports = import_all(&laboratory, &other);
    assert!(
        matches!(reports[0].outcome, Ok(Outcome::Replaced)),
        "{reports:?}"
    );
}

#[test]
fn a_plate_alone_at_another_carrier_is_refused() {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    let bytes = fs::read(folder.join("rec_7.wav")).unwrap();
    let rate_hz = u32::from_le_bytes(bytes[24..28].try_into().unwrap());
    let is_float = u16::from_le_bytes(bytes[20..22].try_into().unwrap()) == 3;
    let data = bytes.windows(4).position(|tag| tag == b"data").unwrap() + 8;
    let map = SIGNALS_MAP.replace("[intervals]", "[baseline]\nfile = 'plate.wav'\n[intervals]");
    for (carrier_hz, is_refused) in [(35_020.0, true), (35_000.0, false)] {
        let mut plate = bytes[..data].to_vec();
        for frame in 0..(bytes.len() - data) / 8 {
            let angle = std::f64::consts::TAU * carrier_hz * frame as f64 / f64::from(rate_hz);
            for value in [0.5 * angle.cos(), 0.2 * (angle - 1.5).cos()] {
                let sample = match is_float {
                    true => (value as f32).to_le_bytes(),
                    false => ((value * f64::from(i32::MAX)) as i32).to_le_bytes(),
                };
                plate.extend(sample);
            }
        }
        fs::write(folder.join("plate.wav"), plate).unwrap();
        let reports = import_all(&laboratory, &map);
        let text = match &reports[0].outcome {
            Ok(_) => String::new(),
            Err(refusal) => refusal.to_string(),
        };
        let is_named = text.contains("has its carrier at 35020 Hz, and the recording at 35000 Hz");
        assert_eq!(is_named, is_refused, "{carrier_hz} Hz: {text}");
    }
}

#[test]
fn a_rate_that_lost_rows_pretend_is_not_taken() {
    let laboratory = Laboratory::with_reference();
    let path = laboratory.folder().join("force_7.csv");
    let text = fs::read_to_string(&path).unwrap();
    let kept = text
        .lines()
        .enumerate()
        .filter(|(row, _)| !(20_000..20_300).contains(row));
    let rows: Vec<&str> = kept.map(|(_, line)| line).collect();
    fs::write(&path, rows.join("\n")).unwrap();
    let map = SIGNALS_MAP.replace(
        "from = \"normal_n\"\ntime = \"time_s\"",
        "from = \"normal_n\"\nrate_hz = 10000.0\nppm = \"found\"\noffset_s = \"found\"",
    );
    assert_ne!(map, SIGNALS_MAP);
    let text = refusal(&laboratory, &map);
    assert!(
        text.contains("normal.ppm cannot be found") && text.contains("rows may be missing"),
        "{text}"
    );
}

/// Writes the samples as a table whose times begin at -0.4 s, as those of an oscilloscope with a pretrigger.
fn add_pretriggered_samples(laboratory: &Laboratory) {
    let folder = laboratory.folder();
    let wav = fs::read(folder.join("rec_7.wav")).unwrap();
    let data = wav.windows(4).position(|name| name == b"data").unwrap() + 8;
    let sample = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    let samples: Vec<f32> = wav[data..].chunks_exact(4).map(sample).collect();
    let mut text = "time_s,drive,pickup\n".to_owned();
    for (index, frame) in samples.chunks_exact(2).enumerate() {
        let time_s = index as f64 * 1e-5 - 0.4;
        writeln!(text, "{time_s:.5},{},{}", frame[0], frame[1]).unwrap();
    }
    fs::write(folder.join("scope_7.csv"), text).unwrap();
}

/// Regression test: the offset was printed as if the drive's times began at 0, and no map could state it.
#[test]
fn a_found_offset_can_be_stated() {
    let laboratory = Laboratory::with_reference();
    add_pretriggered_samples(&laboratory);
    let with_offset = |offset: &str| {
        let map = SIGNALS_MAP
            .replace(
                r"rec_(?<participant>\d+)\.wav",
                r"scope_(?<participant>\d+)\.csv",
            )
            .replace(
                "from = '[:,0]'\nrate_hz = \"file\"",
                "from = 'drive'\ntime = \"time_s\"",
            )
            .replace("'[:,1]'", "'pickup'")
            .replace(
                "tare = \"none\" # normal",
                &format!("tare = \"none\"\noffset_s = {offset}"),
            );
        map.replace(
            "metres_per_unit = 1.0",
            "metres_per_unit = 1.0\noffset_s = -0.4",
        )
    };
    let reports = import_all(&laboratory, &with_offset("\"found\""));
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let found = value(&recorded(&laboratory), "normal.offset_s");
    assert!((found.value + 0.4).abs() < 1.5e-3, "{found:?}");
    let reports = import_all(&laboratory, &with_offset(&found.value.to_string()));
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    // 3.4 s of the drive and as many of the forces do not overlap.
    let refusal = refusal(&laboratory, &with_offset("9.0"));
    assert!(
        refusal.contains("from 9.000 to") && refusal.contains("the drive from -0.400 to 3.000 s"),
        "{refusal}"
    );
    assert!(
        refusal.contains("(-0.400 if both began at once)"),
        "{refusal}"
    );
}

#[test]
fn forces_that_go_on_after_the_drive_are_remarked_on() {
    let laboratory = Laboratory::with_reference();
    let path = laboratory.folder().join("rec_7.wav");
    let whole = fs::read(&path).unwrap();
    let reports = import_all(&laboratory, SIGNALS_MAP);
    assert!(
        !reports[0].notes.join("\n").contains("go on for"),
        "{reports:?}"
    );
    // 3.4 s at 100 kHz, of which 0.8 s are lost.
    fs::write(&path, &split_wav(&whole, &[260_000])[0]).unwrap();
    let reports = import_all(&laboratory, SIGNALS_MAP);
    let notes = reports[0].notes.join("\n");
    assert!(
        notes.contains("the forces go on for 0.80 s after the last sample of the drive"),
        "{notes}"
    );
}
