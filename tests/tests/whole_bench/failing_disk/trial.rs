//! A session of two trials on a failing disk, with the reports of the recorder and the log, and checks of the result.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use recorder::{
    Begin, RecorderCore, RecorderMessage, RecorderNotice, RecorderState, SYNC_INTERVAL,
};
use recording::manifest::{End, EventKind, MINIMAL, Manifest, RecordingEvent};
use recording::storage::{FileSystem, Storage};
use recording::study::event_log::{self, Document, EventLog, ExitStatus};
use recording::sums::{Summation, Sums};
use recording::writer::{DiskSize, Ending};
use recording::{AudioFormat, ForceRow, MANIFEST_FILE, PositionRow, RecordingReader};
use serde_json::{Map, Value};

use super::memory_disk::MemoryDisk;

const LOG: &str = "/session/events.jsonl";
const FORMAT: AudioFormat = AudioFormat {
    sample_rate_hz: 192_000,
    channels: 2,
};
const TRIAL: &str = r#"trial = { number = 1, attempt = 1, practice = false, condition = "c", protocol = "p", seed = 1 }"#;

/// Folder of the session, which exists from the start.
pub fn folder() -> &'static Path {
    Path::new("/session")
}

/// End of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SessionEnd {
    /// By the program, after any failure.
    Program,
    /// By a power cut.
    PowerCut,
}

/// Data of a trial: those given to the recorder, or those on the disk at a sync.
#[derive(Debug, Clone, Default)]
struct Data {
    samples: Vec<f32>,
    force: Vec<ForceRow>,
    position: Vec<PositionRow>,
}

/// Counts of the [`Data`].
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    frames: u64,
    force: usize,
    position: usize,
}

impl Data {
    fn counts(&self) -> Counts {
        Counts {
            frames: self.samples.len() as u64 / 2,
            force: self.force.len(),
            position: self.position.len(),
        }
    }
}

/// Reports of the recorder about a trial.
#[derive(Debug, Default)]
struct Trial {
    folder: PathBuf,
    input: Data,
    synced: Counts,
    has_begun: bool,
    saved: Option<(DiskSize, Sums)>,
    failure: Option<DiskSize>,
}

/// Reports of a session.
#[derive(Debug, Default)]
pub struct Session {
    trials: Vec<Trial>,
    /// Streams of the events that the log accepted.
    logged_streams: Vec<String>,
    is_stopped: bool,
}

impl Session {
    /// Records two trials, the first longer than the writer's buffer, and writes a log.
    pub fn record(disk: &MemoryDisk) -> Self {
        let storage: Arc<dyn Storage> = Arc::new(disk.clone());
        let mut session = Self::default();
        let mut log = EventLog::create_in(Arc::clone(&storage), LOG.into()).ok();
        let mut core = RecorderCore::with_storage(storage);
        let start = Instant::now();
        for (number, frames) in [(1, [33_000, 500, 500]), (2, [100, 100, 100])] {
            session.event(&mut log, "session", Map::new());
            let mut trial = Trial {
                folder: folder().join(format!("trial-{number:03}_attempt-1")),
                ..Trial::default()
            };
            core.handle(RecorderMessage::Begin(Box::new(Begin {
                folder: trial.folder.clone(),
                manifest: Manifest::parse(&format!("{MINIMAL}{TRIAL}"), "recording.toml").unwrap(),
                format: FORMAT,
            })));
            for (block, frames) in (0..).zip(frames) {
                trial.give(&mut core, block, frames);
                let now = start + SYNC_INTERVAL * (4 * number + block);
                core.tick(now);
                if core.status().state == RecorderState::Recording {
                    trial.synced = trial.input.counts();
                    assert_eq!(core.status().on_disk.frames, trial.synced.frames);
                }
            }
            // This block is not yet written when the trial ends.
            trial.give(&mut core, 3, 100);
            core.handle(RecorderMessage::End(Ending::Completed));
            while core.is_summing() {
                core.sum();
            }
            while let Some(notice) = core.take_notice() {
                match notice {
                    RecorderNotice::Began { .. } => trial.has_begun = true,
                    RecorderNotice::Saved { on_disk, sums, .. } => {
                        trial.saved = Some((on_disk, sums.unwrap()));
                        session.event(&mut log, "recording", Map::new());
                    }
                    RecorderNotice::Failed { saved_part, .. } => trial.failure = Some(saved_part),
                }
            }
            session.trials.push(trial);
        }
        session.is_stopped = log.as_mut().is_some_and(|log| {
            let result = log.stop(String::new(), ExitStatus::Success, None);
            result.is_ok()
        });
        session
    }

    fn event(&mut self, log: &mut Option<EventLog>, stream: &str, data: Map<String, Value>) {
        if let Some(log) = log
            && log.event(stream, String::new(), 0.0, data).is_ok()
        {
            self.logged_streams.push(stream.to_owned());
        }
    }

    /// Returns whether the recorder and the log accepted everything.
    pub fn is_saved(&self) -> bool {
        self.trials.iter().all(|trial| trial.saved.is_some())
            && self.is_stopped
            && self.logged_streams.len() == 4
    }

    /// Returns the number of trials that are not saved.
    pub fn lost_trials(&self) -> usize {
        let trials = self.trials.iter();
        trials.filter(|trial| trial.saved.is_none()).count()
    }

    /// Requires the content of `root` to agree with the reports.
    pub fn require_content(&self, root: &Path, end: SessionEnd) {
        for trial in &self.trials {
            trial.require_content(&root.join(trial.folder.strip_prefix("/").unwrap()), end);
        }
        let path = root.join(LOG.strip_prefix('/').unwrap());
        if self.logged_streams.is_empty() && !path.exists() {
            return;
        }
        let content = event_log::read(&path).unwrap();
        let mut events = content
            .documents
            .iter()
            .filter_map(|document| match document {
                Document::Event(event) => Some(event),
                _ => None,
            });
        let numbers: Vec<u64> = events.clone().map(|event| event.seq_num).collect();
        assert_eq!(numbers, (1..=numbers.len() as u64).collect::<Vec<_>>());
        // Lines that were written but not reported as such may exist too.
        for stream in &self.logged_streams {
            assert!(events.any(|event| event.stream == *stream), "{content:?}");
        }
        assert!(!self.is_stopped || content.stop().is_some());
    }
}

impl Trial {
    fn give(&mut self, core: &mut RecorderCore, block: u32, frames: usize) {
        let counts = self.input.counts();
        let start = counts.frames as usize;
        let samples: Vec<f32> = (start..start + frames)
            .flat_map(|n| [n as f32, -(n as f32)])
            .collect();
        let force: Vec<ForceRow> = (0..20)
            .map(|n| ForceRow {
                // The nearest value to a short decimal reads back exactly.
                time_s: f64::from(20 * block + n) / 10_000.0,
                normal_n: 0.5,
                lateral_n: -0.25,
            })
            .collect();
        let position = vec![PositionRow {
            time_s: f64::from(block) / 1000.0,
            position_m: 0.0625,
        }];
        self.input.samples.extend(&samples);
        self.input.force.extend(&force);
        self.input.position.extend(&position);
        core.handle(RecorderMessage::Audio(samples));
        core.handle(RecorderMessage::Force(force));
        core.handle(RecorderMessage::Position(position));
        if block == 1 {
            self.input.samples.extend([f32::NAN; 2 * 7]);
            core.handle(RecorderMessage::Gap(7));
            core.handle(RecorderMessage::Event(RecordingEvent {
                kind: EventKind::Note,
                sample: 3,
                frames: None,
                text: Some("in the second block".to_owned()),
            }));
        }
    }

    fn require_content(&self, folder: &Path, session_end: SessionEnd) {
        assert!(self.saved.is_none() || self.failure.is_none(), "{self:?}");
        if !folder.join(MANIFEST_FILE).exists() {
            assert!(!self.has_begun, "{folder:?} began");
            return;
        }
        let mut reader = RecordingReader::open(folder).unwrap();
        let (mut samples, mut block) = (Vec::new(), Vec::new());
        while reader.read_block(10_000, &mut block).unwrap() > 0 {
            samples.extend_from_slice(&block);
        }
        let content = Data {
            samples,
            force: reader.force().unwrap().map(Result::unwrap).collect(),
            position: reader.position().unwrap().map(Result::unwrap).collect(),
        };
        let mut secured = self.synced;
        secured.frames = secured
            .frames
            .max(self.failure.map_or(0, |on_disk| on_disk.frames));
        content.is_no_shorter_than(secured);
        // Only the part that a power cut tore may differ from the given data.
        self.input.begins_with(
            &content,
            match session_end {
                SessionEnd::Program => content.counts(),
                SessionEnd::PowerCut => secured,
            },
        );
        let end = reader.manifest().trial.as_ref().unwrap().end;
        // A completed manifest is as reliable as the recorder's report.
        if self.saved.is_some() || end == Some(End::Completed) {
            assert_eq!(end, Some(End::Completed));
            assert_eq!(reader.warnings(), []);
            let events = &reader.manifest().events;
            assert_eq!(events.len(), 2, "the gap and the note: {events:?}");
            let counts = self.input.counts();
            self.input.begins_with(&content, counts);
            content.is_no_shorter_than(counts);
            assert_eq!(content.counts().frames, counts.frames);
        }
        if let Some((on_disk, sums)) = &self.saved {
            assert_eq!(on_disk.frames, self.input.counts().frames);
            assert_eq!(*sums, checksums(folder));
        }
    }
}

impl Data {
    /// Requires the first `counts` rows of both to be equal.
    fn begins_with(&self, content: &Self, counts: Counts) {
        let bits = |data: &Self| -> Vec<u32> {
            let samples = data.samples.iter().take(2 * counts.frames as usize);
            samples.map(|sample| sample.to_bits()).collect()
        };
        assert!(bits(self) == bits(content), "other samples");
        let force = |data: &Self| {
            data.force
                .iter()
                .take(counts.force)
                .copied()
                .collect::<Vec<_>>()
        };
        assert!(force(self) == force(content), "other forces");
        let position = |data: &Self| {
            data.position
                .iter()
                .take(counts.position)
                .copied()
                .collect::<Vec<_>>()
        };
        assert!(position(self) == position(content), "other positions");
    }

    fn is_no_shorter_than(&self, counts: Counts) {
        let own_counts = self.counts();
        assert!(
            own_counts.frames >= counts.frames
                && own_counts.force >= counts.force
                && own_counts.position >= counts.position,
            "{own_counts:?} of {counts:?}"
        );
    }
}

fn checksums(folder: &Path) -> BTreeMap<String, String> {
    let mut summing = Summation::new(Arc::new(FileSystem), folder);
    while summing.advance(1 << 20).unwrap() > 0 {}
    summing.sums().unwrap().clone()
}
