//! `[field_box]`: a box on a USB port that reads forces, position and lines, and can stop the amplifier on its own.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::refusal::{Refused, require_range};

/// Hexadecimal digits of a box's serial number.
const SERIAL_DIGITS: usize = 16;

/// `[field_box]`: the field box; required if another section names it as its source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FieldBox {
    /// Serial port of the box.
    pub port: PathBuf,
    /// Serial number of the box, hexadecimal; any connected box if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Shortest time from a conversion to its arrival at the computer, s.
    #[serde(default)]
    pub latency_s: f64,
}

impl FieldBox {
    pub(super) fn check(&self) -> Result<(), Refused> {
        require_range("field_box.latency_s", self.latency_s, 0.0, 0.1, "s")?;
        let digits = |serial: &String| {
            serial.len() == SERIAL_DIGITS && serial.bytes().all(|byte| byte.is_ascii_hexdigit())
        };
        match &self.serial {
            Some(serial) if !digits(serial) => {
                let why = format!(
                    "field_box.serial = \"{serial}\" is not a serial number of a box, {SERIAL_DIGITS} hexadecimal \
                     digits such as \"E661410403002A21\": `friction-bench check` shows the serial number of the box \
                     that is plugged in"
                );
                Err(Refused::new("field_box.serial", why))
            }
            _ => Ok(()),
        }
    }

    /// Returns the identification of this box: its serial number, or else its port.
    #[must_use]
    pub fn identity(&self) -> String {
        match &self.serial {
            Some(serial) => serial.to_ascii_uppercase(),
            None => self.port.display().to_string(),
        }
    }
}

/// `[force.field_box]`: the force sensor on the box's converter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BoxForce {
    /// Force at the positive end of the converter's range, normal and lateral, N; negative for a reversed axis.
    pub newtons_per_full_scale: [f64; 2],
}

impl BoxForce {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let key = "force.field_box.newtons_per_full_scale";
        let checked = self.newtons_per_full_scale;
        checked
            .iter()
            .try_for_each(|newtons| require_range(key, newtons.abs(), 0.1, 1e4, "N"))
    }
}
