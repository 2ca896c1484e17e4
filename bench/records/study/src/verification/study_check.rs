//! Verification of a study's sessions and of its other files.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use crate::exclusions;
use crate::verification::defect::StudyDefect;
use crate::verification::findings::StudyFindings;
use recording::disk::entries;
use recording::study::{
    DESCRIPTION_FILE, EVENTS_FILE, EXCLUSIONS_FILE, ID_COLUMN, PARTICIPANTS_FILE, TrialLabel,
    parse_description,
};
use recording::{DiskError, MANIFEST_FILE, rights};
use text_tables::TabTable;

/// Levels of folders below a study: participants, sessions.
const DEPTH: usize = 2;

/// Why a folder cannot be verified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A folder cannot be listed.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The path is not a folder.
    #[error(
        "{} is not a folder{}",
        path.display(),
        nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
    )]
    NoFolder {
        /// Given path.
        path: PathBuf,
        /// Sibling folder with the most similar name.
        nearest: Option<String>,
    },
    /// The folder is a recording.
    #[error("{} is a recording; only its session's log has sums: name its session or study", path.display())]
    Recording {
        /// The folder.
        path: PathBuf,
    },
    /// The folder contains no session.
    #[error("{} is not a study, participant or session: it contains no {EVENTS_FILE}", path.display())]
    NoSession {
        /// The folder.
        path: PathBuf,
    },
}

/// Returns the sessions of the study, participant or session at `path`, in order.
///
/// # Errors
/// [`VerifyError`] names the folder, and the most similar one.
pub fn sessions(path: &Path) -> Result<Vec<PathBuf>, VerifyError> {
    if !path.is_dir() {
        return Err(VerifyError::NoFolder {
            path: path.to_owned(),
            nearest: nearest(path),
        });
    }
    if path.join(MANIFEST_FILE).exists() {
        return Err(VerifyError::Recording {
            path: path.to_owned(),
        });
    }
    let mut sessions = Vec::new();
    descend(path, DEPTH, &mut sessions)?;
    if sessions.is_empty() && !path.join(DESCRIPTION_FILE).exists() {
        return Err(VerifyError::NoSession {
            path: path.to_owned(),
        });
    }
    Ok(sessions)
}

fn descend(folder: &Path, depth: usize, sessions: &mut Vec<PathBuf>) -> Result<(), DiskError> {
    let names = entries(folder)?;
    let is_session = names.iter().any(|name| {
        name == EVENTS_FILE || name.parse::<TrialLabel>().is_ok() && folder.join(name).is_dir()
    });
    if is_session {
        sessions.push(folder.to_owned());
    } else if depth > 0 {
        for name in names {
            let path = folder.join(name);
            if path.is_dir() {
                descend(&path, depth - 1, sessions)?;
            }
        }
    }
    Ok(())
}

/// Returns the sibling of `path` with the most similar name.
fn nearest(path: &Path) -> Option<String> {
    let parent = path.parent()?;
    let folder = if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    };
    let mut folders = entries(folder).ok()?;
    folders.retain(|name| folder.join(name).is_dir());
    let name = strict_toml::nearest(path.file_name()?.to_str()?, &folders)?;
    Some(parent.join(name).display().to_string())
}

/// Returns the participants in the table at `path`.
///
/// # Errors
/// The words for the fault of the table.
fn participants(path: &Path) -> Result<Vec<String>, String> {
    let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES);
    let text = text.map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            "it is missing: put it back from a copy, or write a table with the column participant_id and a row for each participant".to_owned()
        }
        _ => bounded_files::cause(&error),
    })?;
    let table = TabTable::parse(text, ID_COLUMN).map_err(|fault| fault.to_string())?;
    if let Some(fault) = table.uneven_row() {
        return Err(fault.to_string());
    }
    let mut names = BTreeSet::new();
    if let Some(name) = table.columns().iter().find(|name| !names.insert(*name)) {
        return Err(format!(
            "its header has the column {name} twice: keep one of them"
        ));
    }
    let id_column = table.column(ID_COLUMN).unwrap_or_default();
    let ids = table
        .rows()
        .iter()
        .filter_map(|row| row.cells.get(id_column));
    Ok(ids.filter(|id| !id.is_empty()).cloned().collect())
}

/// Verifies the files of the study outside its sessions, if `folder` is a whole study.
///
/// # Errors
/// The folder cannot be listed.
pub fn verify_study_files(folder: &Path, findings: &mut StudyFindings) -> Result<(), DiskError> {
    let description = folder.join(DESCRIPTION_FILE);
    if !description.exists() {
        if folder.join(PARTICIPANTS_FILE).is_file() {
            let reason = "it is missing: put it back from a copy, or copy that of another study and correct its Name";
            let defect = StudyDefect::Unreadable {
                path: description,
                reason: reason.to_owned(),
            };
            findings.defects.push(defect);
        }
        return Ok(());
    }
    findings
        .notes
        .extend(rights::other_readers(folder, &description));
    let unreadable_defect =
        |path: PathBuf, reason: String| StudyDefect::Unreadable { path, reason };
    let description_result = bounded_files::read(&description, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| bounded_files::cause(&error))
        .and_then(|text| parse_description(&text));
    if let Err(reason) = description_result {
        findings
            .defects
            .push(unreadable_defect(description, reason));
    }
    for path in exclusions::unread(folder) {
        let reason = "nothing reads it; exclusions are the lines of exclusions.tsv: put its lines there, or move it away";
        // Beside the table it is a copy; without the table, the exclusions are lost.
        if folder.join(EXCLUSIONS_FILE).exists() {
            let path = path.display().to_string();
            let note = format!("{}: {reason}", escaping::escaped_line(&path));
            findings.notes.push(note);
        } else {
            findings
                .defects
                .push(unreadable_defect(path, reason.to_owned()));
        }
    }
    let table = folder.join(PARTICIPANTS_FILE);
    let participants = match participants(&table) {
        Ok(participants) => participants,
        Err(reason) => {
            findings.defects.push(unreadable_defect(table, reason));
            return Ok(());
        }
    };
    for participant in &participants {
        if !folder.join(participant).is_dir() {
            let nearest = same_number(folder, participant);
            let participant = participant.clone();
            findings.defects.push(StudyDefect::NoParticipant {
                participant,
                nearest,
            });
        }
    }
    let mut known = BTreeSet::new();
    let twice = participants.iter().filter(|id| !known.insert(*id));
    for id in twice.collect::<BTreeSet<_>>() {
        let reason = format!("lists {id} more than once: keep one row");
        findings
            .defects
            .push(unreadable_defect(table.clone(), reason));
    }
    for name in entries(folder)? {
        if folder.join(&name).is_dir() && !participants.contains(&name) {
            let count = recording_count(&folder.join(&name), DEPTH);
            let contents = match count {
                0 => String::new(),
                _ => format!("; `analyze` reads the {count} recordings in it, except copies"),
            };
            let name = escaping::escaped_line(&name);
            let note = format!("{name} is not in {PARTICIPANTS_FILE}{contents}");
            findings.notes.push(note);
        }
    }
    Ok(())
}

/// Returns the participant's folder that a row of digits means, such as sub-01 for the 1 that a spreadsheet made of 01.
fn same_number(folder: &Path, participant: &str) -> Option<String> {
    let number: u32 = participant.trim_start_matches("sub-").parse().ok()?;
    let mut names = entries(folder).ok()?.into_iter();
    names.find(|name| {
        let digits = name.strip_prefix("sub-").map(str::parse);
        digits == Some(Ok(number))
    })
}

/// Returns the number of recordings down to `depth` levels below a folder.
fn recording_count(folder: &Path, depth: usize) -> usize {
    let names = entries(folder).unwrap_or_default();
    let folders = names.iter().map(|name| folder.join(name));
    let count = |path: PathBuf| match depth {
        _ if path.join(MANIFEST_FILE).exists() => 1,
        0 => 0,
        _ => recording_count(&path, depth - 1),
    };
    folders.map(count).sum()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Returns the defects and notes of a study of two participants with this table of them.
    fn findings(table: &str, other_file: Option<&str>) -> StudyFindings {
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path();
        for id in ["sub-01", "sub-02"] {
            fs::create_dir(study.join(id)).unwrap();
        }
        let description = r#"{ "Name": "study", "DatasetType": "raw", "GeneratedBy": [] }"#;
        fs::write(study.join(DESCRIPTION_FILE), description).unwrap();
        fs::write(study.join(PARTICIPANTS_FILE), table).unwrap();
        if let Some(name) = other_file {
            fs::write(study.join(name), "").unwrap();
        }
        let mut findings = StudyFindings::default();
        verify_study_files(study, &mut findings).unwrap();
        findings
    }

    fn defects(table: &str, other_file: Option<&str>) -> Vec<String> {
        let defects = findings(table, other_file).defects;
        defects.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn rows_that_no_analysis_could_join_are_defects() {
        let sound = "participant_id\tage\nsub-01\t25\nsub-02\t31\n";
        assert_eq!(defects(sound, None), [""; 0]);
        for (table, named) in [
            (
                format!("{sound}sub-01\t26\n"),
                "lists sub-01 more than once",
            ),
            (sound.replace("sub-01", "1"), "did you mean `sub-01`?"),
            (
                sound
                    .replace("age", "age\tage")
                    .replace("25", "25\t26")
                    .replace("31", "31\t32"),
                "age twice",
            ),
        ] {
            let defects = defects(&table, None);
            assert!(
                defects.len() == 1 && defects[0].contains(named),
                "{defects:?}"
            );
        }
    }

    #[test]
    fn a_missing_table_of_participants_is_named_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let lost = participants(&folder.path().join(PARTICIPANTS_FILE)).unwrap_err();
        assert!(lost.starts_with("it is missing: put it back"), "{lost}");
    }

    #[test]
    fn exclusions_under_another_name_are_a_defect_and_a_copy_of_them_is_noted() {
        let table = "participant_id\nsub-01\nsub-02\n";
        let lost = defects(table, Some("exclusions.csv"));
        assert!(
            lost.len() == 1 && lost[0].contains("nothing reads it"),
            "{lost:?}"
        );
        assert_eq!(defects(table, Some("notes.txt")), [""; 0]);
    }
}
