//! The modal mass or the force factor, one of which a sweep needs for the other.

use std::f64::consts::TAU;

use metrology::FittedValue;

/// Known scale of the mode: one sweep determines only the ratio of force factor and modal mass, or of its square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModalScale {
    /// The modal mass, kg.
    ModalMass(FittedValue),
    /// The force factor, N/V.
    ForceFactor(FittedValue),
}

/// Constants of a plate by a sweep and a modal scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptConstants {
    /// Modal mass m_p, kg.
    pub modal_mass_kg: FittedValue,
    /// Force factor γ, N/V.
    pub force_factor_n_per_v: FittedValue,
    /// Damping b_p = ω0 m_p/Q, N·s/m.
    pub damping_n_s_per_m: FittedValue,
    /// Stiffness k_p = ω0² m_p, N/m.
    pub stiffness_n_per_m: FittedValue,
    /// Static displacement over voltage of the mode, γ/k_p, m/V.
    pub displacement_m_per_v: FittedValue,
}

fn relative(value: FittedValue) -> f64 {
    (value.standard_error / value.value).abs()
}

fn with_relative(value: f64, error: f64) -> FittedValue {
    FittedValue {
        value,
        standard_error: (value * error).abs(),
    }
}

impl SweptConstants {
    /// Returns the constants of the mode with this resonance (Hz), quality and static response, which is charge over voltage
    /// (C/V) if `is_electrical`, and else displacement over voltage (m/V).
    pub(crate) fn new(
        resonance_hz: FittedValue,
        quality: FittedValue,
        static_response: FittedValue,
        is_electrical: bool,
        scale: ModalScale,
    ) -> Self {
        let omega = TAU * resonance_hz.value;
        let [f0_error, response_error] = [resonance_hz, static_response].map(relative);
        let response = static_response.value;
        // Charge: A = γ²/k_p; displacement: A = γ/k_p; k_p = ω0² m_p.
        let (power, share) = if is_electrical {
            (2.0, 0.5)
        } else {
            (1.0, 1.0)
        };
        let (mass, force_factor) = match scale {
            ModalScale::ModalMass(mass) => {
                let gamma = (response * omega.powi(2) * mass.value).powf(share);
                let error = share * response_error.hypot(2.0 * f0_error).hypot(relative(mass));
                (mass, with_relative(gamma, error))
            }
            ModalScale::ForceFactor(gamma) => {
                let mass = gamma.value.powf(power) / (response * omega.powi(2));
                let error = response_error
                    .hypot(2.0 * f0_error)
                    .hypot(power * relative(gamma));
                (with_relative(mass, error), gamma)
            }
        };
        let stiffness = omega.powi(2) * mass.value;
        let mass_error = relative(mass);
        Self {
            modal_mass_kg: mass,
            force_factor_n_per_v: force_factor,
            damping_n_s_per_m: with_relative(
                omega * mass.value / quality.value,
                relative(quality).hypot(f0_error).hypot(mass_error),
            ),
            stiffness_n_per_m: with_relative(stiffness, (2.0 * f0_error).hypot(mass_error)),
            displacement_m_per_v: with_relative(
                force_factor.value / stiffness,
                // Of a charge, A/γ.
                if is_electrical {
                    response_error.hypot(relative(force_factor))
                } else {
                    response_error
                },
            ),
        }
    }
}
