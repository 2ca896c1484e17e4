//! Impedances of a recording as they would arrive live, from raw signals or from envelopes.

use std::path::Path;

use analysis::demodulation::EnvelopeDemodulator;
use analysis::vibration::Vibration;
use anyhow::Context;
use recording::RecordingReader;
use recording::manifest::{Manifest, Streams};
use recording::pipeline::{Account, Batch, PickupOffset, Pipeline};
use recording::reader::{Warning, read_manifest};

/// Frames of audio per read.
const BLOCK_FRAMES: usize = 4096;

/// Impedances of a recording.
pub(crate) enum Film {
    /// Raw signals through the live pipeline.
    Signals(Box<Signals>),
    /// Envelopes through the filter that follows a demodulator.
    Envelopes(Box<Envelopes>),
}

/// Raw signals.
pub(crate) struct Signals {
    reader: RecordingReader,
    pipeline: Pipeline,
    block: Vec<f32>,
}

/// Envelopes, with the length of the recording, s.
pub(crate) struct Envelopes {
    manifest: Manifest,
    demodulator: EnvelopeDemodulator,
    duration_s: f64,
}

impl Film {
    /// Opens the recording in `folder`.
    pub(crate) fn open(folder: &Path) -> anyhow::Result<(Self, Vibration)> {
        let manifest = read_manifest(folder)?;
        let shown = folder.display();
        let vibration = |manifest: &Manifest| {
            Vibration::stated(manifest).with_context(|| {
                format!("{shown}: its carrier moves, and a replay needs a steady one: `friction-bench analyze {shown}` reads it")
            })
        };
        match &manifest.streams {
            Streams::Signals(_) => {
                let reader = RecordingReader::open(folder)?;
                let vibration = vibration(&manifest)?;
                let pipeline = Pipeline::from_recording(reader.manifest(), reader.format())
                    .context("the recording cannot be demodulated")?;
                let signals = Signals {
                    reader,
                    pipeline,
                    block: Vec::new(),
                };
                Ok((Self::Signals(Box::new(signals)), vibration))
            }
            Streams::Envelopes(_) => {
                let vibration = vibration(&manifest)?;
                let open = || {
                    let description = (&manifest, &vibration);
                    EnvelopeDemodulator::open(folder, description, PickupOffset::default())
                };
                let mut all = open()?;
                all.read_until(f64::INFINITY, |_| ())?;
                let (duration_s, demodulator) = (all.end_s(), open()?);
                let envelopes = Envelopes {
                    manifest,
                    demodulator,
                    duration_s,
                };
                Ok((Self::Envelopes(Box::new(envelopes)), vibration))
            }
            Streams::Forces(_) => anyhow::bail!(
                "{shown} has forces alone, and a replay shows the plate and the film under the finger: `friction-bench analyze {shown}` \
                 gives the friction of each stroke, `friction-bench export {shown} --to FOLDER --as csv` its friction over time"
            ),
        }
    }

    /// Returns the manifest of the recording.
    pub(crate) fn manifest(&self) -> &Manifest {
        match self {
            Self::Signals(signals) => signals.reader.manifest(),
            Self::Envelopes(envelopes) => &envelopes.manifest,
        }
    }

    /// Returns the rate of samples or envelopes, Hz.
    pub(crate) fn rate_hz(&self) -> f64 {
        match self {
            Self::Signals(signals) => signals.reader.rate_hz(),
            Self::Envelopes(envelopes) => envelopes.demodulator.rate_hz(),
        }
    }

    /// Returns the length of the recording, s.
    pub(crate) fn duration_s(&self) -> f64 {
        match self {
            Self::Signals(signals) => signals.reader.duration_s(),
            Self::Envelopes(envelopes) => envelopes.duration_s,
        }
    }

    /// Returns the defects found so far.
    pub(crate) fn warnings(&self) -> &[Warning] {
        match self {
            Self::Signals(signals) => signals.reader.warnings(),
            Self::Envelopes(_) => &[],
        }
    }

    /// Reads on to `until_s`, with the account so far; returns whether more follows.
    pub(crate) fn read_until(&mut self, until_s: f64, batch: &mut Batch) -> anyhow::Result<bool> {
        match self {
            Self::Signals(signals) => signals.read_until(until_s, batch),
            Self::Envelopes(envelopes) => {
                let demodulator = &mut envelopes.demodulator;
                let follows = demodulator.read_until(until_s, |frame| batch.frames.push(frame))?;
                let (frames, [drive, pickup]) = demodulator.counts();
                batch.audio_s = if follows {
                    demodulator.time_s().min(envelopes.duration_s)
                } else {
                    envelopes.duration_s
                };
                batch.account = Account {
                    frames,
                    lost_frames: drive.max(pickup),
                    ..Account::default()
                };
                Ok(follows)
            }
        }
    }
}

impl Signals {
    fn read_until(&mut self, until_s: f64, batch: &mut Batch) -> anyhow::Result<bool> {
        let end_frame = (until_s * self.pipeline.rate_hz()) as u64;
        let mut follows = true;
        while follows {
            let missing_frames = end_frame.saturating_sub(self.pipeline.account().frames);
            if missing_frames == 0 {
                break;
            }
            let block = usize::try_from(missing_frames)
                .map_or(BLOCK_FRAMES, |frames| frames.min(BLOCK_FRAMES));
            follows = self.reader.read_block(block, &mut self.block)? > 0;
            self.pipeline
                .process_recorded(&self.block, &mut batch.frames)?;
        }
        batch.audio_s = self.pipeline.audio_s();
        batch.account = self.pipeline.account();
        Ok(follows)
    }
}
