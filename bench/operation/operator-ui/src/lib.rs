//! The operator's view of a bench.
//!
//! | module | contents |
//! | --- | --- |
//! | [`console`] | the dashboard on its thread, or lines of text in its place; keys that stop the drive |
//! | [`bench_page`] | data for the dashboard's page of the bench: calibrations, lines, limits, losses, rates |
//! | [`questions`] | questions about a participant |

pub mod bench_page;
pub mod console;
pub mod questions;
