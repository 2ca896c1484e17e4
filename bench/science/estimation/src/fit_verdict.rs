//! Whether a fit's parameters may be used.

use std::fmt;

/// Relative standard error above which a parameter is not identified.
pub(super) const IDENTIFIABLE_RELATIVE_STD: f64 = 0.5;

/// Returns the standard error that exceeds its limit by the largest factor, if any does. NaN ranks above every number, whatever
/// its sign.
pub(super) fn find_unidentified(
    errors: impl IntoIterator<Item = (FitParameter, f64, f64)>,
) -> Option<FitVerdict> {
    let size = |&(_, std, limit): &(FitParameter, f64, f64)| {
        if std.is_nan() {
            f64::INFINITY
        } else {
            std / limit
        }
    };
    let worst = errors
        .into_iter()
        .max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let (parameter, std, _) = worst;
    (size(&worst) > 1.0).then_some(FitVerdict::NotIdentifiable { parameter, std })
}

/// Whether a fit's parameters may be used, and the reason if not.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
                (FitParameter::SigmaT, 0.1, 0.5),
                (FitParameter::ZT, z_t_std, 0.5),
                (FitParameter::Tau, 1e-3, 2e-3),
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
