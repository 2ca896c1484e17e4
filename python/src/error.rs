//! The exception of the package.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;

create_exception!(
    friction_bench,
    FrictionBenchError,
    PyValueError,
    "Input that cannot be used, or a file that cannot be read; the message is that of the command line."
);
