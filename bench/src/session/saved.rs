//! The recorder's notices about recordings, for the session's log and its operator.

use std::collections::VecDeque;
use std::path::PathBuf;

use protocols::{Interruption, RecordingOutcome, TrialKey, TrialOutcome, TrialRecord};
use recorder::{RecorderGauge, RecorderNotice};

use journal::{Entry, EntrySender, SavedRecording};

/// The latest recording, and the outcomes of recordings.
#[derive(Default)]
pub(super) struct Recordings {
    /// The latest recording, until the recorder has reported its end.
    open: Option<(TrialKey, PathBuf)>,
    /// Outcomes that the protocol's state machine has not observed yet.
    outcomes: VecDeque<(TrialKey, RecordingOutcome)>,
    /// Number of messages refused by the recorder's queue so far.
    messages_lost: u64,
    /// The recording that lost them.
    overflowed: Option<PathBuf>,
    /// Whether the operator was told that the session's log is incomplete.
    log_loss_reported: bool,
}

impl Recordings {
    /// Begins a recording.
    pub(super) fn begin(&mut self, key: TrialKey, folder: PathBuf) {
        self.open = Some((key, folder));
    }

    /// Returns whether the recorder has not yet reported the end of the latest recording.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Returns the failure if the queue has refused data of the open recording; the recorder may report it much later.
    pub(super) fn overflow(&mut self, gauge: &RecorderGauge) -> Option<String> {
        let messages_lost = gauge.messages_lost();
        if std::mem::replace(&mut self.messages_lost, messages_lost) == messages_lost {
            return None;
        }
        let (key, folder) = self.open.as_ref()?;
        if self.overflowed.as_ref() == Some(folder) {
            return None;
        }
        self.overflowed = Some(folder.clone());
        let message = format!(
            "the recorder's queue has overflowed: the recording {} has lost data, because the study's disk is too slow",
            folder.display()
        );
        let outcome = RecordingOutcome::Failed(message.clone());
        self.outcomes.push_back((key.clone(), outcome));
        Some(message)
    }

    /// Returns, once, the losses of the session's log.
    pub(super) fn log_loss(&mut self, journal: &EntrySender) -> Option<String> {
        let loss = journal.loss().filter(|_| !self.log_loss_reported)?;
        self.log_loss_reported = true;
        Some(loss.to_string())
    }

    /// Takes the end of a recording. Returns whether it is news, which the end of a recording with lost data is not.
    pub(super) fn end(&mut self, end: &RecordingEnd) -> bool {
        if let Some((key, _)) = self.open.take_if(|(_, open)| *open == end.folder) {
            let outcome = match &end.outcome {
                Ok(_) => RecordingOutcome::Saved,
                Err(message) => RecordingOutcome::Failed(message.clone()),
            };
            self.outcomes.push_back((key, outcome));
        }
        self.overflowed.as_ref() != Some(&end.folder)
    }

    /// Returns the oldest outcome that the protocol's state machine has not observed.
    pub(super) fn outcome(&mut self) -> Option<(TrialKey, RecordingOutcome)> {
        self.outcomes.pop_front()
    }
}

/// Returns why an attempt is interrupted if its recording was not saved.
pub(super) fn not_saved(record: &TrialRecord) -> Option<String> {
    match &record.outcome {
        TrialOutcome::Interrupted {
            interruption: Interruption::NotSaved { reason },
        } => Some(reason.clone()),
        _ => None,
    }
}

/// End of a recording.
pub(super) struct RecordingEnd {
    /// Its folder.
    pub(super) folder: PathBuf,
    /// The log's entry, or the failure.
    pub(super) outcome: Result<Entry, String>,
}

/// Returns the end of a recording that `notice` reports at `t_s`, if it reports one.
pub(super) fn ending(notice: RecorderNotice, t_s: f64, rate_hz: u32) -> Option<RecordingEnd> {
    match notice {
        RecorderNotice::Began { .. } => None,
        RecorderNotice::Saved {
            folder,
            sums,
            interrupted,
            ..
        } => Some(RecordingEnd {
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
            saved_part,
        } => {
            let kept_s = saved_part.frames as f64 / f64::from(rate_hz);
            let message = format!(
                "the recording {} failed: {error}; {kept_s:.1} s of it are readable",
                folder.display(),
            );
            Some(RecordingEnd {
                folder,
                outcome: Err(message),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use recorder::{RecorderError, recorder};
    use recording::writer::DiskSize;

    use super::*;

    fn key(attempt: u32) -> TrialKey {
        TrialKey {
            number: 1,
            attempt,
            practice: false,
            condition: "c".to_owned(),
        }
    }

    fn end(folder: &str, saved: bool) -> RecordingEnd {
        let folder = PathBuf::from(folder);
        let notice = if saved {
            RecorderNotice::Saved {
                folder,
                on_disk: DiskSize::default(),
                sums: None,
                interrupted: false,
            }
        } else {
            RecorderNotice::Failed {
                folder,
                error: RecorderError::Disconnected,
                saved_part: DiskSize::default(),
            }
        };
        ending(notice, 1.0, 48_000).unwrap()
    }

    /// Fault 27.
    #[test]
    fn each_attempt_gets_the_end_of_its_own_recording() {
        let mut recordings = Recordings::default();
        recordings.begin(key(1), "a".into());
        recordings.begin(key(2), "b".into());
        assert!(recordings.end(&end("a", true)), "of an earlier attempt");
        assert_eq!(recordings.outcome(), None);
        assert!(recordings.is_open());
        assert!(recordings.end(&end("b", false)));
        let (attempt, outcome) = recordings.outcome().unwrap();
        assert_eq!(attempt, key(2));
        assert!(matches!(outcome, RecordingOutcome::Failed(_)));
        assert!(!recordings.is_open());
    }

    /// Fault 27.
    #[test]
    fn a_queue_that_overflows_fails_the_recording_before_the_recorder_says_so() {
        use recorder::RecorderMessage::Gap;
        let (mut sender, _notices, _hung) = recorder(1);
        let gauge = sender.gauge();
        let mut recordings = Recordings::default();
        recordings.begin(key(1), "a".into());
        assert!(sender.send(Gap(1)).is_ok());
        assert_eq!(recordings.overflow(&gauge), None);
        assert!(sender.send(Gap(1)).is_err());
        assert!(recordings.overflow(&gauge).is_some());
        assert!(sender.send(Gap(1)).is_err());
        assert_eq!(recordings.overflow(&gauge), None, "it is told once");
        let (attempt, outcome) = recordings.outcome().unwrap();
        assert_eq!(attempt, key(1));
        assert!(matches!(outcome, RecordingOutcome::Failed(_)));
        assert!(!recordings.end(&end("a", false)), "it is known");
    }
}
