//! The source that `bench.toml` names.

use std::net::SocketAddr;
use std::path::PathBuf;

use config::{Config, Sensor};

use crate::force_source::ForceSource;
use crate::netft::open_net;
use crate::serial::{SerialForce, open_port};

/// Where the force sensor is, in the place of what is configured: a simulated one has no fixed place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A serial port.
    Port(PathBuf),
    /// An address in the network.
    Address(SocketAddr),
}

/// The force sensor that is there is of another source than the configured one.
#[derive(Debug, thiserror::Error)]
#[error("the force sensor that is there needs force.source = \"{0}\" in bench.toml")]
struct OtherSensor(&'static str);

/// Opens the force sensor of `config`, at `place` if it is given; `None` for a bench without one.
///
/// # Errors
/// When the sensor is missing, busy or forbidden.
pub fn open(config: &Config, place: Option<Place>) -> anyhow::Result<Option<Box<dyn ForceSource>>> {
    let Some(force) = &config.force else {
        return Ok(None);
    };
    let (correction, range_n) = (force.correction(), force.range_n);
    Ok(Some(match &force.sensor {
        Sensor::Serial(serial) => {
            let path = match &place {
                Some(Place::Port(path)) => path,
                Some(Place::Address(_)) => return Err(OtherSensor("netft").into()),
                None => &serial.port,
            };
            let port = open_port(path, serial.baud)?;
            let protocol = serial.protocol;
            Box::new(SerialForce::new(
                port,
                protocol,
                force.latency_s,
                correction,
                range_n,
            ))
        }
        Sensor::Netft(netft) => {
            let address = match place {
                Some(Place::Address(address)) => Some(address),
                Some(Place::Port(_)) => return Err(OtherSensor("serial").into()),
                None => None,
            };
            Box::new(open_net(
                netft,
                address,
                force.latency_s,
                correction,
                range_n,
            )?)
        }
    }))
}
