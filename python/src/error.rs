//! The exception of the package.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;

create_exception!(
    friction_bench,
    FrictionBenchError,
    PyValueError,
    "Input that cannot be used, or a file that cannot be read; the message is that of the command line."
);

/// Returns the exception for an error of the analysis.
pub(crate) fn refusal(error: impl Display) -> PyErr {
    FrictionBenchError::new_err(error.to_string())
}
