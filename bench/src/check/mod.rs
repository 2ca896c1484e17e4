//! `check`: the preflight. A faint tone at the carrier, and a look at everything that must be alive. `run` does its quick part
//! before every session, and `monitor` before it drives the plate.

mod extent;
mod judge;
mod measure;
mod surroundings;
mod table;

pub use extent::Extent;
pub use table::{Row, Table};

use config::{CalibrationError, Effective};
use devices::Hardware;

/// Runs the preflight of `bench`; `hardware` is asked for once. `refused` is why its calibration could not be put in force.
pub fn run(
    bench: &Effective,
    refused: Option<&CalibrationError>,
    extent: &Extent,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> Table {
    let mut table = Table::default();
    match measure::measure(bench, extent, hardware) {
        Ok(measured) => {
            judge::judge(&mut table, bench, refused, &measured);
            if wants_wiring(extent, bench.calibration().is_some()) {
                judge::judge_wiring(&mut table, bench.config(), &measured);
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
    use config::Config;
    use std::path::PathBuf;

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
