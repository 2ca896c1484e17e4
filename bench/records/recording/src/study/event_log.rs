//! Log of a session: start, descriptors, events and stop in the manner of bluesky, one JSON object per line.
//!
//! Every document is on disk when the call of [`EventLog`] that appends it returns. A log without a stop at its end
//! belongs to a killed session; a resumed session appends another start. A log never exceeds the size limit for reading.

use std::collections::BTreeMap;
use std::io::{self, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::DiskError;
use crate::disk::{self, OnPath};
use crate::storage::{FileSystem, Storage, StoredFile};
use bounded_files::parse_json;

/// Maximum size of a log, bytes: some 120 000 events, four hundred times as many as in a long session.
const LIMIT_BYTES: u64 = 64 << 20;

/// Bytes of a log that are reserved for its stop.
const STOP_BYTES: u64 = 64 << 10;

/// Line of the log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "document", rename_all = "snake_case")]
pub enum Document {
    /// A session begins or is resumed.
    Start(Box<Start>),
    /// Keys of the events of one stream.
    Descriptor(Descriptor),
    /// An event.
    Event(LogEvent),
    /// The session ended.
    Stop(Stop),
}

/// Start of a session, with everything needed to repeat it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Wall clock, RFC 3339.
    pub time: String,
    /// Whether this part resumes an earlier part of the session.
    pub resumed: bool,
    /// Identifier of the participant.
    pub participant: String,
    /// Number of the session, from 1.
    pub session: u32,
    /// Name of the protocol.
    pub protocol: String,
    /// File in the session's folder with the protocol of this part; absent in logs of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub protocol_file: Option<String>,
    /// Keys of the protocol that were edited since the previous part, each with both values; empty unless the operator
    /// accepted an edited protocol.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub protocol_edits: Vec<String>,
    /// SHA-256 of each of the session's copies of files; empty in logs of earlier versions.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub copies: BTreeMap<String, String>,
    /// Seed of the randomisation.
    pub seed: u64,
    /// Name of the program.
    pub software: String,
    /// Version of the program.
    pub version: String,
    /// Devices by purpose.
    pub devices: BTreeMap<String, String>,
    /// Calibration in use; null if uncalibrated.
    pub calibration: Option<String>,
    /// Effective configuration.
    pub configuration: Value,
    /// Faults injected on purpose, such as `estop@12s`; absent in a session with real data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rehearsed: Vec<String>,
    /// Rows of the preflight: check, verdict and finding, including the times of the exercised stops. Null in logs of
    /// versions without preflight.
    #[serde(default)]
    pub preflight: Value,
}

/// Keys of the events of one stream.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Descriptor {
    /// Name of the stream.
    pub stream: String,
    /// Keys of `data` in its events.
    pub data_keys: BTreeMap<String, DataKey>,
}

/// Type, unit and source of a value of an event.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DataKey {
    /// `number`, `integer`, `string`, `boolean`, `array` or `object`.
    pub dtype: String,
    /// Unit, if the value has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Source of the value.
    pub source: String,
}

/// Event of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogEvent {
    /// Name of the stream.
    pub stream: String,
    /// Number within the log, from 1 and rising by 1.
    pub seq_num: u64,
    /// Wall clock, RFC 3339.
    pub time: String,
    /// Time on the audio clock since the session began, s; not affected by jumps of the wall clock.
    pub audio_s: f64,
    /// Values.
    pub data: Map<String, Value>,
}

/// End of a session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stop {
    /// Wall clock, RFC 3339.
    pub time: String,
    /// Exit status.
    pub exit_status: ExitStatus,
    /// Reason, unless the session succeeded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Number of events in the log.
    pub num_events: u64,
}

/// Exit status of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExitStatus {
    /// All trials are done.
    Success,
    /// The operator aborted the session.
    Abort,
    /// A fault ended the session.
    Fail,
}

/// Error of writing or reading a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EventLogError {
    /// The operating system refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// A line is not a document, and was not merely torn by a killed process.
    #[error("{}, line {line}: {reason}", path.display())]
    Line {
        /// Path of the log.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Words for the fault.
        reason: String,
    },
    /// The log would become too long to be read.
    #[error(
        "{}: a document of {bytes} bytes would make the log longer than the {limit_bytes} bytes that are read: \
         begin another session with --new-session",
        path.display()
    )]
    Full {
        /// Path of the log.
        path: PathBuf,
        /// Length of the document, bytes.
        bytes: u64,
        /// Maximum length of the log, bytes.
        limit_bytes: u64,
    },
    /// JSON cannot represent a value.
    #[error("a document for {} cannot be written: {reason}", path.display())]
    Json {
        /// Path of the log.
        path: PathBuf,
        /// Error text of the serialiser.
        reason: String,
    },
}

/// Content of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogContent {
    /// Documents in order.
    pub documents: Vec<Document>,
    /// Numbers of torn lines, from 1, each the last line of a killed process; they are omitted.
    pub torn_lines: Vec<usize>,
}

impl LogContent {
    /// Returns the starts of the session's parts.
    pub fn starts(&self) -> impl Iterator<Item = &Start> {
        self.documents.iter().filter_map(|document| match document {
            Document::Start(start) => Some(&**start),
            _ => None,
        })
    }

    /// Returns the last stop, unless a start follows it.
    #[must_use]
    pub fn stop(&self) -> Option<&Stop> {
        match self.documents.last() {
            Some(Document::Stop(stop)) => Some(stop),
            _ => None,
        }
    }

    fn events(&self) -> u64 {
        self.documents
            .iter()
            .filter(|document| matches!(document, Document::Event(_)))
            .count() as u64
    }
}

/// Append-only log of a session.
#[derive(Debug)]
pub struct EventLog {
    path: PathBuf,
    storage: Arc<dyn Storage>,
    file: Box<dyn StoredFile>,
    /// Length of the complete lines, bytes.
    bytes: u64,
    events: u64,
    /// Whether the last line may be torn or not on disk; a further line would make the log unreadable.
    is_spoilt: bool,
}

impl EventLog {
    /// Creates a log; fails if the file exists.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(path: PathBuf) -> Result<Self, EventLogError> {
        Self::create_in(Arc::new(FileSystem), path)
    }

    /// Does the same as [`create`](Self::create), on any storage.
    ///
    /// # Errors
    /// The disk refused.
    pub fn create_in(storage: Arc<dyn Storage>, path: PathBuf) -> Result<Self, EventLogError> {
        disk::create_empty(&*storage, &path)?;
        Self::open_in(storage, path).map(|(log, _)| log)
    }

    /// Opens a log for appending; ends a line torn by a killed process.
    ///
    /// # Errors
    /// The operating system refused, or a line is not a document.
    pub fn open(path: PathBuf) -> Result<(Self, LogContent), EventLogError> {
        Self::open_in(Arc::new(FileSystem), path)
    }

    /// Does the same as [`open`](Self::open), on any storage.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_in(
        storage: Arc<dyn Storage>,
        path: PathBuf,
    ) -> Result<(Self, LogContent), EventLogError> {
        let text = storage
            .read(&path)
            .and_then(|file| bounded_files::read_limited(file, LIMIT_BYTES))
            .with_path("read", &path)?;
        let content = parse(&text, &path)?;
        let mut file = storage.append(&path).with_path("open", &path)?;
        if !text.is_empty() && !text.ends_with(b"\n") {
            file.write_all(b"\n").with_path("write", &path)?;
        }
        let bytes = file.seek(SeekFrom::End(0)).with_path("read", &path)?;
        let log = Self {
            path,
            storage,
            file,
            bytes,
            events: content.events(),
            is_spoilt: false,
        };
        Ok((log, content))
    }

    /// Returns the path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends the start of a session or of its resumption.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn start(&mut self, start: Start) -> Result<(), EventLogError> {
        self.append(&Document::Start(Box::new(start)))
    }

    /// Appends the keys of the events of a stream.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn descriptor(&mut self, descriptor: Descriptor) -> Result<(), EventLogError> {
        self.append(&Document::Descriptor(descriptor))
    }

    /// Appends an event under the next number. JSON has no NaN: such values become null.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn event(
        &mut self,
        stream: &str,
        time: String,
        audio_s: f64,
        data: Map<String, Value>,
    ) -> Result<(), EventLogError> {
        self.append(&Document::Event(LogEvent {
            stream: stream.to_owned(),
            seq_num: self.events + 1,
            time,
            audio_s,
            data,
        }))
    }

    /// Appends the end of the session.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn stop(
        &mut self,
        time: String,
        exit_status: ExitStatus,
        reason: Option<String>,
    ) -> Result<(), EventLogError> {
        self.append(&Document::Stop(Stop {
            time,
            exit_status,
            reason,
            num_events: self.events,
        }))
    }

    fn append(&mut self, document: &Document) -> Result<(), EventLogError> {
        let mut line = serde_json::to_string(document).map_err(|error| EventLogError::Json {
            path: self.path.clone(),
            reason: error.to_string(),
        })?;
        line.push('\n');
        let reserved_bytes = match document {
            Document::Stop(_) => 0,
            _ => STOP_BYTES,
        };
        if self.bytes + line.len() as u64 + reserved_bytes > LIMIT_BYTES {
            return Err(EventLogError::Full {
                path: self.path.clone(),
                bytes: line.len() as u64,
                limit_bytes: LIMIT_BYTES,
            });
        }
        if self.is_spoilt {
            return Err(io::Error::other("an earlier line could not be saved"))
                .with_path("write", &self.path)?;
        }
        let write_result = self.file.write_all(line.as_bytes());
        if write_result.is_err() {
            // Half a line would corrupt the next one.
            self.is_spoilt = self.file.set_len(self.bytes).is_err();
        }
        write_result.with_path("write", &self.path)?;
        self.bytes += line.len() as u64;
        self.events += u64::from(matches!(document, Document::Event(_)));
        let sync_result = self.file.sync_data();
        // A second sync could succeed after the system dropped unwritten data.
        self.is_spoilt = sync_result.is_err();
        sync_result.with_path("sync", &self.path)?;
        // Syncing an unlinked file succeeds.
        self.storage
            .find(&self.path)
            .with_path("find", &self.path)?;
        Ok(())
    }
}

/// Reads a log. An unreadable line at the end or before a start was torn by a killed process and is omitted.
///
/// # Errors
/// The operating system refused, or another line is not a document.
pub fn read(path: &Path) -> Result<LogContent, EventLogError> {
    parse(
        &bounded_files::read(path, LIMIT_BYTES).with_path("read", path)?,
        path,
    )
}

fn parse(bytes: &[u8], path: &Path) -> Result<LogContent, EventLogError> {
    let mut content = LogContent::default();
    let mut unreadable_line: Option<(usize, String)> = None;
    let lines = bounded_files::without_mark(bytes)
        .split(|byte| *byte == b'\n')
        .enumerate();
    for (index, line) in lines.filter(|(_, line)| !line.trim_ascii().is_empty()) {
        let document = parse_json::<Document>(line);
        if let Some((line, reason)) = unreadable_line.take() {
            if !matches!(document, Ok(Document::Start(_))) {
                return Err(EventLogError::Line {
                    path: path.to_owned(),
                    line,
                    reason,
                });
            }
            content.torn_lines.push(line);
        }
        match document {
            Ok(document) => content.documents.push(document),
            Err(reason) => unreadable_line = Some((index + 1, reason)),
        }
    }
    content
        .torn_lines
        .extend(unreadable_line.map(|(line, _)| line));
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_of_maximum_length_is_read_with_its_stop() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("events.jsonl");
        let mut log = EventLog::create(path.clone()).unwrap();
        // Mostly in one document, because syncing a hundred thousand documents takes too long.
        let mut length = (LIMIT_BYTES - STOP_BYTES) as usize - 1000;
        let mut events = 0;
        while length > 0 {
            let data = Map::from_iter([("text".to_owned(), Value::String("x".repeat(length)))]);
            match log.event("session", String::new(), 0.0, data) {
                Ok(()) => events += 1,
                Err(EventLogError::Full { bytes, .. }) => assert!(bytes > length as u64),
                Err(error) => panic!("{error}"),
            }
            length /= 2;
        }
        assert!((2..20).contains(&events), "{events} events");
        log.stop(String::new(), ExitStatus::Fail, Some("full".to_owned()))
            .unwrap();
        drop(log);
        let content = read(&path).unwrap();
        assert_eq!(content.events(), events);
        assert_eq!(content.stop().map(|stop| stop.num_events), Some(events));
        assert!(EventLog::open(path).is_ok());
    }
}
