//! Quantities of a sweep.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use num_complex::Complex64;

/// Quantity that was swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweptQuantity {
    /// Electrical admittance of the actuators, S.
    Admittance,
    /// Electrical impedance of the actuators, Ω.
    Impedance,
    /// Displacement of the plate over the actuators' voltage, m/V.
    Displacement,
    /// Velocity of the plate over the actuators' voltage, m/s/V.
    Velocity,
}

impl SweptQuantity {
    /// All quantities.
    pub const ALL: [Self; 4] = [
        Self::Admittance,
        Self::Impedance,
        Self::Displacement,
        Self::Velocity,
    ];

    /// Returns the name, as options and files state it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Admittance => "admittance",
            Self::Impedance => "impedance",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
        }
    }

    /// Returns the unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Admittance => "S",
            Self::Impedance => "Ω",
            Self::Displacement => "m/V",
            Self::Velocity => "m/s/V",
        }
    }

    /// Returns whether the sweep was measured at the actuators' terminals.
    #[must_use]
    pub fn is_electrical(self) -> bool {
        matches!(self, Self::Admittance | Self::Impedance)
    }

    /// Returns charge over voltage of an electrical value, C/V, and displacement over voltage of a mechanical one, m/V: both
    /// have the static response of the mode as a constant.
    #[must_use]
    pub fn response(self, frequency_hz: f64, value: Complex64) -> Complex64 {
        let derivative = Complex64::new(0.0, TAU * frequency_hz);
        match self {
            Self::Admittance | Self::Velocity => value / derivative,
            Self::Impedance => (value * derivative).inv(),
            Self::Displacement => value,
        }
    }

    /// Returns the response of the conjugate value.
    pub(crate) fn conjugate_response(self, response: Complex64) -> Complex64 {
        match self {
            // The factor 1/(iω) is not conjugated.
            Self::Admittance | Self::Impedance | Self::Velocity => -response.conj(),
            Self::Displacement => response.conj(),
        }
    }
}

impl fmt::Display for SweptQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no swept quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a quantity of a sweep: write admittance, impedance, displacement or velocity"
)]
pub struct UnknownQuantity(String);

impl FromStr for SweptQuantity {
    type Err = UnknownQuantity;

    fn from_str(text: &str) -> Result<Self, UnknownQuantity> {
        let mut all = Self::ALL.into_iter();
        let quantity = all.find(|quantity| quantity.name().eq_ignore_ascii_case(text.trim()));
        quantity.ok_or_else(|| UnknownQuantity(text.to_owned()))
    }
}
