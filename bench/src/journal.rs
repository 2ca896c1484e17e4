//! The session's log as a task: the session never waits for the disk.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use crossbeam_channel::Receiver;
use protocols::SessionEvent;
use serde_json::{Map, Value};

use recording::study::SessionFolder;
use recording::study::event_log::ExitStatus;
use recording::sums::Sums;
use tasks::Clock;
use tasks::Task;

/// What the session leaves in its log.
#[derive(Debug)]
pub enum Entry {
    /// Something happened in the protocol.
    Event(SessionEvent),
    /// A recording is complete and on disk.
    Saved {
        /// Audio clock, s.
        t_s: f64,
        /// Its folder.
        folder: PathBuf,
        /// Sums of its files; `None` if the session ended before they were made.
        sums: Option<Sums>,
    },
    /// The session ended.
    Stop {
        /// How.
        status: ExitStatus,
        /// Why, unless it succeeded.
        reason: Option<String>,
    },
}

/// Streams of the log.
const SESSION_STREAM: &str = "session";
const RECORDING_STREAM: &str = "recording";

/// The task.
pub struct Journal {
    session: SessionFolder,
    entries: Receiver<Entry>,
    clock: Arc<dyn Clock>,
    stopped: bool,
}

impl Journal {
    /// Writes what comes through `entries`; the start document has been written.
    ///
    /// # Errors
    /// When the descriptors cannot be written.
    pub fn new(
        mut session: SessionFolder,
        entries: Receiver<Entry>,
        clock: Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        for descriptor in descriptors() {
            session.log().descriptor(descriptor)?;
        }
        Ok(Self {
            session,
            entries,
            clock,
            stopped: false,
        })
    }

    fn write(&mut self, entry: Entry) -> anyhow::Result<()> {
        let time = self.clock.utc().to_string();
        let log = self.session.log();
        match entry {
            Entry::Event(event) => {
                let data = match serde_json::to_value(&event.kind)? {
                    Value::Object(data) => data,
                    other => Map::from_iter([("event".to_owned(), other)]),
                };
                log.event(SESSION_STREAM, time, event.t_s, data)?;
            }
            Entry::Saved { t_s, folder, sums } => {
                let name = folder
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned();
                let mut data = Map::from_iter([("saved".to_owned(), Value::String(name))]);
                if let Some(sums) = sums {
                    data.insert("sha256".to_owned(), serde_json::to_value(sums)?);
                }
                log.event(RECORDING_STREAM, time, t_s, data)?;
            }
            Entry::Stop { status, reason } => {
                self.stopped = true;
                log.stop(time, status, reason)?;
            }
        }
        Ok(())
    }

    fn write_waiting(&mut self) -> anyhow::Result<()> {
        while let Ok(entry) = self.entries.try_recv() {
            self.write(entry).context(
                "cannot write the session's log: the drive was stopped, what is on disk is kept",
            )?;
        }
        Ok(())
    }
}

fn descriptors() -> [recording::study::event_log::Descriptor; 2] {
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
                key("saved", "string", "folder of a recording that is complete and synced"),
                key("sha256", "object", "SHA-256 of each file of that folder, by name"),
            ]
            .into(),
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
        self.write_waiting()?;
        if !self.stopped {
            let reason = Some("the session task failed".to_owned());
            self.write(Entry::Stop {
                status: ExitStatus::Fail,
                reason,
            })?;
        }
        Ok(())
    }
}
