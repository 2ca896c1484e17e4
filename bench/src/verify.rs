//! `verify`: whether a study is complete and unchanged since it was recorded.

use std::io::Write;
use std::path::Path;

use config::{CalibrationFile, CalibrationFileError};
use recording::study::DESCRIPTION_FILE;
use study::verification::{SessionDefect, StudyDefect, StudyFindings};

use crate::cli::Verify;
use crate::outcome::{progress_bar, require_writable, write_text};
use crate::verbosity::Verbosity;
use study::result_files::ResultFile;

/// The session's copy of the calibration.
const CALIBRATION_COPY: &str = "calibration.toml";

/// Runs the command. Returns true if no file is damaged or missing.
///
/// # Errors
/// There is nothing to verify, a folder cannot be listed, or the findings cannot be written.
pub fn run(options: &Verify, verbosity: Verbosity) -> anyhow::Result<bool> {
    if let Some(path) = &options.json {
        require_writable(path, ResultFile::Json)?;
    }
    let findings = findings(&options.study, verbosity)?;
    match &options.json {
        Some(path) => write_text(path, &study::verification::to_json(&findings)?)?,
        None => write!(
            standard_streams::stdout(),
            "{}",
            study::verification::to_text(&findings)
        )?,
    }
    Ok(findings.is_whole())
}

fn findings(study: &Path, verbosity: Verbosity) -> anyhow::Result<StudyFindings> {
    let sessions = study::verification::sessions(study)?;
    let mut recordings = 0;
    for session in &sessions {
        recordings += study::verification::recordings(session)?.len();
    }
    verbosity.note(format_args!(
        "{} sessions, {recordings} recordings",
        sessions.len()
    ));
    let bar = progress_bar(recordings as u64, verbosity);
    let mut findings = StudyFindings::default();
    for session in &sessions {
        let mut session = study::verification::session(session, || bar.inc(1))?;
        session.defects.extend(edited_calibration(&session.folder));
        findings.sessions.push(session);
    }
    bar.finish_and_clear();
    study::verification::verify_study_files(study, &mut findings)?;
    if study.join(DESCRIPTION_FILE).exists() {
        let table = study::exclusions::read(study);
        match table.and_then(|table| table.require_known().map(|()| table)) {
            Ok(table) => {
                let notes = table.list.iter();
                let notes = notes.map(|exclusion| format!("excluded from analysis: {exclusion}"));
                findings.notes.extend(notes);
            }
            Err(error) => findings.defects.push(StudyDefect::Exclusions {
                reason: error.to_string(),
            }),
        }
    }
    Ok(findings)
}

/// Returns the defect of the session's copy of the calibration, which has its own hash. A missing copy or invalid TOML
/// has already been found; a copy that breaks rules of this version is not damaged.
fn edited_calibration(session: &Path) -> Option<SessionDefect> {
    match CalibrationFile::read(&session.join(CALIBRATION_COPY)) {
        Err(CalibrationFileError::Edited { .. } | CalibrationFileError::NoHash { .. }) => {
            Some(SessionDefect::BrokenCopy {
                file: CALIBRATION_COPY.to_owned(),
                reason: "calibration.toml: it was edited after it was measured".to_owned(),
            })
        }
        _ => None,
    }
}
