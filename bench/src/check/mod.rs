//! `check`: the preflight. A faint tone at the carrier, and a look at everything that must be alive. `run` does its quick part
//! before every session, and `monitor` before it drives the plate.

mod extent;
mod judge;
mod measure;
mod surroundings;
mod table;
mod wiring;

pub use extent::Extent;
pub use table::{Row, Table, Verdict};

use config::{CalibrationError, Effective};
use devices::Hardware;

use crate::complaint;

/// What a preflight came to.
#[derive(Debug)]
pub struct Preflight {
    /// Its rows.
    pub table: Table,
    /// Whether the test tone was played.
    pub driven: bool,
}

/// Runs the preflight of `bench`; `hardware` is asked for once. `refused` is why its calibration could not be put in force.
pub fn run(
    bench: &Effective,
    refused: Option<&CalibrationError>,
    extent: &Extent,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> Preflight {
    let mut table = Table::default();
    let mut driven = false;
    match measure::measure(bench, extent, hardware) {
        Ok(measured) => {
            judge::judge(&mut table, bench, refused, &measured);
            wiring::judge(&mut table, bench.config(), &measured);
            driven = measured.driven;
        }
        Err(error) => table.row("hardware", false, complaint::lines(&error).join(": ")),
    }
    if let Extent::Whole {
        study,
        session_bytes,
        dashboard,
    } = extent
    {
        surroundings::judge_disk(&mut table, study, *session_bytes);
        if *dashboard {
            surroundings::judge_terminal(&mut table, tui::shell::size());
        }
    }
    Preflight { table, driven }
}
