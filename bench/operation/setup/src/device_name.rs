//! Names of devices: of a serial port, and paths in `bench.toml`.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::ask::{Ask, Question};
use crate::inventory::Listing;

/// Returns the serial port that was named, or asks for one of those that are there.
///
/// # Errors
/// There is no port, or nobody to ask.
pub(crate) fn port(
    named: Option<&PathBuf>,
    listing: &Listing,
    question: &Question<'_>,
    ask: &mut dyn Ask,
) -> anyhow::Result<PathBuf> {
    if let Some(port) = named {
        return Ok(port.clone());
    }
    let ports = &listing.serial_ports;
    if ports.is_empty() {
        bail!(
            "{} There is no serial port: plug it in, or give {}",
            question.text,
            question.option
        );
    }
    let lines: Vec<String> = ports
        .iter()
        .map(|port| port.display().to_string())
        .collect();
    Ok(ports[ask.choose(question, &lines)?].clone())
}

/// Returns a path as text for a TOML file.
pub(crate) fn in_toml(path: &Path) -> anyhow::Result<&str> {
    path.to_str().with_context(|| {
        format!(
            "the name of {} is not Unicode and cannot be written into bench.toml: rename the file, or use a link",
            path.display()
        )
    })
}
