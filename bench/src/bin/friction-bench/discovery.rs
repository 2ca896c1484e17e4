//! The hardware to choose from.

use std::ffi::OsStr;
use std::path::Path;

use devices::stop_on_signals;
use friction_bench::cli::Speed;
use setup::inventory::{Listing, audio, serial_ports};
use setup::{Ask, InitOptions, NoOperator, Terminal};
use signalgen::audio::{Capability, HostChoice, Offer, open_host};
use sources::Place;
use tasks::StopFlag;

use crate::{real_gpio, simulated};

/// Returns the hardware of this computer, or the simulated hardware of a scenario.
pub fn listing(mock: Option<&str>) -> anyhow::Result<Listing> {
    let Some(scenario) = mock else {
        return Ok(Listing {
            hosts: [
                ("native", open_host(HostChoice::Default)),
                ("jack", open_host(HostChoice::Jack)),
                ("nidaqmx", ni_daqmx::listed()),
            ]
            .map(|(name, host)| audio(name, host.as_ref()))
            .into(),
            // A computer without NI's driver has no cards.
            cards: ni_daqmx::cards(None).unwrap_or_default(),
            serial_ports: serial_ports()?,
            gpio_chips: real_gpio::chips(),
        });
    };
    let cards = simulated::cards(scenario)?;
    let simulated = simulated::apparatus(scenario, 1, Speed::Max, None, &[], None)?.hardware;
    let ports = match simulated.force_place {
        Some(Place::Port(path)) => vec![path],
        Some(Place::Address(_)) | None => Vec::new(),
    };
    Ok(Listing {
        hosts: vec![audio("simulated", Ok(&simulated.host))],
        cards,
        serial_ports: ports,
        gpio_chips: Vec::new(),
    })
}

/// Returns the hardware for a new bench configuration.
pub fn for_rig(options: &InitOptions) -> anyhow::Result<Listing> {
    let mut listing = listing(options.mock.as_deref())?;
    if options.mock.is_some() {
        // In a configuration, simulated hardware has the names of real hardware.
        for host in &mut listing.hosts {
            host.name = "native";
        }
        complete(&mut listing);
    }
    Ok(listing)
}

/// Adds equipment that the simulated bench gets once it is chosen: inputs for a sensor's gauges, and a port for a field box.
fn complete(listing: &mut Listing) {
    let devices = listing.hosts.iter_mut().flat_map(|host| &mut host.devices);
    for device in devices {
        for offer in [&mut device.output, &mut device.input] {
            if let Some(Offer::Listed(capabilities)) = offer {
                let wide = capabilities.iter().map(|capability| Capability {
                    channels: capability.channels.max(GAUGES_INPUTS),
                    ..capability.clone()
                });
                let wide: Vec<Capability> = wide.collect();
                capabilities.extend(wide);
            }
        }
    }
    if listing.serial_ports.is_empty() {
        listing.serial_ports.push(SIMULATED_PORT.into());
    }
}

/// Number of the simulated card's inputs with a sensor's gauges.
const GAUGES_INPUTS: u16 = 9;
/// Port that stands for the simulated field box in a configuration.
const SIMULATED_PORT: &str = "/dev/ttyACM0";

/// Returns the source of answers: a person at the terminal until a signal comes, or an unattended default.
pub fn dialogue(attended: bool) -> anyhow::Result<Box<dyn Ask>> {
    if !attended {
        return Ok(Box::new(NoOperator));
    }
    let stop = StopFlag::default();
    let signal_guard = stop_on_signals(&stop)?;
    Ok(Box::new(Terminal::new(move || {
        let _guard = &signal_guard;
        stop.is_raised()
    })))
}

/// Returns the message about a configuration that was written without a person to permit a tone.
pub fn unchecked_message(options: &InitOptions) -> String {
    format!(
        "check: not run, because it drives a tone, and without a terminal nobody can confirm that the plate is clear; \
         once it is clear, run `friction-bench check --config {}`\n",
        escaping::quoted(&options.config)
    )
}

/// Rows of the check that say nothing of the equipment: the calibration, which is still to be measured, and the disk, whose study
/// is still to be chosen.
const NOT_OF_THE_EQUIPMENT: [&str; 2] = ["calibration", "disk"];

/// Returns the fault of a new bench's equipment by its check.
pub fn fault(result: anyhow::Result<Option<preflight::Table>>) -> Option<String> {
    match result {
        Err(error) => Some(bounded_files::cause_line(error.as_ref())),
        Ok(None) => None,
        Ok(Some(mut table)) => {
            table
                .rows
                .retain(|row| !NOT_OF_THE_EQUIPMENT.contains(&row.name));
            let cause = table.root_cause()?;
            Some(format!("{}: {}", cause.name, cause.found))
        }
    }
}

/// Returns the message about a configuration that does not fit the bench.
pub fn faulty_message(options: &InitOptions, mock: Option<&str>, fault: &str) -> String {
    let mock = mock.map_or_else(String::new, |scenario| {
        format!(" --mock {}", escaping::quoted(Path::new(scenario)))
    });
    format!(
        "the bench is not yet as {} describes it. Correct this first:\n  {fault}\nthen repeat\n  friction-bench \
         check --config {}{mock}\nuntil no other row than `calibration` fails, and calibrate (docs/handbook/src/calibrating.md)\n",
        options.config.display(),
        escaping::quoted(&options.config),
    )
}

/// Returns the command that checks the written configuration.
pub fn check<'a>(options: &'a InitOptions, mock: Option<&'a str>) -> Vec<&'a OsStr> {
    let mut words: Vec<&OsStr> = ["friction-bench", "check", "--config"]
        .map(OsStr::new)
        .into();
    words.push(options.config.as_os_str());
    if let Some(scenario) = mock {
        words.extend(["--mock", scenario].map(OsStr::new));
    }
    words
}

#[cfg(test)]
mod tests {
    use preflight::{Row, RowVerdict, Table};

    use super::*;

    fn table(names: &[&'static str]) -> Table {
        let rows = names.iter().map(|name| Row {
            name,
            passed: false,
            verdict: RowVerdict::Failed,
            found: format!("{name} is wrong"),
        });
        Table {
            rows: rows.collect(),
        }
    }

    #[test]
    fn a_full_disk_and_a_calibration_to_come_are_no_faults_of_the_equipment() {
        let fault_of = |names: &[&'static str]| fault(Ok(Some(table(names))));
        assert_eq!(fault_of(&["calibration", "disk"]), None);
        assert_eq!(
            fault_of(&["calibration", "disk", "e-stop"]).as_deref(),
            Some("e-stop: e-stop is wrong")
        );
    }
}
