//! `[friction]`: friction effects in addition to the load carried by the asperities.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Friction beyond `Huloux 2021`, Eq. 19; no addition by default.
///
/// The growth of friction on glass by first-order kinetics over about 20 s as sweat softens the skin is measured: Dzidek et al.
/// 2017, PNAS 114(41); Adams et al. 2013, J. R. Soc. Interface 10. All other laws here, and all sizes, are assumptions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FrictionTable {
    /// Share of the friction coefficient that levitation does not reduce; drawn for a person if `spread` gives a range.
    pub floor: f64,
    /// Exponent of the sliding speed, relative to 50 mm/s, in the friction coefficient; drawn for a person if `spread` gives a
    /// range.
    pub speed_exponent: f64,
    /// Relative growth of the friction coefficient after a long touch; drawn for a person if `spread` gives a range.
    pub ageing: f64,
    /// Time constant of the growth during touch, and of its loss after lift-off, s; drawn for a person if `spread` gives a
    /// range.
    pub ageing_time_s: f64,
    /// Exponent of the normal force, relative to 1 N, in the friction coefficient.
    pub load_exponent: f64,
    /// Lateral force per sliding speed, independent of the normal force, N·s/m.
    pub viscous_n_s_per_m: f64,
}

impl Default for FrictionTable {
    fn default() -> Self {
        Self {
            floor: 0.0,
            speed_exponent: 0.0,
            ageing: 0.0,
            ageing_time_s: 8.0,
            load_exponent: 0.0,
            viscous_n_s_per_m: 0.0,
        }
    }
}

impl FrictionTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "friction", self,
            floor: 0.0, 0.9, "";
            speed_exponent: -0.5, 0.5, "";
            ageing: -0.5, 5.0, "";
            ageing_time_s: 0.1, 1e3, "s";
            load_exponent: -0.5, 0.5, "";
            viscous_n_s_per_m: 0.0, 20.0, "N·s/m";
        }
        Ok(())
    }
}
