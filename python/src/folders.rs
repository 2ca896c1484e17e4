//! Analysis of folders.

use std::path::PathBuf;

use attempts::find::TrialFilter;
use pyo3::prelude::*;
use study_analysis::Request;

use crate::analysis::Analysis;
use crate::background;
use crate::error::refusal;
use crate::settings::assumptions;

/// Analyse folders of recordings, or of studies, participants or sessions.
#[pyfunction]
#[pyo3(signature = (folders, *, settings=None, practice=false, include_rejected=false, include_excluded=false, exclude=Vec::new(), progress=None))]
#[allow(clippy::too_many_arguments, reason = "the keywords of Python")]
pub(crate) fn analyze_folders(
    py: Python<'_>,
    folders: Vec<PathBuf>,
    settings: Option<&Bound<'_, PyAny>>,
    practice: bool,
    include_rejected: bool,
    include_excluded: bool,
    exclude: Vec<PathBuf>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Analysis> {
    let settings = assumptions(settings)?;
    let request = Request {
        folders,
        filter: TrialFilter {
            practice,
            rejected: include_rejected,
        },
        include_excluded,
        exceptions: exclude,
    };
    let found = background::run(py, 0, None, move |_| request.find())?.map_err(refusal)?;
    let total = found.recordings().len();
    let study = background::run(py, total, progress, move |steps| {
        found.analyse(&settings, |_| steps.report())
    })?;
    match study.map_err(refusal)? {
        Some(study) => Ok(Analysis::new(study)),
        None => Err(refusal("the analysis was broken off")),
    }
}
