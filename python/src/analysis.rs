//! Result of an analysis.

use std::sync::Arc;

use analysis::estimate::Method;
use published_figures::measured::FigureSelection;
use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList};
use study_analysis::{StudyAnalysis, html, summary, warnings};
use tables::TableKind;
use tasks::{Clock, SystemClock};

use crate::error::{FrictionBenchError, refusal};
use crate::table::Table;

/// Name and version of the program, as a report states them.
const PROGRAM: &str = concat!("friction-bench ", env!("CARGO_PKG_VERSION"));

/// Result of an analysis, as `friction_bench.analyze` returns it.
///
/// The keys of `results` are attributes too: ``result.recordings``, ``result.statistics``, ``result.descriptive``,
/// ``result.skin``, ``result.provenance``. The tables are `instances`, `estimates`, `samples`, `explorations`, `friction`, `trials`
/// and `participants`; `table` has each by name.
#[pyclass(frozen, module = "friction_bench")]
pub(crate) struct Analysis {
    study: Arc<StudyAnalysis>,
    results: PyOnceLock<Py<PyAny>>,
    tables: [PyOnceLock<Py<Table>>; TableKind::ALL.len()],
}

impl Analysis {
    /// Makes the result of an analysis with its reductions.
    pub(crate) fn new(study: StudyAnalysis) -> Self {
        Self {
            study: Arc::new(study),
            results: PyOnceLock::new(),
            tables: TableKind::ALL.map(|_| PyOnceLock::new()),
        }
    }

    fn table_of<'py>(&self, py: Python<'py>, kind: TableKind) -> PyResult<Bound<'py, Table>> {
        let kinds = TableKind::ALL.into_iter().zip(&self.tables);
        let mut slots = kinds.filter_map(|(other, slot)| (other == kind).then_some(slot));
        let make = || {
            let table = py.detach(|| self.study.tables().table(kind));
            Py::new(py, Table::new(table.map_err(refusal)?)?)
        };
        match slots.next() {
            Some(slot) => Ok(slot.get_or_try_init(py, make)?.bind(py).clone()),
            None => Ok(make()?.into_bound(py)),
        }
    }
}

#[pymethods]
impl Analysis {
    /// Results, as the file of ``friction-bench analyze --json`` has them.
    #[getter]
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parse = || {
            let results = py
                .import("json")?
                .call_method1("loads", (self.to_json(py)?,))?;
            PyResult::Ok(results.unbind())
        };
        Ok(self.results.get_or_try_init(py, parse)?.bind(py).clone())
    }

    /// Return the text of the file that ``friction-bench analyze --json`` writes.
    ///
    /// Returns
    /// -------
    /// str
    ///     JSON by the schema of docs/RECORDING.md, ending in a line feed.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.study.to_json()).map_err(refusal)
    }

    /// Return all results as one self-contained HTML page, as ``friction-bench analyze --report`` writes it.
    ///
    /// Parameters
    /// ----------
    /// methods : sequence of str, optional
    ///     Methods shown in the figures: "paper", "dynamic", "trial"; by default all.
    /// whole_trial : bool
    ///     Whether the figure of instances shows those of the whole typical trial instead of one exploration.
    ///
    /// Returns
    /// -------
    /// str
    #[pyo3(signature = (*, methods=None, whole_trial=false))]
    fn report(
        &self,
        py: Python<'_>,
        methods: Option<&Bound<'_, PyAny>>,
        whole_trial: bool,
    ) -> PyResult<String> {
        let content = figure_selection(methods, whole_trial)?;
        let page = py.detach(|| {
            let results = self.study.results();
            self.study
                .page(&results, &content, (SystemClock::start().utc(), PROGRAM))
        });
        page.map_err(refusal)
    }

    /// Return the published figures that these recordings allow, as ``friction-bench analyze --figures`` draws them.
    ///
    /// Parameters
    /// ----------
    /// methods : sequence of str, optional
    ///     Methods shown in the figures: "paper", "dynamic", "trial"; by default all.
    /// whole_trial : bool
    ///     Whether the figure of instances shows those of the whole typical trial instead of one exploration.
    ///
    /// Returns
    /// -------
    /// dict of str to str
    ///     SVG of each figure, by its name; the caption is in it.
    #[pyo3(signature = (*, methods=None, whole_trial=false))]
    fn figures<'py>(
        &self,
        py: Python<'py>,
        methods: Option<&Bound<'py, PyAny>>,
        whole_trial: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let content = figure_selection(methods, whole_trial)?;
        let figures = py.detach(|| self.study.figures(&content));
        let dict = PyDict::new(py);
        for figure in figures.map_err(refusal)? {
            let svg = py.detach(|| figure.to_svg()).map_err(refusal)?;
            dict.set_item(figure.name, svg)?;
        }
        Ok(dict)
    }

    /// Warnings, in the words of the command line: flaws of recordings, trials that were left out, provenance, assumptions.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        warnings::all(&self.study)
    }

    /// Return a table by its name.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     One of "instances", "estimates", "samples", "explorations", "friction", "trials", "participants", "descriptive".
    ///
    /// Returns
    /// -------
    /// Table
    fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, Table>> {
        let Some(kind) = TableKind::named(name) else {
            let names = TableKind::ALL.map(TableKind::name).join(", ");
            return Err(FrictionBenchError::new_err(format!(
                "no table is called `{name}`; the tables are {names}"
            )));
        };
        self.table_of(py, kind)
    }

    /// Table of the instances: measured quantities, and the estimates of one method.
    #[getter]
    fn instances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Instances)
    }

    /// Table of the estimates: a row for each instance and method.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Estimates)
    }

    /// Table of the samples of instances: a row for each sample and method.
    #[getter]
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Samples)
    }

    /// Table of the explorations, with their friction.
    #[getter]
    fn explorations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Explorations)
    }

    /// Table of the samples of explorations of recordings without instances.
    #[getter]
    fn friction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Friction)
    }

    /// Table of the trials.
    #[getter]
    fn trials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Trials)
    }

    /// Table of the participants and conditions.
    #[getter]
    fn participants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Table>> {
        self.table_of(py, TableKind::Participants)
    }

    fn __getattr__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        // Programs probe objects for names like `_repr_png_`, which is no reason to make all results.
        let found = match name.starts_with('_') {
            true => None,
            false => self.results(py)?.get_item(name).ok(),
        };
        found.ok_or_else(|| PyAttributeError::new_err(format!("the results have no {name}")))
    }

    fn __dir__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyList>> {
        let py = slf.py();
        let object = py.import("builtins")?.getattr("object")?;
        let names = object.call_method1("__dir__", (slf,))?;
        let names = PyList::new(py, names.try_iter()?.collect::<PyResult<Vec<_>>>()?)?;
        for key in slf.get().results(py)?.try_iter()? {
            names.append(key?)?;
        }
        Ok(names)
    }

    fn __repr__(&self) -> String {
        format!("<friction_bench.Analysis {}>", summary::counts(&self.study))
    }

    fn __str__(&self) -> String {
        summary::text(&self.study, None)
    }

    fn _repr_html_(&self) -> String {
        html::table(&self.study)
    }
}

/// Returns the content of the figures.
fn figure_selection(
    methods: Option<&Bound<'_, PyAny>>,
    whole_trial: bool,
) -> PyResult<FigureSelection> {
    let mut content = FigureSelection {
        whole_trial,
        ..FigureSelection::default()
    };
    if let Some(methods) = methods {
        let Ok(names) = methods.extract::<Vec<String>>() else {
            return Err(FrictionBenchError::new_err(
                "`methods` is no list of names: pass one, as methods=[\"trial\"]",
            ));
        };
        let method = |name: &String| {
            let mut methods = Method::ALL.into_iter();
            methods.find(|method| method.name() == name).ok_or_else(|| {
                FrictionBenchError::new_err(format!(
                    "no method is called `{name}`; the methods are {}",
                    Method::ALL.map(Method::name).join(", ")
                ))
            })
        };
        content.methods = names.iter().map(method).collect::<PyResult<_>>()?;
    }
    Ok(content)
}
