//! The recorder: a bounded queue from the acquisition into a [`RecordingWriter`], on a thread or polled in lock step.
//!
//! Audio never waits for the disk: a full queue refuses data, the loss is counted, and the trial fails at that sample
//! with an error. What was recorded up to there is kept.

use std::collections::VecDeque;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError, TrySendError};

use crate::csv_rows::{ForceRow, PositionRow};
use crate::manifest::{EventKind, Manifest, RecordedInterval, RecordingEvent};
use crate::wav::AudioFormat;
use crate::writer::{Ending, OnDisk, RecordingWriter, WriteError};

/// Time between syncs; together with the sync itself well under the 1 s within which everything must be on disk.
pub const SYNC_INTERVAL: Duration = Duration::from_millis(400);

/// Places in the queue that are reserved for messages without data.
const RESERVED: usize = 16;

/// Message from the acquisition to the recorder.
#[derive(Debug)]
pub enum RecorderMessage {
    /// Starts a recording in a folder that does not exist yet.
    Begin(Box<Begin>),
    /// Interleaved samples.
    Audio(Vec<f32>),
    /// Number of frames that were lost.
    Gap(u64),
    /// Force readings on the audio clock.
    Force(Vec<ForceRow>),
    /// Position readings on the audio clock.
    Position(Vec<PositionRow>),
    /// An event.
    Event(RecordingEvent),
    /// An event that may go on: replaces the event of this kind at this sample, if there is one.
    Flag(RecordingEvent),
    /// An interval with a known meaning.
    Interval(RecordedInterval),
    /// Ends the recording.
    End(Ending),
}

/// Recording to begin.
#[derive(Debug)]
pub struct Begin {
    /// Folder of the recording, which must not exist; its parent must.
    pub folder: PathBuf,
    /// Description of the recording.
    pub manifest: Manifest,
    /// Format of the audio.
    pub format: AudioFormat,
}

/// Answer of the recorder; answers come in order.
#[derive(Debug)]
pub enum RecorderNotice {
    /// The folder is on disk and takes data.
    Began {
        /// The recording.
        folder: PathBuf,
    },
    /// The recording is complete and synced.
    Saved {
        /// The recording.
        folder: PathBuf,
        /// What the recording holds.
        on_disk: OnDisk,
    },
    /// The recording failed; later data up to the next `Begin` are discarded.
    Failed {
        /// The recording.
        folder: PathBuf,
        /// Reason.
        error: RecorderError,
        /// What of it is readable.
        kept: OnDisk,
    },
}

/// Why a recording failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The disk was slower than the data for longer than the queue holds.
    #[error(
        "the recorder's queue overflowed: {messages} messages with {frames} frames of audio were lost after frame {at_frame}; the disk is too slow"
    )]
    Overflow {
        /// Messages lost.
        messages: u64,
        /// Frames of audio among them.
        frames: u64,
        /// Frames recorded before.
        at_frame: u64,
    },
    /// A recording was begun before the last one had ended.
    #[error("the next recording began before this one had ended")]
    NotEnded,
    /// The acquisition ended without ending the recording, by a panic for example.
    #[error("the acquisition ended before the recording had ended")]
    Disconnected,
}

/// State of the recorder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RecorderState {
    /// No recording is open.
    #[default]
    Idle,
    /// A recording is being written.
    Recording,
    /// The last recording failed.
    Failed,
}

/// Snapshot of the recorder for the screen.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RecorderStatus {
    /// State of the recorder.
    pub state: RecorderState,
    /// The current or the last recording.
    pub folder: Option<PathBuf>,
    /// Frames taken, on disk or not.
    pub frames: u64,
    /// What the last sync put on disk.
    pub on_disk: OnDisk,
    /// Why the last recording failed.
    pub error: Option<String>,
}

/// Recorder without queue or clock of its own.
#[derive(Debug, Default)]
pub struct RecorderCore {
    writer: Option<RecordingWriter>,
    status: RecorderStatus,
    synced_at: Option<Instant>,
    notices: VecDeque<RecorderNotice>,
}

impl RecorderCore {
    /// Makes a recorder without an open recording.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one message. Errors become notices; data outside a recording are discarded.
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
            RecorderMessage::Flag(event) => self.write(|w| {
                w.renew_event(event);
                Ok(())
            }),
            RecorderMessage::Interval(interval) => self.write(|w| w.add_interval(interval)),
            RecorderMessage::End(ending) => self.end(ending),
        }
    }

    /// Syncs when [`SYNC_INTERVAL`] has passed since the last sync; `now` is the monotonic clock, also in lock step.
    pub fn tick(&mut self, now: Instant) {
        let due = self
            .synced_at
            .is_none_or(|at| now.saturating_duration_since(at) >= SYNC_INTERVAL);
        if due {
            self.synced_at = Some(now);
            self.write(|w| w.sync().map(drop));
        }
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
        match RecordingWriter::create(&folder, manifest, format) {
            Ok(writer) => {
                self.writer = Some(writer);
                self.notices.push_back(RecorderNotice::Began { folder });
            }
            Err(error) => self.failed(folder, error.into(), OnDisk::default()),
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
        match writer.finish(ending) {
            Ok(on_disk) => {
                self.status.state = RecorderState::Idle;
                self.status.on_disk = on_disk;
                self.notices
                    .push_back(RecorderNotice::Saved { folder, on_disk });
            }
            Err(unfinished) => self.failed(folder, unfinished.error.into(), unfinished.kept),
        }
    }

    /// Ends the recording at this sample, because data were lost on their way to the recorder.
    fn overflow(&mut self, messages: u64, frames: u64) {
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

    fn fail(&mut self, error: RecorderError) {
        if let Some(writer) = self.writer.take() {
            let folder = writer.folder().to_owned();
            let kept = writer.abandon(error.to_string());
            self.failed(folder, error, kept);
        }
    }

    fn failed(&mut self, folder: PathBuf, error: RecorderError, kept: OnDisk) {
        self.status.state = RecorderState::Failed;
        self.status.on_disk = kept;
        self.status.error = Some(error.to_string());
        self.notices.push_back(RecorderNotice::Failed {
            folder,
            error,
            kept,
        });
    }
}

/// Message that was not taken.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SendError {
    /// The queue is full. Data are counted as lost and fail the recording; other messages may be sent again.
    #[error("the recorder's queue is full")]
    Full(RecorderMessage),
    /// The recorder has ended.
    #[error("the recorder has ended")]
    Closed(RecorderMessage),
}

/// Data that the full queue refused just before a message.
#[derive(Debug, Default, Clone, Copy)]
struct Loss {
    messages: u64,
    frames: u64,
}

#[derive(Debug)]
struct Queued {
    lost_before: Loss,
    frames: u64,
    message: RecorderMessage,
}

#[derive(Debug, Default)]
struct Shared {
    sample_rate_hz: AtomicU32,
    frames_sent: AtomicU64,
    frames_settled: AtomicU64,
    messages_lost: AtomicU64,
    status: Mutex<RecorderStatus>,
}

/// Gauge of the recorder's lag and state, for any thread.
#[derive(Debug, Clone)]
pub struct RecorderGauge(Arc<Shared>);

impl RecorderGauge {
    /// Returns the seconds of audio sent but neither on disk nor discarded after a failure.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        let rate_hz = self.0.sample_rate_hz.load(Ordering::Relaxed);
        if rate_hz == 0 {
            return 0.0;
        }
        let settled = self.0.frames_settled.load(Ordering::Acquire);
        let sent = self.0.frames_sent.load(Ordering::Acquire);
        sent.saturating_sub(settled) as f64 / f64::from(rate_hz)
    }

    /// Returns how many messages with data the full queue has refused so far.
    #[must_use]
    pub fn messages_lost(&self) -> u64 {
        self.0.messages_lost.load(Ordering::Relaxed)
    }

    /// Returns the state of the recorder.
    #[must_use]
    pub fn status(&self) -> RecorderStatus {
        self.0
            .status
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// The acquisition's end of the queue; never blocks.
#[derive(Debug)]
pub struct RecorderSender {
    queue: Sender<Queued>,
    data_capacity: usize,
    channels: u64,
    lost: Loss,
    shared: Arc<Shared>,
}

impl RecorderSender {
    /// Sends a message.
    ///
    /// # Errors
    /// [`SendError`] gives the message back. If it held data, the recording has failed.
    pub fn send(&mut self, message: RecorderMessage) -> Result<(), SendError> {
        if let RecorderMessage::Begin(begin) = &message {
            self.channels = u64::from(begin.format.channels).max(1);
            self.shared
                .sample_rate_hz
                .store(begin.format.sample_rate_hz, Ordering::Relaxed);
        }
        let frames = match &message {
            RecorderMessage::Audio(samples) => samples.len() as u64 / self.channels,
            RecorderMessage::Gap(frames) => *frames,
            _ => 0,
        };
        let is_data = matches!(
            message,
            RecorderMessage::Audio(_)
                | RecorderMessage::Gap(_)
                | RecorderMessage::Force(_)
                | RecorderMessage::Position(_)
        );
        let full = |sender: &mut Self, message| {
            if is_data {
                sender.lost.messages += 1;
                sender.lost.frames += frames;
                sender.shared.messages_lost.fetch_add(1, Ordering::Relaxed);
            }
            Err(SendError::Full(message))
        };
        if is_data && self.queue.len() >= self.data_capacity {
            return full(self, message);
        }
        // Counted before it can be settled.
        self.shared.frames_sent.fetch_add(frames, Ordering::Release);
        let sent = self.queue.try_send(Queued {
            lost_before: self.lost,
            frames,
            message,
        });
        if sent.is_err() {
            self.shared.frames_sent.fetch_sub(frames, Ordering::Release);
        }
        match sent {
            Ok(()) => {
                self.lost = Loss::default();
                Ok(())
            }
            Err(TrySendError::Full(queued)) => full(self, queued.message),
            Err(TrySendError::Disconnected(queued)) => Err(SendError::Closed(queued.message)),
        }
    }

    /// Returns a gauge of this recorder.
    #[must_use]
    pub fn gauge(&self) -> RecorderGauge {
        RecorderGauge(Arc::clone(&self.shared))
    }
}

/// Recorder at the other end of the queue, to be run on a thread or polled.
#[derive(Debug)]
pub struct RecorderTask {
    core: RecorderCore,
    queue: Receiver<Queued>,
    notices: Sender<RecorderNotice>,
    frames_taken: u64,
    shared: Arc<Shared>,
}

/// Whether a polled recorder may still get messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polled {
    /// The sender is still there.
    Open,
    /// The sender is gone; whatever was open has been failed and kept.
    Closed,
}

impl RecorderTask {
    /// Takes every message that waits, then syncs if it is time.
    pub fn poll(&mut self, now: Instant) -> Polled {
        let polled = loop {
            match self.queue.try_recv() {
                Ok(queued) => self.take(queued),
                Err(TryRecvError::Empty) => break Polled::Open,
                Err(TryRecvError::Disconnected) => {
                    self.core.fail(RecorderError::Disconnected);
                    break Polled::Closed;
                }
            }
        };
        self.core.tick(now);
        self.publish();
        polled
    }

    /// Runs until the sender is gone.
    pub fn run(mut self) {
        loop {
            match self.queue.recv_timeout(SYNC_INTERVAL / 4) {
                Ok(queued) => {
                    self.take(queued);
                    self.core.tick(Instant::now());
                    self.publish();
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                    if self.poll(Instant::now()) == Polled::Closed {
                        return;
                    }
                }
            }
        }
    }

    /// Runs on a thread of its own.
    ///
    /// # Errors
    /// The operating system has no thread to give.
    pub fn spawn(self) -> io::Result<JoinHandle<()>> {
        thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || self.run())
    }

    fn take(&mut self, queued: Queued) {
        let Queued {
            lost_before,
            frames,
            message,
        } = queued;
        if lost_before.messages > 0 {
            self.core.overflow(lost_before.messages, lost_before.frames);
        }
        self.core.handle(message);
        self.frames_taken += frames;
    }

    fn publish(&mut self) {
        let status = self.core.status();
        let settled =
            status.state != RecorderState::Recording || status.on_disk.frames == status.frames;
        if settled {
            self.shared
                .frames_settled
                .store(self.frames_taken, Ordering::Release);
        }
        let mut shown = self
            .shared
            .status
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if *shown != *status {
            shown.clone_from(status);
        }
        drop(shown);
        while let Some(notice) = self.core.take_notice() {
            // Recording goes on even if nobody receives the notices.
            let _ = self.notices.send(notice);
        }
    }
}

/// Makes a recorder whose queue holds `data_capacity` messages with data.
///
/// DESIGN.md asks for 10 s: that many seconds divided by the length of an audio block, times the messages sent per
/// block.
#[must_use]
pub fn recorder(data_capacity: usize) -> (RecorderSender, Receiver<RecorderNotice>, RecorderTask) {
    let (queue, waiting) = crossbeam_channel::bounded(data_capacity + RESERVED);
    let (notices, answers) = crossbeam_channel::unbounded();
    let shared = Arc::new(Shared::default());
    let sender = RecorderSender {
        queue,
        data_capacity,
        channels: 1,
        lost: Loss::default(),
        shared: Arc::clone(&shared),
    };
    let task = RecorderTask {
        core: RecorderCore::new(),
        queue: waiting,
        notices,
        frames_taken: 0,
        shared,
    };
    (sender, answers, task)
}
