//! Inputs for the safety watch during a calibration.

use config::Config;
use devices::CardPace;
use safety::{DriveReading, Signals};
use signalgen::BlockHeader;

use crate::recent::Recent;

/// Span over which the read-back for the safety watch is averaged, s.
const READBACK_S: f64 = 1e-3;

/// Inputs of drive and pickup, with the constants known so far.
pub(super) struct WatchedInputs {
    /// Number of inputs of the stream.
    inputs: usize,
    /// Input of the drive's read-back.
    pub(super) drive: usize,
    pickup: usize,
    /// Actuator volts per sample value.
    pub(super) volts_per_unit: f64,
    /// Plate displacement per sample value, m.
    pub(super) metres_per_unit: f64,
    pace: CardPace,
    /// Drive and pickup.
    recent: [Recent; 2],
    /// Number of frames read so far.
    frames: u64,
}

impl WatchedInputs {
    /// Creates a watch on a stream with `inputs` inputs.
    pub(super) fn new(config: &Config, inputs: usize) -> Self {
        let span = (READBACK_S * f64::from(config.audio.rate_hz)) as usize;
        Self {
            inputs,
            drive: usize::from(config.channels.drive.index),
            pickup: usize::from(config.channels.pickup.index),
            volts_per_unit: config.channels.drive.volts_per_unit,
            metres_per_unit: config.channels.pickup.metres_per_unit,
            pace: CardPace::new(f64::from(config.audio.rate_hz)),
            recent: [(); 2].map(|()| Recent::new(span)),
            frames: 0,
        }
    }

    /// Returns the inputs of drive and pickup.
    pub(super) fn channels(&self) -> [usize; 2] {
        [self.drive, self.pickup]
    }

    /// Publishes the peak amplitudes of the drive's read-back and of the pickup, at any frequency, for the safety watch.
    ///
    /// # Errors
    /// If the card has delivered far more than its rate allows.
    pub(super) fn publish(
        &mut self,
        block: &[f32],
        header: &BlockHeader,
        now_ns: u64,
        signals: &Signals,
    ) -> anyhow::Result<()> {
        self.pace.take(header, now_ns)?;
        self.frames += (block.len() / self.inputs) as u64;
        let channels = self.channels();
        for (recent, channel) in self.recent.iter_mut().zip(channels) {
            recent.take(block, self.inputs, channel);
        }
        let [drive, pickup] = &self.recent;
        // Computed with the constants known so far; it serves the estimate of the plate's temperature.
        if let Some(amplitude) = pickup.amplitude() {
            signals.amplitude_m.set(amplitude * self.metres_per_unit);
        }
        if let Some(amplitude) = drive.amplitude() {
            signals.readback.set(DriveReading {
                volts: amplitude * self.volts_per_unit,
                // Middle of the averaged samples.
                sample: self.frames - drive.len() as u64 / 2,
                ahead: header.drive.frames as i64 - self.frames as i64,
                at_ns: now_ns,
            });
        }
        Ok(())
    }
}
