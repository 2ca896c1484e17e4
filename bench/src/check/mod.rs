//! `check`: the preflight. A faint tone at the carrier, and a look at everything that must be alive. `run` does its quick part
//! before every session, and `monitor` before it drives the plate.

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
    /// Two seconds, before the plate is driven.
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
            if wants_wiring(extent, held.is_some()) {
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

/// A calibrated bench is held to its e-stop, heartbeat and encoder before it is driven; only one that runs as uncalibrated,
/// which its operator has decided, may lack them.
fn wants_wiring(extent: &Extent, calibrated: bool) -> bool {
    calibrated || matches!(extent, Extent::Whole { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_quick_part_of_an_uncalibrated_bench_leaves_wiring_out() {
        let whole = Extent::Whole {
            study: PathBuf::new(),
            session_bytes: 0,
        };
        assert!(wants_wiring(&whole, false) && wants_wiring(&whole, true));
        assert!(wants_wiring(&Extent::Quick, true));
        assert!(!wants_wiring(&Extent::Quick, false));
    }

    #[test]
    fn a_bench_without_a_hardware_stop_fails() {
        let config = Config::parse(include_str!("../../mock-bench.toml"), "test").unwrap();
        for (estop_wired, heartbeat_wired) in [(true, true), (false, true), (true, false)] {
            let measured = measure::Measured {
                positions: 1,
                estop_wired,
                heartbeat_wired,
                ..measure::Measured::default()
            };
            let mut table = Table::default();
            judge::judge_wiring(&mut table, &config, &measured);
            assert_eq!(
                table.passed(),
                estop_wired && heartbeat_wired,
                "{}",
                table.to_text()
            );
        }
    }
}
