//! Cards of National Instruments through NI-DAQmx: a host of streams behind the same seam as sound cards, a counter and
//! digital lines. The library is loaded at run time, and nothing links to it.
//!
//! What is used of it, why so, and what each card allows is in `docs/nidaqmx.md`.

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

/// Opens the card of `config`: the host of its streams, and its lines and counter, the others from `beside`. The library
/// is that at `library` if it is given, or else the configured one.
///
/// # Errors
/// When the library cannot be loaded, or a line or the counter cannot be had; says what to change.
pub fn open(
    config: &Config,
    library: Option<&Path>,
    beside: Lines,
) -> anyhow::Result<(Host, Lines)> {
    let table = config
        .nidaqmx
        .as_ref()
        .context("bench.toml has no table [nidaqmx]")?;
    let library = Daqmx::load(library.or(table.library.as_deref()))?;
    require_card(&library, &config.audio.output_device)?;
    let lines = lines::take(&library, config, table, beside)?;
    let block_frames = config::Nidaqmx::block_frames(&config.audio);
    Ok((
        host::host(&library, Some(table.clone()), block_frames),
        lines,
    ))
}

/// Requires that there is a card of this name: its terminals begin with it.
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
    let there = match names.collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => "there is none".to_owned(),
        names => format!("there is {names}"),
    };
    anyhow::bail!(
        "there is no NI card {device}, {there}: plug it in, or name another as audio.output_device and audio.input_device in \
         bench.toml"
    )
}

/// Returns the cards of this computer, by the library at `library` or where the system's loader finds it.
///
/// # Errors
/// When NI-DAQmx is not installed, or does not answer.
pub fn cards(library: Option<&Path>) -> anyhow::Result<Vec<Card>> {
    Ok(Daqmx::load(library)?.cards()?)
}

/// Returns the cards of this computer as a host whose devices can be listed.
///
/// # Errors
/// When NI-DAQmx is not installed.
pub fn listed() -> Result<Host, AudioError> {
    let library = Daqmx::load(None).map_err(|error| AudioError::HostUnavailable {
        host: "nidaqmx".to_owned(),
        reason: error.to_string(),
    })?;
    Ok(host::host(&library, None, 0))
}
