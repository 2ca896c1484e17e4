//! Envelopes and impedance of arrays, by the demodulator of the bench.

use std::sync::atomic::{AtomicBool, Ordering};

use impedance::{Demodulator, EnvelopeFrame, Filter, InputChannel, samples_per_frame};
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::RecordingSource;
use recording::pipeline::{DemodulationError, Pipeline};
use recording::reader::ReadError;
use recording::recorded_arrays::Samples;

use crate::analyze_arrays::DriveAndPickup;
use crate::arrays::Signal;
use crate::background;
use crate::description::{Description, whole_rate_hz};
use crate::error::refusal;

/// Samples demodulated between two looks at a pending Ctrl-C.
const BLOCK_FRAMES: usize = 16_384;

/// Complex values and their times, s.
type Series = (Vec<Complex64>, Vec<f64>);
type SeriesArrays<'py> = (Bound<'py, PyArray1<Complex64>>, Bound<'py, PyArray1<f64>>);

/// Reasons why signals cannot be demodulated.
#[derive(Debug, thiserror::Error)]
enum SignalError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Demodulation(#[from] DemodulationError),
}

/// Return the impedance of drive and pickup and its times; `description` has the content of their `recording.toml`.
#[pyfunction]
#[pyo3(signature = (drive, pickup, rate_hz, description, *, corrected))]
pub(crate) fn impedance_of_arrays<'py>(
    py: Python<'py>,
    drive: &Bound<'py, PyAny>,
    pickup: &Bound<'py, PyAny>,
    rate_hz: f64,
    description: &Bound<'py, PyDict>,
    corrected: bool,
) -> PyResult<SeriesArrays<'py>> {
    let signals = DriveAndPickup::read(drive, pickup)?;
    let description = Description::read(description, rate_hz)?;
    let arrays = signals.recorded(description)?;
    let series = background::run_borrowed(py, None, |stop| {
        let source = RecordingSource::arrays(&arrays).with_stop(stop);
        impedance_series(&source, corrected)
    })?;
    Ok(into_arrays(py, series.map_err(refusal)?))
}

/// Return the envelope of a signal about its carrier, and its times.
#[pyfunction]
pub(crate) fn envelopes<'py>(
    py: Python<'py>,
    signal: &Bound<'py, PyAny>,
    rate_hz: f64,
    carrier_hz: f64,
) -> PyResult<SeriesArrays<'py>> {
    whole_rate_hz(rate_hz)?;
    let samples = Signal::read(signal, "`signal`")?;
    let samples = samples.samples()?;
    let series = background::run_borrowed(py, None, |stop| {
        envelope_series(samples, (rate_hz, carrier_hz), stop)
    })?;
    Ok(into_arrays(py, series.map_err(refusal)?))
}

/// Return the array of which the samples are read.
#[pyfunction]
pub(crate) fn as_samples<'py>(values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    Ok(match Signal::read(values, "`values`")? {
        Signal::Single(samples) => samples.as_any().clone(),
        Signal::Double(samples) => samples.as_any().clone(),
    })
}

fn impedance_series(source: &RecordingSource<'_>, corrected: bool) -> Result<Series, SignalError> {
    let mut reader = source.signals()?;
    let mut pipeline = Pipeline::from_recording(reader.manifest(), reader.format())?;
    let (mut block, mut frames, mut series) = (Vec::new(), Vec::new(), Series::default());
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        pipeline
            .process(&block, &mut frames)
            .map_err(DemodulationError::from)?;
        for frame in frames.drain(..) {
            series.0.push(match corrected {
                true => frame.corrected_n_s_per_m,
                false => frame.plain_n_s_per_m,
            });
            series.1.push(frame.time_s);
        }
    }
    Ok(series)
}

fn envelope_series(
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

fn into_arrays(py: Python<'_>, (values, time_s): Series) -> SeriesArrays<'_> {
    (values.into_pyarray(py), time_s.into_pyarray(py))
}
