//! List of the recordings of studies: one each, with its standing and size, for other programs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use envelope_files::EvenRows;
use recording::manifest::{End, Manifest, Streams};
use recording::reader::{RecordingReader, force_rows, read_manifest};
use recording::study::{EVENTS_FILE, TrialLabel};
use recording::{CsvRow, DiskError, ENVELOPES_FILE, MANIFEST_FILE, disk};
use serde::Serialize;

use crate::exclusions::{self, ExclusionsError};
use crate::identity::duplicates;
use crate::provenance::Provenance;
use crate::sessions::{self, Attempt, LoggedSession, Standing};

/// Levels of folders below a study: participants, sessions, trials.
const DEPTH: usize = 3;

/// Recording of a list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedRecording {
    /// Folder, below the one given.
    #[serde(serialize_with = "serialize_path")]
    pub path: PathBuf,
    /// Name of the study's folder; null outside a study.
    pub study: Option<String>,
    /// Participant.
    pub participant: Option<String>,
    /// Session of the participant, from 1.
    pub session: Option<u32>,
    /// Trial, among practice trials or among the others, from 1.
    pub trial: Option<u32>,
    /// Attempt at the trial, from 1.
    pub attempt: Option<u32>,
    /// Whether the trial is a practice trial.
    pub practice: Option<bool>,
    /// Name of the condition.
    pub condition: Option<String>,
    /// Standing in the study.
    pub standing: ListedStanding,
    /// Length, s; null if the recording cannot be read.
    pub seconds: Option<f64>,
    /// Bytes of its files.
    pub bytes: u64,
    /// Whether the bench was simulated, by the session's log.
    pub simulated: bool,
    /// Whether it names the calibration of its constants.
    pub calibrated: bool,
    /// Whether it is an archive: envelopes in place of the samples.
    pub archived: bool,
    /// Reason why it cannot be read, in words.
    pub fault: Option<String>,
}

fn serialize_path<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// Standing of a recording in its study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ListedStanding {
    /// Accepted, and not excluded.
    Accepted,
    /// Left out by the study's exclusions.
    Excluded,
    /// Rejected by the operator or the rules, or followed by another attempt that counts.
    Rejected,
    /// Interrupted, or without an end.
    BrokenOff,
    /// Complete, without a log that states more.
    Complete,
    /// Absent from the log of its session.
    NotInLog,
    /// The same recording as one in another folder, which counts.
    Copy,
    /// Its description cannot be read, and it may count.
    Unreadable,
}

impl ListedStanding {
    /// All standings.
    pub const ALL: [Self; 8] = [
        Self::Accepted,
        Self::Excluded,
        Self::Rejected,
        Self::BrokenOff,
        Self::Complete,
        Self::NotInLog,
        Self::Copy,
        Self::Unreadable,
    ];

    /// Returns the word for it in a list.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Excluded => "excluded",
            Self::Rejected => "rejected",
            Self::BrokenOff => "broken-off",
            Self::Complete => "complete",
            Self::NotInLog => "not-in-log",
            Self::Copy => "copy",
            Self::Unreadable => "unreadable",
        }
    }
}

/// Returns all recordings in the study, participant or session at `folder`, in order, including interrupted and repeated trials; the
/// folder itself if it is a recording.
///
/// # Errors
/// A folder cannot be listed.
pub fn recordings(folder: &Path) -> Result<Vec<PathBuf>, DiskError> {
    let mut recordings = Vec::new();
    if folder.join(MANIFEST_FILE).exists() {
        recordings.push(folder.to_owned());
    } else {
        descend(folder, DEPTH, &mut recordings)?;
    }
    Ok(recordings)
}

fn descend(folder: &Path, depth: usize, recordings: &mut Vec<PathBuf>) -> Result<(), DiskError> {
    use disk::OnPath;
    let mut folders = Vec::new();
    for entry in fs::read_dir(folder).with_path("list", folder)? {
        let entry = entry.with_path("list", folder)?;
        // A hidden folder is one that is being written.
        let is_hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        if !is_hidden && entry.path().is_dir() {
            folders.push(entry.path());
        }
    }
    folders.sort_unstable();
    for path in folders {
        if path.join(MANIFEST_FILE).exists() {
            recordings.push(path);
        } else if depth > 1 {
            descend(&path, depth - 1, recordings)?;
        }
    }
    Ok(())
}

/// Reason why recordings cannot be listed.
#[derive(Debug, thiserror::Error)]
pub enum ListError {
    /// A folder cannot be listed.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The exclusions of a study cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
    /// The folder has no recording.
    #[error(
        "{} is neither a recording (it has no {MANIFEST_FILE}) nor a study with recordings{cause}",
        path.display()
    )]
    Nothing {
        /// Folder given.
        path: PathBuf,
        /// Likely cause and remedy, after a semicolon; empty if none is known.
        cause: &'static str,
    },
}

/// Returns why a folder seems to have no recordings, as the end of a sentence: a zip made on Windows, unpacked by a program that
/// takes `sub-01\ses-01\recording.toml` for the name of one file. Empty if the names in the folder do not show it.
#[must_use]
pub fn empty_cause(folder: &Path) -> &'static str {
    let has_backslash = |path: &Path| {
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name());
        names.any(|name| name.as_encoded_bytes().contains(&b'\\'))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders = entries
        .map(|entry| entry.path())
        .filter(|path| path.is_dir());
    if has_backslash(folder) || folders.any(|path| has_backslash(&path)) {
        "; its files have names with backslashes, as a zip made on Windows leaves them where the program that unpacks it does not \
         make folders of them: unpack the zip again, with `unzip`"
    } else {
        ""
    }
}

/// Recordings in folders.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingList {
    /// Recordings, each once, in order.
    pub recordings: Vec<ListedRecording>,
    /// Lines on the logs that cannot be read or are of other recordings.
    pub unread_logs: Vec<String>,
}

/// Returns the recordings in `folders`.
///
/// # Errors
/// A folder has no recording or cannot be listed, or the exclusions of a study cannot be read.
pub fn list(folders: &[PathBuf]) -> Result<RecordingList, ListError> {
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut known = std::collections::HashSet::new();
    for folder in folders {
        let found = recordings(folder)?;
        if found.is_empty() {
            return Err(ListError::Nothing {
                path: folder.clone(),
                cause: empty_cause(folder),
            });
        }
        let is_new = |path: &PathBuf| known.insert(path.canonicalize().unwrap_or(path.clone()));
        paths.extend(found.into_iter().filter(is_new));
    }
    let selection = exclusions::select(paths.clone())?;
    let excluded = selection.excluded.iter();
    let excluded: std::collections::HashSet<&PathBuf> =
        excluded.flat_map(|excluded| &excluded.recordings).collect();
    let mut session: Option<(PathBuf, Option<LoggedSession>)> = None;
    let mut unread_logs = Vec::new();
    let listed = paths.iter().map(|path| {
        // The recordings of a session follow each other.
        let folder = path.canonicalize().ok();
        let folder = folder.as_deref().and_then(Path::parent).unwrap_or(path);
        if session.as_ref().is_none_or(|(known, _)| known != folder) {
            let log = sessions::read(folder);
            // A session that was made elsewhere has no log.
            if let Some(reason) = log
                .as_ref()
                .err()
                .filter(|_| folder.join(EVENTS_FILE).exists())
            {
                let log = path.with_file_name(EVENTS_FILE);
                unread_logs.push(format!(
                    "{}: no standing is from this log: {reason}",
                    log.display()
                ));
            }
            session = Some((folder.to_owned(), log.ok()));
        }
        let log = session.as_ref().and_then(|(_, log)| log.as_ref());
        listed(path, log, excluded.contains(path))
    });
    let mut listed: Vec<ListedRecording> = listed.collect();
    reject_earlier_attempts(&mut listed);
    let copies = duplicates(paths.iter().map(PathBuf::as_path));
    for copy in copies.iter().filter(|duplicate| duplicate.is_copy) {
        let mut recordings = listed.iter_mut();
        if let Some(recording) = recordings.find(|recording| recording.path == copy.path) {
            recording.standing = ListedStanding::Copy;
        }
    }
    Ok(RecordingList {
        recordings: listed,
        unread_logs,
    })
}

/// Rejects the attempts at a trial before the last one that counts, as an analysis takes only that.
fn reject_earlier_attempts(listed: &mut [ListedRecording]) {
    let key = |recording: &ListedRecording| {
        let session = recording.path.parent().map(Path::to_owned);
        Some((session, recording.practice?, recording.trial?))
    };
    let counts = |recording: &ListedRecording| {
        let standing = recording.standing;
        matches!(
            standing,
            ListedStanding::Accepted | ListedStanding::Complete
        )
    };
    let mut last = BTreeMap::new();
    for recording in listed.iter().filter(|recording| counts(recording)) {
        if let Some(key) = key(recording) {
            let attempt = last.entry(key).or_insert(recording.attempt);
            *attempt = recording.attempt.max(*attempt);
        }
    }
    for recording in listed.iter_mut().filter(|recording| counts(recording)) {
        let last = key(recording).and_then(|key| last.get(&key));
        if last.is_some_and(|last| *last != recording.attempt) {
            recording.standing = ListedStanding::Rejected;
        }
    }
}

fn listed(path: &Path, log: Option<&LoggedSession>, is_excluded: bool) -> ListedRecording {
    let study = exclusions::study_of(path);
    let name = study.as_deref().and_then(Path::file_name);
    let label = path.canonicalize().ok();
    let label = label.as_deref().and_then(Path::file_name);
    let label: Option<TrialLabel> = label.and_then(|name| name.to_str()?.parse().ok());
    let manifest = read_manifest(path);
    let mut recording = ListedRecording {
        path: path.to_owned(),
        study: name.map(|name| name.to_string_lossy().into_owned()),
        participant: None,
        session: None,
        trial: label.map(|label| label.number),
        attempt: label.map(|label| label.attempt),
        practice: label.map(|label| label.is_practice()),
        condition: None,
        standing: ListedStanding::Unreadable,
        seconds: None,
        bytes: bytes(path),
        simulated: false,
        calibrated: false,
        archived: false,
        fault: None,
    };
    let manifest = match manifest {
        Ok(manifest) => manifest,
        Err(error) => {
            recording.fault = Some(error.to_string());
            recording.standing = match is_excluded {
                true => ListedStanding::Excluded,
                false => unread_standing(log, label),
            };
            return recording;
        }
    };
    let provenance = Provenance::new(&manifest, log);
    recording.simulated = provenance.simulated;
    recording.calibrated = provenance.calibrated;
    recording.archived = manifest.archived().is_some();
    if let Some(participant) = &manifest.participant {
        recording.participant = Some(participant.id.clone());
        recording.session = Some(participant.session);
    }
    if let Some(trial) = &manifest.trial {
        recording.trial = Some(trial.number);
        recording.attempt = Some(trial.attempt);
        recording.practice = Some(trial.practice);
        recording.condition = Some(trial.condition.clone());
    }
    match seconds(path, &manifest) {
        Ok(seconds) => recording.seconds = Some(seconds),
        Err(fault) => recording.fault = Some(fault),
    }
    recording.standing = match is_excluded {
        true => ListedStanding::Excluded,
        false => standing(&manifest, log, label),
    };
    recording
}

fn standing(
    manifest: &Manifest,
    log: Option<&LoggedSession>,
    label: Option<TrialLabel>,
) -> ListedStanding {
    let is_complete = match &manifest.trial {
        Some(trial) => trial.end == Some(End::Completed),
        // Made elsewhere.
        None => true,
    };
    let Some((log, label)) = log.zip(label) else {
        return match is_complete {
            true => ListedStanding::Complete,
            false => ListedStanding::BrokenOff,
        };
    };
    let attempt = log.attempt(label);
    if attempt.is_some_and(Attempt::is_rejected_practice) {
        return ListedStanding::Rejected;
    }
    match attempt.map(Attempt::standing) {
        Some(Standing::Accepted) if is_complete => ListedStanding::Accepted,
        Some(Standing::Repeated | Standing::GivenUp) => ListedStanding::Rejected,
        Some(Standing::Accepted | Standing::Interrupted) => ListedStanding::BrokenOff,
        Some(Standing::Unknown) | None => ListedStanding::NotInLog,
    }
}

/// Returns the standing of a recording of which the description cannot be read: that of an attempt that cannot count, by the log.
fn unread_standing(log: Option<&LoggedSession>, label: Option<TrialLabel>) -> ListedStanding {
    let attempt = log.zip(label).and_then(|(log, label)| log.attempt(label));
    match attempt.map(Attempt::standing) {
        Some(Standing::Repeated | Standing::GivenUp) => ListedStanding::Rejected,
        Some(Standing::Interrupted) => ListedStanding::BrokenOff,
        Some(Standing::Accepted | Standing::Unknown) | None => ListedStanding::Unreadable,
    }
}

/// Returns the length of a recording, s, or the reason why it cannot be read.
fn seconds(path: &Path, manifest: &Manifest) -> Result<f64, String> {
    match (&manifest.streams, manifest.archived()) {
        (_, Some(archived)) => Ok(archived.duration_s),
        (Streams::Signals(_), None) => {
            let reader = RecordingReader::open(path).map_err(|error| error.to_string())?;
            Ok(reader.duration_s())
        }
        (Streams::Envelopes(_), None) => {
            let error = |error: envelope_files::EnvelopeError| error.to_string();
            let mut rows = EvenRows::open(&path.join(ENVELOPES_FILE)).map_err(error)?;
            let mut envelopes = Vec::new();
            while rows.read(&mut envelopes).map_err(error)? > 0 {
                envelopes.clear();
            }
            Ok(rows.end_s())
        }
        (Streams::Forces(_), None) => {
            let rows = force_rows(path, f64::INFINITY).map_err(|error| error.to_string())?;
            let times = rows.filter_map(Result::ok).map(|row| row.time_s());
            Ok(times.last().unwrap_or(0.0))
        }
    }
}

/// Returns the bytes of the files in a folder.
fn bytes(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter_map(|entry| entry.metadata().ok());
    files
        .filter(|metadata| metadata.is_file())
        .map(|metadata| metadata.len())
        .sum()
}

#[cfg(test)]
mod tests {
    use recording::manifest::MINIMAL;
    use recording::study::DESCRIPTION_FILE;

    use super::*;

    const FORCES: &str = "time_s,normal_n,lateral_n\n0,0,0\n2.5,0,0\n";

    /// Makes a recording of forces alone, with an end or without one.
    fn recording(session: &Path, trial: u32, attempt: u32, end: &str) -> PathBuf {
        let folder = session.join(format!("trial-{trial:03}_attempt-{attempt}"));
        fs::create_dir_all(&folder).unwrap();
        let text = format!(
            "format = 1\nparticipant = {{ id = \"sub-01\", session = 1 }}\ntrial = {{ number = {trial}, attempt = {attempt}, \
             practice = false, condition = \"glass\", protocol = \"p\", seed = 1{end} }}\n"
        );
        fs::write(folder.join(MANIFEST_FILE), text).unwrap();
        fs::write(folder.join("force.csv"), FORCES).unwrap();
        folder
    }

    #[test]
    fn each_recording_has_its_standing() {
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path().join("my study");
        let session = study.join("sub-01/ses-01");
        let completed = ", end = \"completed\"";
        recording(&session, 1, 1, completed);
        recording(&session, 1, 2, completed);
        recording(&session, 2, 1, "");
        let excluded = recording(&session, 3, 1, completed);
        let unreadable = recording(&session, 4, 1, completed);
        fs::write(unreadable.join(MANIFEST_FILE), "format = 7\n").unwrap();
        // A recording that lacks its samples.
        let faulty = recording(&session, 5, 1, completed);
        fs::write(faulty.join(MANIFEST_FILE), MINIMAL).unwrap();
        // Being written.
        recording(&study.join("sub-01/.ses-02.partial"), 1, 1, completed);
        fs::write(study.join(DESCRIPTION_FILE), "{}").unwrap();
        fs::write(
            study.join("exclusions.tsv"),
            "participant_id\tsession\ttrial\treason\tby\nsub-01\t1\t3\tasleep\tAnn\n",
        )
        .unwrap();

        let listed = list(&[study.clone(), excluded.clone()]).unwrap().recordings;
        let standings: Vec<&str> = listed
            .iter()
            .map(|recording| recording.standing.word())
            .collect();
        let expected = [
            "rejected",
            "complete",
            "broken-off",
            "excluded",
            "unreadable",
            "complete",
        ];
        assert_eq!(standings, expected);
        let first = &listed[0];
        assert_eq!(first.study.as_deref(), Some("my study"));
        assert_eq!(
            (first.trial, first.attempt, first.session),
            (Some(1), Some(1), Some(1))
        );
        assert_eq!((first.seconds, first.calibrated), (Some(2.5), false));
        assert!(first.bytes > FORCES.len() as u64);
        let faults: Vec<bool> = listed
            .iter()
            .map(|recording| recording.fault.is_some())
            .collect();
        assert_eq!(faults, [false, false, false, false, true, true]);
        // Its folder names the trial.
        assert_eq!((listed[4].trial, listed[4].attempt), (Some(4), Some(1)));

        fs::write(session.join(EVENTS_FILE), "no log\n{}\n").unwrap();
        let list_of_session = list(std::slice::from_ref(&session)).unwrap();
        assert_eq!(list_of_session.unread_logs.len(), 1);
        assert_eq!(list_of_session.recordings.len(), listed.len());

        let empty = folder.path().join("empty");
        fs::create_dir(&empty).unwrap();
        let refused = |folder: &Path| list(&[folder.to_owned()]).unwrap_err().to_string();
        assert!(refused(&empty).ends_with("nor a study with recordings"));
        #[cfg(unix)]
        {
            // A zip made on Windows, in a folder of its own.
            let inner = empty.join("study");
            fs::create_dir(&inner).unwrap();
            fs::write(inner.join("sub-01\\ses-01\\recording.toml"), "").unwrap();
            assert!(refused(&empty).contains("names with backslashes"));
            assert!(refused(&inner).ends_with("unpack the zip again, with `unzip`"));
        }
    }
}
