//! Analysis of a recording in memory.

use protocols::Protocol;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::RecordingSource;
use recording::recorded_arrays::{self, RecordedArrays};
use report::in_arguments;
use study::provenance::StatedProvenance;
use study_analysis::StudyAnalysis;

use crate::analysis::Analysis;
use crate::arrays::{Readings, Signal};
use crate::background;
use crate::description::{Description, rule_refusal};
use crate::error::{FrictionBenchError, refusal};
use crate::settings::assumptions;

/// Analyse one recording of arrays; `description` has the content of its `recording.toml`.
#[pyfunction]
#[pyo3(signature = (drive, pickup, rate_hz, description, *, normal=None, lateral=None, position=None, protocol=None, settings=None, simulated=false, uncalibrated=false, progress=None))]
#[allow(clippy::too_many_arguments, reason = "the keywords of Python")]
pub(crate) fn analyze_arrays(
    py: Python<'_>,
    drive: &Bound<'_, PyAny>,
    pickup: &Bound<'_, PyAny>,
    rate_hz: f64,
    description: &Bound<'_, PyDict>,
    normal: Option<&Bound<'_, PyAny>>,
    lateral: Option<&Bound<'_, PyAny>>,
    position: Option<&Bound<'_, PyAny>>,
    protocol: Option<&str>,
    settings: Option<&Bound<'_, PyAny>>,
    simulated: bool,
    uncalibrated: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Analysis> {
    let settings = assumptions(settings)?;
    let signals = DriveAndPickup::read(drive, pickup)?;
    let description = Description::read(description, rate_hz, &signals.drive)?;
    let normal = normal
        .map(|pair| Readings::read(pair, "normal"))
        .transpose()?;
    let lateral = lateral
        .map(|pair| Readings::read(pair, "lateral"))
        .transpose()?;
    let position = position
        .map(|pair| Readings::read(pair, "position"))
        .transpose()?;
    let protocol = protocol.map(|text| Protocol::parse(text, "protocol"));
    let arrays = signals
        .recorded(description)?
        .with_forces(columns(normal.as_ref())?, columns(lateral.as_ref())?)
        .with_position(columns(position.as_ref())?)
        .with_protocol(protocol.transpose().map_err(refusal)?);
    let stated = StatedProvenance {
        simulated,
        uncalibrated,
    };
    let study = background::run_borrowed(py, progress, |stop| {
        let source = RecordingSource::arrays(&arrays).with_stop(stop);
        StudyAnalysis::in_memory(&source, &settings, stated)
    })?;
    let study = study.map_err(|error| refusal(in_arguments(&error.to_string())))?;
    Ok(Analysis::new(study))
}

/// Drive and pickup, sampled at the same times.
pub(crate) struct DriveAndPickup<'py> {
    pub(crate) drive: Signal<'py>,
    pickup: Signal<'py>,
}

impl<'py> DriveAndPickup<'py> {
    /// Reads both signals.
    ///
    /// # Errors
    /// One of them cannot be used, or they have different lengths.
    pub(crate) fn read(drive: &Bound<'py, PyAny>, pickup: &Bound<'py, PyAny>) -> PyResult<Self> {
        let signals = Self {
            drive: Signal::read(drive, "`drive`")?,
            pickup: Signal::read(pickup, "`pickup`")?,
        };
        let (drive, pickup) = (signals.drive.len(), signals.pickup.len());
        if drive != pickup {
            return Err(FrictionBenchError::new_err(format!(
                "`drive` has {drive} samples and `pickup` {pickup}: pass both over the same time"
            )));
        }
        Ok(signals)
    }

    /// Returns the recording of these signals.
    ///
    /// # Errors
    /// The description does not fit them.
    pub(crate) fn recorded(&self, description: Description) -> PyResult<RecordedArrays<'_>> {
        let signals = [self.drive.samples()?, self.pickup.samples()?];
        RecordedArrays::new(description.manifest, description.sample_rate_hz, signals)
            .map_err(|rule| rule_refusal(&rule))
    }
}

fn columns<'a>(
    readings: Option<&'a Readings<'_>>,
) -> PyResult<Option<recorded_arrays::Readings<'a>>> {
    let columns = readings.map(|readings| {
        Ok(recorded_arrays::Readings {
            time_s: readings.time_s.as_slice()?,
            values: readings.values.as_slice()?,
        })
    });
    columns.transpose()
}
