//! Archives of recordings, read as recordings.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use analysis::findings::RecordingFindings;
use analysis::{Settings, recording_analysis};
use archive::{ArchiveError, ArchiveOptions, ArchiveSummary, RecordingState};
use recording::lock::Lock;
use recording::manifest::{MINIMAL, Manifest};
use recording::study::{DESCRIPTION_FILE, LOCK_FILE};
use recording::{FORCE_FILE, MANIFEST_FILE, SIGNALS_FILE, reader};
use study::verification::Integrity;

/// Trial of the reference recording, within a session.
const TRIAL: &str = r#"
[participant]
id = "sub-01"
session = 1

[trial]
number = 1
attempt = 1
practice = false
condition = "6 Hz"
protocol = "own"
seed = 1
end = "completed"

[[events]]
kind = "force_over_range"
sample = 100000
frames = 1000
"#;

/// Creates a study with the reference recording as its only trial; returns the recording.
fn study(folder: &Path) -> PathBuf {
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a");
    let recording = folder.join("sub-01/ses-01/trial-001_attempt-1");
    fs::create_dir_all(&recording).unwrap();
    for entry in fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, recording.join(path.file_name().unwrap())).unwrap();
    }
    let text = fs::read_to_string(recording.join(MANIFEST_FILE)).unwrap();
    fs::write(recording.join(MANIFEST_FILE), text + TRIAL).unwrap();
    fs::write(
        folder.join(DESCRIPTION_FILE),
        "{\"Name\":\"s\",\"DatasetType\":\"raw\",\"GeneratedBy\":[]}",
    )
    .unwrap();
    fs::write(folder.join("participants.tsv"), "participant_id\nsub-01\n").unwrap();
    recording
}

/// State of each recording, by the name of its folder.
type States = BTreeMap<String, Result<RecordingState, String>>;

/// Archives folders; returns the summary and the state of each recording by its folder's name.
fn archive(sources: &[&Path], to: &Path) -> Result<(ArchiveSummary, States), ArchiveError> {
    let options = ArchiveOptions {
        sources: sources.iter().map(|path| (*path).to_owned()).collect(),
        to: to.to_owned(),
        shared: true,
    };
    let states = Mutex::new(BTreeMap::new());
    let summary = archive::archive(
        &options,
        "0.0.0",
        |_| {},
        |recording| {
            let name = recording.recording.file_name().unwrap();
            let state = recording.state.as_ref();
            let state = state
                .map(|(state, _)| state.clone())
                .map_err(ToString::to_string);
            states
                .lock()
                .unwrap()
                .insert(name.to_string_lossy().into_owned(), state);
        },
    )?;
    Ok((summary, states.into_inner().unwrap()))
}

fn findings(folder: &Path) -> RecordingFindings {
    let analysis = recording_analysis::analyse(folder, &Settings::default());
    analysis.findings.unwrap()
}

/// Bytes of every file in a folder and below it.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(contents(&path)),
            false => drop(all.insert(path.clone(), fs::read(path).unwrap())),
        }
    }
    all
}

/// The bounds that docs/RECORDING.md states.
#[test]
fn an_archive_is_a_study_with_the_same_estimates() {
    let folder = tempfile::tempdir().unwrap();
    let (study, to) = (folder.path().join("study"), folder.path().join("archive"));
    let recording = self::study(&study);
    let before = contents(&study);
    let (summary, states) = archive(&[&study], &to).unwrap();
    let archived = to.join("sub-01/ses-01/trial-001_attempt-1");
    assert_eq!(states["trial-001_attempt-1"], Ok(RecordingState::Archived));
    assert_eq!((summary.archived, summary.failed), (1, 0));
    assert!(
        summary.archive_bytes * 12 < summary.original_bytes,
        "{summary:?}"
    );
    assert_eq!(contents(&study), before, "the original is as it was");
    assert!(!archived.join(SIGNALS_FILE).exists() && !archived.join(FORCE_FILE).exists());

    let [original, copy] = [&recording, &archived].map(|folder| findings(folder));
    assert_eq!(copy.instances.len(), original.instances.len());
    let is_near = |name: &str, value: f64, expected: f64, bound: f64| {
        let difference = (value / expected - 1.0).abs();
        assert!(
            difference < bound,
            "{name}: {value}, not {expected}: {difference:.6}"
        );
    };
    for (copy, original) in copy.instances.iter().zip(&original.instances) {
        let [copy, original] = [copy, original].map(|instance| instance.trial.as_ref().unwrap());
        is_near("sigma_t", copy.sigma_t_m(), original.sigma_t_m(), 1e-3);
        let z_t = (copy.z_t_n_s_per_m - original.z_t_n_s_per_m).norm();
        is_near(
            "Z_t",
            original.z_t_n_s_per_m.norm() + z_t,
            original.z_t_n_s_per_m.norm(),
            1e-3,
        );
        is_near("mu", copy.mu0, original.mu0, 1e-3);
        // Regression test: 11 % smaller, because frames lay between those of the samples.
        is_near(
            "its error",
            copy.sigma_t_std_m(),
            original.sigma_t_std_m(),
            0.03,
        );
    }
    let [copy_fit, original_fit] =
        [&copy, &original].map(|findings| findings.trial.as_ref().unwrap());
    is_near(
        "S",
        copy_fit.contact_area_m2.value,
        original_fit.contact_area_m2.value,
        1e-3,
    );
    is_near(
        "error of S",
        copy_fit.contact_area_m2.ln_std,
        original_fit.contact_area_m2.ln_std,
        0.03,
    );
    // Events count in samples, which the archive lacks.
    let saturated = |findings: &RecordingFindings| {
        findings
            .manifest
            .saturated_s(findings.manifest.event_rate_hz(100e3))
    };
    assert_eq!(saturated(&copy), saturated(&original));
    assert_eq!(
        copy.flaws
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>(),
        original
            .flaws
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    );
}

#[test]
fn a_second_run_keeps_the_archive_and_an_interrupted_one_is_completed() {
    let folder = tempfile::tempdir().unwrap();
    let (study, to) = (folder.path().join("study"), folder.path().join("archive"));
    let recording = self::study(&study);
    archive(&[&study], &to).unwrap();
    let first = contents(&to);
    let (_, states) = archive(&[&study], &to).unwrap();
    assert_eq!(states["trial-001_attempt-1"], Ok(RecordingState::Kept));
    assert_eq!(contents(&to), first);

    // Ended within a recording.
    let session = to.join("sub-01/ses-01");
    fs::rename(
        session.join("trial-001_attempt-1"),
        session.join(".trial-001_attempt-1.partial"),
    )
    .unwrap();
    fs::remove_file(
        session
            .join(".trial-001_attempt-1.partial")
            .join(MANIFEST_FILE),
    )
    .unwrap();
    let (_, states) = archive(&[&study], &to).unwrap();
    assert_eq!(states["trial-001_attempt-1"], Ok(RecordingState::Archived));
    assert_eq!(contents(&to), first, "the same bytes");

    // Another recording of this name.
    fs::write(
        recording.join(FORCE_FILE),
        "time_s,normal_n,lateral_n\n0,0,0\n",
    )
    .unwrap();
    let (summary, states) = archive(&[&study], &to).unwrap();
    let error = states["trial-001_attempt-1"].clone().unwrap_err();
    assert!(error.contains("force.csv changed"), "{error}");
    assert_eq!(summary.failed, 1);
    assert_eq!(contents(&to), first);
}

#[test]
fn verification_finds_a_changed_archive() {
    let folder = tempfile::tempdir().unwrap();
    let (study, to) = (folder.path().join("study"), folder.path().join("archive"));
    self::study(&study);
    archive(&[&study], &to).unwrap();
    let session = to.join("sub-01/ses-01");
    let check = || {
        let mut findings = study::verification::session(&session, || {}).unwrap();
        findings.trials.remove(0)
    };
    let trial = check();
    assert_eq!(trial.integrity, Integrity::NoSum, "{:?}", trial.defects);
    let path = session.join("trial-001_attempt-1/force.csv.gz");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let trial = check();
    assert_eq!(trial.integrity, Integrity::Damaged);
    let words: Vec<String> = trial.defects.iter().map(ToString::to_string).collect();
    assert!(
        words
            .iter()
            .any(|words| words.contains("force.csv.gz has changed since it was archived")),
        "{words:?}"
    );
    fs::remove_file(&path).unwrap();
    assert_eq!(check().integrity, Integrity::Damaged);
}

#[test]
fn recordings_without_samples_are_copied() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("forces");
    fs::create_dir(&recording).unwrap();
    fs::write(recording.join(MANIFEST_FILE), "format = 1\n").unwrap();
    fs::write(
        recording.join(FORCE_FILE),
        "time_s,normal_n,lateral_n\n0,0,0\n0.001,0,0\n",
    )
    .unwrap();
    let unreadable = folder.path().join("unreadable");
    fs::create_dir(&unreadable).unwrap();
    fs::write(unreadable.join(MANIFEST_FILE), MINIMAL).unwrap();
    let to = folder.path().join("to");
    let (summary, states) = archive(&[&recording, &unreadable], &to).unwrap();
    assert!(matches!(
        states["forces"],
        Ok(RecordingState::Copied { .. })
    ));
    assert!(states["unreadable"].is_err());
    assert_eq!((summary.archived, summary.failed), (1, 1));
    let equal = contents(&recording)
        .into_values()
        .eq(contents(&to.join("forces")).into_values());
    assert!(equal && !to.join("unreadable").exists());
    let manifest: Manifest = reader::read_manifest(&to.join("forces")).unwrap();
    assert_eq!(manifest.archived(), None);
}

#[test]
fn a_study_in_which_a_session_runs_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (study, to) = (folder.path().join("study"), folder.path().join("archive"));
    self::study(&study);
    let running = Lock::try_take(&study.join(LOCK_FILE)).unwrap();
    let error = archive(&[&study], &to).unwrap_err();
    assert!(matches!(error, ArchiveError::InUse(_)), "{error}");
    assert!(!to.exists());
    drop(running);
    assert_eq!(archive(&[&study], &to).unwrap().0.archived, 1);
}

#[test]
fn a_folder_with_other_files_and_the_study_itself_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let recording = self::study(&study);
    for target in [
        &study,
        &study.join("archive"),
        &recording.join("new/archive"),
    ] {
        let error = archive(&[&study], target).unwrap_err();
        assert!(matches!(error, ArchiveError::InsideStudy { .. }), "{error}");
    }
    let occupied = folder.path().join("occupied");
    fs::create_dir(&occupied).unwrap();
    fs::write(occupied.join("notes.txt"), "x").unwrap();
    let error = archive(&[&study], &occupied).unwrap_err();
    assert!(error.to_string().contains("notes.txt"), "{error}");

    let other = folder.path().join("other");
    self::study(&other);
    let to = folder.path().join("to");
    let error = archive(&[&study, &other], &to).unwrap_err();
    assert!(matches!(error, ArchiveError::TwoStudies { .. }), "{error}");
    assert!(!to.exists());
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let error = archive(&[&empty], &to).unwrap_err();
    assert!(matches!(error, ArchiveError::Nothing { .. }), "{error}");
}
