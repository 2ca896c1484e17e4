//! What hardware there is to choose from.

use std::ffi::OsStr;
use std::io::IsTerminal;

use friction_bench::cli::Speed;
use setup::inventory::{Listing, audio, serial_ports};
use setup::{Ask, Options, Terminal, Unattended, Written};
use signalgen::audio::{HostChoice, open_host};
use sources::Place;

use crate::{real_gpio, simulated};

/// What this computer offers, or the simulated hardware of a scenario.
pub fn listing(mock: Option<&str>) -> anyhow::Result<Listing> {
    let Some(scenario) = mock else {
        return Ok(Listing {
            hosts: [
                ("native", open_host(HostChoice::Default)),
                ("jack", open_host(HostChoice::Jack)),
                ("nidaqmx", daqmx::listed()),
            ]
            .map(|(name, host)| audio(name, host.as_ref()))
            .into(),
            // A computer without NI's driver has none.
            cards: daqmx::cards(None).unwrap_or_default(),
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

/// Asks what the bench is made of, and writes its configuration.
pub fn write(options: &Options) -> anyhow::Result<Written> {
    let mut found = listing(options.mock.as_deref())?;
    if options.mock.is_some() {
        // In a configuration simulated hardware has the names of real one.
        for host in &mut found.hosts {
            host.name = "native";
        }
    }
    let attended = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    let ask: &mut dyn Ask = if attended {
        &mut Terminal
    } else {
        &mut Unattended
    };
    setup::write(options, &found, ask)
}

/// The command that checks what was written.
pub fn check(options: &Options) -> Vec<&OsStr> {
    let mut words: Vec<&OsStr> = ["friction-bench", "check", "--config"]
        .map(OsStr::new)
        .into();
    words.push(options.config.as_os_str());
    if let Some(scenario) = &options.mock {
        words.extend(["--mock", scenario].map(OsStr::new));
    }
    words
}
