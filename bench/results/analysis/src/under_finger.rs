//! Amplitude and impedance under the finger, for a plate with a motion that varies along its length.
//!
//! The pickup reads the mode's amplitude x̃_p; under a finger at x the plate moves with φ(x) x̃_p. The finger's force
//! f̃ acts on the mode with φ f̃, so that Z_m − Z_p is φ² times the finger's own impedance Z_F: f̃_a = Z_p ṽ_p + φ f̃ and
//! f̃ = Z_F φ ṽ_p give Z_m = f̃_a/ṽ_p = Z_p + φ² Z_F. Hence Z_p + (Z_m − Z_p)/φ² and φ x̃_p are the impedance and amplitude of
//! a plate that moves everywhere as this one does under the finger. With these two, Eqs. 9 to 12 and 21 of Huloux 2021 hold
//! unchanged, and f̃ = (Z_m − Z_p) ṽ_p (Eq. 10) is the force on the finger. A drift of the plate itself is divided by φ² too:
//! if it adds y to Z_m, it adds y/φ² here.

use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::amplitude_profile::AmplitudeProfile;
use crate::measurements::FrameSeries;

/// Amplitude and impedance under the finger, frame by frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnderFinger {
    /// φ, the ratio of the amplitude there to the pickup's reading.
    pub ratio: Vec<f64>,
    /// φ|x̃_p|, peak, m.
    pub amplitude_m: Vec<f64>,
    /// Z_p + (Z_m − Z_p)/φ², corrected for envelope dynamics, N·s/m.
    pub z_m_n_s_per_m: Vec<Complex64>,
}

impl UnderFinger {
    /// Returns amplitude and impedance under the finger for the frames of `series`. If Z_p is unknown the impedance remains
    /// Z_m.
    pub fn new(
        series: &FrameSeries,
        profile: &AmplitudeProfile,
        z_p_n_s_per_m: Option<Complex64>,
    ) -> Self {
        let ratio = profile.ratios_along(&series.position_m);
        let amplitude_m = series.amplitude_m.iter().zip(&ratio);
        let z_m = series.frames.iter().map(|frame| frame.corrected_n_s_per_m);
        Self {
            amplitude_m: amplitude_m
                .map(|(amplitude_m, ratio)| amplitude_m * ratio)
                .collect(),
            z_m_n_s_per_m: z_m
                .zip(&ratio)
                .map(|(z_m, &ratio)| z_p_n_s_per_m.map_or(z_m, |z_p| impedance(z_m, z_p, ratio)))
                .collect(),
            ratio,
        }
    }

    /// Returns the part for a range of frames.
    pub fn slice(&self, range: Range<usize>) -> Self {
        Self {
            ratio: self.ratio[range.clone()].to_vec(),
            amplitude_m: self.amplitude_m[range.clone()].to_vec(),
            z_m_n_s_per_m: self.z_m_n_s_per_m[range].to_vec(),
        }
    }
}

/// Returns Z_p + (Z_m − Z_p)/φ²; at φ = 1 exactly Z_m.
pub fn impedance(z_m: Complex64, z_p: Complex64, ratio: f64) -> Complex64 {
    z_m + (z_m - z_p) * ((ratio * ratio).recip() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use contact::harmonic::{self, observed};

    /// Compares with mode and finger solved directly, with φ in the force on the mode and in the motion under the finger.
    #[test]
    fn the_fingers_impedance_and_force_are_recovered_at_any_ratio() {
        let omega = std::f64::consts::TAU * 35e3;
        let (z_p, z_t) = (Complex64::new(7.0, 0.2), Complex64::new(0.47, 3.16));
        let z_c = harmonic::contact_impedance(3e5, 0.3, omega);
        let finger = z_t * z_c / (z_t + z_c);
        for ratio in [0.2, 0.9, 1.0, 1.07, 2.0] {
            let z_m = z_p + ratio * ratio * finger;
            let corrected = impedance(z_m, z_p, ratio);
            let expected = observed(z_p, z_t, z_c);
            assert_relative_eq!((corrected - expected).norm(), 0.0, epsilon = 1e-12);
            let v_p = Complex64::new(0.3, 0.0);
            let force_n = harmonic::contact_force_n(corrected, z_p, ratio * v_p);
            let expected_n = finger * ratio * v_p;
            assert_relative_eq!((force_n - expected_n).norm(), 0.0, epsilon = 1e-12);
        }
        let z_m = Complex64::new(9.3, -2.4);
        assert_eq!(impedance(z_m, z_p, 1.0), z_m);
    }
}
