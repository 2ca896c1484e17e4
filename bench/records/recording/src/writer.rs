//! Writes a recording folder so that a killed process leaves a readable one.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::csv_rows::{CsvRow, ForceRow, PositionRow};
use crate::disk::{self, AppendFile, DiskError, Records};
use crate::manifest::End;
use crate::manifest::{
    EventKind, MAX_ENTRIES, Manifest, ManifestError, RecordedClock, RecordedInterval,
    RecordingEvent,
};
use crate::storage::{FileSystem, Storage};
use crate::{FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE};
use wav_files::{AudioFormat, SAMPLE_BYTES};

/// Frames of NaN per write.
const GAP_BATCH_FRAMES: u64 = 4096;

/// Error of writing a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The folder exists already; recordings are never overwritten.
    #[error("{} exists already and is never overwritten; use another attempt, trial or session", path.display())]
    Exists {
        /// Folder of the recording.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The manifest violates a rule of the format.
    #[error("the recording's description is not valid: {0}")]
    Manifest(#[from] ManifestError),
    /// The number of channels or the sampling rate is zero or does not fit into a WAV header.
    #[error("{channels} channels at {sample_rate_hz} Hz cannot be recorded")]
    Format {
        /// Number of channels.
        channels: u16,
        /// Sampling rate, Hz.
        sample_rate_hz: u32,
    },
    /// The recording would exceed the 4 GiB of the WAV format.
    #[error(
        "the recording would exceed the {limit_frames} frames ({limit_s:.0} s) that fit into a WAV file; end the trial earlier or record fewer channels"
    )]
    TooLong {
        /// Maximum number of frames.
        limit_frames: u64,
        /// The same as a time, s.
        limit_s: f64,
    },
    /// The length of a block is not a multiple of the number of channels.
    #[error("a block of {samples} samples is not a whole number of frames of {channels} channels")]
    PartialFrame {
        /// Samples in the block.
        samples: usize,
        /// Number of channels.
        channels: u16,
    },
    /// The time of a row is not finite.
    #[error("{file}: time {time_s} is not finite")]
    Time {
        /// The file.
        file: &'static str,
        /// Time, s.
        time_s: f64,
    },
}

/// Size of a recording on disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DiskSize {
    /// Frames in `signals.wav`.
    pub frames: u64,
    /// Bytes in the three data files.
    pub bytes: u64,
}

/// Failure to end a recording, with the size of the saved part.
#[derive(Debug, thiserror::Error)]
#[error("{error}; {} frames of the recording are kept", saved_part.frames)]
pub struct FinishError {
    /// Reason.
    #[source]
    pub error: WriteError,
    /// Part that is on disk and synced.
    pub saved_part: DiskSize,
}

/// End of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// The trial is complete.
    Completed,
    /// The trial was interrupted.
    Interrupted {
        /// Reason.
        reason: String,
    },
}

impl From<&protocols::TrialEnd> for Ending {
    fn from(end: &protocols::TrialEnd) -> Self {
        match end {
            protocols::TrialEnd::Completed => Self::Completed,
            protocols::TrialEnd::Interrupted { interruption } => Self::Interrupted {
                reason: interruption.to_string(),
            },
        }
    }
}

/// Writer of one recording.
///
/// ```
/// use recording::manifest::Manifest;
/// use recording::writer::Ending;
/// use recording::{AudioFormat, ForceRow, RecordingReader, RecordingWriter};
///
/// let text = r#"
/// format = 1
/// carrier_hz = 35000.0
/// modulation_hz = 6.0
/// modulation_index = 0.95
/// channels.drive = { index = 0, volts_per_unit = 20.0 }
/// channels.pickup = { index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }
/// plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.05 }
/// "#;
/// let study = tempfile::tempdir()?;
/// let folder = study.path().join("trial-001_attempt-1");
/// let format = AudioFormat { sample_rate_hz: 96_000, channels: 2 };
/// let mut writer = RecordingWriter::create(&folder, Manifest::parse(text, "recording.toml")?, format)?;
/// writer.write_audio(&[0.5, 0.25, 0.5, 0.25])?;
/// writer.write_gap(1)?;
/// writer.write_force(&[ForceRow { time_s: 0.0, normal_n: 0.65, lateral_n: -0.3 }])?;
/// writer.finish(Ending::Completed)?;
///
/// let mut reader = RecordingReader::open(&folder)?;
/// let mut block = Vec::new();
/// assert_eq!(reader.read_block(1024, &mut block)?, 3);
/// assert_eq!(block[..4], [0.5, 0.25, 0.5, 0.25]);
/// assert!(block[4].is_nan() && block[5].is_nan(), "lost samples are NaN");
/// assert_eq!(reader.manifest().carrier_hz(), Some(35e3));
/// assert_eq!(reader.force()?.next().unwrap()?.lateral_n as f32, -0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Data are saved only once [`sync`](Self::sync) or [`finish`](Self::finish) has returned `Ok`. A writer dropped without
/// `finish` leaves a recording without `end`, as a killed process does.
#[derive(Debug)]
pub struct RecordingWriter {
    storage: Arc<dyn Storage>,
    folder: PathBuf,
    manifest: Manifest,
    manifest_changed: bool,
    /// Indices of the flags' events in the manifest, by the numbers of the flags.
    flags: BTreeMap<u64, usize>,
    format: AudioFormat,
    signals: AppendFile,
    frames: u64,
    force: CsvFile,
    position: CsvFile,
    on_disk: DiskSize,
}

impl RecordingWriter {
    /// Creates the folder with `recording.toml` and the headers of the other files, all on disk on return.
    ///
    /// # Errors
    /// [`WriteError::Exists`] if `folder` exists; its parent must exist.
    pub fn create(
        folder: &Path,
        manifest: Manifest,
        format: AudioFormat,
    ) -> Result<Self, WriteError> {
        Self::create_in(Arc::new(FileSystem), folder, manifest, format)
    }

    /// Does the same as [`create`](Self::create), on any storage.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn create_in(
        storage: Arc<dyn Storage>,
        folder: &Path,
        manifest: Manifest,
        format: AudioFormat,
    ) -> Result<Self, WriteError> {
        if !format.fits_a_header() {
            return Err(WriteError::Format {
                channels: format.channels,
                sample_rate_hz: format.sample_rate_hz,
            });
        }
        let text = manifest.to_toml()?;
        manifest.validate_audio(format.sample_rate_hz, format.channels)?;
        storage.create_folder(folder).map_err(|source| {
            if source.kind() == std::io::ErrorKind::AlreadyExists {
                WriteError::Exists {
                    path: folder.to_owned(),
                }
            } else {
                DiskError {
                    action: "create",
                    path: folder.to_owned(),
                    source,
                }
                .into()
            }
        })?;
        disk::sync_parent(&*storage, folder)?;
        let signals = AppendFile::create(
            &storage,
            folder.join(SIGNALS_FILE),
            &wav_files::header(format, 0),
            Records::Bytes(format.frame_bytes() as usize),
        )?;
        let mut writer = Self {
            folder: folder.to_owned(),
            manifest,
            manifest_changed: false,
            flags: BTreeMap::new(),
            format,
            signals,
            frames: 0,
            force: CsvFile::create::<ForceRow>(&storage, folder, FORCE_FILE)?,
            position: CsvFile::create::<PositionRow>(&storage, folder, POSITION_FILE)?,
            on_disk: DiskSize::default(),
            storage,
        };
        writer.sync()?;
        // Written last and as a whole: a folder without it is not a recording, and a recording has all of its files, also
        // after a power cut.
        disk::sync_parent(&*writer.storage, &folder.join(MANIFEST_FILE))?;
        writer.replace_manifest(&text)?;
        Ok(writer)
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the sampling rate and the number of channels.
    #[must_use]
    pub fn format(&self) -> AudioFormat {
        self.format
    }

    /// Returns the number of frames written, including gaps, whether on disk or not; this is also the index of the next
    /// frame.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the size of the recording on disk at the last sync.
    #[must_use]
    pub fn on_disk(&self) -> DiskSize {
        self.on_disk
    }

    /// Appends interleaved samples.
    ///
    /// # Errors
    /// [`WriteError::TooLong`], before any sample of the block is written.
    pub fn write_audio(&mut self, interleaved: &[f32]) -> Result<(), WriteError> {
        let channels = usize::from(self.format.channels);
        if !interleaved.len().is_multiple_of(channels) {
            return Err(WriteError::PartialFrame {
                samples: interleaved.len(),
                channels: self.format.channels,
            });
        }
        let frames = (interleaved.len() / channels) as u64;
        self.require_room(frames)?;
        self.signals.append(|bytes| {
            let start = bytes.len();
            bytes.resize(start + interleaved.len() * SAMPLE_BYTES as usize, 0);
            let (chunks, _) = bytes[start..].as_chunks_mut();
            for (chunk, sample) in chunks.iter_mut().zip(interleaved) {
                *chunk = sample.to_le_bytes();
            }
        })?;
        self.frames += frames;
        Ok(())
    }

    /// Appends exactly `frames` frames of NaN for lost samples, and a `gap` event.
    ///
    /// # Errors
    /// As [`write_audio`](Self::write_audio).
    pub fn write_gap(&mut self, frames: u64) -> Result<(), WriteError> {
        if frames == 0 {
            return Ok(());
        }
        self.require_room(frames)?;
        self.add_event(RecordingEvent {
            kind: EventKind::Gap,
            sample: self.frames,
            frames: Some(frames),
            text: None,
        });
        let mut rest = frames;
        while rest > 0 {
            let batch = rest.min(GAP_BATCH_FRAMES);
            let samples = batch * u64::from(self.format.channels);
            self.signals.append(|bytes| {
                for _ in 0..samples {
                    bytes.extend(f32::NAN.to_le_bytes());
                }
            })?;
            rest -= batch;
        }
        self.frames += frames;
        Ok(())
    }

    fn require_room(&self, frames: u64) -> Result<(), WriteError> {
        let limit_frames = self.format.max_frames();
        if frames > limit_frames.saturating_sub(self.frames) {
            return Err(WriteError::TooLong {
                limit_frames,
                limit_s: limit_frames as f64 / f64::from(self.format.sample_rate_hz),
            });
        }
        Ok(())
    }

    /// Appends rows to `force.csv`. A time that does not increase is written and marked by a `time_disorder` event.
    ///
    /// # Errors
    /// The operating system refused, or [`WriteError::Time`].
    pub fn write_force(&mut self, rows: &[ForceRow]) -> Result<(), WriteError> {
        let disorder = self.force.write(rows)?;
        self.add_disorder(disorder);
        Ok(())
    }

    /// Appends rows to `position.csv`. A time that does not increase is written and marked by a `time_disorder` event.
    ///
    /// # Errors
    /// The operating system refused, or [`WriteError::Time`].
    pub fn write_position(&mut self, rows: &[PositionRow]) -> Result<(), WriteError> {
        let disorder = self.position.write(rows)?;
        self.add_disorder(disorder);
        Ok(())
    }

    fn add_disorder(&mut self, text: Option<String>) {
        if text.is_some() {
            self.add_event(RecordingEvent {
                kind: EventKind::TimeDisorder,
                sample: self.frames,
                frames: None,
                text,
            });
        }
    }

    /// Adds an event to the manifest; on disk with the next sync. The last event that fits notes that further ones are
    /// omitted.
    pub fn add_event(&mut self, event: RecordingEvent) {
        let events = &mut self.manifest.events;
        match (events.len() + 1).cmp(&MAX_ENTRIES) {
            Ordering::Less => events.push(event),
            Ordering::Equal => events.push(RecordingEvent {
                kind: EventKind::Note,
                sample: event.sample,
                frames: None,
                text: Some("more events followed, which are not listed".to_owned()),
            }),
            Ordering::Greater => return,
        }
        self.manifest_changed = true;
    }

    /// Adds an event as [`add_event`](Self::add_event) does, or replaces the event of the same flag. The flag is not
    /// identified by its sample, because an event found later may have begun before it.
    pub fn renew_event(&mut self, flag: u64, event: RecordingEvent) {
        if let Some(index) = self.flags.get(&flag) {
            self.manifest.events[*index] = event;
            self.manifest_changed = true;
            return;
        }
        let index = self.manifest.events.len();
        if index + 1 < MAX_ENTRIES {
            self.flags.insert(flag, index);
        }
        self.add_event(event);
    }

    /// Sets the state of the clocks that give the times of readings; on disk with the next sync.
    pub fn set_clocks(&mut self, clocks: Vec<RecordedClock>) {
        if self.manifest.clocks != clocks {
            self.manifest.clocks = clocks;
            self.manifest_changed = true;
        }
    }

    /// Adds an interval to the manifest; on disk with the next sync.
    ///
    /// # Errors
    /// The interval violates a rule of the manifest; it is not added.
    pub fn add_interval(&mut self, interval: RecordedInterval) -> Result<(), WriteError> {
        interval.validate(self.manifest.intervals.len())?;
        self.manifest.intervals.push(interval);
        self.manifest_changed = true;
        Ok(())
    }

    /// Returns once all written data are on disk, with their size.
    ///
    /// # Errors
    /// The operating system refused, or the files were removed; then only the data of an earlier sync are saved.
    pub fn sync(&mut self) -> Result<DiskSize, WriteError> {
        self.signals
            .set_head(&wav_files::header(self.format, self.frames))?;
        self.signals.sync()?;
        self.force.file.sync()?;
        self.position.file.sync()?;
        if self.manifest_changed {
            let text = self.manifest.to_toml()?;
            self.replace_manifest(&text)?;
            self.manifest_changed = false;
        }
        self.on_disk = DiskSize {
            frames: self.frames,
            bytes: self.bytes(),
        };
        Ok(self.on_disk)
    }

    fn replace_manifest(&self, text: &str) -> Result<(), DiskError> {
        let path = self.folder.join(MANIFEST_FILE);
        disk::replace_file_on(&*self.storage, &path, text.as_bytes())
    }

    fn bytes(&self) -> u64 {
        self.signals.bytes() + self.force.file.bytes() + self.position.file.bytes()
    }

    /// Ends the recording; it is saved if and only if this returns `Ok`.
    ///
    /// # Errors
    /// [`FinishError`] gives the reason and the size of the saved part.
    pub fn finish(mut self, ending: Ending) -> Result<DiskSize, Box<FinishError>> {
        self.set_end(ending);
        self.sync().map_err(|error| {
            // Readers must not take it for complete.
            self.set_end(Ending::Interrupted {
                reason: error.to_string(),
            });
            Box::new(FinishError {
                error,
                saved_part: self.salvage(),
            })
        })
    }

    /// Saves as much as possible after an error: cuts the files to complete frames and rows, updates the WAV header, and
    /// marks the trial interrupted for `reason`, each as far as the disk still allows. Returns the size of the readable
    /// part.
    #[must_use]
    pub fn abandon(mut self, reason: String) -> DiskSize {
        self.set_end(Ending::Interrupted { reason });
        self.salvage()
    }

    fn set_end(&mut self, ending: Ending) {
        if let Some(trial) = &mut self.manifest.trial {
            (trial.end, trial.interruption) = match ending {
                Ending::Completed => (Some(End::Completed), None),
                Ending::Interrupted { reason } => (Some(End::Interrupted), Some(reason)),
            };
            self.manifest_changed = true;
        }
    }

    /// Cuts the intervals to the length of the saved audio.
    fn end_intervals_at(&mut self, frames: u64) {
        let end_s = frames as f64 / f64::from(self.format.sample_rate_hz);
        let intervals = &mut self.manifest.intervals;
        intervals.retain(|interval| interval.start_s < end_s);
        for interval in intervals {
            interval.end_s = interval.end_s.min(end_s);
        }
    }

    fn salvage(&mut self) -> DiskSize {
        let format = self.format;
        let frames =
            |bytes: u64| bytes.saturating_sub(wav_files::HEADER_BYTES) / format.frame_bytes();
        let signals = self
            .signals
            .salvage(|bytes| wav_files::header(format, frames(bytes)).to_vec());
        let force = self.force.file.salvage(|_| Vec::new());
        let position = self.position.file.salvage(|_| Vec::new());
        if let Ok(bytes) = signals {
            self.end_intervals_at(frames(bytes));
        }
        // Last, because it needs space that a full disk does not have.
        if let Ok(text) = self.manifest.to_toml() {
            let _ = self.replace_manifest(&text);
        }
        match signals {
            Ok(bytes) => DiskSize {
                frames: frames(bytes),
                bytes: bytes + force.unwrap_or(0) + position.unwrap_or(0),
            },
            Err(_) if self.storage.find(&self.folder.join(SIGNALS_FILE)).is_ok() => self.on_disk,
            Err(_) => DiskSize::default(),
        }
    }
}

/// CSV file with a fixed header and increasing times.
#[derive(Debug)]
struct CsvFile {
    name: &'static str,
    file: AppendFile,
    rows: u64,
    last_time_s: f64,
    is_disordered: bool,
}

impl CsvFile {
    fn create<R: CsvRow>(
        storage: &Arc<dyn Storage>,
        folder: &Path,
        name: &'static str,
    ) -> Result<Self, DiskError> {
        let head = R::COLUMNS.required.join(",") + "\n";
        Ok(Self {
            name,
            file: AppendFile::create(storage, folder.join(name), head.as_bytes(), Records::Lines)?,
            rows: 0,
            last_time_s: f64::NEG_INFINITY,
            is_disordered: false,
        })
    }

    /// Writes rows; returns the text of an event the first time that a row's time does not increase.
    fn write<R: CsvRow>(&mut self, rows: &[R]) -> Result<Option<String>, WriteError> {
        let mut disorder = None;
        for row in rows {
            let time_s = row.time_s();
            if !time_s.is_finite() {
                return Err(WriteError::Time {
                    file: self.name,
                    time_s,
                });
            }
            self.rows += 1;
            if time_s <= self.last_time_s && !self.is_disordered {
                self.is_disordered = true;
                disorder = Some(format!(
                    "{}: row {}: {time_s:.6} s after {:.6} s",
                    self.name, self.rows, self.last_time_s
                ));
            }
            self.last_time_s = time_s;
            self.file.append(|line| row.write_line(line))?;
        }
        Ok(disorder)
    }
}
