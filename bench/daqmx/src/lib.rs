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
    let lines = lines::take(&library, config, table, beside)?;
    let block_frames = config::Nidaqmx::block_frames(&config.audio);
    Ok((
        host::host(&library, Some(table.clone()), block_frames),
        lines,
    ))
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
