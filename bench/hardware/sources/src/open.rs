//! Creation of the force source that `bench.toml` names.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Context;
use config::{Config, Sensor};
use signalgen::InputTap;

use crate::channels::GaugeForce;
use crate::field_box::FieldBoxDevice;
use crate::force_source::ForceSource;
use crate::netft::open_net;
use crate::serial::{SerialForce, open_port};

/// Address of the force sensor that replaces the configured one; a simulated sensor has no fixed address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A serial port.
    Port(PathBuf),
    /// An address in the network.
    Address(SocketAddr),
}

/// The present force sensor does not match the configured source.
#[derive(Debug, thiserror::Error)]
#[error("the force sensor that is there needs force.source = \"{0}\" in bench.toml")]
struct OtherSensor(&'static str);

/// Returns the input channels that the force sensor of `config` reads; empty for a sensor that is not on the card.
#[must_use]
pub fn tapped(config: &Config) -> Vec<u16> {
    match config.force.as_ref().map(|force| &force.sensor) {
        Some(Sensor::Channels(gauges)) => gauges.inputs.clone(),
        _ => Vec::new(),
    }
}

/// Opens the force sensor of `config`: at `place` if given, on the inputs delivered by `tap`, or on `field_box`; `None` for a
/// bench without a force sensor.
///
/// # Errors
/// If the sensor is missing, busy or forbidden.
pub fn open(
    config: &Config,
    place: Option<Place>,
    tap: Option<InputTap>,
    field_box: Option<&FieldBoxDevice>,
) -> anyhow::Result<Option<Box<dyn ForceSource>>> {
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
        Sensor::Channels(gauges) => {
            if place.is_some() {
                return Err(OtherSensor("serial\" or \"netft").into());
            }
            let tap = tap.context("the inputs of force.channels are not handed out")?;
            let card_hz = f64::from(config.audio.rate_hz);
            let latency_s = force.latency_s;
            Box::new(GaugeForce::new(
                tap, gauges, card_hz, latency_s, correction, range_n,
            ))
        }
        Sensor::FieldBox(table) => {
            let field_box = field_box
                .context("no field box is open: force.source = \"field-box\" needs one")?;
            field_box.force(table, force.latency_s, correction, range_n)
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
