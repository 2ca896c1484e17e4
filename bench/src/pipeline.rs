//! Samples in, impedance frames and totals out: what a sound card and a file share. A file is a stream that arrives fast.

use std::f64::consts::PI;

use anyhow::Context;
use impedance::{
    Channels, Demodulator, DemodulatorError, Filter, Input, Mask, OUTPUT_RATE_HZ, PlateConstants,
    Settings, Zm, ZmFrame,
};

use crate::recording::manifest::Manifest;
use crate::recording::{AudioFormat, ForceRow, PositionRow};

/// What was acquired since the last batch, on the audio clock: seconds of frames read since the stream was opened.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Batch {
    /// End of what was acquired, s.
    pub audio_s: f64,
    /// Impedance, 2 kHz; lags `audio_s` by the demodulator's delay.
    pub frames: Vec<ZmFrame>,
    /// Force.
    pub force: Vec<ForceRow>,
    /// Position.
    pub position: Vec<PositionRow>,
    /// Totals since the start.
    pub account: Account,
}

/// Account of the frames since the stream was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Frames on the audio clock, the lost ones included.
    pub frames: u64,
    /// Frames lost, written as NaN.
    pub lost_frames: u64,
    /// Envelope frames touched by clipping.
    pub clipped_frames: u64,
    /// Overruns of the input.
    pub input_xruns: u64,
    /// Underruns of the output.
    pub output_xruns: u64,
}

/// |sample| from which on a converter is taken to clip, of full scale.
pub const CLIP_LEVEL: f32 = 0.999;

/// Demodulates one stream.
pub struct Pipeline {
    demodulator: Demodulator<2>,
    zm: Zm,
    channels: usize,
    rate_hz: f64,
    account: Account,
}

/// Lost frames are demodulated in pieces of this many: a gap may be longer than memory should follow.
const LOST_PIECE: u64 = 1024;

impl Pipeline {
    /// For a stream of `channels` interleaved channels.
    pub fn new(demodulator: Demodulator<2>, zm: Zm, channels: usize) -> Self {
        let rate_hz = f64::from(demodulator.filter().settings().sample_rate_hz);
        Self {
            demodulator,
            zm,
            channels,
            rate_hz,
            account: Account::default(),
        }
    }

    /// For the audio of a recording, with the constants that it states.
    ///
    /// # Errors
    /// When sample rate and carrier do not go together.
    pub fn of_recording(manifest: &Manifest, format: AudioFormat) -> anyhow::Result<Self> {
        let filter = Filter::new(Settings {
            sample_rate_hz: format.sample_rate_hz,
            carrier_hz: manifest.carrier_hz,
            output_rate_hz: OUTPUT_RATE_HZ,
        })
        .context("the recording cannot be demodulated")?;
        let zm = recorded_zm(manifest, &filter)?;
        // Recordings of this bench are in parts of full scale; of others the range is unknown.
        let clip_level = if manifest.hardware.is_some() {
            CLIP_LEVEL
        } else {
            f32::INFINITY
        };
        let input = |index: u16| Input {
            channel: usize::from(index),
            clip_level,
        };
        let channels = usize::from(format.channels);
        let demodulator = Demodulator::drive_and_pickup(
            filter,
            channels,
            input(manifest.channels.drive.index),
            input(manifest.channels.pickup.index),
        )?;
        Ok(Self::new(demodulator, zm, channels))
    }

    /// End of what was taken, on the audio clock, s.
    pub fn audio_s(&self) -> f64 {
        self.account.frames as f64 / self.rate_hz
    }

    /// Sample rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Interleaved channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Totals so far.
    pub fn account(&self) -> Account {
        self.account
    }

    /// The stream's own counts of its xruns.
    pub fn count_xruns(&mut self, input: u64, output: u64) {
        self.account.input_xruns = input;
        self.account.output_xruns = output;
    }

    /// Takes interleaved samples and appends the frames that they complete.
    ///
    /// # Errors
    /// When they are not whole frames.
    pub fn take(
        &mut self,
        samples: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulatorError> {
        self.account.frames += (samples.len() / self.channels) as u64;
        let (zm, clipped) = (&self.zm, &mut self.account.clipped_frames);
        self.demodulator.push(samples, |frame| {
            let frame = zm.read(frame);
            *clipped += u64::from(frame.mask.contains(Mask::CLIPPED));
            frames.push(frame);
        })
    }

    /// Takes `lost` frames that never came.
    ///
    /// # Errors
    /// Never; the demodulator's type asks.
    pub fn lose(&mut self, lost: u64, frames: &mut Vec<ZmFrame>) -> Result<(), DemodulatorError> {
        self.account.lost_frames += lost;
        let missing = vec![f32::NAN; LOST_PIECE as usize * self.channels];
        let mut left = lost;
        while left > 0 {
            let piece = left.min(LOST_PIECE);
            self.take(&missing[..piece as usize * self.channels], frames)?;
            left -= piece;
        }
        Ok(())
    }

    /// Takes samples read back from a file, in which lost frames are NaN.
    ///
    /// # Errors
    /// As [`Pipeline::take`].
    pub fn take_recorded(
        &mut self,
        samples: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulatorError> {
        let lost = samples
            .chunks_exact(self.channels)
            .filter(|frame| frame.iter().all(|sample| sample.is_nan()));
        self.account.lost_frames += lost.count() as u64;
        self.take(samples, frames)
    }
}

/// A recording may state a channel or the force factor with the opposite sign; the sign is a phase of half a turn.
fn recorded_zm(manifest: &Manifest, filter: &Filter) -> anyhow::Result<Zm> {
    let Manifest {
        channels, plate, ..
    } = manifest;
    let signs = [
        channels.drive.volts_per_unit,
        channels.pickup.metres_per_unit,
        plate.force_factor_n_per_v,
    ];
    let inverted = signs.iter().filter(|value| **value < 0.0).count() % 2 == 1;
    let zm = Zm::new(
        PlateConstants {
            resonance_hz: plate.resonance_hz,
            modal_mass_kg: plate.modal_mass_kg,
            force_factor_n_per_v: plate.force_factor_n_per_v.abs(),
        },
        Channels {
            drive_volts_per_unit: channels.drive.volts_per_unit.abs(),
            pickup_metres_per_unit: channels.pickup.metres_per_unit.abs(),
            pickup_phase_rad: channels.pickup.phase_rad + if inverted { PI } else { 0.0 },
        },
        filter,
    )?;
    Ok(zm)
}
