//! Forces and motion of the skin at the carrier, from the measured impedance (Huloux 2021, section V-A).

use crate::harmonic;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Forces on the skin and its motion, frame by frame. Phases are relative to the plate: a real force is in phase with ṽ_p,
/// a real displacement with x̃_p.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SkinMotion {
    /// f̃ = (Z_m − Z_p) ṽ_p, the reaction of the finger on the plate (Huloux 2021, Eq. 10), peak, N, relative to ṽ_p; for
    /// `dynamic` with Z_m and ṽ_p under the finger.
    pub reaction_force_n: Vec<Complex64>,
    /// Z_c (ṽ_p − ṽ_t), the force of the contact with the estimated stiffness and the assumed loss factor (Eq. 7), peak, N,
    /// relative to ṽ_p. It equals the reaction force if the contact has the assumed loss factor.
    pub contact_force_n: Vec<Complex64>,
    /// x̃_t/x̃_p (Eq. 11).
    pub skin_per_plate: Vec<Complex64>,
    /// ½ Re(f̃ ṽ_p*), mean power from the plate into contact and skin, W.
    pub plate_power_w: Vec<f64>,
    /// ½ Re Z_t |ṽ_t|², mean power into the skin, W; the rest is dissipated in the contact.
    pub skin_power_w: Vec<f64>,
}

/// Impedances of one method, N·s/m, and the carrier.
#[derive(Debug, Clone, Copy)]
pub struct Impedances {
    /// Z_p of the unloaded plate.
    pub z_p_n_s_per_m: Complex64,
    /// Z_t of the skin.
    pub z_t_n_s_per_m: Complex64,
    /// Loss factor of the contact.
    pub loss_factor: f64,
    /// Carrier, rad/s.
    pub carrier_rad_per_s: f64,
}

impl Impedances {
    /// Returns f̃ = (Z_m − Z_p) ṽ_p (Huloux 2021, Eq. 10), peak, N, relative to ṽ_p, for an amplitude |x̃_p|, m.
    #[must_use]
    pub fn reaction_force_n(&self, z_m: Complex64, amplitude_m: f64) -> Complex64 {
        let v_p = Complex64::new(self.carrier_rad_per_s * amplitude_m, 0.0);
        harmonic::contact_force_n(z_m, self.z_p_n_s_per_m, v_p)
    }
}

impl SkinMotion {
    /// Computes the motion from Z_m, N·s/m, the amplitude |x̃_p|, m, and the estimated k_c, N/m, of each frame.
    #[must_use]
    pub fn new(
        impedances: &Impedances,
        z_m: &[Complex64],
        amplitude_m: &[f64],
        k_c_n_per_m: &[f64],
    ) -> Self {
        let omega = impedances.carrier_rad_per_s;
        let (z_p, z_t) = (impedances.z_p_n_s_per_m, impedances.z_t_n_s_per_m);
        let skin_per_plate: Vec<Complex64> = z_m
            .iter()
            .map(|&z_m| harmonic::skin_velocity_m_per_s(z_m, z_p, z_t, Complex64::ONE))
            .collect();
        let reaction_force_n: Vec<Complex64> = z_m
            .iter()
            .zip(amplitude_m)
            .map(|(&z_m, &amplitude)| impedances.reaction_force_n(z_m, amplitude))
            .collect();
        let velocities = || amplitude_m.iter().map(|amplitude| omega * amplitude);
        Self {
            contact_force_n: velocities()
                .zip(k_c_n_per_m)
                .zip(&skin_per_plate)
                .map(|((v_p, &k_c), skin)| {
                    harmonic::contact_impedance(k_c, impedances.loss_factor, omega)
                        * (1.0 - skin)
                        * v_p
                })
                .collect(),
            plate_power_w: velocities()
                .zip(&reaction_force_n)
                .map(|(v_p, force)| 0.5 * force.re * v_p)
                .collect(),
            skin_power_w: velocities()
                .zip(&skin_per_plate)
                .map(|(v_p, skin)| 0.5 * z_t.re * (skin.norm() * v_p).powi(2))
                .collect(),
            reaction_force_n,
            skin_per_plate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonic::{HarmonicMotion, observed};
    use approx::assert_relative_eq;

    /// Compares with the two degrees of freedom solved directly (Eqs. 4–8).
    #[test]
    fn forces_and_motion_are_those_of_the_two_degrees_of_freedom() {
        let omega = std::f64::consts::TAU * 35e3;
        let (z_p, z_t) = (Complex64::new(7.0, 0.2), Complex64::new(0.47, 3.16));
        let impedances = Impedances {
            z_p_n_s_per_m: z_p,
            z_t_n_s_per_m: z_t,
            loss_factor: 0.3,
            carrier_rad_per_s: omega,
        };
        for k_c in [2e4, 3e5, 4e6] {
            let z_c = harmonic::contact_impedance(k_c, 0.3, omega);
            let z_m = observed(z_p, z_t, z_c);
            let drive_n = Complex64::new(3.0, 1.0);
            let harmonic_motion = HarmonicMotion::under_force(drive_n, z_p, z_t, z_c);
            let v_p = harmonic_motion.plate_m_per_s;
            let amplitude_m = v_p.norm() / omega;
            let motion = SkinMotion::new(&impedances, &[z_m], &[amplitude_m], &[k_c]);

            // The part of the drive that does not move the plate acts on the finger; rotated to the plate's phase.
            let finger_force_n = (drive_n - z_p * v_p) * v_p.norm() / v_p;
            let reaction = motion.reaction_force_n[0];
            assert_relative_eq!(reaction.re, finger_force_n.re, max_relative = 1e-9);
            assert_relative_eq!(reaction.im, finger_force_n.im, max_relative = 1e-9);
            assert_relative_eq!(
                (motion.contact_force_n[0] - finger_force_n).norm(),
                0.0,
                epsilon = 1e-9 * finger_force_n.norm()
            );
            let skin = motion.skin_per_plate[0];
            assert_relative_eq!(
                (skin - harmonic_motion.transmission()).norm(),
                0.0,
                epsilon = 1e-9
            );
            // Power from the plate equals power into the skin and into the contact's damper.
            let slip = v_p - harmonic_motion.skin_m_per_s;
            let contact_power_w = 0.5 * z_c.re * slip.norm_sqr();
            assert_relative_eq!(
                motion.plate_power_w[0],
                motion.skin_power_w[0] + contact_power_w,
                max_relative = 1e-9
            );
        }
    }
}
