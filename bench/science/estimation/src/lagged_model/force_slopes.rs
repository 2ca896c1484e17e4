//! Derivatives that determine the response to the normal force.

use num_complex::Complex64;

/// Derivatives of Z_m at a sample that determine its response to the normal force.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ForceSlopes {
    /// ∂Z_m/∂gap, N·s/m².
    pub(super) by_gap: Complex64,
    /// ∂Z_m/∂ ln S at a fixed gap, N·s/m.
    pub(super) by_ln_area: Complex64,
}
