//! Frames for unit tests.

use impedance::{Mask, ZmFrame};
use num_complex::Complex64;

/// A frame of a plate with an amplitude of 1 µm.
pub(crate) fn frame(sample: u64, time_s: f64, z_m: Complex64) -> ZmFrame {
    ZmFrame {
        sample,
        time_s,
        mask: Mask::CLEAR,
        drive_v: Complex64::ONE,
        displacement_m: Complex64::new(1e-6, 0.0),
        amplitude_m: 1e-6,
        amplitude_rate_m_per_s: 0.0,
        amplitude_std_m: 1e-12,
        plain_n_s_per_m: z_m,
        plain_std_n_s_per_m: 1e-3,
        corrected_n_s_per_m: z_m,
        corrected_std_n_s_per_m: 1e-3,
    }
}
