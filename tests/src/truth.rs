//! What really happened, as the simulated apparatus wrote it down; the bench never reads it.

use std::path::Path;

use num_complex::Complex64;

/// The skin as simulated, averaged over the time that the finger slides.
pub struct Skin {
    /// Asperity scale, m.
    pub sigma_t_m: f64,
    /// Tissue impedance, N·s/m.
    pub z_t: Complex64,
}

impl Skin {
    /// Reads what the apparatus wrote into `folder`.
    pub fn read(folder: &Path) -> Self {
        let series = std::fs::read_to_string(folder.join("truth.csv")).expect("the truth");
        let (mut n, mut sigma_t_m, mut z_t) = (0.0, 0.0, Complex64::ZERO);
        for line in series.lines().skip(1) {
            let value = |column: usize| -> f64 {
                let cell = line.split(',').nth(column).expect("a column");
                cell.parse().expect("a number")
            };
            // gap_m is NaN off the plate; velocity tells sliding from waiting.
            if value(6).is_finite() && value(12).abs() > 0.02 {
                n += 1.0;
                sigma_t_m += value(2);
                z_t += Complex64::new(value(3), value(4));
            }
        }
        assert!(n > 500.0, "{n} samples of sliding in {}", folder.display());
        Self {
            sigma_t_m: sigma_t_m / n,
            z_t: z_t / n,
        }
    }
}
