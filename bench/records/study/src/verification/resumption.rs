//! Log and protocol copy of a session to be resumed.

use std::path::Path;

use recording::study::event_log::{self, EventLogError, LogContent, Start};
use recording::study::{EVENTS_FILE, TrialLabel};
use recording::sums::{file_sum, text_sum};

use super::resume_error::ResumeError;
use super::session_names::{folder_session, recordings, session_words};
use crate::provenance::is_simulated;
use crate::sessions::{LoggedSession, history_in};

/// Most recordings that a part leaves without a line in the log if its program is killed.
const MOST_UNLOGGED: usize = 1;

/// Reads the log of the session in `folder`; `None` if the session was killed before it had one, or if the system refuses to read it,
/// which the opening of the session reports.
///
/// # Errors
/// [`ResumeError::Distrusted`]: the log has a hole, ends before several recordings, is lost although there are recordings, or is that of
/// another session.
pub fn trusted_log(folder: &Path) -> Result<Option<(LogContent, LoggedSession)>, ResumeError> {
    let distrust = |because: String| ResumeError::Distrusted {
        session: folder.to_owned(),
        because,
    };
    let path = folder.join(EVENTS_FILE);
    let has_recordings = recordings(folder).is_ok_and(|labels| !labels.is_empty());
    let lost = |what: &str| Err(distrust(format!("{what}, and there are recordings")));
    let log = match event_log::read(&path) {
        Ok(log) => log,
        Err(error @ EventLogError::Line { .. }) => return Err(distrust(error.to_string())),
        Err(_) if has_recordings && !path.exists() => return lost("it is missing"),
        Err(_) => return Ok(None),
    };
    if has_recordings && log.starts().next().is_none() {
        return lost("it states no start");
    }
    if let Some(expected) = folder_session(folder) {
        let mut found = log.starts().map(session_words);
        if let Some(found) = found.find(|found| *found != expected) {
            return Err(distrust(format!(
                "it is that of {found}, in the folder of {expected}"
            )));
        }
    }
    let history = history_in(folder, &log);
    let mut defects = history.defects.iter();
    if let Some(hole) = defects.find(|defect| defect.hides_trials()) {
        return Err(distrust(hole.to_string()));
    }
    let unlogged = unlogged(folder, &history);
    // At greatest speed, a simulated session records several trials in the second that a killed program loses of its log.
    let is_simulated = history.start.as_ref().is_some_and(is_simulated);
    if !is_simulated && unlogged.len() > MOST_UNLOGGED * (1 + history.n_resumptions) {
        return Err(distrust(format!(
            "{} recordings are not in it: it is an older copy, or lines of its end are lost",
            unlogged.len()
        )));
    }
    Ok(Some((log, history)))
}

/// Returns the recordings in a session's folder that its log does not mention.
fn unlogged(folder: &Path, history: &LoggedSession) -> Vec<TrialLabel> {
    let labels = recordings(folder).unwrap_or_default().into_iter();
    labels
        .filter(|label| history.attempt(*label).is_none())
        .collect()
}

/// Returns the words about several recordings that the log does not mention, to follow others; empty with one at most.
#[must_use]
pub fn unlogged_words(folder: &Path, history: &LoggedSession) -> String {
    match unlogged(folder, history).len() {
        0 | 1 => String::new(),
        count => format!(
            "; {count} recordings are not in the log, and their trials are done again: if events.jsonl is an older copy, quit and put the \
             newest one back"
        ),
    }
}

/// Returns the text of the session's copy of the protocol that its last part followed.
///
/// # Errors
/// [`ResumeError::Copy`]: it is gone, cannot be read, or was changed since.
pub fn followed_protocol(copy: &Path, last_start: Option<&Start>) -> Result<String, ResumeError> {
    let refuse = |because: String| ResumeError::Copy {
        copy: copy.to_owned(),
        because,
    };
    if !copy.exists() {
        return Err(refuse("is missing".to_owned()));
    }
    let name = copy.file_name().and_then(|name| name.to_str());
    let sum = name
        .zip(last_start)
        .and_then(|(name, start)| start.copies.get(name));
    if sum.is_some_and(|sum| is_changed(copy, sum)) {
        return Err(refuse("was changed after the session wrote it".to_owned()));
    }
    bounded_files::read_text(copy, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| refuse(format!("cannot be read ({})", bounded_files::cause(&error))))
}

/// Returns whether a copy that can be read differs from the one with this sum in more than line ends.
pub(super) fn is_changed(copy: &Path, sum: &str) -> bool {
    let is_same = file_sum(copy).map_or(true, |(_, actual)| actual == sum);
    !is_same && text_sum(copy).map_or(true, |actual| actual != sum)
}
