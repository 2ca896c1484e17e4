//! Envelopes and impedance of arrays, by the demodulator of the bench.

use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::RecordingSource;
use recording::pipeline::{DemodulationError, Pipeline};
use report::in_arguments;

use crate::analyze_arrays::DriveAndPickup;
use crate::arrays::Signal;
use crate::background;
use crate::description::{Description, whole_rate_hz};
use crate::envelope_series::{BLOCK_FRAMES, Series, SignalError, envelope_series};
use crate::error::refusal;

type SeriesArrays<'py> = (Bound<'py, PyArray1<Complex64>>, Bound<'py, PyArray1<f64>>);

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
    let description = Description::read(description, rate_hz, &signals.drive)?;
    let arrays = signals.recorded(description)?;
    let series = background::run_borrowed(py, None, |stop| {
        let source = RecordingSource::arrays(&arrays).with_stop(stop);
        impedance_series(&source, corrected)
    })?;
    let series = series.map_err(|error| refusal(in_arguments(&error.to_string())))?;
    Ok(into_arrays(py, series))
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

fn into_arrays(py: Python<'_>, (values, time_s): Series) -> SeriesArrays<'_> {
    (values.into_pyarray(py), time_s.into_pyarray(py))
}
