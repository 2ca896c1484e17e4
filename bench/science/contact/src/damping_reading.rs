//! Readings of the published "damping factor 0.3".

/// The published number.
const PUBLISHED: f64 = 0.3;

/// Meaning of the published "damping factor 0.3" of the contact, a Kelvin–Voigt element Z_c = k_c/(iω) + b_c.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DampingReading {
    /// Loss factor η = ω b_c/k_c: b_c = 0.3 k_c/ω.
    LossFactor,
    /// Damping ratio ζ: b_c = 0.6 k_c/ω.
    Ratio,
}

impl DampingReading {
    /// Name of the setting.
    pub const NAME: &'static str = "damping";
    /// Names of the readings.
    pub const ALLOWED: &'static str = "loss_factor, ratio";

    /// Returns the reading with this name, which may be quoted as in TOML.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name.trim_matches('"') {
            "loss_factor" => Some(Self::LossFactor),
            "ratio" => Some(Self::Ratio),
            _ => None,
        }
    }

    /// Returns the contact's loss factor η at the carrier.
    ///
    /// ```text
    ///  b_c = 2 ζ √(k_c m) = 2 ζ k_c/ω_n,   ω_n = √(k_c/m)      damping ratio of k_c and b_c with a mass m
    ///  η = ω b_c/k_c = 2 ζ ω/ω_n = 2 ζ     at ω = ω_n
    /// ```
    /// The paper names no mass of the contact; its one frequency is the carrier, which is therefore taken as ω_n.
    #[must_use]
    pub fn loss_factor(self) -> f64 {
        match self {
            Self::LossFactor => PUBLISHED,
            Self::Ratio => 2.0 * PUBLISHED,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damping_ratio_is_half_the_loss_factor_of_an_oscillator_at_its_resonance() {
        let (stiffness, mass) = (2e6_f64, 3e-4_f64);
        let resonance = (stiffness / mass).sqrt();
        let damping = 2.0 * PUBLISHED * (stiffness * mass).sqrt();
        let loss_factor = resonance * damping / stiffness;
        assert!((DampingReading::Ratio.loss_factor() - loss_factor).abs() < 1e-12);
        assert_eq!(
            DampingReading::LossFactor.loss_factor(),
            crate::AssumedConstants::ESTIMATION.loss_factor
        );
    }
}
