//! The one rule for the roughness σ_t at which a fit ends: a skin must be able to have it.

/// Largest σ_t of a skin, m: twenty times the roughest's. A larger one stems from forces in another unit, or from a fit that ran
/// away.
const LARGEST_SIGMA_T_M: f64 = 1e-4;

/// A σ_t that no skin has. The gap and the film's force, which follow from it, have no meaning either.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the fit ended at a σ_t of {sigma_t_m:.1e} m, and that of a skin is below {LARGEST_SIGMA_T_M:.0e} m: the data do not follow the \
     method's laws; check the units of the forces and the plate's constants"
)]
pub struct RoughnessError {
    /// σ_t of the fit, m.
    pub sigma_t_m: f64,
}

/// Returns the σ_t of a fit, m.
///
/// # Errors
/// [`RoughnessError`] if no skin has it.
pub fn roughness(sigma_t_m: f64) -> Result<f64, RoughnessError> {
    if sigma_t_m <= LARGEST_SIGMA_T_M {
        Ok(sigma_t_m)
    } else {
        Err(RoughnessError { sigma_t_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skin_has_less_than_a_tenth_of_a_millimetre_and_no_unknown_roughness() {
        assert_eq!(roughness(3e-6), Ok(3e-6));
        assert_eq!(roughness(1e-4), Ok(1e-4));
        let error = roughness(0.31).unwrap_err().to_string();
        assert!(error.contains("a σ_t of 3.1e-1 m"), "{error}");
        assert!(error.contains("check the units of the forces"), "{error}");
        assert!(roughness(f64::NAN).is_err());
    }
}
