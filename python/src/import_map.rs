//! Import of recordings made elsewhere.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use import::{FileReport, Outcome, Plan, Program};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::background;
use crate::description::{about_dict, table};
use crate::error::refusal;

/// Version that a study names as its maker.
const PROGRAM: Program<'static> = Program {
    version: env!("CARGO_PKG_VERSION"),
};

/// Import recordings made elsewhere, by the map at `path`, or by `map` in its place.
#[pyfunction]
#[pyo3(signature = (path, *, map=None, study=None, dry_run=false, progress=None))]
pub(crate) fn import_by_map<'py>(
    py: Python<'py>,
    path: PathBuf,
    map: Option<&Bound<'py, PyDict>>,
    study: Option<PathBuf>,
    dry_run: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    let map = map.map(|map| table(map, "")).transpose()?;
    let file = path.display().to_string();
    let is_dict = map.is_some();
    let plan = background::run(py, 0, None, move |_| match map {
        Some(map) => Plan::parse(&map.to_string(), &path),
        None => Plan::read(&path),
    });
    let plan = plan?.map_err(|error| match is_dict {
        true => refusal(about_dict(&error.to_string(), &file, "the map")),
        false => refusal(error),
    })?;
    let study = match (study, dry_run) {
        (_, true) => None,
        (None, false) => {
            return Err(refusal(
                "study: name the folder of the study, or convert without writing by dry_run=True",
            ));
        }
        (study, false) => study,
    };
    let reports = background::run(py, plan.file_count(), progress, move |steps| {
        let reports = Mutex::new(Vec::new());
        import::import(&plan, study.as_deref(), PROGRAM, |report| {
            let mut reports = reports.lock().unwrap_or_else(PoisonError::into_inner);
            reports.push(FileLines::new(report));
            steps.report()
        })?;
        Ok::<_, import::ImportError>(reports.into_inner().unwrap_or_else(PoisonError::into_inner))
    })?;
    let mut reports = reports.map_err(refusal)?;
    reports.sort_by(|a, b| a.file.cmp(&b.file));
    let list = PyList::empty(py);
    for report in reports {
        list.append(report.into_dict(py)?)?;
    }
    Ok(list)
}

/// Report of a file, in words.
struct FileLines {
    file: String,
    recording: String,
    status: &'static str,
    refusal: Option<String>,
    found: Vec<String>,
    notes: Vec<String>,
}

impl FileLines {
    fn new(report: &FileReport) -> Self {
        let (status, refusal) = match &report.outcome {
            Ok(Outcome::Written) => ("written", None),
            Ok(Outcome::Replaced) => ("replaced", None),
            Ok(Outcome::Unchanged) => ("unchanged", None),
            Ok(Outcome::Checked) => ("checked", None),
            Err(refusal) => ("refused", Some(refusal.to_string())),
        };
        Self {
            file: report.file.clone(),
            recording: report.recording.clone(),
            status,
            refusal,
            found: report.found.clone(),
            notes: report.notes.clone(),
        }
    }

    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("path", self.file)?;
        dict.set_item("recording", self.recording)?;
        dict.set_item("status", self.status)?;
        dict.set_item("corrections", self.found)?;
        let flaws = self.refusal.into_iter().chain(self.notes);
        dict.set_item("flaws", flaws.collect::<Vec<_>>())?;
        Ok(dict)
    }
}
