//! Sessions as files of every format: equal results, and the intervals that rules find. `./dev campaign import` takes many sessions.

use std::path::{Path, PathBuf};

use bench_tests::campaign;
use bench_tests::session::{SessionFolder, VirtualParticipant, text};
use bench_tests::truth::{Course, recording_began_s};
use rayon::prelude::*;
use recording::Manifest;
use recording::manifest::RecordedIntervalKind;
use recording::reader::read_manifest;

use super::envelopes::{self, LockIns};
use super::results::{EstimateDifferences, RecordingResults};
use super::written::{import, results as results_of, write};

/// Number of sessions in every test run; `FRICTION_BENCH_IMPORTS` asks for more, in every format.
const SESSIONS: usize = 1;
/// Formats in every test run.
const FEW: [&str; 3] = ["v7.3", "TDMS", "NPZ"];
/// Formats with doubles, or with the integers of the converter.
const EXACT: [&str; 12] = [
    "v5",
    "v7",
    "v7.3",
    "TDMS",
    "HDF5",
    "NPY",
    "NPZ",
    "CSV with points",
    "CSV with commas",
    "Parquet",
    "FLAC",
    "RF64",
];
/// Greatest relative difference of any result.
const EQUAL: f64 = 1e-6;
/// Formats that round the values, each with the greatest relative difference of σ_t, Z_t and μ0: single precision has 24 bits
/// of forces and times, 4 µs at the end of a minute, and 16 bits of the converter's 24 are 1.5·10⁻⁵ of its full scale.
const ROUNDED: [(&str, f64); 2] = [("v7 of singles", 1e-3), ("FLAC of 16 bits", 1e-2)];
/// Least overlap of an interval with the true one: time in both over time in either.
const OVERLAP: f64 = 0.98;

/// Results of the sessions.
struct Tally {
    instances: usize,
    difference: f64,
    rounded: [EstimateDifferences; ROUNDED.len()],
    overlap: f64,
    lock_ins: LockIns,
}

impl Tally {
    fn merge(mut self, other: Self) -> Self {
        for (all, new) in self.rounded.iter_mut().zip(other.rounded) {
            all.merge(new);
        }
        Self {
            instances: self.instances + other.instances,
            difference: self.difference.max(other.difference),
            rounded: self.rounded,
            overlap: self.overlap.min(other.overlap),
            lock_ins: self.lock_ins.merge(other.lock_ins),
        }
    }
}

/// A session on the simulated bench, its truth, and its last recording.
struct NativeSession {
    truth: PathBuf,
    recording: PathBuf,
}

impl NativeSession {
    fn run(seed: u64, folder: &Path) -> Self {
        let person = VirtualParticipant::run("population", seed, folder);
        assert!(person.output.status.success(), "{}", text(&person.output));
        let session = SessionFolder::read(&person.study, "sub-01").expect("a session");
        let recording = session.recordings().pop().expect("a recording");
        Self {
            truth: person.truth,
            recording,
        }
    }
}

fn session(seed: u64, folder: &Path, is_campaign: bool) -> Tally {
    let native = NativeSession::run(seed, folder);
    let results_file = folder.join(format!("results-{seed}.json"));
    let results = RecordingResults::new(&native.recording, &results_file, &[]);
    assert!(results.instances() > 0, "seed {seed}");
    let files = folder.join(format!("files-{seed}"));
    let exact: &[&str] = if is_campaign { &EXACT } else { &FEW };
    let rounded: &[(&str, f64)] = if is_campaign { &ROUNDED } else { &[] };
    let kinds: Vec<&str> = exact
        .iter()
        .copied()
        .chain(rounded.iter().map(|(format, _)| *format))
        .collect();
    write("write_formats.py", &native.recording, &files, &kinds);
    let imported = |format: &str| results_of(&files.join(format));
    let differences = exact.iter().map(|format| {
        let difference = results.difference(&imported(format));
        assert!(
            difference <= EQUAL,
            "seed {seed}, {format}: results differ by {difference:.1e}"
        );
        difference
    });
    let difference = differences.fold(0.0, f64::max);
    let mut rounded_differences = [EstimateDifferences::default(); ROUNDED.len()];
    for (all, (format, limit)) in rounded_differences.iter_mut().zip(rounded) {
        *all = results.estimate_differences(&imported(format));
        assert!(all.greatest() <= *limit, "seed {seed}, {format}: {all}");
    }
    let by_rules =
        read_manifest(&import(&files.join(exact[0]), "rules.toml")).expect("a recording");
    let overlap = least_overlap(&by_rules, &native);
    assert!(overlap >= OVERLAP, "seed {seed}: overlap {overlap:.4}");
    let lock_ins = envelopes::differences(&native.recording, &results, folder, seed, is_campaign);
    std::fs::remove_dir_all(&files).expect("the files can be removed");
    Tally {
        instances: results.instances(),
        difference,
        rounded: rounded_differences,
        overlap,
        lock_ins,
    }
}

/// Returns the least overlap of an interval found by a rule with the stretch of the truth in which the rule holds.
fn least_overlap(manifest: &Manifest, native: &NativeSession) -> f64 {
    let course = Course::read(&native.truth);
    let began_s = recording_began_s(&native.recording);
    let overlaps = manifest.intervals.iter().map(|interval| {
        let found_s = (interval.start_s + began_s, interval.end_s + began_s);
        let middle_s = 0.5 * (found_s.0 + found_s.1);
        let (from_s, to_s) = match interval.kind {
            RecordedIntervalKind::Unloaded => {
                course.stretch("normal_n", middle_s, |normal_n| normal_n < 0.05)
            }
            RecordedIntervalKind::Exploration(_) => {
                let is_fast = |velocity: f64| (0.04..=0.06).contains(&velocity.abs());
                course.stretch("velocity_m_per_s", middle_s, is_fast)
            }
        };
        let true_s = (from_s.max(began_s), to_s);
        let common_s = found_s.1.min(true_s.1) - found_s.0.max(true_s.0);
        common_s / (found_s.1.max(true_s.1) - found_s.0.min(true_s.0))
    });
    let kinds = |is_kind: fn(&RecordedIntervalKind) -> bool| {
        let intervals = manifest.intervals.iter();
        intervals.filter(|interval| is_kind(&interval.kind)).count()
    };
    assert!(kinds(|kind| *kind == RecordedIntervalKind::Unloaded) > 0);
    assert_eq!(kinds(|kind| *kind != RecordedIntervalKind::Unloaded), 1);
    overlaps.fold(1.0, f64::min)
}

#[test]
fn sessions_in_files_of_other_programs_have_equal_results() {
    let folder = tempfile::tempdir().expect("a folder");
    let sessions = campaign::repeats("FRICTION_BENCH_IMPORTS", SESSIONS);
    let is_campaign = campaign::results_path().is_some();
    let tally = (1..=sessions as u64)
        .into_par_iter()
        .map(|seed| session(seed, folder.path(), is_campaign))
        .reduce_with(Tally::merge)
        .expect("a session");
    let formats = if is_campaign { EXACT.len() } else { FEW.len() };
    let mut text = format!(
        "{} instances; {formats} formats of doubles or the converter's integers: results differ by at most {:.1e}",
        tally.instances, tally.difference
    );
    if is_campaign {
        for ((format, _), differences) in ROUNDED.iter().zip(tally.rounded) {
            text += &format!("; {format}: {differences}");
        }
    }
    text += &format!(
        "; intervals by rules overlap the true ones by at least {:.1} %",
        100.0 * tally.overlap
    );
    campaign::report("sessions as files of other programs", sessions, &text);
    campaign::report(
        "sessions as envelopes of lock-in amplifiers",
        sessions,
        &tally.lock_ins.to_string(),
    );
}
