//! `check`: the preflight. A faint tone at the carrier, and a look at everything that must be alive. `run` does its quick part
//! before every session.

mod judge;
mod measure;
mod surroundings;
mod table;

use std::path::PathBuf;

pub use table::{Row, Table};

use crate::assembly::Hardware;
use crate::calibration::Held;
use crate::config::Config;

/// How much is looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// Two seconds, and what can have changed since the last session: before every session.
    Quick,
    /// Ten seconds for drop-outs, the wiring, and what the computer has for a session.
    Whole {
        /// Where the study lies, or will.
        study: PathBuf,
        /// What a session may take there, bytes.
        session_bytes: u64,
    },
}

/// Runs the preflight; `hardware` is asked for once. `calibration` is the one in force, its constants already in `config`, or
/// why none can be.
pub fn run(
    config: &Config,
    calibration: &anyhow::Result<Option<Held>>,
    extent: &Extent,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> Table {
    let mut table = Table::default();
    let held = calibration.as_ref().ok().and_then(Option::as_ref);
    match measure::measure(config, held, extent, hardware) {
        Ok(measured) => {
            judge::judge(&mut table, config, calibration, &measured);
            if matches!(extent, Extent::Whole { .. }) {
                judge::judge_wiring(&mut table, config, &measured);
            }
        }
        Err(error) => table.row("hardware", false, format!("{error:#}")),
    }
    if let Extent::Whole {
        study,
        session_bytes,
    } = extent
    {
        surroundings::judge(&mut table, study, *session_bytes);
    }
    table
}
