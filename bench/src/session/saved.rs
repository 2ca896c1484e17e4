//! What the recorder says of a recording, for the session's log and its operator.

use std::path::PathBuf;

use recording::recorder::RecorderNotice;

use crate::journal::{Entry, SavedRecording};

/// End of a recording.
pub(super) struct Ended {
    /// Its folder.
    pub(super) folder: PathBuf,
    /// The log's entry, or what failed.
    pub(super) outcome: Result<Entry, String>,
}

/// Returns the end of a recording that the recorder tells of at `t_s`, if it does.
pub(super) fn ended(notice: RecorderNotice, t_s: f64, rate_hz: u32) -> Option<Ended> {
    match notice {
        RecorderNotice::Began { .. } => None,
        RecorderNotice::Saved {
            folder,
            sums,
            interrupted,
            ..
        } => Some(Ended {
            folder: folder.clone(),
            outcome: Ok(Entry::Saved(SavedRecording {
                t_s,
                folder,
                sums,
                interrupted,
            })),
        }),
        RecorderNotice::Failed {
            folder,
            error,
            kept,
        } => {
            let kept_s = kept.frames as f64 / f64::from(rate_hz);
            let message = format!(
                "the recording {} failed: {error}; {kept_s:.1} s of it are readable",
                folder.display(),
            );
            Some(Ended {
                folder,
                outcome: Err(message),
            })
        }
    }
}
