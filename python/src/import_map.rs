//! Import of recordings made elsewhere.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use import::{FileReport, Outcome, Plan, Program};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple};

use crate::background;
use crate::error::refusal;

/// Version that a study names as its maker.
const PROGRAM: Program<'static> = Program {
    version: env!("CARGO_PKG_VERSION"),
};

/// Import recordings made elsewhere by the map at `path`, or by `map`, whose place `path` is.
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
    let text = map.map(toml_text).transpose()?;
    let plan = background::run(py, 0, None, move |_| match text {
        Some(text) => Plan::parse(&text, &path),
        None => Plan::read(&path),
    });
    let plan = plan?.map_err(refusal)?;
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

/// Returns the text of a map.
fn toml_text(map: &Bound<'_, PyDict>) -> PyResult<String> {
    let table = toml_value(map.as_any(), "map")?;
    toml::to_string(&table).map_err(refusal)
}

/// Returns a value of Python as one of TOML; `name` names it in errors.
fn toml_value(value: &Bound<'_, PyAny>, name: &str) -> PyResult<toml::Value> {
    if let Ok(dict) = value.cast::<PyDict>() {
        let mut table = toml::Table::new();
        for (key, value) in dict {
            let value = toml_value(&value, &format!("{name}[{key:?}]"))?;
            table.insert(key.to_string(), value);
        }
        return Ok(table.into());
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        let items = items.map(|(index, item)| toml_value(&item?, &format!("{name}[{index}]")));
        return Ok(toml::Value::Array(items.collect::<PyResult<_>>()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(value.to_string().into());
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(number.into());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(number.into());
    }
    Err(refusal(format_args!(
        "{name}: a text, number, truth value, list or dict is needed, not {}; leave out keys without a value",
        value.get_type().name()?
    )))
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
