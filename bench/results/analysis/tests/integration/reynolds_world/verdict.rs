//! Whether a method's estimate of a recording is right, covered by its interval, flagged or refused; or wrong in silence.

use std::fmt;

use analysis::estimate::InstanceEstimate;
use analysis::findings::RecordingFindings;
use analysis::method::Method;
use contact::uncertain::Uncertain;
use num_complex::Complex64;

use super::recorded_world::{Truth, World, parameter};

/// Largest error of a right estimate: relative, but for the friction's RMS.
const LIMITS: [(Quantity, f64); 5] = [
    (Quantity::SigmaT, 0.03),
    (Quantity::ZT, 0.05),
    (Quantity::Area, 0.06),
    (Quantity::Mu0, 0.03),
    (Quantity::RmsMu, 0.02),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    SigmaT,
    ZT,
    Area,
    Mu0,
    RmsMu,
}

/// Error of a quantity, and whether the stated 95 % interval includes the truth.
#[derive(Debug, Clone, Copy)]
struct Comparison {
    quantity: Quantity,
    error: f64,
    is_covered: bool,
}

impl Comparison {
    fn is_right(&self) -> bool {
        let limit = LIMITS.iter().find(|limit| limit.0 == self.quantity);
        limit.is_some_and(|limit| self.error <= limit.1)
    }
}

/// Outcome of a method on a recording.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The method gives no estimate.
    Refused,
    /// The method says that its model does not hold.
    Flagged(String),
    /// All errors are within the limits.
    Right,
    /// An error exceeds a limit, but the interval includes the truth.
    Covered,
    /// An error exceeds a limit, its interval misses the truth, and nothing says so.
    WrongInSilence(String),
}

/// Outcome of a method, with its values for the table.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// The method.
    pub method: Method,
    /// The outcome.
    pub outcome: Outcome,
    estimates: usize,
    sigma_t_ratio: f64,
    /// Half of the 95 % interval of σ_t, over the estimate.
    sigma_t_uncertainty: f64,
    z_t_error: f64,
    area_ratio: Option<f64>,
    rms_mu: f64,
    r2: f64,
}

impl Verdict {
    /// Compares the estimates of a method with the truth.
    pub fn new(method: Method, findings: &RecordingFindings, truth: &Truth, world: &World) -> Self {
        let estimates: Vec<(f64, f64, &InstanceEstimate)> = findings
            .instances
            .iter()
            .filter_map(|instance| {
                let estimate = instance.estimate(method)?;
                Some((instance.start_s, instance.end_s, estimate))
            })
            .collect();
        let mut comparisons = Vec::new();
        let mut area_ratio = None;
        let (mut sigma_t_ratios, mut z_t_errors) = (Vec::new(), Vec::new());
        for (start_s, end_s, estimate) in &estimates {
            let mean = |column| truth.mean(column, *start_s, *end_s);
            let sigma_t_m = mean("sigma_t_m");
            let z_t = Complex64::new(mean("re_z_t_n_s_per_m"), mean("im_z_t_n_s_per_m"));
            sigma_t_ratios.push(estimate.sigma_t_m / sigma_t_m);
            z_t_errors.push((estimate.z_t_n_s_per_m - z_t).norm() / z_t.norm());
            if estimate.misfit.is_empty() {
                comparisons.extend(compared(estimate, sigma_t_m, z_t, world));
            }
        }
        if method == Method::Trial
            && let (Some(shared), Some(first), Some(last)) =
                (&findings.trial, estimates.first(), estimates.last())
        {
            let area_m2 = truth.mean("contact_area_m2", first.0, last.1);
            let ratio = shared.contact_area_m2.value / area_m2;
            let [low, high] = shared.contact_area_m2.interval95();
            comparisons.push(Comparison {
                quantity: Quantity::Area,
                error: (ratio - 1.0).abs(),
                is_covered: (low..=high).contains(&area_m2),
            });
            area_ratio = Some(ratio);
        }
        let uncertainties = estimates.iter().map(|(_, _, estimate)| {
            let (value, std) = (estimate.sigma_t_m, estimate.sigma_t_std_m);
            let [low, high] = Uncertain { value, std }.interval95();
            (high - low) / 2.0 / value
        });
        let sigma_t_uncertainty = median(uncertainties);
        let agreements = estimates.iter().map(|estimate| estimate.2.agreement);
        Self {
            method,
            outcome: outcome(&comparisons, misfit_flag(findings, method)),
            estimates: estimates.len(),
            sigma_t_ratio: median(sigma_t_ratios),
            sigma_t_uncertainty,
            z_t_error: median(z_t_errors),
            area_ratio,
            rms_mu: median(agreements.clone().map(|agreement| agreement.rms_mu)),
            r2: median(agreements.map(|agreement| agreement.r2_impedance)),
        }
    }

    /// Whether the method stands by a σ_t within a fifth of the truth, and knows it to 60 %.
    pub fn is_useful(&self) -> bool {
        let is_unflagged = !matches!(self.outcome, Outcome::Flagged(_) | Outcome::Refused);
        is_unflagged && (self.sigma_t_ratio - 1.0).abs() < 0.2 && self.sigma_t_uncertainty < 0.6
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:8} {} estimates", self.method.name(), self.estimates)?;
        if self.estimates > 0 {
            write!(
                f,
                ", sigma_t/true {:.3} ± {:.0} %, Z_t off {:.2}, RMS of mu {:.3}, R2 {:.4}",
                self.sigma_t_ratio,
                100.0 * self.sigma_t_uncertainty,
                self.z_t_error,
                self.rms_mu,
                self.r2
            )?;
        }
        if let Some(ratio) = self.area_ratio {
            write!(f, ", S/true {ratio:.2}")?;
        }
        match &self.outcome {
            Outcome::Refused => write!(f, ": refused"),
            Outcome::Flagged(sign) => write!(f, ": flagged: {sign}"),
            Outcome::Right => write!(f, ": right"),
            Outcome::Covered => write!(f, ": covered"),
            Outcome::WrongInSilence(quantities) => write!(f, ": WRONG IN SILENCE: {quantities}"),
        }
    }
}

/// Returns the sign by which a method says that its model does not hold: `trial` of the recording, `paper` and `dynamic` if they
/// flag each instance. Instances that they flag are not compared.
fn misfit_flag(findings: &RecordingFindings, method: Method) -> Option<String> {
    if method == Method::Trial {
        let signs = &findings.trial.as_ref()?.misfit;
        return signs.first().map(ToString::to_string);
    }
    let mut estimates = findings
        .instances
        .iter()
        .filter_map(|instance| instance.estimate(method));
    let first = estimates.next()?.misfit.first()?;
    let is_each_flagged = estimates.all(|estimate| !estimate.misfit.is_empty());
    is_each_flagged.then(|| first.to_string())
}

fn outcome(comparisons: &[Comparison], flag: Option<String>) -> Outcome {
    if let Some(sign) = flag {
        return Outcome::Flagged(sign);
    }
    if comparisons.is_empty() {
        return Outcome::Refused;
    }
    if comparisons.iter().all(Comparison::is_right) {
        return Outcome::Right;
    }
    let mut wrong: Vec<String> = Vec::new();
    for (quantity, _) in LIMITS {
        let of_quantity = comparisons.iter().filter(|c| c.quantity == quantity);
        let errors = of_quantity
            .filter(|comparison| !comparison.is_right() && !comparison.is_covered)
            .map(|comparison| comparison.error);
        if let Some(error) = errors.reduce(f64::max) {
            wrong.push(format!("{quantity:?} {error:.3}"));
        }
    }
    if wrong.is_empty() {
        Outcome::Covered
    } else {
        Outcome::WrongInSilence(wrong.join(", "))
    }
}

fn compared(
    estimate: &InstanceEstimate,
    sigma_t_m: f64,
    z_t: Complex64,
    world: &World,
) -> Vec<Comparison> {
    let includes = |value: f64, std: f64, truth: f64| {
        let [low, high] = Uncertain { value, std }.interval95();
        (low..=high).contains(&truth)
    };
    let (z, z_std) = (estimate.z_t_n_s_per_m, estimate.z_t_std_n_s_per_m);
    let mut comparisons = vec![
        Comparison {
            quantity: Quantity::SigmaT,
            error: (estimate.sigma_t_m / sigma_t_m - 1.0).abs(),
            is_covered: includes(estimate.sigma_t_m, estimate.sigma_t_std_m, sigma_t_m),
        },
        Comparison {
            quantity: Quantity::ZT,
            error: (z - z_t).norm() / z_t.norm(),
            is_covered: includes(z.re, z_std.re, z_t.re) && includes(z.im, z_std.im, z_t.im),
        },
        Comparison {
            quantity: Quantity::RmsMu,
            error: estimate.agreement.rms_mu,
            is_covered: false,
        },
    ];
    if let Some(mu0) = parameter(world, "mu0") {
        comparisons.push(Comparison {
            quantity: Quantity::Mu0,
            error: (estimate.mu0 / mu0 - 1.0).abs(),
            is_covered: includes(estimate.mu0, estimate.mu0_std, mu0),
        });
    }
    comparisons
}

fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
