//! Whether a fit's parameters may be used.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Relative standard error above which a parameter is not identified.
const IDENTIFIABLE_RELATIVE_STD: f64 = 0.5;

/// Standard error of a parameter, and the limit above which the parameter is not identified.
#[derive(Clone, Copy)]
pub(super) struct StandardError {
    pub(super) parameter: FitParameter,
    pub(super) std: f64,
    pub(super) limit: f64,
}

impl StandardError {
    /// Makes a standard error relative to the parameter's value.
    pub(super) fn relative(parameter: FitParameter, std: f64) -> Self {
        Self {
            parameter,
            std,
            limit: IDENTIFIABLE_RELATIVE_STD,
        }
    }

    /// Returns the ratio of the error to its limit. NaN of either sign ranks above every number.
    fn size(&self) -> f64 {
        if self.std.is_nan() {
            f64::INFINITY
        } else {
            self.std / self.limit
        }
    }
}

/// Returns the standard error that exceeds its limit by the largest factor, if any does.
pub(super) fn find_unidentified(
    errors: impl IntoIterator<Item = StandardError>,
) -> Option<FitVerdict> {
    let worst = errors
        .into_iter()
        .max_by(|a, b| a.size().total_cmp(&b.size()))?;
    (worst.size() > 1.0).then_some(FitVerdict::NotIdentifiable {
        parameter: worst.parameter,
        std: worst.std,
    })
}

/// Whether a fit's parameters may be used, and the reason if not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FitVerdict {
    /// The fit is a minimum and every parameter is identified.
    Converged,
    /// The unbounded optimum has τ < 0; τ is held at 0 and the other parameters are fitted with it.
    LagAtBound {
        /// Estimate of τ without the bound, s.
        unbounded_tau_s: f64,
    },
    /// The fit is a minimum, but the data hardly depend on a parameter.
    NotIdentifiable {
        /// The least well identified parameter.
        parameter: FitParameter,
        /// Standard error of that parameter: relative for σ_t, |Z_t| and S, s for τ; infinite if the data do not depend on
        /// it at all.
        std: f64,
    },
    /// The fit is not a minimum.
    NotConverged {
        /// Why the optimiser stopped.
        reason: String,
    },
}

impl FitVerdict {
    /// Whether the parameters may be used.
    pub fn is_usable(&self) -> bool {
        matches!(self, Self::Converged | Self::LagAtBound { .. })
    }
}

/// A fitted parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FitParameter {
    /// σ_t, the roughness of the finger.
    SigmaT,
    /// Z_t, the impedance of the tissues.
    ZT,
    /// τ, the levitation lag.
    Tau,
    /// S, the apparent contact area.
    ContactArea,
}

impl fmt::Display for FitParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SigmaT => "sigma_t",
            Self::ZT => "Z_t",
            Self::Tau => "tau",
            Self::ContactArea => "the contact area",
        })
    }
}

impl fmt::Display for FitVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged"),
            Self::LagAtBound { unbounded_tau_s } => {
                write!(
                    f,
                    "tau held at its bound 0 s; unbounded it would be {unbounded_tau_s:.1e} s"
                )
            }
            Self::NotIdentifiable {
                parameter: FitParameter::Tau,
                std,
            } => {
                write!(
                    f,
                    "the data do not determine tau: standard error {std:.1e} s"
                )
            }
            Self::NotIdentifiable { parameter, std } => {
                write!(
                    f,
                    "the data do not determine {parameter}: relative standard error {std:.2}"
                )
            }
            Self::NotConverged { reason } => write!(f, "not converged: {reason}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_error_ranks_worst() {
        let verdict_for = |z_t_std: f64| {
            find_unidentified([
                StandardError::relative(FitParameter::SigmaT, 0.1),
                StandardError::relative(FitParameter::ZT, z_t_std),
                StandardError {
                    parameter: FitParameter::Tau,
                    std: 1e-3,
                    limit: 2e-3,
                },
            ])
        };
        assert_eq!(verdict_for(0.2), None);
        assert_eq!(verdict_for(0.5), None);
        for std in [0.6, f64::INFINITY, f64::NAN, -f64::NAN] {
            let verdict = verdict_for(std);
            let parameter = FitParameter::ZT;
            assert!(
                matches!(verdict, Some(FitVerdict::NotIdentifiable { parameter: worst, .. }) if worst == parameter),
                "{std}: {verdict:?}"
            );
        }
    }
}
