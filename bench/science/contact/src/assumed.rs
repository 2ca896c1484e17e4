use serde::{Deserialize, Serialize};

use crate::error::{ModelError, positive};

/// Assumed constants of finger and air. σ_t, Z_t and τ are conditional on them; friction hardly depends on them
/// (see `estimation::Sensitivities`). Every result prints them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AssumedConstants {
    /// q0, rad/m: wave number of the coarsest roughness in Persson's pressure. Default 1.4e4, 2π over a fingerprint
    /// ridge of 0.45 mm; an assumption, the paper does not give it.
    pub q0_rad_per_m: f64,
    /// Poisson's ratio ν. Default 0.5, incompressible tissue; an assumption, the paper does not give it.
    pub poisson_ratio: f64,
    /// Young's modulus E, Pa. Default 20 MPa (Huloux 2021, stratum corneum).
    pub young_modulus_pa: f64,
    /// Apparent contact area S, m². Default 300 mm² for estimation, 314 mm² for the model figures (both Huloux 2021).
    pub contact_area_m2: f64,
    /// Ambient pressure p0, Pa. Default 101 325.
    pub ambient_pressure_pa: f64,
    /// Loss factor η of the contact: b_c = η k_c/ω. Default 0.3 (Huloux 2021, "damping factor 0.3").
    pub loss_factor: f64,
}

impl AssumedConstants {
    /// Constants for estimation from measurements; also the [`Default`].
    pub const ESTIMATION: Self = Self {
        q0_rad_per_m: 1.4e4,
        poisson_ratio: 0.5,
        young_modulus_pa: 20e6,
        contact_area_m2: 300e-6,
        ambient_pressure_pa: 101_325.0,
        loss_factor: 0.3,
    };
    /// Constants of the published model figures: [`ESTIMATION`](Self::ESTIMATION) except S = 314 mm².
    pub const FIGURES: Self = Self {
        contact_area_m2: 314e-6,
        ..Self::ESTIMATION
    };

    /// Returns the constants with a measured ambient pressure, Pa, if there is one.
    #[must_use]
    pub fn with_measured_pressure(self, ambient_pressure_pa: Option<f64>) -> Self {
        Self {
            ambient_pressure_pa: ambient_pressure_pa.unwrap_or(self.ambient_pressure_pa),
            ..self
        }
    }

    /// Returns p_c S/σ_t, N/m: with p_c = 0.375 q0 σ_t E/(1 − ν²) (Huloux 2021, Eq. 15) it does not depend on σ_t.
    pub(crate) fn asperity_scale_n_per_m(&self) -> f64 {
        0.375 * self.q0_rad_per_m * self.young_modulus_pa * self.contact_area_m2
            / (1.0 - self.poisson_ratio.powi(2))
    }

    /// Returns (5/4) p0 S, N (Huloux 2021, Eq. 14).
    pub(crate) fn squeeze_scale_n(&self) -> f64 {
        1.25 * self.ambient_pressure_pa * self.contact_area_m2
    }

    /// Returns these constants.
    ///
    /// # Errors
    /// If one is outside its physical range.
    pub fn validated(&self) -> Result<&Self, ModelError> {
        positive("q0", "rad/m", self.q0_rad_per_m)?;
        positive("Young's modulus", "Pa", self.young_modulus_pa)?;
        positive("contact area", "m2", self.contact_area_m2)?;
        positive("ambient pressure", "Pa", self.ambient_pressure_pa)?;
        crate::error::not_negative("loss factor", "", self.loss_factor)?;
        if !(self.poisson_ratio > -1.0 && self.poisson_ratio <= 0.5) {
            return Err(ModelError::OutOfRange {
                name: "Poisson's ratio",
                value: self.poisson_ratio,
                unit: "",
                limit: "above -1 and at most 0.5",
            });
        }
        Ok(self)
    }
}

impl Default for AssumedConstants {
    fn default() -> Self {
        Self::ESTIMATION
    }
}
