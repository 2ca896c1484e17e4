//! Quantities that a rule can limit, and their units.

use std::fmt;

use statistics::significant;

/// Quantity that a rule limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Normal force, N.
    Normal,
    /// Lateral force, N.
    Lateral,
    /// Speed of the finger along the plate, m/s.
    Speed,
}

impl Quantity {
    /// Returns the units in which a rule may state the quantity.
    #[must_use]
    pub fn units(self) -> &'static str {
        match self {
            Self::Normal | Self::Lateral => "N or mN",
            Self::Speed => "mm/s, cm/s or m/s",
        }
    }

    /// Returns the SI value of `unit`, if it is one of the quantity's.
    pub(crate) fn unit(self, unit: &str) -> Option<f64> {
        match (self, unit) {
            (Self::Normal | Self::Lateral, "N") | (Self::Speed, "m/s") => Some(1.0),
            (Self::Normal | Self::Lateral, "mN") | (Self::Speed, "mm/s") => Some(1e-3),
            (Self::Speed, "cm/s") => Some(1e-2),
            _ => None,
        }
    }

    /// Returns a value with its unit, as printed for people.
    #[must_use]
    pub fn text(self, value: f64) -> String {
        match self {
            Self::Normal | Self::Lateral => {
                format!("{} N", significant((value * 1e4).round() / 1e4))
            }
            Self::Speed => format!("{} mm/s", significant((value * 1e4).round() / 10.0)),
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Normal => "the normal force",
            Self::Lateral => "the lateral force",
            Self::Speed => "the speed",
        })
    }
}
