//! Recorder: a bounded queue from the acquisition into a [`RecordingWriter`](recording::RecordingWriter), on a thread or
//! polled in lock step.
//!
//! Audio never waits for the disk: a full queue refuses data, the loss is counted, and the trial fails at that sample
//! with an error. Data recorded before it are kept.

mod message;
mod recorder_core;

use std::io;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError, TrySendError};

pub use message::{
    Begin, RecorderError, RecorderMessage, RecorderNotice, RecorderState, RecorderStatus,
};
pub use recorder_core::{RecorderCore, SYNC_INTERVAL};

/// Places in the queue that are reserved for messages without data.
const RESERVED_PLACES: usize = 16;

/// Message that was not accepted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SendError {
    /// The queue is full. Refused data count as lost and fail the recording; other messages may be sent again.
    #[error("the recorder's queue is full")]
    Full(RecorderMessage),
    /// The recorder has ended.
    #[error("the recorder has ended")]
    Closed(RecorderMessage),
}

/// Data refused by the full queue just before a message.
#[derive(Debug, Default, Clone, Copy)]
struct Loss {
    messages: u64,
    frames: u64,
}

#[derive(Debug)]
struct QueuedMessage {
    earlier_loss: Loss,
    frames: u64,
    message: RecorderMessage,
}

#[derive(Debug)]
struct RecorderProgress {
    creation: Instant,
    /// Time at which the recorder last checked its queue or finished its messages, ms since its creation.
    last_check_ms: AtomicU64,
    sample_rate_hz: AtomicU32,
    frames_sent: AtomicU64,
    frames_settled: AtomicU64,
    greatest_lag_frames: AtomicU64,
    messages_lost: AtomicU64,
    status: Mutex<RecorderStatus>,
}

impl RecorderProgress {
    fn new() -> Self {
        Self {
            creation: Instant::now(),
            last_check_ms: AtomicU64::default(),
            sample_rate_hz: AtomicU32::default(),
            frames_sent: AtomicU64::default(),
            frames_settled: AtomicU64::default(),
            greatest_lag_frames: AtomicU64::default(),
            messages_lost: AtomicU64::default(),
            status: Mutex::default(),
        }
    }

    fn now_ms(&self) -> u64 {
        self.creation.elapsed().as_millis() as u64
    }

    fn note_check(&self) {
        self.last_check_ms.store(self.now_ms(), Ordering::Release);
    }

    /// Returns the time since the recorder last checked its queue, s; it grows while the disk does not respond.
    fn check_age_s(&self) -> f64 {
        let last_check_ms = self.last_check_ms.load(Ordering::Acquire);
        self.now_ms().saturating_sub(last_check_ms) as f64 * 1e-3
    }

    fn lag_frames(&self) -> u64 {
        let n_settled = self.frames_settled.load(Ordering::Acquire);
        let n_sent = self.frames_sent.load(Ordering::Acquire);
        n_sent.saturating_sub(n_settled)
    }

    fn seconds(&self, frames: u64) -> f64 {
        let rate_hz = self.sample_rate_hz.load(Ordering::Relaxed);
        if rate_hz == 0 {
            return 0.0;
        }
        frames as f64 / f64::from(rate_hz)
    }
}

/// Gauge of the recorder's lag and state, usable from any thread.
#[derive(Debug, Clone)]
pub struct RecorderGauge(Arc<RecorderProgress>);

impl RecorderGauge {
    /// Returns the audio sent but neither on disk nor discarded after a failure, s.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        self.0.seconds(self.0.lag_frames())
    }

    /// Returns the lag, or the time since the recorder last checked its queue if that is longer, s: between recordings a
    /// hung recorder has no lag, because no audio is sent.
    #[must_use]
    pub fn behind_s(&self) -> f64 {
        self.lag_s().max(self.0.check_age_s())
    }

    /// Returns the largest lag so far, s.
    #[must_use]
    pub fn greatest_lag_s(&self) -> f64 {
        let frames = self.0.greatest_lag_frames.load(Ordering::Relaxed);
        self.0.seconds(frames)
    }

    /// Returns the number of messages refused by the full queue so far; known at once, even while the recorder waits.
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

/// Sending end of the queue, for the acquisition; never blocks.
#[derive(Debug)]
pub struct RecorderSender {
    queue: Sender<QueuedMessage>,
    data_capacity: usize,
    channels: u64,
    loss: Loss,
    shared: Arc<RecorderProgress>,
}

impl RecorderSender {
    /// Sends a message.
    ///
    /// # Errors
    /// [`SendError`] returns the message. If it contained data, the recording has failed.
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
        let refuse = |sender: &mut Self, message| {
            if is_data {
                sender.loss.messages += 1;
                sender.loss.frames += frames;
            }
            sender.shared.messages_lost.fetch_add(1, Ordering::Relaxed);
            Err(SendError::Full(message))
        };
        if is_data && self.queue.len() >= self.data_capacity {
            return refuse(self, message);
        }
        // Counted before the recorder can settle it.
        self.shared.frames_sent.fetch_add(frames, Ordering::Release);
        let result = self.queue.try_send(QueuedMessage {
            earlier_loss: self.loss,
            frames,
            message,
        });
        if result.is_err() {
            self.shared.frames_sent.fetch_sub(frames, Ordering::Release);
        }
        match result {
            Ok(()) => {
                self.loss = Loss::default();
                let lag = self.shared.lag_frames();
                self.shared
                    .greatest_lag_frames
                    .fetch_max(lag, Ordering::Relaxed);
                Ok(())
            }
            Err(TrySendError::Full(queued)) => refuse(self, queued.message),
            Err(TrySendError::Disconnected(queued)) => Err(SendError::Closed(queued.message)),
        }
    }

    /// Returns a gauge of this recorder.
    #[must_use]
    pub fn gauge(&self) -> RecorderGauge {
        RecorderGauge(Arc::clone(&self.shared))
    }
}

/// Longest time that computing sums may delay the end of a session.
const MAX_SUM_TIME: Duration = Duration::from_millis(400);

/// Receiving end of the queue, to be run on a thread or polled.
#[derive(Debug)]
pub struct RecorderTask {
    core: RecorderCore,
    queue: Receiver<QueuedMessage>,
    notices: Sender<RecorderNotice>,
    frames_taken: u64,
    shared: Arc<RecorderProgress>,
}

/// Whether a polled recorder may still receive messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QueueState {
    /// The sender still exists.
    Open,
    /// The sender was dropped; an open recording has failed and is kept.
    Closed,
}

impl RecorderTask {
    /// Handles all waiting messages, syncs if it is due, and reads on for the sums of saved recordings.
    pub fn poll(&mut self, now: Instant) -> QueueState {
        self.shared.note_check();
        let state = loop {
            match self.queue.try_recv() {
                Ok(queued) => self.take(queued),
                Err(TryRecvError::Empty) => break QueueState::Open,
                Err(TryRecvError::Disconnected) => {
                    self.core.fail(RecorderError::Disconnected);
                    self.core.leave_sums();
                    break QueueState::Closed;
                }
            }
        };
        self.core.tick(now);
        self.core.sum();
        self.publish();
        state
    }

    /// Handles all waiting messages for the last time, and reads on for the sums of saved recordings. Recordings without
    /// sums after 0.4 s are reported without them, so that ending a session takes no longer.
    pub fn finish(&mut self, now: Instant) {
        self.poll(now);
        let start = Instant::now();
        while self.core.is_summing() && start.elapsed() < MAX_SUM_TIME {
            self.core.sum();
        }
        self.core.leave_sums();
        self.publish();
    }

    /// Runs until the sender is dropped.
    pub fn run(mut self) {
        loop {
            let wait = if self.core.is_summing() {
                Duration::ZERO
            } else {
                SYNC_INTERVAL / 4
            };
            match self.queue.recv_timeout(wait) {
                Ok(queued) => {
                    self.take(queued);
                    self.core.tick(Instant::now());
                    self.publish();
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                    if self.poll(Instant::now()) == QueueState::Closed {
                        return;
                    }
                }
            }
        }
    }

    /// Runs on a new thread.
    ///
    /// # Errors
    /// The operating system cannot create a thread.
    pub fn spawn(self) -> io::Result<JoinHandle<()>> {
        thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || self.run())
    }

    fn take(&mut self, queued: QueuedMessage) {
        let QueuedMessage {
            earlier_loss,
            frames,
            message,
        } = queued;
        if earlier_loss.messages > 0 {
            self.core
                .overflow(earlier_loss.messages, earlier_loss.frames);
        }
        self.core.handle(message);
        self.frames_taken += frames;
    }

    fn publish(&mut self) {
        self.shared.note_check();
        let status = self.core.status();
        let is_settled =
            status.state != RecorderState::Recording || status.on_disk.frames == status.frames;
        if is_settled {
            self.shared
                .frames_settled
                .store(self.frames_taken, Ordering::Release);
        }
        let mut screen_status = self
            .shared
            .status
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if *screen_status != *status {
            screen_status.clone_from(status);
        }
        drop(screen_status);
        while let Some(notice) = self.core.take_notice() {
            // Recording continues even if the receiver of the notices was dropped.
            let _ = self.notices.send(notice);
        }
    }
}

/// Creates a recorder with a queue for `data_capacity` messages with data.
///
/// DESIGN.md requires 10 s: that many seconds divided by the length of an audio block, times the messages sent per block.
#[must_use]
pub fn recorder(data_capacity: usize) -> (RecorderSender, Receiver<RecorderNotice>, RecorderTask) {
    let (queue, receiver) = crossbeam_channel::bounded(data_capacity + RESERVED_PLACES);
    let (notices, answers) = crossbeam_channel::unbounded();
    let shared = Arc::new(RecorderProgress::new());
    let sender = RecorderSender {
        queue,
        data_capacity,
        channels: 1,
        loss: Loss::default(),
        shared: Arc::clone(&shared),
    };
    let task = RecorderTask {
        core: RecorderCore::new(),
        queue: receiver,
        notices,
        frames_taken: 0,
        shared,
    };
    (sender, answers, task)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 27.
    #[test]
    fn a_recorder_that_hangs_between_recordings_is_behind() {
        let (sender, _notices, mut recorder) = recorder(1);
        let gauge = sender.gauge();
        let start = Instant::now();
        while gauge.behind_s() < 0.02 {
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "it is never behind"
            );
        }
        recorder.poll(Instant::now());
        // The recorder was created before `start`, but has just checked its queue.
        assert!(gauge.behind_s() < start.elapsed().as_secs_f64());
    }
}
