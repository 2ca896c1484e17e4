//! Measurements for unit tests.

use impedance::{Mask, ZmFrame};
use num_complex::Complex64;
use recording::ForceRow;

use crate::measurements::Measurements;

/// Returns `duration_s` of readings at 2 kHz of a plate with the impedance `z_m`, N·s/m, moving with 1 µm, and of the normal
/// and lateral `force`, N, by time.
pub(crate) fn measured(
    duration_s: f64,
    z_m: impl Fn(f64) -> Complex64,
    force: impl Fn(f64) -> (f64, f64),
) -> Measurements {
    let times_s = (0..(2000.0 * duration_s) as u32).map(|i| f64::from(i) / 2000.0);
    let frame = |time_s: f64| ZmFrame {
        sample: 0,
        time_s,
        mask: Mask::CLEAR,
        drive_v: Complex64::ONE,
        displacement_m: Complex64::new(1e-6, 0.0),
        amplitude_m: 1e-6,
        amplitude_rate_m_per_s: 0.0,
        amplitude_std_m: 1e-9,
        plain_n_s_per_m: z_m(time_s),
        plain_std_n_s_per_m: 0.01,
        corrected_n_s_per_m: z_m(time_s),
        corrected_std_n_s_per_m: 0.01,
    };
    let row = |time_s: f64| {
        let (normal_n, lateral_n) = force(time_s);
        ForceRow {
            time_s,
            normal_n,
            lateral_n,
        }
    };
    Measurements {
        frames: times_s.clone().map(frame).collect(),
        force: times_s.map(row).collect(),
        ..Measurements::default()
    }
}
