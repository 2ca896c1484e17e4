//! Impedance frames of a recording with a carrier that moves.

use impedance::moving_carrier::{CarrierTrack, MovingCarrierError, MovingDemodulator, referred};
use impedance::{ConstantError, EnvelopeFrame, Filter, ZmFrame};

use crate::AudioFormat;
use crate::manifest::{Manifest, RecordedSignals};
use crate::pipeline::{DemodulationError, SignalProperties};
use crate::recorded_chain::{recorded_inputs, recorded_zm, sample_rate_hz};

/// Demodulator of the signals of a recording, at the frequency that the drive has.
pub struct MovingPipeline {
    demodulator: MovingDemodulator,
    signals: RecordedSignals,
    properties: SignalProperties,
    reference_hz: f64,
}

impl MovingPipeline {
    /// Creates a pipeline for the audio of a recording with its carrier along `track`. Impedances are referred to the mean
    /// frequency.
    ///
    /// # Errors
    /// The recording has no raw signals, or sampling rate, carrier and constants are not compatible.
    pub fn new(
        manifest: &Manifest,
        format: AudioFormat,
        properties: SignalProperties,
        track: CarrierTrack,
    ) -> Result<Self, DemodulationError> {
        let signals = manifest
            .signals()
            .ok_or(DemodulationError::NoSteadyCarrier)?;
        let rate_hz = sample_rate_hz(signals, format);
        let inputs = recorded_inputs(manifest, signals, &properties);
        let reference_hz = track.mean_hz();
        let channels = usize::from(format.channels);
        Ok(Self {
            demodulator: MovingDemodulator::new(track, rate_hz, channels, inputs)?,
            signals: signals.clone(),
            properties,
            reference_hz,
        })
    }

    /// Processes interleaved samples and appends the completed frames.
    ///
    /// # Errors
    /// The samples are not whole frames, or the carrier leaves the band of the sampling rate.
    pub fn process(
        &mut self,
        samples: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulationError> {
        self.advance(frames, |demodulator, emit| demodulator.push(samples, emit))
    }

    /// Appends the frames at the end of the recording.
    ///
    /// # Errors
    /// As [`process`](Self::process).
    pub fn finish(&mut self, frames: &mut Vec<ZmFrame>) -> Result<(), DemodulationError> {
        self.advance(frames, |demodulator, emit| demodulator.finish(emit))
    }

    fn advance(
        &mut self,
        frames: &mut Vec<ZmFrame>,
        run: impl FnOnce(
            &mut MovingDemodulator,
            &mut dyn FnMut(&EnvelopeFrame<2>, &Filter),
        ) -> Result<(), MovingCarrierError>,
    ) -> Result<(), DemodulationError> {
        let plate = self.signals.plate.constants();
        let (signals, properties, reference_hz) =
            (&self.signals, &self.properties, self.reference_hz);
        let mut constant_error: Option<ConstantError> = None;
        run(
            &mut self.demodulator,
            &mut |envelopes, filter| match recorded_zm(signals, properties, filter) {
                Ok(zm) => {
                    let frame = zm.read(envelopes);
                    frames.push(referred(frame, envelopes, filter, &plate, reference_hz));
                }
                Err(error) => constant_error = Some(error),
            },
        )?;
        constant_error.map_or(Ok(()), |error| Err(error.into()))
    }
}
