//! `[force.netft]`: an ATI Net F/T on the network.

use std::net::{IpAddr, SocketAddr};

use serde::{Deserialize, Serialize};

use crate::refusal::{Refused, require_range};
use crate::six_axis::SixAxis;

/// UDP port on which a Net F/T serves raw data transfer (ATI 9620-05-NET FT, section 10).
const RDT_PORT: u16 = 49_152;

/// `[force.netft]`: an ATI Net F/T, which sends its readings over UDP on request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Netft {
    /// IP address of the sensor, with its UDP port if that is not 49152.
    pub address: String,
    /// Counts per newton; if absent, read from the device's web page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counts_per_n: Option<f64>,
    /// Rate at which the device counts its samples, Hz.
    pub sample_hz: f64,
    /// Axis that reads the normal force, positive when the finger presses.
    pub normal: SixAxis,
    /// Axis that reads the lateral force, positive towards increasing position.
    pub lateral: SixAxis,
}

impl Default for Netft {
    /// Returns the settings of a device as delivered, mounted with its face up.
    fn default() -> Self {
        Self {
            address: "192.168.1.1".to_owned(),
            counts_per_n: None,
            sample_hz: 7000.0,
            normal: SixAxis::PRESS,
            lateral: SixAxis::X,
        }
    }
}

impl Netft {
    pub(super) fn check(&self) -> Result<(), Refused> {
        if self.socket().is_none() {
            let why = format!(
                "force.netft.address = \"{}\" is not an IP address, such as \"192.168.1.1\" or \
                 \"192.168.1.1:{RDT_PORT}\"",
                self.address
            );
            return Err(Refused::new("force.netft.address", why));
        }
        if let Some(counts_per_n) = self.counts_per_n {
            require_range("force.netft.counts_per_n", counts_per_n, 1.0, 1e9, "1/N")?;
        }
        require_range("force.netft.sample_hz", self.sample_hz, 500.0, 20e3, "Hz")?;
        if self.normal.is_along(self.lateral) {
            let why = format!(
                "force.netft.normal = \"{}\" and force.netft.lateral = \"{}\" lie along one axis: name two across each other",
                self.normal, self.lateral
            );
            return Err(Refused::new("force.netft.lateral", why));
        }
        Ok(())
    }

    /// Returns the socket address for requests; `None` if the address is invalid, which a checked configuration excludes.
    #[must_use]
    pub fn socket(&self) -> Option<SocketAddr> {
        let bare_address = |text: &str| {
            let ip: IpAddr = text.parse().ok()?;
            Some(SocketAddr::new(ip, RDT_PORT))
        };
        let address = bare_address(&self.address).or_else(|| self.address.parse().ok());
        address.filter(|address| address.port() != 0 && !address.ip().is_unspecified())
    }

    pub(crate) fn identity(&self) -> String {
        let Self {
            address,
            normal,
            lateral,
            ..
        } = self;
        format!("netft {address}, normal {normal}, lateral {lateral}")
    }
}
