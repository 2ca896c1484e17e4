//! Output of the model over an instance.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Impedance, stiffness, gap and friction of the model at each sample of an instance, independent of the measured values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelledSeries {
    /// Observed impedance Z_m (Huloux 2021, Eq. 9), N·s/m.
    pub z_m_n_s_per_m: Vec<Complex64>,
    /// Contact stiffness k_c (Eq. 18), N/m.
    pub k_c_n_per_m: Vec<f64>,
    /// Levitation gap ⟨x_t⟩ (Eq. 17), m.
    pub gap_m: Vec<f64>,
    /// Friction μ (Eq. 19).
    pub mu: Vec<f64>,
}
