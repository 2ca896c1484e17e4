//! Whether a method's estimate of a recording is right, covered by its interval, flagged or refused; or wrong in silence.

use std::fmt;

use analysis::estimate::{InstanceAnalysis, InstanceEstimate};
use analysis::findings::RecordingFindings;
use analysis::method::Method;
use analysis::recording_series::{EstimateSeries, RecordingSeries};
use contact::uncertain::{LogUncertain, Uncertain};
use num_complex::Complex64;
use statistics::NORMAL_95;

use reference_worlds::truth::{Truth, World, parameter};

/// Quantity with a limit of a right estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// σ_t.
    SigmaT,
    /// Z_t.
    ZT,
    /// S.
    Area,
    /// μ0.
    Mu0,
    /// RMS of μ.
    RmsMu,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 5] = [Self::SigmaT, Self::ZT, Self::Area, Self::Mu0, Self::RmsMu];

    /// Returns the largest error of a right estimate: relative, but for the friction's RMS.
    const fn limit(self) -> f64 {
        match self {
            Self::SigmaT | Self::Mu0 => 0.03,
            Self::ZT => 0.05,
            Self::Area => 0.06,
            Self::RmsMu => 0.02,
        }
    }
}

/// Whether intervals include a true value.
#[derive(Debug, Clone, Copy)]
pub struct Coverage {
    /// Whether the stated 95 % interval includes it.
    pub total: bool,
    /// Whether the 95 % interval with the laws as published taken as true includes it; `None` without such an interval.
    pub within_laws: Option<bool>,
    /// Width of the stated interval over that within the laws.
    pub widening: Option<f64>,
}

impl Coverage {
    /// Compares the stated interval, and that within the laws, with the truth.
    fn new(total: [f64; 2], within_laws: Option<[f64; 2]>, truth: f64) -> Self {
        let includes = |[low, high]: [f64; 2]| (low..=high).contains(&truth);
        let width = |[low, high]: [f64; 2]| high - low;
        Self {
            total: includes(total),
            within_laws: within_laws.map(includes),
            widening: within_laws.map(|published| width(total) / width(published)),
        }
    }
}

/// Error of a quantity, and whether its intervals include the truth.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Quantity.
    pub quantity: Quantity,
    /// Relative error with its sign, modulus of Z_t's, or RMS error of μ.
    pub error: f64,
    /// Intervals: of real and imaginary part for Z_t.
    pub coverage: Vec<Coverage>,
}

impl Comparison {
    fn is_right(&self) -> bool {
        self.error.abs() <= self.quantity.limit()
    }

    fn is_covered(&self) -> bool {
        self.coverage.iter().all(|coverage| coverage.total)
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
    /// Errors of all instances; those of flagged instances of `paper` and `dynamic` are left out.
    pub comparisons: Vec<Comparison>,
    estimates: usize,
    sigma_t_ratio: f64,
    /// Half of the 95 % interval of σ_t, over the estimate.
    sigma_t_uncertainty: f64,
    z_t_error: f64,
    area_ratio: Option<f64>,
    /// As stated: relative to the measured friction.
    rms_mu: f64,
    r2: f64,
}

impl Verdict {
    /// Compares the estimates of a method with the truth.
    pub fn new(
        method: Method,
        (findings, series): (&RecordingFindings, &RecordingSeries),
        truth: &Truth,
        world: &World,
    ) -> Self {
        let sampled = |instance: &InstanceAnalysis| {
            let start_s = instance.start_s;
            let mut all = findings.instances.iter().zip(&series.instances);
            let (_, samples) = all.find(|(other, _)| other.start_s == start_s)?;
            samples.estimate(method)
        };
        let estimates: Vec<(&InstanceAnalysis, &InstanceEstimate)> = findings
            .instances
            .iter()
            .filter_map(|instance| Some((instance, instance.estimate(method)?)))
            .collect();
        let mut comparisons = Vec::new();
        let (mut sigma_t_ratios, mut z_t_errors) = (Vec::new(), Vec::new());
        for (instance, estimate) in &estimates {
            let true_skin = TrueSkin::new(instance, truth, world);
            sigma_t_ratios.push(estimate.sigma_t_m() / true_skin.sigma_t_m);
            z_t_errors.push(true_skin.z_t_error(estimate));
            if estimate.misfit.is_empty() {
                comparisons.extend(true_skin.compare(method, instance, estimate));
                let samples = sampled(instance);
                comparisons.extend(samples.map(|samples| compare_friction(samples, truth)));
            }
        }
        let area = (method == Method::Trial)
            .then(|| compare_area(findings, truth))
            .flatten()
            .filter(|_| !estimates.is_empty());
        let area_ratio = area.as_ref().map(|comparison| 1.0 + comparison.error);
        comparisons.extend(area);
        let uncertainties = estimates.iter().map(|(_, estimate)| {
            let [low, high] = log_interval95(estimate.sigma_t_m(), estimate.sigma_t_std_m());
            (high - low) / 2.0 / estimate.sigma_t_m()
        });
        let sigma_t_uncertainty = median(uncertainties);
        let agreements = estimates.iter().map(|estimate| estimate.1.agreement);
        Self {
            method,
            outcome: outcome(&comparisons, misfit_flag(findings, method)),
            comparisons,
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

    /// Whether each error of a quantity is within its limit.
    pub fn is_right_in(&self, quantity: Quantity) -> bool {
        let mut comparisons = self.comparisons.iter().filter(|c| c.quantity == quantity);
        comparisons.all(Comparison::is_right)
    }

    fn errors(&self, quantity: Quantity) -> impl Iterator<Item = f64> {
        let comparisons = self.comparisons.iter();
        comparisons
            .filter(move |comparison| comparison.quantity == quantity)
            .map(|comparison| comparison.error)
    }

    /// Returns the median error of a quantity over the instances, with its sign; `None` without any.
    pub fn error(&self, quantity: Quantity) -> Option<f64> {
        let errors: Vec<f64> = self.errors(quantity).collect();
        (!errors.is_empty()).then(|| median(errors))
    }

    /// Returns the largest error of a quantity in one instance, with its sign; `None` without any.
    fn largest_error(&self, quantity: Quantity) -> Option<f64> {
        self.errors(quantity)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
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
        if let Some((error, largest)) = self
            .error(Quantity::Mu0)
            .zip(self.largest_error(Quantity::Mu0))
        {
            let (error, largest) = (100.0 * error, 100.0 * largest);
            write!(f, ", mu0 off {error:+.1} % ({largest:+.1} % at most)")?;
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
    for quantity in Quantity::ALL {
        let of_quantity = comparisons.iter().filter(|c| c.quantity == quantity);
        let errors = of_quantity
            .filter(|comparison| !comparison.is_right() && !comparison.is_covered())
            .map(|comparison| comparison.error);
        if let Some(error) = errors.max_by(|a, b| a.abs().total_cmp(&b.abs())) {
            wrong.push(format!("{quantity:?} {error:.3}"));
        }
    }
    if wrong.is_empty() {
        Outcome::Covered
    } else {
        Outcome::WrongInSilence(wrong.join(", "))
    }
}

/// Means of the true skin over an instance.
struct TrueSkin {
    sigma_t_m: f64,
    z_t: Complex64,
    mu0: Option<f64>,
}

impl TrueSkin {
    fn new(instance: &InstanceAnalysis, truth: &Truth, world: &World) -> Self {
        let mean = |column| truth.mean(column, instance.start_s, instance.end_s);
        Self {
            sigma_t_m: mean("sigma_t_m"),
            z_t: Complex64::new(mean("re_z_t_n_s_per_m"), mean("im_z_t_n_s_per_m")),
            mu0: parameter(world, "mu0"),
        }
    }

    fn z_t_error(&self, estimate: &InstanceEstimate) -> f64 {
        (estimate.z_t_n_s_per_m - self.z_t).norm() / self.z_t.norm()
    }

    fn compare(
        &self,
        method: Method,
        instance: &InstanceAnalysis,
        estimate: &InstanceEstimate,
    ) -> Vec<Comparison> {
        let total = StatedIntervals::of_estimate(estimate);
        let within_laws = (method == Method::Trial)
            .then(|| StatedIntervals::within_laws(instance))
            .flatten();
        let coverage = |interval: fn(&StatedIntervals) -> [f64; 2], truth: f64| {
            Coverage::new(interval(&total), within_laws.as_ref().map(interval), truth)
        };
        let mut comparisons = vec![
            Comparison {
                quantity: Quantity::SigmaT,
                error: estimate.sigma_t_m() / self.sigma_t_m - 1.0,
                coverage: vec![coverage(|intervals| intervals.sigma_t_m, self.sigma_t_m)],
            },
            Comparison {
                quantity: Quantity::ZT,
                error: self.z_t_error(estimate),
                coverage: vec![
                    coverage(|intervals| intervals.re_z_t, self.z_t.re),
                    coverage(|intervals| intervals.im_z_t, self.z_t.im),
                ],
            },
        ];
        if let Some(mu0) = self.mu0 {
            comparisons.push(Comparison {
                quantity: Quantity::Mu0,
                error: estimate.mu0 / mu0 - 1.0,
                coverage: vec![coverage(|intervals| intervals.mu0, mu0)],
            });
        }
        comparisons
    }
}

/// 95 % intervals of an instance.
struct StatedIntervals {
    sigma_t_m: [f64; 2],
    re_z_t: [f64; 2],
    im_z_t: [f64; 2],
    mu0: [f64; 2],
}

impl StatedIntervals {
    fn of_estimate(estimate: &InstanceEstimate) -> Self {
        let (z_t, z_t_std) = (estimate.z_t_n_s_per_m, estimate.z_t_std_n_s_per_m);
        Self {
            sigma_t_m: log_interval95(estimate.sigma_t_m(), estimate.sigma_t_std_m()),
            re_z_t: interval95(z_t.re, z_t_std.re),
            im_z_t: interval95(z_t.im, z_t_std.im),
            mu0: interval95(estimate.mu0, estimate.mu0_std),
        }
    }

    /// Returns the intervals of `trial` with the laws as published taken as true; `None` without them.
    fn within_laws(instance: &InstanceAnalysis) -> Option<Self> {
        let estimate = instance.within_laws?;
        let (z_t, z_t_std) = (estimate.z_t_n_s_per_m, estimate.z_t_std_n_s_per_m);
        Some(Self {
            sigma_t_m: estimate.sigma_t_m.interval95(),
            re_z_t: interval95(z_t.re, z_t_std.re),
            im_z_t: interval95(z_t.im, z_t_std.im),
            mu0: estimate.mu0.interval95(),
        })
    }
}

/// Compares S with its mean over the instances.
fn compare_area(findings: &RecordingFindings, truth: &Truth) -> Option<Comparison> {
    let area = &findings.trial.as_ref()?.contact_area_m2;
    let within_laws = findings.within_laws.as_ref();
    let within_laws = within_laws.map(|shared| shared.contact_area_m2.interval95());
    let (first, last) = (findings.instances.first()?, findings.instances.last()?);
    let true_m2 = truth.mean("contact_area_m2", first.start_s, last.end_s);
    Some(Comparison {
        quantity: Quantity::Area,
        error: area.value / true_m2 - 1.0,
        coverage: vec![Coverage::new(area.interval95(), within_laws, true_m2)],
    })
}

/// Compares the friction of an instance with the true one. An interval that is as wide as the error is large includes the truth: the
/// RMS of the error over the standard error is compared with the interval of a normal distribution.
fn compare_friction(estimate: &EstimateSeries, truth: &Truth) -> Comparison {
    let series = &estimate.contact;
    let true_mu = truth.at("mu", &series.time_s);
    let errors: Vec<(f64, f64)> = series
        .mu
        .iter()
        .zip(true_mu)
        .zip(&series.mu_std)
        .map(|((mu, true_mu), std)| (mu - true_mu, *std))
        .filter(|(error, _)| error.is_finite())
        .collect();
    let rms = |value: fn(&(f64, f64)) -> f64| {
        let squares = errors.iter().map(|error| value(error).powi(2));
        (squares.sum::<f64>() / errors.len() as f64).sqrt()
    };
    Comparison {
        quantity: Quantity::RmsMu,
        error: rms(|(error, _)| *error),
        coverage: vec![Coverage {
            total: rms(|(error, std)| error / std) <= NORMAL_95,
            within_laws: None,
            widening: None,
        }],
    }
}

fn interval95(value: f64, std: f64) -> [f64; 2] {
    Uncertain { value, std }.interval95()
}

/// Returns the interval of a positive value, as results state it.
fn log_interval95(value: f64, std: f64) -> [f64; 2] {
    let ln_std = std / value;
    LogUncertain { value, ln_std }.interval95()
}

/// Returns the median; NaN without values.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
