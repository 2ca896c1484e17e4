//! Recordings of the reference, as another laboratory would have written them, through the import and back.
#![expect(clippy::unwrap_used, reason = "helpers of tests may fail a test")]

mod laboratory;
mod merged;
mod other_files;
mod parts;
mod waveforms;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;

use import::{FileReport, Outcome, Plan, Program, import, remove};
use laboratory::{Laboratory, SIGNALS_MAP};
use recording::manifest::{FoundValue, RecordedIntervalKind};
use recording::reader::read_manifest;
use recording::{Manifest, RecordingReader};

const PROGRAM: Program<'static> = Program { version: "0.1.0" };

/// Imports the laboratory's files by a map; returns the reports.
fn import_all(laboratory: &Laboratory, map: &str) -> Vec<FileReport> {
    let plan = Plan::read(&laboratory.write_map(map)).unwrap();
    let reports = Mutex::new(Vec::new());
    import(&plan, Some(&laboratory.study()), PROGRAM, |report| {
        reports.lock().unwrap().push(FileReport {
            file: report.file.clone(),
            recording: report.recording.clone(),
            outcome: match &report.outcome {
                Ok(Outcome::Written) => Ok(Outcome::Written),
                Ok(Outcome::Replaced) => Ok(Outcome::Replaced),
                Ok(Outcome::Unchanged) => Ok(Outcome::Unchanged),
                Ok(Outcome::Checked) => Ok(Outcome::Checked),
                Err(refusal) => Err(import::ImportRefusal::ReadBack(refusal.to_string())),
            },
            found: report.found.clone(),
            notes: report.notes.clone(),
        });
        ControlFlow::Continue(())
    })
    .unwrap();
    reports.into_inner().unwrap()
}

/// Returns the refusal of the only file of an import.
fn refusal(laboratory: &Laboratory, map: &str) -> String {
    let reports = import_all(laboratory, map);
    match &reports[0].outcome {
        Err(refusal) => refusal.to_string(),
        Ok(outcome) => panic!("{outcome:?} by {map}"),
    }
}

fn recorded(laboratory: &Laboratory) -> Manifest {
    read_manifest(&laboratory.recording()).unwrap()
}

fn samples(folder: &Path) -> (u32, Vec<f32>) {
    let mut reader = RecordingReader::open(folder).unwrap();
    let (mut all, mut block) = (Vec::new(), Vec::new());
    while reader.read_block(65_536, &mut block).unwrap() > 0 {
        all.extend_from_slice(&block);
    }
    (reader.format().sample_rate_hz, all)
}

fn value(manifest: &Manifest, name: &str) -> FoundValue {
    let found = &manifest
        .origin
        .as_ref()
        .unwrap()
        .imported
        .as_ref()
        .unwrap()
        .found;
    let value = found.iter().find(|value| value.name == name);
    value
        .unwrap_or_else(|| panic!("{name} is not among {found:?}"))
        .clone()
}

#[test]
fn a_recording_comes_back_as_it_was_and_is_taken_back() {
    let laboratory = Laboratory::with_reference();
    let reports = import_all(&laboratory, SIGNALS_MAP);
    assert!(
        matches!(reports[0].outcome, Ok(Outcome::Written)),
        "{reports:?}"
    );
    let (original, imported) = (laboratory.reference(), laboratory.recording());
    assert!(samples(&original) == samples(&imported), "other samples");
    let rows = |folder: &Path| -> Vec<[f64; 3]> {
        let reader = RecordingReader::open(folder).unwrap();
        let rows = reader.force().unwrap().map(|row| row.unwrap());
        rows.map(|row| [row.time_s, row.normal_n, row.lateral_n])
            .collect()
    };
    let (expected, found) = (rows(&original), rows(&imported));
    assert_eq!(expected.len(), found.len());
    for (expected, found) in expected.iter().zip(&found) {
        for (expected, found) in expected.iter().zip(found) {
            assert!((expected - found).abs() <= 1e-9 + 1.2e-7 * expected.abs());
        }
    }
    let (original, imported) = (read_manifest(&original).unwrap(), recorded(&laboratory));
    assert_eq!(original.signals(), imported.signals());
    assert_eq!(
        imported
            .origin
            .as_ref()
            .unwrap()
            .imported
            .as_ref()
            .unwrap()
            .sources
            .len(),
        3
    );
    let overlap = |kind: RecordedIntervalKind| {
        let span = |manifest: &Manifest| {
            let intervals = manifest
                .intervals
                .iter()
                .filter(|interval| interval.kind == kind);
            intervals
                .map(|interval| (interval.start_s, interval.end_s))
                .collect::<Vec<_>>()
        };
        let (expected, found) = (span(&original)[0], span(&imported));
        let common = found
            .iter()
            .map(|(from, to)| (to.min(expected.1) - from.max(expected.0)).max(0.0));
        common.sum::<f64>() / (expected.1 - expected.0)
    };
    assert!(overlap(RecordedIntervalKind::Unloaded) > 0.98);
    let forward = RecordedIntervalKind::Exploration(protocols::Direction::LeftToRight);
    assert!(overlap(forward) > 0.95, "{:?}", imported.intervals);
    let svg = fs::read_to_string(laboratory.recording().join("import.svg")).unwrap();
    assert!(
        svg.contains("Normal") || svg.contains("normal"),
        "the figure shows the forces"
    );
    let participants = fs::read_to_string(laboratory.study().join("participants.tsv")).unwrap();
    assert!(
        participants.contains("sub-7") && participants.contains("vegetarian"),
        "{participants}"
    );

    let again = import_all(&laboratory, SIGNALS_MAP);
    assert!(
        matches!(again[0].outcome, Ok(Outcome::Unchanged)),
        "{again:?}"
    );
    let changed = SIGNALS_MAP.replace("centre_m = 0.0525", "centre_m = 0.05");
    let replaced = import_all(&laboratory, &changed);
    assert!(
        matches!(replaced[0].outcome, Ok(Outcome::Replaced)),
        "{replaced:?}"
    );
    fs::write(laboratory.recording().join("note.txt"), "mine").unwrap();
    let removal = remove(&laboratory.map(), &laboratory.study()).unwrap();
    assert_eq!(removal.removed.len(), 1);
    assert!(removal.notes[0].contains("note.txt"), "{removal:?}");
    assert!(laboratory.recording().join("note.txt").exists());
    assert!(!laboratory.recording().join("signals.wav").exists());
}

#[test]
fn what_the_map_leaves_open_is_found() {
    let laboratory = Laboratory::with_reference();
    let map = SIGNALS_MAP
        .replace("[carrier]\nhz = 35000", "[carrier]\nhz = \"found\"")
        .replace(
            "hz = 6.0\nindex = 0.95",
            "hz = \"found\"\nindex = \"found\"",
        )
        .replace(
            "metres_per_unit = 2e-6",
            "metres_per_unit = \"from modal mass\"",
        )
        .replace("phase_rad = 0", "phase_rad = \"found\"");
    let reports = import_all(&laboratory, &map);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let manifest = recorded(&laboratory);
    for (name, expected, tolerance) in [
        ("carrier.hz", 35_000.0, 0.05),
        ("modulation.hz", 6.0, 0.01),
        ("modulation.index", 0.95, 0.02),
        ("pickup.metres_per_unit", 2e-6, 0.04e-6),
        ("pickup.phase_rad", 0.0, 0.01),
    ] {
        let found = value(&manifest, name);
        assert!((found.value - expected).abs() < tolerance, "{found:?}");
    }
}

#[test]
fn late_and_untared_forces_are_placed_and_tared() {
    let laboratory =
        Laboratory::with_forces(|t, normal, lateral| [t + 0.0123, normal + 0.4, lateral - 0.15]);
    let map = SIGNALS_MAP
        .replace(
            "tare = \"none\" # normal",
            "tare = \"no contact\"\noffset_s = \"found\"",
        )
        .replace("tare = \"none\" # lateral", "tare = \"no contact\"");
    let reports = import_all(&laboratory, &map);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let manifest = recorded(&laboratory);
    for (name, expected, tolerance) in [
        ("normal.tare", 0.4, 0.01),
        ("lateral.tare", -0.15, 0.01),
        ("normal.offset_s", -0.0123, 1e-3),
    ] {
        let found = value(&manifest, name);
        assert!((found.value - expected).abs() < tolerance, "{found:?}");
    }
}

/// Shifts the times of a table by some seconds, with the rows of the recorder's time from 0 on alone.
fn shift_times(path: &Path, decimal: &str, shift_s: f64) {
    let table = fs::read_to_string(path).unwrap();
    let mut lines = table.lines();
    let mut text = format!("{}\n", lines.next().unwrap());
    let separator = if decimal == "," { ';' } else { ',' };
    for line in lines {
        let (time, rest) = line.split_once(separator).unwrap();
        let time_s = time.replace(decimal, ".").parse::<f64>().unwrap() + shift_s;
        if (0.0..=3.4).contains(&time_s) {
            let time = format!("{time_s:.4}").replace('.', decimal);
            text += &format!("{time}{separator}{rest}\n");
        }
    }
    fs::write(path, text).unwrap();
}

#[test]
fn an_untared_and_a_cut_off_normal_force_are_named() {
    let untared = Laboratory::with_forces(|t, normal, lateral| [t, normal + 0.3, lateral]);
    let map = SIGNALS_MAP.replace("tare = \"none\" # lateral", "tare = \"no contact\"");
    let text = refusal(&untared, &map);
    assert!(
        text.contains("it is untared") && text.contains("normal.tare = \"no contact\""),
        "{text}"
    );
    let cut = Laboratory::with_forces(|t, normal, lateral| [t, normal.min(0.65), lateral]);
    let text = refusal(&cut, SIGNALS_MAP);
    assert!(text.contains("normal is 0.6500 N in"), "{text}");
    let cut = Laboratory::with_forces(|t, normal, lateral| [t, normal, lateral.clamp(-0.35, 0.35)]);
    let reports = import_all(&cut, SIGNALS_MAP);
    let is_named = |note: &String| note.contains("lateral_n is 0.35 N in");
    assert!(reports[0].notes.iter().any(is_named), "{reports:?}");
}

#[test]
fn forces_of_another_participant_under_a_wrong_name_are_refused() {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    let mut signals = fs::read(folder.join("rec_7.wav")).unwrap();
    // Another recording by its last sample.
    *signals.last_mut().unwrap() ^= 1;
    fs::write(folder.join("rec_8.wav"), signals).unwrap();
    for stream in ["force", "position"] {
        let name = |participant: u32| folder.join(format!("{stream}_{participant}.csv"));
        fs::copy(name(7), name(8)).unwrap();
    }
    let text = refusal(&laboratory, SIGNALS_MAP);
    assert!(text.contains(".csv has the same bytes as force_"), "{text}");
}

/// The waveform of a generator is one file for each trial, with the same bytes.
#[test]
fn a_drive_that_is_the_same_in_each_recording_is_no_copy() {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    let mut signals = fs::read(folder.join("rec_7.wav")).unwrap();
    for participant in [7, 8] {
        fs::write(folder.join(format!("drive_{participant}.wav")), &signals).unwrap();
    }
    *signals.last_mut().unwrap() ^= 1;
    fs::write(folder.join("rec_8.wav"), signals).unwrap();
    fs::copy(folder.join("position_7.csv"), folder.join("position_8.csv")).unwrap();
    let rows = fs::read_to_string(folder.join("force_7.csv")).unwrap();
    let (rows, _) = rows.trim_end().rsplit_once('\n').unwrap();
    fs::write(folder.join("force_8.csv"), rows).unwrap();
    let map = SIGNALS_MAP.replace(
        "[drive]\nfrom",
        "[drive]\nfile = 'drive_{participant}.wav'\nfrom",
    );
    let reports = import_all(&laboratory, &map);
    assert!(
        reports.len() == 2 && reports.iter().all(|report| report.outcome.is_ok()),
        "{reports:?}"
    );
}

#[test]
fn a_clock_that_is_set_back_is_named_at_its_first_sample() {
    let laboratory = Laboratory::with_reference();
    let path = laboratory.folder().join("force_7.csv");
    let table = fs::read_to_string(&path).unwrap();
    let (mut text, mut first) = (String::new(), None);
    for (line, row) in (0..).zip(table.lines()) {
        let (time, rest) = row.split_once(';').unwrap();
        match time.replace(',', ".").parse::<f64>() {
            Ok(time_s) if time_s > 2.5 => {
                // Samples are counted from 0, below the header.
                first.get_or_insert(line - 1);
                text += &format!("{};{rest}\n", (time_s - 60.0).to_string().replace('.', ","));
            }
            _ => text += &format!("{row}\n"),
        }
    }
    fs::write(&path, text).unwrap();
    let expected = format!("normal.time: the time of sample {} is not", first.unwrap());
    let text = refusal(&laboratory, SIGNALS_MAP);
    assert!(text.contains(&expected), "{expected}: {text}");
}

#[test]
fn times_in_another_unit_than_seconds_want_the_key() {
    let laboratory = Laboratory::with_reference();
    let path = laboratory.folder().join("force_7.csv");
    let table = fs::read_to_string(&path).unwrap();
    let units = table.replacen('\n', "\nms;N;N\n", 1);
    fs::write(&path, units).unwrap();
    let text = refusal(&laboratory, SIGNALS_MAP);
    assert!(
        text.contains("write normal.seconds_per_unit = 0.001"),
        "{text}"
    );
}

#[test]
fn a_position_of_another_rate_is_named() {
    let laboratory = Laboratory::with_reference();
    let map = SIGNALS_MAP.replace(
        "from = \"position_m\"\ntime = \"time_s\"",
        "from = \"position_m\"\nrate_hz = 900",
    );
    let rows = fs::read_to_string(laboratory.folder().join("position_7.csv")).unwrap();
    assert_eq!(rows.lines().count(), 3_400, "1 kHz for 3.4 s");
    let reports = import_all(&laboratory, &map);
    let is_named = |note: &String| note.contains("position.rate_hz is 1000 Hz");
    assert!(reports[0].notes.iter().any(is_named), "{reports:?}");
}

/// Friction repeats with the modulation of 6 Hz: contact tells shifts by whole periods.
#[test]
fn forces_whole_periods_away_are_placed_by_contact() {
    for shift_s in [-0.5, -1.0 / 3.0, 1.0 / 3.0, 0.5] {
        let laboratory = Laboratory::with_reference();
        for (file, decimal) in [("force_7.csv", ","), ("position_7.csv", ".")] {
            shift_times(&laboratory.folder().join(file), decimal, shift_s);
        }
        let map = SIGNALS_MAP
            .replace(
                "tare = \"none\" # normal",
                "tare = \"no contact\"\noffset_s = \"found\"",
            )
            .replace("phase_rad = 0", "phase_rad = \"found\"");
        let reports = import_all(&laboratory, &map);
        assert!(reports[0].outcome.is_ok(), "{shift_s}: {reports:?}");
        let manifest = recorded(&laboratory);
        let offset = value(&manifest, "normal.offset_s");
        assert!(
            (offset.value + shift_s).abs() < 2e-3,
            "{shift_s}: {offset:?}"
        );
        let phase = value(&manifest, "pickup.phase_rad");
        assert!(phase.value.abs() < 0.01, "{shift_s}: {phase:?}");
    }
}

#[test]
fn mistakes_that_show_are_refused_by_name() {
    let laboratory = Laboratory::with_reference();
    for (from, to, named) in [
        (
            "hz = 35000",
            "hz = 34000",
            "carrier.hz = 34000 Hz is not the carrier",
        ),
        ("hz = 6.0", "hz = 5.0", "the drive is modulated at 6.0"),
        (
            "rate_hz = \"file\"",
            "rate_hz = 96e3",
            "correct it, or write \"file\"",
        ),
        ("'[:,0]'", "'[:,9]'", "the index 9 is beyond its end"),
        (
            "from = \"normal_n\"",
            "from = \"normal\"",
            "no array `normal`",
        ),
        (
            "file = 'force_{participant}.csv'",
            "file = 'forces_{participant}.csv'",
            "forces_7.csv",
        ),
    ] {
        assert!(SIGNALS_MAP.contains(from), "{from}");
        let text = refusal(&laboratory, &SIGNALS_MAP.replace(from, to));
        assert!(text.contains(named), "{to}: {text}");
    }
    let exchanged = SIGNALS_MAP
        .replace("'[:,0]'", "'[:,9]'")
        .replace("'[:,1]'", "'[:,0]'")
        .replace("'[:,9]'", "'[:,1]'");
    let text = refusal(&laboratory, &exchanged);
    assert!(text.contains("drive and pickup are exchanged"), "{text}");
    assert!(
        !laboratory.recording().exists(),
        "a refused recording leaves nothing"
    );
    fs::copy(
        laboratory.folder().join("rec_7.wav"),
        laboratory.folder().join("rec_8.wav"),
    )
    .unwrap();
    fs::copy(
        laboratory.folder().join("force_7.csv"),
        laboratory.folder().join("force_8.csv"),
    )
    .unwrap();
    fs::copy(
        laboratory.folder().join("position_7.csv"),
        laboratory.folder().join("position_8.csv"),
    )
    .unwrap();
    let text = refusal(&laboratory, SIGNALS_MAP);
    assert!(text.contains("same bytes"), "{text}");
}

/// Each is found only by values that the map leaves open, which would be named as if nothing showed them.
#[test]
fn mistakes_behind_a_value_that_is_not_found_are_named() {
    let laboratory = Laboratory::with_reference();
    let found = SIGNALS_MAP.replace("phase_rad = 0", "phase_rad = \"found\"");
    // A displacement read as a velocity.
    let velocity = found.replace("\"displacement\"", "\"velocity\"");
    let text = refusal(&laboratory, &velocity);
    assert!(
        text.contains("pickup.phase_rad") && text.contains("pickup.quantity"),
        "{text}"
    );
    let untared = SIGNALS_MAP.replace("tare = \"none\" # normal", "tare = \"no contact\"");
    let newtons = untared.replacen("newtons_per_unit = 1.0", "newtons_per_unit = 1e3", 1);
    let text = refusal(&laboratory, &newtons);
    assert!(
        text.contains("normal.tare") && text.contains("newtons_per_unit of [normal]"),
        "{text}"
    );
}

#[test]
fn stated_times_that_contact_and_friction_deny_are_refused() {
    let laboratory = Laboratory::with_reference();
    let map = |key: &str| {
        SIGNALS_MAP.replace(
            "tare = \"none\" # normal",
            &format!("tare = \"none\"\n{key}"),
        )
    };
    for (key, named) in [
        ("offset_s = 0.05", " ms late"),
        ("offset_s = -0.05", " ms early"),
    ] {
        let text = refusal(&laboratory, &map(key));
        for named in [named, "against drive and pickup", "offset_s = \"found\""] {
            assert!(text.contains(named), "{key}: {text}");
        }
    }
    let reports = import_all(&laboratory, &map("offset_s = 0.0"));
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    assert!(
        !reports[0]
            .notes
            .iter()
            .any(|note| note.contains("in the map")),
        "{reports:?}"
    );
}

/// One file has several recordings: a map for each states which it is.
#[test]
fn maps_of_one_file_state_their_places() {
    let laboratory = Laboratory::with_reference();
    let map = |place: &str| format!("place = {{ {place} }}\n{}", SIGNALS_MAP.trim_start());
    for trial in [2, 3] {
        let reports = import_all(
            &laboratory,
            &map(&format!("trial = {trial}, condition = \"soap\"")),
        );
        assert!(reports[0].outcome.is_ok(), "{reports:?}");
        let folder = format!("study/sub-7/ses-01/trial-00{trial}_attempt-1");
        let folder = laboratory.folder().join(folder);
        let manifest = RecordingReader::open(&folder).unwrap();
        let trial = manifest.manifest().trial.clone().unwrap();
        assert_eq!(trial.condition, "soap");
    }
}

#[test]
fn forces_alone_become_a_recording() {
    let laboratory = Laboratory::with_reference();
    let map = r#"
format = 1
files = 'force_(?<participant>\d)\.csv'
normal = { from = "normal_n", time = "time_s", newtons_per_unit = 1.0 }
lateral = { from = "lateral_n", newtons_per_unit = 1.0 }
position = { file = 'position_{participant}.csv', from = "position_m", time = "time_s", metres_per_unit = 1.0 }
contact = { body = "other" }
intervals = { exploration = "30 to 70 mm/s for 0.5 s" }
"#;
    let reports = import_all(&laboratory, map);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let manifest = recorded(&laboratory);
    assert!(manifest.plate().is_none());
    assert!(!manifest.intervals.is_empty());
    let notes = reports[0].notes.join("\n");
    assert!(
        !notes.contains("normal_n") && !notes.contains("rule"),
        "{notes}"
    );
    // In millimetres.
    let other = map.replace("metres_per_unit = 1.0", "metres_per_unit = 1e3");
    let notes = import_all(&laboratory, &other)[0].notes.join("\n");
    assert!(
        notes.contains("no exploration follows the rule")
            && notes.contains("000 mm/s: check its unit"),
        "{notes}"
    );
    // Upside down; `analyze` would name it later.
    let map = map.replace(
        "newtons_per_unit = 1.0 }\nlateral",
        "newtons_per_unit = -1.0 }\nlateral",
    );
    let reports = import_all(&laboratory, &map);
    let is_named = |note: &String| note.contains("multiply it by -1");
    assert!(reports[0].notes.iter().any(is_named), "{reports:?}");
}

#[test]
fn a_session_shares_the_rate_of_its_clock_and_the_plate_may_be_recorded_apart() {
    let laboratory = Laboratory::with_forces(|t, normal, lateral| [t * 1.0004, normal, lateral]);
    let folder = laboratory.folder();
    // A second trial, and the plate alone.
    for (name, copy) in [
        ("rec_7.wav", "rec_7b.wav"),
        ("rec_7.wav", "plate.wav"),
        ("force_7.csv", "force_7b.csv"),
        ("position_7.csv", "position_7b.csv"),
    ] {
        fs::copy(folder.join(name), folder.join(copy)).unwrap();
    }
    let map = SIGNALS_MAP
        .replace(r"(?<participant>\d+)", r"(?<participant>\d)(?<letter>b?)")
        .replace("{participant}", "{participant}{letter}")
        .replace("tare = \"none\" # normal", "ppm = \"found\"")
        .replace("[intervals]", "[baseline]\nfile = 'plate.wav'\n[intervals]");
    let reports = import_all(&laboratory, &map);
    assert!(
        reports.iter().all(|report| report.outcome.is_ok()),
        "{reports:?}"
    );
    assert_eq!(reports.len(), 2);
    let manifest = recorded(&laboratory);
    let rate = value(&manifest, "normal.ppm");
    let error = rate.error.unwrap();
    assert!(
        (rate.value + 400.0).abs() < 4.0 * error && error < 100.0,
        "{rate:?}"
    );
    assert!(rate.evidence.contains("session"), "{rate:?}");
    let reasons = &manifest
        .origin
        .as_ref()
        .unwrap()
        .imported
        .as_ref()
        .unwrap()
        .interval_reasons;
    assert!(
        reasons.iter().any(|why| why.contains("plate.wav")),
        "{reasons:?}"
    );
    let last = manifest.unloaded_s().last().copied().unwrap();
    let (rate_hz, all) = samples(&laboratory.recording());
    assert!((last.1 * f64::from(rate_hz) * 2.0) as usize <= all.len());
}

#[test]
fn forces_without_a_number_are_refused_by_name() {
    let laboratory = Laboratory::with_forces(|t, normal, _| [t, normal, f64::NAN]);
    let words = refusal(&laboratory, SIGNALS_MAP);
    let expected = "lateral (lateral_n in force_7.csv) is dead: all its values are NaN";
    assert!(words.contains(expected), "{words}");
}

#[test]
fn guesses_that_nobody_confirmed_are_counted_and_a_dry_run_states_its_space() {
    let laboratory = Laboratory::with_reference();
    let guessed = SIGNALS_MAP.replacen('\n', "  # CHECK: no file states it\n", 1);
    let plan = Plan::read(&laboratory.write_map(&guessed)).unwrap();
    let notes = plan.notes().join("\n");
    assert!(notes.contains("line 1 is marked # CHECK"), "{notes}");
    let twice = guessed.clone() + "# CHECK: the whole\n";
    let plan = Plan::read(&laboratory.write_map(&twice)).unwrap();
    let notes = plan.notes().join("\n");
    assert!(notes.contains("2 lines are marked # CHECK (1, "), "{notes}");

    let plan = Plan::read(&laboratory.write_map(SIGNALS_MAP)).unwrap();
    assert!(plan.notes().is_empty(), "{:?}", plan.notes());
    let space = plan.trial_space(true).unwrap();
    let reference = laboratory.reference().join("signals.wav");
    let bytes = fs::metadata(reference).unwrap().len();
    assert!(
        (bytes..6 * bytes).contains(&space.bytes),
        "{space}, {bytes}"
    );
    assert_eq!(plan.trial_space(false), None);
}
