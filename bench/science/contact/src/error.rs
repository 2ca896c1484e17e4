//! Errors for inputs that the contact model rejects.

use statistics::significant;
use thiserror::Error;

/// An input outside the contact model's domain, and the assumption that failed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A parameter or a sample lies outside its physical range.
    #[error("{name} = {}{}: must be {limit}", significant(*.value), spaced(.unit))]
    OutOfRange {
        /// Name of the quantity.
        name: &'static str,
        /// Value of the quantity, in `unit`.
        value: f64,
        /// SI unit of `value`; empty for a dimensionless number.
        unit: &'static str,
        /// Accepted values.
        limit: &'static str,
    },
    /// x_t⁰ ≤ 0: the exponential asperity law (Huloux 2021, Eq. 15) carries at most p_c S, and the normal force is
    /// larger.
    #[error(
        "normal force {} N is not below p_c S = {} N, the most that the asperities carry \
         (Huloux 2021, Eq. 15): the gap at rest would be {} m; sigma_t, q0, E or S is too small",
        significant(*.normal_n), significant(*.limit_n), significant(*.rest_gap_m)
    )]
    RestGapNotPositive {
        /// Normal force, N.
        normal_n: f64,
        /// p_c S, N.
        limit_n: f64,
        /// Gap at rest that the law would give, σ_t ln(p_c S/⟨f_c⟩), m.
        rest_gap_m: f64,
    },
    /// No positive gap has this stiffness: the measured k_c is not positive, or exceeds the asperities' p_c S/σ_t.
    #[error(
        "contact stiffness {} N/m is not between 0 and {} N/m, the stiffest that the contact model can be: \
         the plate or tissue impedance behind it is wrong, or noise exceeds the contact's share of Z_m",
        significant(*.k_c_n_per_m), significant(*.limit_n_per_m)
    )]
    NoGapForStiffness {
        /// Stiffness to invert, N/m.
        k_c_n_per_m: f64,
        /// Greatest stiffness of the contact model, N/m.
        limit_n_per_m: f64,
    },
    /// Slices that describe the same samples differ in length.
    #[error("{name} has {got} samples, expected {expected}")]
    LengthMismatch {
        /// Name of the slice.
        name: &'static str,
        /// Length of the slice.
        got: usize,
        /// Length of the other slices.
        expected: usize,
    },
    /// An error of one sample of a record.
    #[error("sample {index}: {source}")]
    AtSample {
        /// Index of the sample.
        index: usize,
        /// Error of that sample.
        source: Box<ModelError>,
    },
}

/// Returns a unit as it follows a number.
fn spaced(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    }
}

/// Returns `value`, in `unit`.
///
/// # Errors
/// If it is not finite or not above 0.
pub fn positive(name: &'static str, unit: &'static str, value: f64) -> Result<f64, ModelError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ModelError::OutOfRange {
            name,
            value,
            unit,
            limit: "finite and above 0",
        })
    }
}

/// Returns `value`, in `unit`.
///
/// # Errors
/// If it is not finite or below 0.
pub fn not_negative(name: &'static str, unit: &'static str, value: f64) -> Result<f64, ModelError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(ModelError::OutOfRange {
            name,
            value,
            unit,
            limit: "finite and not below 0",
        })
    }
}

/// Compares the lengths of slices of the same samples.
///
/// # Errors
/// If `got` differs from `expected`.
pub fn same_length(name: &'static str, got: usize, expected: usize) -> Result<(), ModelError> {
    if got == expected {
        Ok(())
    } else {
        Err(ModelError::LengthMismatch {
            name,
            got,
            expected,
        })
    }
}
