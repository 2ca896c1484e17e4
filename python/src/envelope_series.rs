//! Envelope of a signal, by the demodulator of the bench, and the modulation of a drive.

use std::sync::atomic::{AtomicBool, Ordering};

use impedance::{Demodulator, EnvelopeFrame, Filter, InputChannel, samples_per_frame};
use metrology::drive_modulation::{self, FoundModulation};
use num_complex::Complex64;
use pyo3::prelude::*;
use recording::pipeline::DemodulationError;
use recording::reader::ReadError;
use recording::recorded_arrays::Samples;

use crate::arrays::Signal;
use crate::background;
use crate::error::refusal;

/// Samples demodulated between two looks at a pending Ctrl-C.
pub(crate) const BLOCK_FRAMES: usize = 16_384;

/// Complex values and their times, s.
pub(crate) type Series = (Vec<Complex64>, Vec<f64>);
/// Reasons why signals cannot be demodulated.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SignalError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Demodulation(#[from] DemodulationError),
}

/// Returns the modulation of a drive; `None` if it is on for too short a time.
///
/// # Errors
/// The carrier cannot be demodulated at this rate.
pub(crate) fn modulation(
    py: Python<'_>,
    drive: &Signal<'_>,
    (rate_hz, carrier_hz): (f64, f64),
) -> PyResult<Option<FoundModulation>> {
    let samples = drive.samples()?;
    let series = background::run_borrowed(py, None, |stop| {
        envelope_series(samples, (rate_hz, carrier_hz), stop)
    })?;
    let (envelope, time_s) = series.map_err(refusal)?;
    let amplitude: Vec<f64> = envelope.iter().map(|value| value.norm()).collect();
    let step_s = time_s.get(1).zip(time_s.first()).map(|(b, a)| b - a);
    Ok(step_s.and_then(|step_s| drive_modulation::find(&amplitude, step_s)))
}

/// Returns the envelope about the carrier with its times, unless `stop` is set.
///
/// # Errors
/// The carrier cannot be demodulated at this rate, or the analysis was asked to stop.
pub(crate) fn envelope_series(
    samples: Samples<'_>,
    (rate_hz, carrier_hz): (f64, f64),
    stop: &AtomicBool,
) -> Result<Series, SignalError> {
    let filter = Filter::with_hop(rate_hz, carrier_hz, samples_per_frame(rate_hz))
        .map_err(DemodulationError::from)?;
    let input = InputChannel {
        channel: 0,
        clip_level: f32::INFINITY,
    };
    let demodulator = Demodulator::new(filter, 1, [input]);
    let mut demodulator = demodulator.map_err(DemodulationError::from)?;
    let mut series = Series::default();
    let mut push = |block: &[f32]| -> Result<(), SignalError> {
        if stop.load(Ordering::Relaxed) {
            return Err(ReadError::Stopped.into());
        }
        let emit = |frame: &EnvelopeFrame<1>| {
            let [envelope] = frame.envelopes;
            series.0.push(envelope.value);
            series.1.push(frame.time_s);
        };
        let pushed = demodulator.push(block, emit);
        Ok(pushed.map_err(DemodulationError::from)?)
    };
    match samples {
        Samples::Single(samples) => samples.chunks(BLOCK_FRAMES).try_for_each(push)?,
        Samples::Double(samples) => samples.chunks(BLOCK_FRAMES).try_for_each(|block| {
            let block: Vec<f32> = block.iter().map(|sample| *sample as f32).collect();
            push(&block)
        })?,
    }
    Ok(series)
}
