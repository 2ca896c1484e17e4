//! Inversion of a sample's impedance to stiffness, gap and friction, with standard errors by the delta method.
//!
//! The pickup reads Z_m = Z_p + s G. The scale ln s = 2 ln φ + iα + ε has the ratio φ of the amplitude under the finger to that
//! at the pickup, a rotation α by another mode, and a calibration error ε. Other modes add a mobility Y to the finger's 1/Z_F:
//! ```text
//!  1/G = 1/Z_F + Y      ⇒    Z_F = G/(1 − Y G),    G = (Z_m − Z_p)/s
//!  1/Z_F = 1/Z_c + 1/Z_t ⇒   Z_c = Z_F Z_t/(Z_t − Z_F)                      Huloux 2021, Eq. 12
//!  k_c = −ω Im Z_c,          k_c = K(x, θ) (Eq. 18) gives x, μ/μ0 = f_r(x)/⟨f_c⟩ (Eq. 19)
//! ```
//! Each quantity y carries its slopes ∂y/∂θ by the parameters θ and the deviation n due to the sample's own noise. Its
//! variance is, to first order, (∂y/∂θ)ᵀ C (∂y/∂θ) + n², with C the covariance of θ; both parts are independent if the sample
//! had no part in the fit, and nearly so if it was one of many.

use nalgebra::{SMatrix, SVector};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::contact::{Contact, StiffnessBranch};
use crate::error::ModelError;
use crate::harmonic::{contact_from_observed, stiffness_n_per_m};
use crate::parameters::{ContactSlopes, LoadSlopes};
use crate::stored_arrays::{complex, square};

/// A quantity of one sample with its derivatives by the fitted parameters, the first of them ln σ_t, and its noise from
/// that sample's impedance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dependent<const N: usize> {
    /// Value, in the quantity's unit.
    pub value: f64,
    /// ∂value/∂parameter.
    pub slopes: SVector<f64, N>,
    /// Standard deviation due to the sample's own noise.
    pub noise: f64,
}

impl<const N: usize> Dependent<N> {
    /// Returns an unknown quantity: NaN throughout.
    pub fn unknown() -> Self {
        Self {
            value: f64::NAN,
            slopes: SVector::repeat(f64::NAN),
            noise: f64::NAN,
        }
    }
}

/// Inversion of the measured impedance to stiffness, gap and friction, with fitted parameters and their covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Inversion<const N: usize> {
    /// The contact with its σ_t.
    pub contact: Contact,
    /// Derivatives of the sample's load by parameters; zero where it does not depend on them.
    pub load: LoadSlopes,
    /// Angular frequency of the carrier, rad/s.
    pub carrier_rad_per_s: f64,
    /// Impedance of the unloaded plate, N·s/m.
    pub z_p: Complex64,
    /// Impedance of the tissues, N·s/m.
    pub z_t: Complex64,
    /// ∂Z_t/∂parameter.
    #[serde(with = "complex")]
    pub z_t_slopes: [Complex64; N],
    /// ∂Z_p/∂parameter.
    #[serde(with = "complex")]
    pub z_p_slopes: [Complex64; N],
    /// Ratio of the measured to the true finger part of Z_m.
    pub finger_scale: Complex64,
    /// ∂ ln `finger_scale`/∂parameter.
    #[serde(with = "complex")]
    pub finger_slopes: [Complex64; N],
    /// Mobility that other modes of the plate add to the finger's part of Z_m, m/(N·s).
    pub residual_mobility: Complex64,
    /// ∂`residual_mobility`/∂parameter.
    #[serde(with = "complex")]
    pub residual_slopes: [Complex64; N],
    /// Covariance of the parameters; `None` if unknown or infinite.
    #[serde(with = "square")]
    pub covariance: Option<SMatrix<f64, N, N>>,
}

impl<const N: usize> Inversion<N> {
    /// Returns the standard error of a quantity from the parameters' covariance and the sample's noise.
    pub fn std(&self, quantity: &Dependent<N>) -> f64 {
        self.covariance.map_or(f64::INFINITY, |c| {
            (quantity.slopes.dot(&(c * quantity.slopes)) + quantity.noise.powi(2)).sqrt()
        })
    }

    /// Returns k_c by Eq. 12, N/m; `z_m_std` is the standard deviation of one component of Z_m.
    pub fn stiffness(&self, z_m: Complex64, z_m_std: f64) -> Dependent<N> {
        let z_observed = (z_m - self.z_p) / self.finger_scale;
        let correction = (1.0 - self.residual_mobility * z_observed).inv();
        let finger = z_observed * correction;
        let rest = self.z_t - finger;
        // From 1/Z_c = 1/Z_F − 1/Z_t: ∂Z_c/∂Z_F = (Z_c/Z_F)² = (Z_t/(Z_t − Z_F))² and ∂Z_c/∂Z_t = −(Z_F/(Z_t − Z_F))².
        let by_z_t = -(finger / rest).powi(2);
        let by_z_m = (self.z_t / rest).powi(2);
        Dependent {
            value: stiffness_n_per_m(
                contact_from_observed(self.z_p + finger, self.z_p, self.z_t),
                self.carrier_rad_per_s,
            ),
            slopes: SVector::from_fn(|i, _| {
                // ∂G/∂θ = −(∂Z_p/∂θ)/s − G ∂ln s/∂θ, and 1/Z_F = 1/G − Y gives ∂Z_F/∂θ = (Z_F/G)² ∂G/∂θ + Z_F² ∂Y/∂θ. With the
                // sign turned: −∂G/∂θ here, −∂Z_F/∂θ in the next line.
                let by_observed =
                    self.z_p_slopes[i] / self.finger_scale + z_observed * self.finger_slopes[i];
                let by_finger = by_observed * correction * correction
                    - finger * finger * self.residual_slopes[i];
                let slope = by_z_t * self.z_t_slopes[i] - by_z_m * by_finger;
                -self.carrier_rad_per_s * slope.im
            }),
            // Noise of independent parts with deviation σ stays so under a complex factor c, with |c| σ.
            noise: self.carrier_rad_per_s * (by_z_m * correction * correction).norm() * z_m_std
                / self.finger_scale.norm(),
        }
    }

    /// Returns the gap from stiffness and amplitude, m.
    pub fn gap(&self, k_c: &Dependent<N>, amplitude_m: f64) -> Result<Dependent<N>, ModelError> {
        let gap_m = self.contact.gap_from_stiffness_m(k_c.value, amplitude_m)?;
        let gap_slope = self.contact.stiffness_slope_n_per_m2(gap_m, amplitude_m);
        let slopes = self.contact.stiffness_slopes_n_per_m(gap_m, amplitude_m);
        Ok(self.implicit(gap_m, k_c, gap_slope, &slopes))
    }

    /// Returns the gap from stiffness in force balance, m.
    pub fn balance_gap(
        &self,
        k_c: &Dependent<N>,
        normal_n: f64,
    ) -> Result<(Dependent<N>, StiffnessBranch), ModelError> {
        let inverted = self
            .contact
            .gap_from_balance_stiffness(k_c.value, normal_n)?;
        let gap_slope = self
            .contact
            .balance_stiffness_slope_n_per_m2(inverted.gap_m, normal_n);
        let slopes = self
            .contact
            .balance_stiffness_slopes_n_per_m(inverted.gap_m, normal_n);
        Ok((
            self.implicit(inverted.gap_m, k_c, gap_slope, &slopes),
            inverted.branch,
        ))
    }

    /// Returns the friction ratio μ/μ0.
    pub fn friction_ratio(&self, gap: &Dependent<N>, normal_n: f64) -> Dependent<N> {
        let sigma = self.contact.sigma_t_m();
        let value = self.contact.friction_ratio(gap.value, normal_n);
        let contact_slopes = self.contact.friction_ratio_slopes(gap.value, normal_n);
        Dependent {
            value,
            // d(μ/μ0)/dθ = −(μ/μ0)/σ_t · dx/dθ + ∂(μ/μ0)/∂θ at a given gap.
            slopes: gap.slopes * (-value / sigma)
                + SVector::from_fn(|i, _| contact_slopes.by_parameter(i, &self.load)),
            noise: value / sigma * gap.noise,
        }
    }

    /// Returns the gap implied by a stiffness; `contact_slopes` gives the derivatives of the stiffness by the contact at a given gap.
    fn implicit(
        &self,
        gap_m: f64,
        k_c: &Dependent<N>,
        by_gap: f64,
        contact_slopes: &ContactSlopes,
    ) -> Dependent<N> {
        // k_c(θ) = K(x, θ)  ⇒  dx/dθ = (dk_c/dθ − ∂K/∂θ)/(∂K/∂x).
        let by_parameters = SVector::from_fn(|i, _| contact_slopes.by_parameter(i, &self.load));
        Dependent {
            value: gap_m,
            slopes: (k_c.slopes - by_parameters) / by_gap,
            noise: k_c.noise / by_gap.abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::assumed::AssumedConstants;

    const Z_M: Complex64 = Complex64::new(7.9, 2.1);

    /// Real and imaginary parts of Z_p, of Z_t, of the scale's logarithm and of the residual mobility.
    const PARAMETERS: usize = 8;

    fn inversion(parameters: [f64; PARAMETERS]) -> Inversion<PARAMETERS> {
        let unit = |index: usize| {
            let mut slopes = [Complex64::ZERO; PARAMETERS];
            (slopes[index], slopes[index + 1]) = (Complex64::ONE, Complex64::I);
            slopes
        };
        let pair = |index: usize| Complex64::new(parameters[index], parameters[index + 1]);
        Inversion {
            contact: Contact::new(&AssumedConstants::default(), 1.7e-6).unwrap(),
            load: LoadSlopes::default(),
            carrier_rad_per_s: std::f64::consts::TAU * 35e3,
            z_p: pair(0),
            z_t: pair(2),
            z_t_slopes: unit(2),
            z_p_slopes: unit(0),
            finger_scale: pair(4).exp(),
            finger_slopes: unit(4),
            residual_mobility: pair(6),
            residual_slopes: unit(6),
            covariance: None,
        }
    }

    const AT: [f64; PARAMETERS] = [7.0, 0.1, 0.5, 3.1, 0.02, 0.03, 0.004, 0.02];

    #[test]
    fn slopes_of_the_stiffness_are_derivatives() {
        let stiffness = |parameters: [f64; PARAMETERS]| inversion(parameters).stiffness(Z_M, 0.0);
        let slopes = stiffness(AT).slopes;
        for (index, expected) in slopes.iter().enumerate() {
            let displaced = |step: f64| {
                let mut parameters = AT;
                parameters[index] += step;
                stiffness(parameters).value
            };
            let slope = (displaced(1e-6) - displaced(-1e-6)) / 2e-6;
            assert_relative_eq!(*expected, slope, max_relative = 1e-5);
        }
    }

    /// Regression test: the derivative by the normal force was 0.
    #[test]
    fn slopes_of_the_stiffness_in_balance_are_derivatives() {
        let (gap_m, normal_n) = (9e-6, 0.6);
        let stiffness = |[ln_sigma_t, ln_area, ln_q0, ln_force]: [f64; 4]| {
            let mut assumed = AssumedConstants::default();
            assumed.contact_area_m2 *= ln_area.exp();
            assumed.q0_rad_per_m *= ln_q0.exp();
            let contact = Contact::new(&assumed, 1.7e-6 * ln_sigma_t.exp()).unwrap();
            contact.balance_stiffness_n_per_m(gap_m, normal_n * ln_force.exp())
        };
        let contact = Contact::new(&AssumedConstants::default(), 1.7e-6).unwrap();
        let slopes = contact.balance_stiffness_slopes_n_per_m(gap_m, normal_n);
        let expected = [
            slopes.by_ln_sigma_t,
            slopes.by_ln_area,
            slopes.by_ln_q0,
            slopes.by_ln_force,
        ];
        for (index, expected) in expected.into_iter().enumerate() {
            let displaced = |step: f64| {
                let mut logarithms = [0.0; 4];
                logarithms[index] = step;
                stiffness(logarithms)
            };
            let slope = (displaced(1e-5) - displaced(-1e-5)) / 2e-5;
            assert_relative_eq!(expected, slope, max_relative = 1e-6);
        }
    }

    /// A finger on a plate with another mode has 1/(1/Z + Y), which the inversion undoes.
    #[test]
    fn the_contribution_of_another_mode_is_subtracted() {
        let stiffness = |mobility: Complex64| {
            let z_finger = Z_M - Complex64::new(AT[0], AT[1]);
            let mut parameters = AT;
            (parameters[4], parameters[5], parameters[6], parameters[7]) =
                (0.0, 0.0, mobility.re, mobility.im);
            let z_observed = (z_finger.inv() + mobility).inv();
            let z_m = Complex64::new(AT[0], AT[1]) + z_observed;
            inversion(parameters).stiffness(z_m, 0.0).value
        };
        let expected = stiffness(Complex64::ZERO);
        assert_relative_eq!(
            stiffness(Complex64::new(0.001, 0.01)),
            expected,
            max_relative = 1e-12
        );
    }
}
