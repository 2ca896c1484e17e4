//! The session's log as a task: the session never waits for the disk.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use anyhow::Context;
use crossbeam_channel::{Receiver, Sender};
use protocols::{ParticipantId, Person, SessionEvent};
use serde_json::{Map, Value};

use recorder::RecorderNotice;
use recording::study::event_log::ExitStatus;
use recording::study::{SessionFolder, Study};
use recording::sums::Sums;
use tasks::Clock;
use tasks::Task;

/// Entry of the session's log.
#[derive(Debug)]
pub enum Entry {
    /// Something happened in the protocol.
    Event(SessionEvent),
    /// Details stated about the participant.
    Person(Person),
    /// A recording has ended and is on disk.
    Saved(SavedRecording),
    /// The carrier or the contact used by the live estimates has changed.
    Live {
        /// Audio clock, s.
        t_s: f64,
        /// The new values.
        data: Map<String, Value>,
    },
    /// An event of the participant's window.
    Display {
        /// Audio clock, s.
        t_s: f64,
        /// The event and its values.
        data: Map<String, Value>,
    },
    /// The session ended.
    Stop {
        /// Audio clock, s.
        t_s: f64,
        /// Exit status.
        status: ExitStatus,
        /// Reason, unless the session succeeded.
        reason: Option<String>,
    },
}

/// A recording that has ended and is on disk.
#[derive(Debug)]
pub struct SavedRecording {
    /// Audio clock, s.
    pub t_s: f64,
    /// Its folder.
    pub folder: PathBuf,
    /// Checksums of its files; `None` if the session ended before they were computed.
    pub sums: Option<Sums>,
    /// Whether the trial was interrupted.
    pub interrupted: bool,
}

/// Maximum number of entries that wait for the disk: 80 s from a window at its highest rate, hours of a session without
/// one.
const MOST_WAITING: usize = 1 << 14;
/// Additional places for the end of the session.
const RESERVED: usize = 1;

/// Number of entries that did not fit in the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0} entries of the session's log are lost, because the study's disk accepted none for minutes: the session cannot \
     go on; trials whose end is not in the log are repeated by --resume"
)]
pub struct EntriesLost(u64);

/// Sender of the session's threads to its log; it never blocks.
#[derive(Debug, Clone)]
pub struct EntrySender {
    tx: Sender<Entry>,
    shared: Arc<Shared>,
}

/// State shared by both ends of the queue.
#[derive(Debug)]
struct Shared {
    epoch: Instant,
    /// Time at which the journal last looked at its queue, ms after `epoch`.
    looked_ms: AtomicU64,
    losses: AtomicU64,
}

impl Shared {
    fn now_ms(&self) -> u64 {
        self.epoch.elapsed().as_millis() as u64
    }

    fn loss(&self) -> Option<EntriesLost> {
        let count = self.losses.load(Ordering::Relaxed);
        (count > 0).then_some(EntriesLost(count))
    }
}

/// Receiving end of the queue to the log.
#[derive(Debug)]
pub struct WaitingEntries {
    /// The entries.
    pub entries: Receiver<Entry>,
    shared: Arc<Shared>,
}

/// Returns both ends of the queue to a session's log.
#[must_use]
pub fn entry_queue() -> (EntrySender, WaitingEntries) {
    let (tx, entries) = crossbeam_channel::bounded(MOST_WAITING + RESERVED);
    let shared = Arc::new(Shared {
        epoch: Instant::now(),
        looked_ms: AtomicU64::default(),
        losses: AtomicU64::default(),
    });
    let sender = EntrySender {
        tx,
        shared: shared.clone(),
    };
    (sender, WaitingEntries { entries, shared })
}

impl EntrySender {
    /// Queues an entry, or counts it as lost if the queue is full.
    pub fn send(&self, entry: Entry) {
        // After a lost entry, only the end is accepted.
        let has_room = self.loss().is_none() && self.tx.len() < MOST_WAITING
            || matches!(entry, Entry::Stop { .. });
        // A disconnected queue is not counted here: the journal's task reports its own end.
        if !has_room || self.tx.try_send(entry).is_err_and(|error| error.is_full()) {
            self.shared.losses.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Returns the number of entries lost so far, if any.
    #[must_use]
    pub fn loss(&self) -> Option<EntriesLost> {
        self.shared.loss()
    }

    /// Returns the time since the journal last looked at its queue, s: it grows while the disk does not answer.
    #[must_use]
    pub fn behind_s(&self) -> f64 {
        let looked_ms = self.shared.looked_ms.load(Ordering::Acquire);
        self.shared.now_ms().saturating_sub(looked_ms) as f64 * 1e-3
    }
}

/// Streams of the log.
const SESSION_STREAM: &str = "session";
const RECORDING_STREAM: &str = "recording";
const LIVE_STREAM: &str = "live";
const DISPLAY_STREAM: &str = "display";

/// Task that writes the session's log.
pub struct Journal {
    /// The study and the participant, locked until the log is closed.
    study: (Study, ParticipantId),
    session: SessionFolder,
    entries: WaitingEntries,
    /// Notices of the recorder after the session has ended.
    notices: Receiver<RecorderNotice>,
    clock: Arc<dyn Clock>,
    /// End of the session, the last line of the log.
    stop: Option<Stop>,
    /// Audio clock of the last line, s.
    last_s: f64,
}

/// End of a session.
struct Stop {
    t_s: f64,
    status: ExitStatus,
    reason: Option<String>,
}

impl Journal {
    /// Writes the `entries`, and at the end the remaining `notices`; the start document has already been written.
    ///
    /// # Errors
    /// When the descriptors cannot be written.
    pub fn new(
        study: (Study, ParticipantId),
        mut session: SessionFolder,
        entries: WaitingEntries,
        notices: Receiver<RecorderNotice>,
        clock: Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        for descriptor in descriptors() {
            session.log().descriptor(descriptor)?;
        }
        Ok(Self {
            study,
            session,
            entries,
            notices,
            clock,
            stop: None,
            last_s: 0.0,
        })
    }

    /// Appends an event. Entries come from several threads, which read the audio clock at different times: the log's
    /// times never decrease, and `happened_s` keeps the true time of a late entry.
    fn event(
        &mut self,
        stream: &str,
        t_s: f64,
        mut data: Map<String, Value>,
    ) -> anyhow::Result<()> {
        if t_s < self.last_s {
            data.insert("happened_s".to_owned(), t_s.into());
        }
        self.last_s = self.last_s.max(t_s);
        let time = self.clock.utc().to_string();
        Ok(self.session.log().event(stream, time, self.last_s, data)?)
    }

    fn write(&mut self, entry: Entry) -> anyhow::Result<()> {
        match entry {
            Entry::Person(person) => {
                let (study, participant) = &self.study;
                study.describe(participant, &person)?;
            }
            Entry::Event(event) => {
                let data = match serde_json::to_value(&event.kind)? {
                    Value::Object(data) => data,
                    value => Map::from_iter([("event".to_owned(), value)]),
                };
                self.event(SESSION_STREAM, event.t_s, data)?;
            }
            Entry::Saved(saved) => {
                let name = saved
                    .folder
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned();
                let mut data = Map::from_iter([("saved".to_owned(), Value::String(name))]);
                if let Some(sums) = saved.sums {
                    data.insert("sha256".to_owned(), serde_json::to_value(sums)?);
                }
                if saved.interrupted {
                    data.insert("interrupted".to_owned(), Value::Bool(true));
                }
                self.event(RECORDING_STREAM, saved.t_s, data)?;
            }
            Entry::Live { t_s, data } => self.event(LIVE_STREAM, t_s, data)?,
            Entry::Display { t_s, data } => self.event(DISPLAY_STREAM, t_s, data)?,
            Entry::Stop {
                t_s,
                status,
                reason,
            } => {
                self.stop = Some(Stop {
                    t_s,
                    status,
                    reason,
                });
            }
        }
        Ok(())
    }

    /// Writes the recordings that the recorder ended after the session.
    fn write_last_recordings(&mut self, t_s: f64) -> anyhow::Result<()> {
        let mut outcome = Ok(());
        while let Ok(notice) = self.notices.try_recv() {
            match notice {
                RecorderNotice::Began { .. } => {}
                RecorderNotice::Saved {
                    folder,
                    sums,
                    interrupted,
                    ..
                } => self.write(Entry::Saved(SavedRecording {
                    t_s,
                    folder,
                    sums,
                    interrupted,
                }))?,
                RecorderNotice::Failed { folder, error, .. } => {
                    outcome = Err(error)
                        .with_context(|| format!("the recording {} failed", folder.display()));
                }
            }
        }
        outcome
    }

    fn write_waiting(&mut self) -> anyhow::Result<()> {
        let shared = &self.entries.shared;
        shared.looked_ms.store(shared.now_ms(), Ordering::Release);
        while let Ok(entry) = self.entries.entries.try_recv() {
            self.write(entry).context(
                "cannot write the session's log: the drive was stopped; files on disk are kept",
            )?;
        }
        self.entries
            .shared
            .loss()
            .map_or(Ok(()), |loss| Err(loss.into()))
    }
}

fn descriptors() -> [recording::study::event_log::Descriptor; 4] {
    use recording::study::event_log::{DataKey, Descriptor};
    let key = |name: &str, dtype: &str, source: &str| {
        (
            name.to_owned(),
            DataKey {
                dtype: dtype.to_owned(),
                unit: None,
                source: source.to_owned(),
            },
        )
    };
    [
        Descriptor {
            stream: SESSION_STREAM.to_owned(),
            data_keys: [key("event", "string", "the protocol's state machine; further keys depend on the event, docs/session-log.md")].into(),
        },
        Descriptor {
            stream: RECORDING_STREAM.to_owned(),
            data_keys: [
                key("saved", "string", "folder of a recording that has ended and is synced"),
                key("sha256", "object", "SHA-256 of each file of that folder, by name"),
                key("interrupted", "boolean", "true if the trial was broken off"),
            ]
            .into(),
        },
        Descriptor {
            stream: LIVE_STREAM.to_owned(),
            data_keys: [key("event", "string", "what the live estimates go by; further keys depend on the event, docs/session-log.md")].into(),
        },
        Descriptor {
            stream: DISPLAY_STREAM.to_owned(),
            data_keys: [key("event", "string", "what the participant's window did; further keys depend on the event, docs/session-log.md")].into(),
        },
    ]
}

impl Task for Journal {
    fn name(&self) -> &'static str {
        "journal"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(20)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        self.write_waiting()
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        let result = self.write_waiting();
        let loss = self.entries.shared.loss();
        // A log that cannot be written gets no end; a log with lost entries gets an end that reports them.
        if let (Err(error), None) = (result, loss) {
            return Err(error);
        }
        let failure = |reason: String, t_s| Stop {
            t_s,
            status: ExitStatus::Fail,
            reason: Some(reason),
        };
        let stop = self.stop.take();
        let t_s = stop.as_ref().map_or(self.last_s, |stop| stop.t_s);
        let stop = match loss {
            Some(loss) => failure(loss.to_string(), t_s),
            None => stop.unwrap_or_else(|| failure("the session task failed".to_owned(), t_s)),
        };
        let outcome = self.write_last_recordings(stop.t_s);
        let time = self.clock.utc().to_string();
        let log = self.session.log();
        log.stop(time, stop.status, stop.reason)
            .context("cannot write the end of the session's log")?;
        outcome?;
        loss.map_or(Ok(()), |loss| Err(loss.into()))
    }
}

#[cfg(test)]
mod tests {
    use recording::study::event_log::{self, Document};
    use recording::study::{EVENTS_FILE, GeneratedBy};
    use tasks::SystemClock;

    use super::*;

    /// Returns a log in `folder`, its file and its sender.
    fn journal(folder: &tempfile::TempDir) -> (Journal, PathBuf, EntrySender) {
        let generator = GeneratedBy {
            name: "test".to_owned(),
            version: "0".to_owned(),
        };
        let study = Study::open_or_create(&folder.path().join("study"), generator).unwrap();
        let participant: ParticipantId = "sub-01".parse().unwrap();
        let session = study
            .begin_session(&participant, 1, "2026-05-04", "demo")
            .unwrap();
        let path = session.folder().join(EVENTS_FILE);
        let (entries, waiting) = entry_queue();
        let (_, notices) = crossbeam_channel::unbounded();
        let clock = Arc::new(SystemClock::start());
        let journal = Journal::new((study, participant), session, waiting, notices, clock);
        (journal.unwrap(), path, entries)
    }

    /// No trial begins while the log is behind.
    /// Fault 49.
    #[test]
    fn a_log_that_nobody_writes_falls_behind_until_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (mut journal, _, entries) = journal(&folder);
        while entries.behind_s() < 0.02 {
            std::thread::yield_now();
        }
        let before_s = entries.behind_s();
        let start = Instant::now();
        journal.poll(0).unwrap();
        assert!(entries.behind_s() <= start.elapsed().as_secs_f64() + 1e-3 && before_s >= 0.02);
    }

    /// Fault 49.
    #[test]
    fn a_log_that_the_disk_does_not_take_loses_what_is_over_its_bound_and_ends_with_that() {
        let folder = tempfile::tempdir().unwrap();
        let (mut journal, path, entries) = journal(&folder);
        let live = |t_s: usize| Entry::Live {
            t_s: t_s as f64,
            data: Map::new(),
        };
        (0..MOST_WAITING).for_each(|k| entries.send(live(k)));
        assert_eq!(entries.loss(), None);
        entries.clone().send(live(MOST_WAITING));
        assert_eq!(entries.loss(), Some(EntriesLost(1)));
        let error = journal.poll(0).unwrap_err().to_string();
        assert_eq!(error, EntriesLost(1).to_string());
        // The disk has room again, but the log takes nothing after the lost entry.
        entries.send(live(MOST_WAITING + 1));
        entries.send(Entry::Stop {
            t_s: 1e6,
            status: ExitStatus::Success,
            reason: None,
        });
        journal.finish().unwrap_err();
        let log = event_log::read(&path).unwrap();
        let is_event = |document: &&Document| matches!(document, Document::Event(_));
        assert_eq!(log.documents.iter().filter(is_event).count(), MOST_WAITING);
        let Some(Document::Stop(stop)) = log.documents.last() else {
            panic!("no end");
        };
        assert_eq!(stop.exit_status, ExitStatus::Fail);
        assert_eq!(stop.reason, Some(EntriesLost(2).to_string()));
    }

    /// The participant's window reads the audio clock in its own thread, up to a period before the session does.
    /// Fault 27.
    #[test]
    fn entries_of_two_threads_make_a_log_whose_times_never_fall() {
        let folder = tempfile::tempdir().unwrap();
        let (mut journal, path, entries) = journal(&folder);
        let data = Map::new();
        for (t_s, is_display) in [(21.533, false), (21.531, true), (21.540, false)] {
            let data = data.clone();
            let entry = if is_display {
                Entry::Display { t_s, data }
            } else {
                Entry::Live { t_s, data }
            };
            entries.send(entry);
        }
        journal.finish().unwrap();
        let log = event_log::read(&path).unwrap();
        let events = log.documents.iter().filter_map(|document| match document {
            Document::Event(event) => Some((event.audio_s, event.data.get("happened_s").cloned())),
            _ => None,
        });
        let events: Vec<_> = events.collect();
        let late = (21.533, Some(Value::from(21.531)));
        assert_eq!(events, [(21.533, None), late, (21.540, None)]);
    }
}
