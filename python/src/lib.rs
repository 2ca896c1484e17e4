//! The native half of the Python package `friction_bench`.

mod arrays;
mod broadcast;
mod contact;
mod error;
mod model;
mod simulate;

use pyo3::prelude::*;

/// Functions and types in Rust; `friction_bench` names them for users.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::contact::Contact;

    #[pymodule_export]
    use crate::error::FrictionBenchError;

    #[pymodule_export]
    use crate::model::curves;

    #[pymodule_export]
    use crate::simulate::simulate;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name of it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
