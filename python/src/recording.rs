//! Recordings as arrays.

use std::path::{Path, PathBuf};

use analysis::recording_analysis::protocol_text;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use recording::manifest::{RecordedIntervalKind, Streams};
use recording::reader::{self, ReadError};
use recording::{CsvRow, ForceRow, Manifest, PositionRow, RecordingReader};
use study::provenance::Provenance;
use study::sessions::Sessions;

use crate::background;
use crate::error::refusal;

/// Frames per read.
const BLOCK_FRAMES: usize = 1 << 16;

/// Content of a recording's files.
struct Content {
    manifest: Manifest,
    signals: Option<Signals>,
    forces: Option<Vec<ForceRow>>,
    positions: Option<Vec<PositionRow>>,
    protocol: Option<String>,
    simulated: bool,
}

/// Drive and pickup, in the unit of their file.
struct Signals {
    rate_hz: f64,
    drive: Vec<f32>,
    pickup: Vec<f32>,
}

/// Recording as arrays, as `friction_bench.read` returns it.
///
/// A stream that the recording does not have raises FrictionBenchError.
#[pyclass(frozen, module = "friction_bench")]
pub(crate) struct Recording {
    path: PathBuf,
    content: Manifest,
    /// Description of the recording, by the keys of recording.toml.
    #[pyo3(get)]
    manifest: Py<PyDict>,
    signals: Option<SampledSignals>,
    normal: Option<Py<PyTuple>>,
    lateral: Option<Py<PyTuple>>,
    position: Option<Py<PyTuple>>,
    /// Text of the protocol's copy in the session's folder.
    protocol: Option<String>,
    /// Whether the bench was simulated, by the session's log.
    #[pyo3(get)]
    simulated: bool,
}

/// Drive and pickup as arrays.
struct SampledSignals {
    rate_hz: f64,
    drive: Py<PyArray1<f32>>,
    pickup: Py<PyArray1<f32>>,
}

/// Read a recording's folder.
#[pyfunction]
pub(crate) fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<Recording> {
    let folder = path.clone();
    let content = background::run(py, 0, None, move |_| read(&folder))?.map_err(refusal)?;
    let manifest = dict(py, &content.manifest)?;
    let signals = content.signals.map(|signals| SampledSignals {
        rate_hz: signals.rate_hz,
        drive: PyArray1::from_vec(py, signals.drive).unbind(),
        pickup: PyArray1::from_vec(py, signals.pickup).unbind(),
    });
    let forces = content.forces.as_deref();
    let positions = content.positions.as_deref();
    Ok(Recording {
        normal: pair(py, forces, |row| row.normal_n)?,
        lateral: pair(py, forces, |row| row.lateral_n)?,
        position: pair(py, positions, |row| row.position_m)?,
        path,
        protocol: content.protocol,
        simulated: content.simulated,
        content: content.manifest,
        manifest: manifest.unbind(),
        signals,
    })
}

/// Reads the files of a recording.
fn read(folder: &Path) -> Result<Content, ReadError> {
    let manifest = reader::read_manifest(folder)?;
    let signals = match manifest.streams {
        Streams::Signals(_) => Some(signals(folder)?),
        Streams::Envelopes(_) | Streams::Forces(_) => None,
    };
    let duration_s = signals.as_ref().map_or(f64::INFINITY, |signals| {
        signals.drive.len() as f64 / signals.rate_hz
    });
    let sessions = Sessions::from_recordings([folder]);
    let session = sessions.session_of(folder).map(|(_, session)| session);
    Ok(Content {
        simulated: Provenance::new(&manifest, session).simulated,
        signals,
        forces: rows(reader::force_rows(folder, duration_s))?,
        positions: rows(reader::position_rows(folder, duration_s))?,
        protocol: protocol_text(folder, &manifest),
        manifest,
    })
}

fn signals(folder: &Path) -> Result<Signals, ReadError> {
    let mut reader = RecordingReader::open(folder)?;
    let places = reader.manifest().signals().map(|signals| {
        let (drive, pickup) = (&signals.channels.drive, &signals.channels.pickup);
        [drive.index, pickup.index].map(usize::from)
    });
    let [drive_place, pickup_place] = places.unwrap_or_default();
    let channels = usize::from(reader.format().channels);
    let frames = usize::try_from(reader.frames()).unwrap_or(0);
    let mut signals = Signals {
        rate_hz: reader.rate_hz(),
        drive: Vec::with_capacity(frames),
        pickup: Vec::with_capacity(frames),
    };
    let mut block = Vec::new();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        for frame in block.chunks_exact(channels) {
            signals.drive.push(frame[drive_place]);
            signals.pickup.push(frame[pickup_place]);
        }
    }
    Ok(signals)
}

/// Returns the rows of a file; `None` if it does not exist.
fn rows<R: CsvRow>(
    rows: Result<reader::RowReader<R>, ReadError>,
) -> Result<Option<Vec<R>>, ReadError> {
    match rows {
        Ok(rows) => rows.collect::<Result<_, _>>().map(Some),
        Err(ReadError::Absent { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Returns a value as the dict of its keys in recording.toml.
fn dict<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyDict>> {
    let text = serde_json::to_string(value).map_err(refusal)?;
    let value = py.import("json")?.call_method1("loads", (text,))?;
    Ok(value.cast_into()?)
}

/// Returns the pair of times and values of a column.
fn pair<R: CsvRow>(
    py: Python<'_>,
    rows: Option<&[R]>,
    value: impl Fn(&R) -> f64,
) -> PyResult<Option<Py<PyTuple>>> {
    let Some(rows) = rows else {
        return Ok(None);
    };
    let times = PyArray1::from_vec(py, rows.iter().map(CsvRow::time_s).collect());
    let values = PyArray1::from_vec(py, rows.iter().map(value).collect());
    let pair = (times, values).into_pyobject(py)?;
    Ok(Some(pair.unbind()))
}

#[pymethods]
impl Recording {
    /// Folder.
    #[getter]
    fn path(&self) -> &Path {
        &self.path
    }

    /// Drive, float32, in the unit of its channel: `drive_volts_per_unit` volts.
    #[getter]
    fn drive(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f32>>> {
        Ok(self.sampled()?.drive.clone_ref(py))
    }

    /// Pickup, float32, in the unit of its channel: `pickup_scale.metres_per_unit` metres.
    #[getter]
    fn pickup(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f32>>> {
        Ok(self.sampled()?.pickup.clone_ref(py))
    }

    /// Sampling rate of drive and pickup, Hz.
    #[getter]
    fn rate_hz(&self) -> PyResult<f64> {
        Ok(self.sampled()?.rate_hz)
    }

    /// Frequency of the carrier, Hz.
    #[getter]
    fn carrier_hz(&self) -> PyResult<f64> {
        self.present(self.content.carrier_hz(), "one frequency of a carrier")
    }

    /// Normal force: times, s, and forces, N; NaN is a lost reading.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let normal = self.present(self.normal.as_ref(), "normal force")?;
        Ok(normal.clone_ref(py))
    }

    /// Lateral force: times, s, and forces, N; NaN is a lost reading.
    #[getter]
    fn lateral(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let lateral = self.present(self.lateral.as_ref(), "lateral force")?;
        Ok(lateral.clone_ref(py))
    }

    /// Position along the plate: times, s, and positions, m; NaN is a lost reading.
    #[getter]
    fn position(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let position = self.present(self.position.as_ref(), "position")?;
        Ok(position.clone_ref(py))
    }

    /// Intervals, each as its kind, start and end in s, and, for an exploration, its direction.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for interval in &self.content.intervals {
            let (start_s, end_s) = (interval.start_s, interval.end_s);
            match interval.kind {
                RecordedIntervalKind::Unloaded => list.append(("unloaded", start_s, end_s))?,
                RecordedIntervalKind::Exploration(direction) => {
                    let direction = match direction {
                        recording::manifest::Direction::LeftToRight => "left_to_right",
                        recording::manifest::Direction::RightToLeft => "right_to_left",
                    };
                    list.append(("exploration", start_s, end_s, direction))?;
                }
            }
        }
        Ok(list)
    }

    /// Plate under the finger, as `friction_bench.Plate`.
    #[getter]
    fn plate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let plate = self.present(self.content.plate(), "plate")?;
        native(py, "Plate", &dict(py, plate)?)
    }

    /// Return the arguments by which `friction_bench.analyze` analyses these arrays.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``fb.analyze(**recording.arguments())`` has the numbers of ``fb.analyze(recording.path)``, bit for bit; only the standing
    ///     of a trial is in the session's log alone, which arrays do not have.
    ///
    /// Raises
    /// ------
    /// FrictionBenchError
    ///     The recording has envelopes, or forces alone, in place of drive and pickup.
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let sampled = self.sampled()?;
        let channels = &self
            .present(self.content.signals(), "drive and pickup as sampled")?
            .channels;
        let arguments = PyDict::new(py);
        arguments.set_item("drive", &sampled.drive)?;
        arguments.set_item("pickup", &sampled.pickup)?;
        arguments.set_item("rate_hz", sampled.rate_hz)?;
        for key in STATED {
            if let Some(value) = self.manifest.bind(py).get_item(key)? {
                arguments.set_item(key, value)?;
            }
        }
        arguments.set_item("manifest", &self.manifest)?;
        arguments.set_item("simulated", self.simulated)?;
        if let Some(protocol) = &self.protocol {
            arguments.set_item("protocol", protocol)?;
        }
        arguments.set_item("plate", self.plate(py)?)?;
        arguments.set_item("normal", &self.normal)?;
        arguments.set_item("lateral", &self.lateral)?;
        arguments.set_item("position", &self.position)?;
        arguments.set_item("intervals", self.intervals(py)?)?;
        let pickup = dict(py, &channels.pickup)?;
        pickup.del_item("index")?;
        arguments.set_item("pickup_scale", native(py, "Pickup", &pickup)?)?;
        arguments.set_item("drive_volts_per_unit", channels.drive.volts_per_unit)?;
        Ok(arguments)
    }

    fn __repr__(&self) -> String {
        format!("<friction_bench.Recording {}>", self.path.display())
    }
}

impl Recording {
    fn sampled(&self) -> PyResult<&SampledSignals> {
        self.present(self.signals.as_ref(), "drive and pickup as sampled")
    }

    /// Returns a part of the recording, or the exception that it has none.
    fn present<T>(&self, part: Option<T>, name: &str) -> PyResult<T> {
        part.ok_or_else(|| {
            refusal(format_args!(
                "{}: the recording has no {name}; friction_bench.analyze reads the folder of any recording",
                self.path.display()
            ))
        })
    }
}

/// Keys of recording.toml that are arguments with the same names.
const STATED: [&str; 6] = [
    "carrier_hz",
    "modulation_hz",
    "modulation_index",
    "participant",
    "standard_errors",
    "room",
];

/// Makes an object of a class of the package from the keys of its table in recording.toml.
fn native<'py>(
    py: Python<'py>,
    class: &str,
    keys: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("friction_bench")?.getattr(class)?;
    class.call((), Some(keys))
}
