//! The native half of the Python package `friction_bench`.

#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "docstrings of Python, in which brackets are indices"
)]

mod analysis;
mod analyze_arrays;
mod arrays;
mod background;
mod broadcast;
mod contact;
mod demodulate;
mod description;
mod envelope_series;
mod error;
mod folders;
mod import_map;
mod model;
mod recording;
mod settings;
mod simulate;
mod table;

use pyo3::prelude::*;

/// Functions and types in Rust; `friction_bench` names them for users.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::analysis::Analysis;
    #[pymodule_export]
    use crate::analyze_arrays::analyze_arrays;
    #[pymodule_export]
    use crate::contact::Contact;
    #[pymodule_export]
    use crate::demodulate::{as_samples, envelopes, impedance_of_arrays};
    #[pymodule_export]
    use crate::error::FrictionBenchError;
    #[pymodule_export]
    use crate::folders::analyze_folders;
    #[pymodule_export]
    use crate::import_map::import_by_map;
    #[pymodule_export]
    use crate::model::curves;
    #[pymodule_export]
    use crate::recording::{Recording, read_recording};
    #[pymodule_export]
    use crate::settings::Settings;
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::table::Table;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name of it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
