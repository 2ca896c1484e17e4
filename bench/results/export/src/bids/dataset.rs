//! Files of the whole dataset.

use std::path::Path;

use recording::study::{DESCRIPTION_FILE, PARTICIPANTS_FILE};
use serde_json::json;

use crate::bids::names::{CHANGES, EVENTS_SIDECAR, PARTICIPANTS_SIDECAR, README};
use crate::bids::participants::ParticipantTable;
use crate::bids::sidecars;
use crate::export_error::ExportError;
use crate::export_origin::ExportOrigin;
use crate::target_folder::TargetFolder;

/// Version of the specification.
const BIDS_VERSION: &str = "1.10.0";

/// Writes the files of the whole dataset; returns sentences about particulars of participants that the study lacks. README, CHANGES
/// and the description are left if they are there: people complete them with authors, licence and ethics.
///
/// # Errors
/// The study's table of participants cannot be read, or a file cannot be written.
pub(crate) fn write(
    study: Option<&Path>,
    participants: &[String],
    origin: &ExportOrigin,
    target: &TargetFolder,
) -> Result<Vec<String>, ExportError> {
    let table = participant_table(study, participants)?;
    let name = study_name(study);
    let ExportOrigin { version, day } = origin;
    let description = json!({
        "Name": name,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [{ "Name": "friction-bench", "Version": version, "Description": "friction-bench export" }]
    });
    let readme = format!("# {name}\n\n{}\n", include_str!("readme.md").trim_end());
    let changes = format!("1.0.0 {day}\n  - First export, by friction-bench {version}.\n");
    let description = sidecars::to_text(&description);
    for (name, text) in [
        (DESCRIPTION_FILE, &description),
        (README, &readme),
        (CHANGES, &changes),
    ] {
        target.put_draft(Path::new(name), text)?;
    }
    target.put_text(Path::new(PARTICIPANTS_FILE), &table.to_text())?;
    target.put_text(Path::new(PARTICIPANTS_SIDECAR), &table.sidecar())?;
    target.put_text(Path::new(EVENTS_SIDECAR), &sidecars::events())?;
    Ok(table.remarks())
}

fn participant_table(
    study: Option<&Path>,
    participants: &[String],
) -> Result<ParticipantTable, ExportError> {
    let path = study.map(|study| study.join(PARTICIPANTS_FILE));
    let path = path.filter(|path| path.exists());
    let read = |path: &Path| {
        bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES).map_err(|source| {
            recording::DiskError {
                action: "read",
                path: path.to_owned(),
                source,
            }
        })
    };
    let text = path.as_deref().map(read).transpose()?;
    ParticipantTable::new(text, participants).map_err(|fault| ExportError::Participants {
        path: path.unwrap_or_default(),
        fault,
    })
}

/// Returns the name of the study, by its description or its folder.
fn study_name(study: Option<&Path>) -> String {
    let described = |study: &Path| {
        let text = bounded_files::read_text(
            &study.join(DESCRIPTION_FILE),
            bounded_files::TEXT_LIMIT_BYTES,
        );
        let description = recording::study::parse_description(text.ok()?.as_bytes()).ok()?;
        Some(description.name).filter(|name| !name.is_empty())
    };
    let named = |study: &Path| Some(study.file_name()?.to_string_lossy().into_owned());
    let name = study.and_then(|study| described(study).or_else(|| named(study)));
    name.unwrap_or_else(|| "study".to_owned())
}
