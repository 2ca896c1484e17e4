//! `[encoder]`: the pulley encoder.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// The pulley encoder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct EncoderTable {
    /// Quadrature counts per metre of finger travel.
    pub counts_per_m: f64,
}

impl Default for EncoderTable {
    fn default() -> Self {
        Self {
            counts_per_m: 40_000.0,
        }
    }
}

impl EncoderTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "encoder", self,
            counts_per_m: 1e3, 1e7, "1/m";
        }
        Ok(())
    }
}
