//! The source that `bench.toml` names.

use std::path::PathBuf;

use config::Config;

use crate::force_source::ForceSource;
use crate::serial::{SerialForce, open_port};

/// Where the force sensor is, in the place of what is configured: a simulated one has no fixed place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A serial port.
    Port(PathBuf),
}

/// Opens the force sensor of `config`, at `place` if it is given; `None` for a bench without one.
///
/// # Errors
/// When the sensor is missing, busy or forbidden.
pub fn open(config: &Config, place: Option<Place>) -> anyhow::Result<Option<Box<dyn ForceSource>>> {
    let Some(force) = &config.force else {
        return Ok(None);
    };
    let path = match &place {
        Some(Place::Port(path)) => path,
        None => &force.port,
    };
    let port = open_port(path, force.baud)?;
    Ok(Some(Box::new(SerialForce::new(
        port,
        force.protocol,
        force.latency_s,
        force.correction(),
        force.range_n,
    ))))
}
