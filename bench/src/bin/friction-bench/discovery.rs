//! The hardware to choose from.

use std::ffi::OsStr;

use devices::stop_on_signals;
use friction_bench::cli::Speed;
use setup::inventory::{Listing, audio, serial_ports};
use setup::{Ask, InitOptions, NoOperator, Terminal};
use signalgen::audio::{HostChoice, open_host};
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
    }
    Ok(listing)
}

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

/// Returns the command that checks the written configuration.
pub fn check(options: &InitOptions) -> Vec<&OsStr> {
    let mut words: Vec<&OsStr> = ["friction-bench", "check", "--config"]
        .map(OsStr::new)
        .into();
    words.push(options.config.as_os_str());
    if let Some(scenario) = &options.mock {
        words.extend(["--mock", scenario].map(OsStr::new));
    }
    words
}
