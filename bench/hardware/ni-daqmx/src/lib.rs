//! Cards of National Instruments through NI-DAQmx: a host of streams behind the same interface as sound cards, a
//! counter and digital lines. The library is loaded at run time; the program is not linked to it.
//!
//! `docs/nidaqmx.md` describes the functions used, the reasons for that choice, and the limits of each card.

mod host;
mod library;
mod lines;

use std::path::Path;

use anyhow::Context;
use config::Config;
use signalgen::audio::{AudioError, Host};
use sources::Lines;

pub use library::Card;
use library::Daqmx;

/// Opens the card of `config`: the host of its streams, and its lines and counter; the other lines come from `other_lines`.
/// The library is the one at `library` if it is given, or else the configured one.
///
/// # Errors
/// If the library cannot be loaded, or a line or the counter is unavailable; the message names the remedy.
pub fn open(
    config: &Config,
    library: Option<&Path>,
    other_lines: Lines,
) -> anyhow::Result<(Host, Lines)> {
    let table = config
        .nidaqmx
        .as_ref()
        .context("bench.toml has no table [nidaqmx]")?;
    let library = Daqmx::load(library.or(table.library.as_deref()))?;
    require_card(&library, &config.audio.output_device)?;
    let lines = lines::take(&library, config, table, other_lines)?;
    let block_frames = config::Nidaqmx::block_frames(&config.audio);
    Ok((
        host::host(&library, Some(table.clone()), block_frames),
        lines,
    ))
}

/// Requires a card of this name, with which its terminals begin.
fn require_card(library: &Daqmx, device: &str) -> anyhow::Result<()> {
    let cards = library
        .cards()
        .context("the cards of this computer cannot be listed")?;
    if cards.iter().any(|card| card.name == device) {
        return Ok(());
    }
    let names = cards
        .iter()
        .map(|card| format!("{} ({})", card.name, card.product));
    let list = match names.collect::<Vec<_>>().join(", ") {
        empty if empty.is_empty() => "there is none".to_owned(),
        names => format!("there is {names}"),
    };
    anyhow::bail!(
        "there is no NI card {device}, {list}: plug it in, or name another as audio.output_device and audio.input_device in \
         bench.toml"
    )
}

/// Returns the cards of this computer, by the library at `library` or, without it, the one that the system's loader
/// finds.
///
/// # Errors
/// If NI-DAQmx is not installed, or does not answer.
pub fn cards(library: Option<&Path>) -> anyhow::Result<Vec<Card>> {
    Ok(Daqmx::load(library)?.cards()?)
}

/// Returns the cards of this computer as a host with devices that can be listed.
///
/// # Errors
/// If NI-DAQmx is not installed.
pub fn listed() -> Result<Host, AudioError> {
    let library = Daqmx::load(None).map_err(|error| AudioError::HostUnavailable {
        host: "nidaqmx".to_owned(),
        reason: error.to_string(),
    })?;
    Ok(host::host(&library, None, 0))
}
