//! Plate, contact and tissue at the carrier (Huloux 2021, Eqs. 4–12 and 21).
//!
//! ```text
//!  f_a → plate Z_p ──┬── contact Z_c ──┬── tissue Z_t
//!               v_p  │                 │  v_t
//! ```
//! Complex envelopes with exp(+iωt) throughout; impedances in N·s/m.
//!
//! The actuators move the plate, and the plate moves the tissue through the contact. Contact and tissue carry the same
//! force f̃_c, so their mobilities add to that of the finger, Z_F = Z_m − Z_p:
//! ```text
//!  f̃_a = Z_p ṽ_p + f̃_c,    f̃_c = Z_c (ṽ_p − ṽ_t) = Z_t ṽ_t = Z_F ṽ_p
//!  1/Z_F = 1/Z_t + 1/Z_c    ⇒    Z_F = Z_t Z_c/(Z_t + Z_c),    Z_c = Z_F Z_t/(Z_t − Z_F)
//! ```

use num_complex::Complex64;

/// A mass, a spring and a damper moving together: iω m + k/(iω) + b (Huloux 2021, Eqs. 4–6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonator {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Stiffness k, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping b, N·s/m.
    pub damping_n_s_per_m: f64,
}

impl Resonator {
    /// Returns the impedance at an angular frequency, N·s/m.
    pub fn impedance_n_s_per_m(&self, carrier_rad_per_s: f64) -> Complex64 {
        let reactance =
            carrier_rad_per_s * self.mass_kg - self.stiffness_n_per_m / carrier_rad_per_s;
        Complex64::new(self.damping_n_s_per_m, reactance)
    }
}

/// Returns Z_c = k_c/(iω) + η k_c/ω = (η − i) k_c/ω, N·s/m (Huloux 2021, Eq. 7; η is a loss factor).
pub fn contact_impedance(k_c_n_per_m: f64, loss_factor: f64, carrier_rad_per_s: f64) -> Complex64 {
    Complex64::new(loss_factor, -1.0) * (k_c_n_per_m / carrier_rad_per_s)
}

/// Returns k_c = −ω Im Z_c, N/m.
pub fn stiffness_n_per_m(z_c: Complex64, carrier_rad_per_s: f64) -> f64 {
    -carrier_rad_per_s * z_c.im
}

/// Returns b_c = Re Z_c, N·s/m.
pub fn damping_n_s_per_m(z_c: Complex64) -> f64 {
    z_c.re
}

/// Returns Z_m = Z_p + Z_t Z_c/(Z_t + Z_c), N·s/m (Huloux 2021, Eq. 9).
pub fn observed(z_p: Complex64, z_t: Complex64, z_c: Complex64) -> Complex64 {
    z_p + z_t * z_c / (z_t + z_c)
}

/// Returns Z_c = (Z_m − Z_p) Z_t/(Z_t − Z_m + Z_p), N·s/m (Huloux 2021, Eq. 12), the inverse of [`observed`].
///
/// ```
/// use contact::harmonic::{contact_from_observed, observed};
/// use num_complex::Complex64;
///
/// let (z_p, z_t) = (Complex64::new(7.0, 0.0), Complex64::new(0.47, 3.16));
/// let z_c = Complex64::new(0.5, -1.7);
/// let z_m = observed(z_p, z_t, z_c);
/// assert!((contact_from_observed(z_m, z_p, z_t) - z_c).norm() < 1e-12);
/// ```
pub fn contact_from_observed(z_m: Complex64, z_p: Complex64, z_t: Complex64) -> Complex64 {
    let finger = z_m - z_p;
    finger * z_t / (z_t - finger)
}

/// Returns Z_t = (Z_m⁰ − Z_p) Z_c⁰/(Z_c⁰ − Z_m⁰ + Z_p), N·s/m (Huloux 2021, Eq. 21): Eq. 12 with contact and tissue
/// exchanged.
pub fn tissue_from_observed(z_m0: Complex64, z_p: Complex64, z_c0: Complex64) -> Complex64 {
    contact_from_observed(z_m0, z_p, z_c0)
}

/// Returns f̃_c = (Z_m − Z_p) ṽ_p, N (Huloux 2021, Eq. 10).
pub fn contact_force_n(z_m: Complex64, z_p: Complex64, v_p_m_per_s: Complex64) -> Complex64 {
    (z_m - z_p) * v_p_m_per_s
}

/// Returns ṽ_t = (Z_m − Z_p)/Z_t · ṽ_p, m/s (Huloux 2021, Eq. 11).
pub fn skin_velocity_m_per_s(
    z_m: Complex64,
    z_p: Complex64,
    z_t: Complex64,
    v_p_m_per_s: Complex64,
) -> Complex64 {
    (z_m - z_p) / z_t * v_p_m_per_s
}

/// Velocities of plate and skin under a harmonic force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicMotion {
    /// Velocity of the plate ṽ_p, m/s.
    pub plate_m_per_s: Complex64,
    /// Velocity of the skin ṽ_t, m/s.
    pub skin_m_per_s: Complex64,
}

impl HarmonicMotion {
    /// Solves the two degrees of freedom (Z_p + Z_c) ṽ_p − Z_c ṽ_t = f̃_a, (Z_t + Z_c) ṽ_t = Z_c ṽ_p (Huloux 2021, Eqs.
    /// 4–8) under the actuator force `f_a_n`, by Cramer's rule.
    pub fn under_force(f_a_n: Complex64, z_p: Complex64, z_t: Complex64, z_c: Complex64) -> Self {
        // D = (Z_p + Z_c)(Z_t + Z_c) − Z_c²,  ṽ_p = f̃_a (Z_t + Z_c)/D,  ṽ_t = f̃_a Z_c/D; f̃_a/ṽ_p = D/(Z_t + Z_c) is Eq. 9.
        let determinant = (z_p + z_c) * (z_t + z_c) - z_c * z_c;
        Self {
            plate_m_per_s: f_a_n * (z_t + z_c) / determinant,
            skin_m_per_s: f_a_n * z_c / determinant,
        }
    }

    /// Returns the transmission ṽ_t/ṽ_p.
    pub fn transmission(&self) -> Complex64 {
        self.skin_m_per_s / self.plate_m_per_s
    }
}
