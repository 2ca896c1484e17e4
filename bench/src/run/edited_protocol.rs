//! A resumed session keeps its protocol, unless the operator accepts an edited one.

use std::path::Path;

use anyhow::Context;
use protocols::Protocol;
use recording::study::SessionFolder;
use recording::study::event_log::Start;
use study::verification::{ResumeError, followed_protocol, protocol_edits};

use super::plan::SessionPlan;

/// Returns the edits of the protocol since the last part of the resumed session, which began with `last_start`, each key with its
/// values; empty for a new session.
///
/// # Errors
/// The protocol was edited and the operator does not accept that, or the previous protocol cannot be read.
pub(super) fn accepted_edits(
    plan: &SessionPlan,
    session: &SessionFolder,
    last_start: Option<&Start>,
) -> anyhow::Result<Vec<String>> {
    let Some(file) = last_followed(session, last_start, &plan.protocol.protocol.name) else {
        return Ok(Vec::new());
    };
    let path = session.folder().join(&file);
    let text = followed_protocol(&path, last_start)?;
    let before = Protocol::parse(&text, &path.display().to_string())?;
    let edits = protocol_edits(&before, &plan.protocol.protocol)
        .context("a protocol that cannot be compared")?;
    if !edits.is_empty() && !plan.accept_edited_protocol {
        return Err(ResumeError::EditedProtocol {
            session: session.folder().to_owned(),
            protocol: plan.protocol.protocol.name.clone(),
            edits: edits.join(", "),
            copy: path,
        }
        .into());
    }
    Ok(edits)
}

/// Returns the name of a file.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Returns the file with the protocol that the last part of a session followed: the file named in its log, or the newest
/// copy if an earlier version wrote the log; `None` if there is no copy.
fn last_followed(
    session: &SessionFolder,
    last_start: Option<&Start>,
    protocol: &str,
) -> Option<String> {
    let logged_name = last_start.and_then(|start| start.protocol_file.clone());
    let later_copies = (2..).map(|number| format!("{protocol}.{number}.toml"));
    let copies = std::iter::once(format!("{protocol}.toml")).chain(later_copies);
    logged_name.or_else(|| {
        copies
            .take_while(|name| session.folder().join(name).exists())
            .last()
    })
}
