//! Checks on the samples of a recording.

use std::f64::consts::TAU;
use std::path::Path;

use num_complex::Complex64;
use recording::RecordingReader;
use recording::manifest::{End, Manifest};
use recording::study::event_log::{ExitStatus, LogEvent};

use crate::session::SessionFolder;

/// A recording in memory.
pub struct Recording {
    /// `recording.toml`.
    pub manifest: Manifest,
    /// Warnings of the reader, as text.
    pub warnings: Vec<String>,
    /// Frames per second.
    pub rate_hz: u32,
    /// Number of channels.
    pub channels: usize,
    /// Interleaved samples.
    pub samples: Vec<f32>,
}

impl Recording {
    /// Reads the recording folder at `path`.
    pub fn read(path: &Path) -> Self {
        let mut reader = RecordingReader::open(path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let format = reader.format();
        let channels = usize::from(format.channels);
        let mut samples = Vec::with_capacity(reader.frames() as usize * channels);
        let mut block = Vec::new();
        loop {
            let frames = reader
                .read_block(1 << 16, &mut block)
                .expect("readable audio");
            if frames == 0 {
                break;
            }
            samples.extend_from_slice(&block[..frames * channels]);
        }
        Self {
            manifest: reader.manifest().clone(),
            warnings: reader.warnings().iter().map(ToString::to_string).collect(),
            rate_hz: format.sample_rate_hz,
            channels,
            samples,
        }
    }

    /// Returns the number of audio frames.
    pub fn frames(&self) -> usize {
        self.samples.len() / self.channels
    }

    /// Returns the length of the audio, s.
    pub fn duration_s(&self) -> f64 {
        self.frames() as f64 / f64::from(self.rate_hz)
    }

    /// Returns the number of samples that are not finite.
    pub fn nonfinite_samples(&self) -> usize {
        self.samples
            .iter()
            .filter(|sample| !sample.is_finite())
            .count()
    }

    /// Returns the phase of the drive's carrier in blocks of 1 ms, each a whole number of cycles, against an oscillator that
    /// counts every frame: one frame lost or repeated turns all later phases by 65.6° at 192 kHz. Blocks below a tenth of the
    /// greatest amplitude are left out.
    pub fn drive_phases_rad(&self) -> Vec<f64> {
        let block = (self.rate_hz / 1000) as usize;
        let signals = self.manifest.signals().expect("raw signals");
        let cycles = self.manifest.carrier_hz().expect("a steady carrier") / 1000.0;
        assert!(cycles.fract() == 0.0, "pieces of whole cycles");
        let oscillator: Vec<_> = (0..block)
            .map(|k| Complex64::cis(-TAU * cycles * k as f64 / block as f64))
            .collect();
        let index = usize::from(signals.channels.drive.index);
        let envelope: Vec<Complex64> = self
            .samples
            .chunks_exact(block * self.channels)
            .map(|frames| {
                let drive = frames.iter().skip(index).step_by(self.channels);
                drive.zip(&oscillator).map(|(&x, o)| o * f64::from(x)).sum()
            })
            .collect();
        let greatest = envelope
            .iter()
            .map(|block| block.norm())
            .fold(0.0, f64::max);
        envelope
            .iter()
            .filter(|block| block.norm() > 0.1 * greatest)
            .map(|block| block.arg())
            .collect()
    }

    /// Returns the greatest deviation of the drive's carrier phase from its first value, rad.
    pub fn greatest_phase_step_rad(&self) -> f64 {
        let phases = self.drive_phases_rad();
        assert!(
            phases.len() > 100,
            "the drive sounds: {} pieces",
            phases.len()
        );
        phases
            .iter()
            .map(|phase| Complex64::cis(phase - phases[0]).arg().abs())
            .fold(0.0, f64::max)
    }
}

/// Requires each recording of a completed session on the simulated bench to have every sample in its place; returns the number
/// of recordings. In real time the length of a recording may differ from the log's times by `tolerance` frames.
///
/// # Panics
/// When a recording does not.
pub fn require_every_sample(session: &SessionFolder, tolerance: usize) -> usize {
    let recordings = session.recordings();
    for (index, path) in recordings.iter().enumerate() {
        let recording = Recording::read(path);
        let audio_s = |event: Option<&LogEvent>| event.expect("an event of each trial").audio_s;
        let began_s = audio_s(session.named("trial_began").nth(index));
        let ended_s = audio_s(session.phases("verdict").nth(index));
        let frames = ((ended_s - began_s) * 192_000.0).round() as usize;
        let name = path.display();
        let error = recording.frames().abs_diff(frames);
        assert!(error <= tolerance, "{name}: {error} frames off");
        assert_eq!(recording.channels, 4, "{name}");
        assert_eq!(recording.nonfinite_samples(), 0, "{name}");
        assert!(recording.greatest_phase_step_rad() < 0.01, "{name}");
    }
    recordings.len()
}

/// Requires a session to have been interrupted in its first recording and to have ended in good order; returns that recording.
///
/// # Panics
/// When it did not.
pub fn require_orderly_interruption(session: &SessionFolder) -> Recording {
    let stop = session.stops()[0];
    assert_eq!(stop.exit_status, ExitStatus::Abort);
    assert_eq!(stop.reason.as_deref(), Some("stopped before its end"));
    let recording = Recording::read(&session.recordings()[0]);
    assert_eq!(recording.warnings, Vec::<String>::new());
    let end = recording
        .manifest
        .trial
        .as_ref()
        .and_then(|trial| trial.end);
    assert_eq!(end, Some(End::Interrupted));
    assert!(recording.duration_s() > 1.0, "{} s", recording.duration_s());
    assert_eq!(recording.nonfinite_samples(), 0);
    let event = session.events().last().map(|event| &event.data);
    let event = event.expect("the recording's event, last of all");
    assert_eq!(event.get("interrupted"), Some(&true.into()), "{event:?}");
    // A busy computer may have no time for the checksums.
    let sums = event.get("sha256").and_then(|sums| sums.as_object());
    assert!(sums.is_none_or(|sums| sums.len() == 4), "{event:?}");
    session.require_whole();
    recording
}
