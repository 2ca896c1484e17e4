//! A resumed session repeats the last accepted trial if its recording is lost, and others only if the operator asks.

use std::path::Path;

use escaping::quoted;
use protocols::{Session, TrialRecord};
use study::sessions;
use study::verification::{LostRecording, ResumeError};

use super::plan::SessionPlan;

/// Returns the accepted trials of the session in `folder` to repeat because the disk does not have their recordings as
/// its `history` states.
///
/// # Errors
/// More than the last accepted trial is lost, for example because recordings were moved, and the operator did not ask to
/// repeat them; or the folder cannot be listed.
pub(super) fn to_repeat(
    plan: &SessionPlan,
    folder: &Path,
    history: &sessions::LoggedSession,
) -> anyhow::Result<Vec<LostRecording>> {
    let recordings = study::verification::lost_recordings(folder, history)?;
    if plan.repeat_lost || recordings.iter().all(|recording| recording.is_last) {
        return Ok(recordings);
    }
    let names: Vec<_> = recordings.iter().map(in_words).collect();
    Err(ResumeError::LostRecordings {
        session: folder.to_owned(),
        lost: names.join("; "),
        quoted: quoted(folder),
    }
    .into())
}

/// Withdraws the acceptance of these trials; returns the attempts as they count now, for the session's log.
pub(super) fn withdrawn(
    machine: &mut Session,
    recordings: &[LostRecording],
    practice_trials: u32,
) -> Vec<TrialRecord> {
    let withdraw = |recording: &LostRecording| {
        let number = recording.label.number_in_session(practice_trials);
        let reason = recording.defect.to_string();
        machine.withdraw(number, recording.label.attempt, reason)
    };
    recordings.iter().filter_map(withdraw).collect()
}

/// Returns the warning on a trial that is repeated because its recording is lost.
pub(super) fn warning(recording: &LostRecording) -> String {
    format!(
        "{}: it was accepted, but counts as interrupted and is repeated",
        in_words(recording)
    )
}

fn in_words(loss: &LostRecording) -> String {
    format!("the recording of {} is lost ({})", loss.label, loss.defect)
}
