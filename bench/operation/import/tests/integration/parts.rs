//! Recordings that are split over several files.

use std::fs;

use import::{Outcome, Plan};

use crate::laboratory::{Laboratory, SIGNALS_MAP, split_wav};
use crate::{import_all, recorded, refusal};

/// Splits samples and forces of the reference at the same sorts of places that a recorder does: at no whole second.
fn split_reference() -> Laboratory {
    let laboratory = Laboratory::with_reference();
    let folder = laboratory.folder();
    let whole = fs::read(folder.join("rec_7.wav")).unwrap();
    fs::remove_file(folder.join("rec_7.wav")).unwrap();
    for (part, bytes) in (1..).zip(split_wav(&whole, &[100_001, 100_104])) {
        fs::write(folder.join(format!("rec_7_part{part}.wav")), bytes).unwrap();
    }
    let table = fs::read_to_string(folder.join("force_7.csv")).unwrap();
    fs::remove_file(folder.join("force_7.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    let rows = &lines[1..];
    for (part, rows) in (1..).zip([&rows[..9], &rows[9..20_000], &rows[20_000..]]) {
        let text = format!("{}\n{}\n", lines[0], rows.join("\n"));
        fs::write(folder.join(format!("force_7_{part}.csv")), text).unwrap();
    }
    laboratory
}

fn split_map() -> String {
    SIGNALS_MAP
        .replace(
            r"rec_(?<participant>\d+)\.wav",
            r"rec_(?<participant>\d+)_part(?<part>\d+)\.wav",
        )
        .replace("force_{participant}.csv", "force_{participant}_{part}.csv")
}

#[test]
fn parts_of_a_recording_follow_each_other() {
    let (whole, split) = (Laboratory::with_reference(), split_reference());
    assert!(import_all(&whole, SIGNALS_MAP)[0].outcome.is_ok());
    let reports = import_all(&split, &split_map());
    assert!(
        matches!(&reports[..], [report] if report.outcome.is_ok()),
        "{reports:?}"
    );
    let files = |laboratory: &Laboratory| {
        ["signals.wav", "force.csv", "position.csv"]
            .map(|file| fs::read(laboratory.recording().join(file)).unwrap())
    };
    assert!(files(&whole) == files(&split), "other streams");
    let (whole, manifest) = (recorded(&whole), recorded(&split));
    assert_eq!(whole.intervals, manifest.intervals);
    let sources = manifest.origin.unwrap().imported.unwrap().sources;
    assert_eq!(sources.len(), 7, "{sources:?}");

    let again = import_all(&split, &split_map());
    assert!(matches!(again[0].outcome, Ok(Outcome::Unchanged)));
    let folder = split.folder();
    // A part that was copied later makes another recording.
    let last = fs::read(folder.join("rec_7_part1.wav")).unwrap();
    let next = split_wav(&last, &[50_000]).swap_remove(0);
    fs::write(folder.join("rec_7_part4.wav"), next).unwrap();
    let rows = fs::read_to_string(folder.join("force_7_3.csv")).unwrap();
    let (rows, _) = rows.trim_end().rsplit_once('\n').unwrap();
    fs::write(folder.join("force_7_4.csv"), rows).unwrap();
    let text = refusal(&split, &split_map());
    assert!(
        text.contains("the times of force_7_4.csv begin at"),
        "{text}"
    );
    let whole_force = split_map().replace("force_{participant}_{part}.csv", "force_7_2.csv");
    let reports = import_all(&split, &whole_force);
    assert!(
        matches!(reports[0].outcome, Ok(Outcome::Replaced)),
        "{reports:?}"
    );
}

#[test]
fn parts_that_cannot_follow_each_other_are_named() {
    let split = split_reference();
    let folder = split.folder();
    let path = |part: u32| folder.join(format!("rec_7_part{part}.wav"));
    let third = fs::read(path(3)).unwrap();
    fs::copy(path(1), path(3)).unwrap();
    let text = refusal(&split, &split_map());
    assert!(text.contains("has the same bytes as rec_7_part1"), "{text}");
    let mut slower = third.clone();
    slower[24..28].copy_from_slice(&96_000_u32.to_le_bytes());
    fs::write(path(3), slower).unwrap();
    let text = refusal(&split, &split_map());
    assert!(
        text.contains("drive.rate_hz") && text.contains("rec_7_part3.wav states 96000"),
        "{text}"
    );
    fs::write(path(3), third).unwrap();
    fs::remove_file(path(2)).unwrap();
    let text = refusal(&split, &split_map());
    assert!(
        text.contains("part 2 of the recording of `rec_7_part1.wav` and `rec_7_part3.wav`"),
        "{text}"
    );
    let marks = split_map().replace(
        "unloaded = \"normal < 0.05 N for 0.3 s\"\nexploration = \"30 to 70 mm/s for 0.5 s\"",
        "marks = 'marks_{part}.csv'",
    );
    let error = Plan::read(&split.write_map(&marks))
        .unwrap_err()
        .to_string();
    assert!(error.contains("leave {part} out"), "{error}");
}
