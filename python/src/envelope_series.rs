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

/// Returns the modulation of a drive, of which a value of 1 is `volts_per_unit`.
///
/// # Errors
/// The carrier cannot be demodulated at this rate, or the drive is off, or on too briefly.
pub(crate) fn modulation(
    py: Python<'_>,
    drive: &Signal<'_>,
    (rate_hz, carrier_hz, volts_per_unit): (f64, f64, f64),
) -> PyResult<FoundModulation> {
    let samples = drive.samples()?;
    let read = background::run_borrowed(py, None, |stop| {
        let series = envelope_series(samples, (rate_hz, carrier_hz), stop)?;
        Ok::<_, SignalError>((series, rms(samples)))
    })?;
    let ((envelope, time_s), rms) = read.map_err(refusal)?;
    let scale = volts_per_unit.abs();
    let amplitude_v: Vec<f64> = envelope.iter().map(|value| scale * value.norm()).collect();
    let step_s = time_s.get(1).zip(time_s.first()).map(|(b, a)| b - a);
    let step_s = step_s.unwrap_or(1.0 / rate_hz);
    drive_modulation::require(&amplitude_v, step_s, scale * rms).map_err(|error| {
        refusal(format_args!(
            "`modulation_hz` and `modulation_index` cannot be found in `drive`: {error}. Pass the voltage across the actuators as \
             `drive`, correct `carrier_hz`, or state both"
        ))
    })
}

/// Returns the RMS of the samples that are not lost.
fn rms(samples: Samples<'_>) -> f64 {
    let (mut squares, mut count) = (0.0, 0_u64);
    let mut take = |value: f64| {
        if value.is_finite() {
            squares += value * value;
            count += 1;
        }
    };
    match samples {
        Samples::Single(samples) => samples.iter().for_each(|sample| take(f64::from(*sample))),
        Samples::Double(samples) => samples.iter().for_each(|sample| take(*sample)),
    }
    (squares / count.max(1) as f64).sqrt()
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
