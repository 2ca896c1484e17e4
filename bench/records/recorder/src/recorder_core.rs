//! Recorder without queue or clock.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::message::{
    Begin, RecorderError, RecorderMessage, RecorderNotice, RecorderState, RecorderStatus,
};
use recording::manifest::{EventKind, RecordingEvent};
use recording::storage::{FileSystem, Storage};
use recording::sums::Summation;
use recording::writer::{DiskSize, Ending, RecordingWriter, WriteError};

/// Time between syncs; together with the sync well under the 1 s within which everything must be on disk.
pub const SYNC_INTERVAL: Duration = Duration::from_millis(400);

/// Bytes of a saved recording read back for its sums before the queue is checked again: well under 0.1 s.
const SUM_BYTES: usize = 4 << 20;

/// Recorder without queue or clock.
#[derive(Debug)]
pub struct RecorderCore {
    storage: Arc<dyn Storage>,
    writer: Option<RecordingWriter>,
    status: RecorderStatus,
    last_sync: Option<Instant>,
    /// Ended recordings with unfinished sums, oldest first.
    summing: VecDeque<EndedRecording>,
    notices: VecDeque<RecorderNotice>,
}

/// Recording that has ended and is synced.
#[derive(Debug)]
struct EndedRecording {
    summing: Summation,
    on_disk: DiskSize,
    interrupted: bool,
}

impl EndedRecording {
    fn saved_notice(&self) -> RecorderNotice {
        RecorderNotice::Saved {
            folder: self.summing.folder().to_owned(),
            on_disk: self.on_disk,
            sums: self.summing.sums().cloned(),
            interrupted: self.interrupted,
        }
    }
}

impl Default for RecorderCore {
    fn default() -> Self {
        Self::new()
    }
}

impl RecorderCore {
    /// Creates a recorder without an open recording.
    #[must_use]
    pub fn new() -> Self {
        Self::with_storage(Arc::new(FileSystem))
    }

    /// Creates a recorder without an open recording, on any storage.
    #[must_use]
    pub fn with_storage(storage: Arc<dyn Storage>) -> Self {
        Self {
            storage,
            writer: None,
            status: RecorderStatus::default(),
            last_sync: None,
            summing: VecDeque::new(),
            notices: VecDeque::new(),
        }
    }

    /// Handles one message. Errors become notices; data outside a recording are discarded.
    pub fn handle(&mut self, message: RecorderMessage) {
        match message {
            RecorderMessage::Begin(begin) => self.begin(*begin),
            RecorderMessage::Audio(samples) => self.write(|w| w.write_audio(&samples)),
            RecorderMessage::Gap(frames) => self.write(|w| w.write_gap(frames)),
            RecorderMessage::Force(rows) => self.write(|w| w.write_force(&rows)),
            RecorderMessage::Position(rows) => self.write(|w| w.write_position(&rows)),
            RecorderMessage::Event(event) => self.write(|w| {
                w.add_event(event);
                Ok(())
            }),
            RecorderMessage::Flag(number, event) => self.write(|w| {
                w.renew_event(number, event);
                Ok(())
            }),
            RecorderMessage::Clocks(clocks) => self.write(|w| {
                w.set_clocks(clocks);
                Ok(())
            }),
            RecorderMessage::Interval(interval) => self.write(|w| w.add_interval(interval)),
            RecorderMessage::End(ending) => self.end(ending),
        }
    }

    /// Syncs if [`SYNC_INTERVAL`] has passed since the last sync; `now` is the monotonic clock, also in lock step.
    pub fn tick(&mut self, now: Instant) {
        let is_due = self
            .last_sync
            .is_none_or(|time| now.saturating_duration_since(time) >= SYNC_INTERVAL);
        if is_due {
            self.last_sync = Some(now);
            self.write(|w| w.sync().map(drop));
        }
    }

    /// Reads on in the oldest recording without sums; to be called when idle. [`RecorderNotice::Saved`] follows.
    pub fn sum(&mut self) {
        let Some(recording) = self.summing.front_mut() else {
            return;
        };
        if let Err(error) = recording.summing.advance(SUM_BYTES) {
            let (folder, saved_part) = (recording.summing.folder().to_owned(), recording.on_disk);
            self.summing.pop_front();
            self.report_failure(folder, error.into(), saved_part);
        } else if recording.summing.sums().is_some() {
            self.notices.push_back(recording.saved_notice());
            self.summing.pop_front();
        }
    }

    /// Returns whether recordings still lack their sums.
    #[must_use]
    pub fn is_summing(&self) -> bool {
        !self.summing.is_empty()
    }

    /// Reports recordings without finished sums as saved without them.
    pub(super) fn leave_sums(&mut self) {
        let recordings = self.summing.drain(..);
        self.notices
            .extend(recordings.map(|recording| recording.saved_notice()));
    }

    /// Returns the oldest answer not yet taken.
    pub fn take_notice(&mut self) -> Option<RecorderNotice> {
        self.notices.pop_front()
    }

    /// Returns the state of the recorder.
    #[must_use]
    pub fn status(&self) -> &RecorderStatus {
        &self.status
    }

    fn begin(&mut self, begin: Begin) {
        self.fail(RecorderError::NotEnded);
        let Begin {
            folder,
            manifest,
            format,
        } = begin;
        self.status = RecorderStatus {
            state: RecorderState::Recording,
            folder: Some(folder.clone()),
            ..RecorderStatus::default()
        };
        match RecordingWriter::create_in(Arc::clone(&self.storage), &folder, manifest, format) {
            Ok(writer) => {
                self.writer = Some(writer);
                self.notices.push_back(RecorderNotice::Began { folder });
            }
            Err(error) => self.report_failure(folder, error.into(), DiskSize::default()),
        }
    }

    fn write(&mut self, write: impl FnOnce(&mut RecordingWriter) -> Result<(), WriteError>) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        match write(writer) {
            Ok(()) => {
                self.status.frames = writer.frames();
                self.status.on_disk = writer.on_disk();
            }
            Err(error) => self.fail(error.into()),
        }
    }

    fn end(&mut self, ending: Ending) {
        let Some(writer) = self.writer.take() else {
            return;
        };
        let folder = writer.folder().to_owned();
        let interrupted = matches!(ending, Ending::Interrupted { .. });
        match writer.finish(ending) {
            Ok(on_disk) => {
                self.status.state = RecorderState::Idle;
                self.status.on_disk = on_disk;
                let summing = Summation::new(Arc::clone(&self.storage), &folder);
                self.summing.push_back(EndedRecording {
                    summing,
                    on_disk,
                    interrupted,
                });
            }
            Err(unfinished) => {
                self.report_failure(folder, unfinished.error.into(), unfinished.saved_part)
            }
        }
    }

    /// Ends the recording at this sample, because data were lost on the way to the recorder.
    pub(super) fn overflow(&mut self, messages: u64, frames: u64) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        let at_frame = writer.frames();
        writer.add_event(RecordingEvent {
            kind: EventKind::RecorderOverflow,
            sample: at_frame,
            frames: Some(frames),
            text: None,
        });
        self.fail(RecorderError::Overflow {
            messages,
            frames,
            at_frame,
        });
    }

    pub(super) fn fail(&mut self, error: RecorderError) {
        if let Some(writer) = self.writer.take() {
            let folder = writer.folder().to_owned();
            let saved_part = writer.abandon(error.to_string());
            self.report_failure(folder, error, saved_part);
        }
    }

    fn report_failure(&mut self, folder: PathBuf, error: RecorderError, saved_part: DiskSize) {
        if self.status.folder.as_deref() == Some(&folder) {
            self.status.state = RecorderState::Failed;
            self.status.on_disk = saved_part;
        }
        self.status.error = Some(error.to_string());
        self.notices.push_back(RecorderNotice::Failed {
            folder,
            error,
            saved_part,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::manifest::{MINIMAL, Manifest};
    use recording::{AudioFormat, RecordingReader};

    #[test]
    fn a_flag_with_an_earlier_sample_replaces_its_event_only() {
        let study = tempfile::tempdir().unwrap();
        let folder = study.path().join("trial-001_attempt-1");
        let mut core = RecorderCore::new();
        core.handle(RecorderMessage::Begin(Box::new(Begin {
            folder: folder.clone(),
            manifest: Manifest::parse(MINIMAL, "recording.toml").unwrap(),
            format: AudioFormat {
                sample_rate_hz: 192_000,
                channels: 2,
            },
        })));
        core.handle(RecorderMessage::Audio(vec![0.5; 400]));
        let event = |sample, text: &str| RecordingEvent {
            kind: EventKind::ForceLost,
            sample,
            frames: Some(10),
            text: Some(text.to_owned()),
        };
        for (flag, sample, text) in [(1, 100, "1"), (2, 150, "1"), (1, 90, "2"), (3, 90, "1")] {
            core.handle(RecorderMessage::Flag(flag, event(sample, text)));
        }
        core.handle(RecorderMessage::End(Ending::Completed));
        let reader = RecordingReader::open(&folder).unwrap();
        let expected = [event(90, "2"), event(150, "1"), event(90, "1")];
        assert_eq!(reader.manifest().events, expected);
    }
}
