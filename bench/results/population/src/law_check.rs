//! Check of a participant's estimates that needs no law of the contact.
//!
//! σ_t, S, τ and Z_t belong to the finger. Under any law of film and asperities, a right estimate agrees between
//! drive levels, modulation frequencies and carriers; a wrong law shows as a difference. For each setting, the trials at
//! two of its values are compared within each combination of the other settings, and the differences are averaged. Compared are the
//! values by the published laws, with the errors that these leave: doubts about laws are common to all conditions.
//!
//! A condition's mean weights its trials by their errors and the variance between them (DerSimonian and Laird 1986). Its variance
//! follows from the scatter of the trials (Hartung and Knapp 2001), never less than their errors allow; degrees of freedom are
//! those of Welch (1947) and Satterthwaite (1946). p-values are adjusted for the number of a participant's comparisons (Holm
//! 1979), so that 95 % of the participants with a right estimate have no difference at all.

mod trials;
mod words;

use std::collections::BTreeSet;

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

pub use trials::law_checks;

/// Adjusted p-value below which two conditions differ.
const LEVEL: f64 = 0.05;
/// Fewest trials of a condition for its mean: the scatter needs two.
const FEWEST_TRIALS: usize = 2;

/// Setting in which conditions differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Setting {
    /// Peak voltage of the carrier, averaged over the modulation.
    DriveV,
    /// Modulation frequency.
    ModulationHz,
    /// Carrier frequency.
    CarrierHz,
}

impl Setting {
    /// All settings, in the order of [`Condition`].
    pub const ALL: [Self; 3] = [Self::DriveV, Self::ModulationHz, Self::CarrierHz];

    /// Returns the ratio of two neighbouring values above which they are two settings: larger than the drift of a drive level,
    /// and of a carrier that follows the plate's resonance.
    fn least_ratio(self) -> f64 {
        match self {
            Self::DriveV => 1.1,
            Self::ModulationHz => 1.05,
            Self::CarrierHz => 1.005,
        }
    }

    /// Returns whether its values may belong to different calibrations: the trials' errors are then shared by all trials of a
    /// value, and do not shrink with their number.
    fn changes_calibration(self) -> bool {
        self == Self::CarrierHz
    }
}

/// Settings of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Condition {
    /// Peak voltage of the carrier across the actuators, averaged over the modulation, V.
    pub drive_v: f64,
    /// Modulation frequency, Hz.
    pub modulation_hz: f64,
    /// Carrier frequency, Hz.
    pub carrier_hz: f64,
}

impl Condition {
    fn as_array(&self) -> [f64; 3] {
        [self.drive_v, self.modulation_hz, self.carrier_hz]
    }

    fn is_known(&self) -> bool {
        self.as_array()
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
    }
}

/// A value for each compared quantity. Lengths and times are compared by their natural logarithms.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Quantities<T> {
    /// ln σ_t.
    pub ln_sigma_t: T,
    /// ln S, at the mean force of the participant's trials.
    pub ln_contact_area: T,
    /// ln τ, at the mean gap of the participant's trials.
    pub ln_tau: T,
    /// Re Z_t, N·s/m.
    pub re_z_t_n_s_per_m: T,
    /// Im Z_t/ω, kg: the same at all carriers if the skin's reactance is that of a mass.
    pub im_z_t_over_omega_kg: T,
}

impl<T> Quantities<T> {
    fn from_fn(mut value: impl FnMut(usize) -> T) -> Self {
        Self {
            ln_sigma_t: value(0),
            ln_contact_area: value(1),
            ln_tau: value(2),
            re_z_t_n_s_per_m: value(3),
            im_z_t_over_omega_kg: value(4),
        }
    }

    /// Returns the values in order.
    pub fn as_array(&self) -> [&T; 5] {
        [
            &self.ln_sigma_t,
            &self.ln_contact_area,
            &self.ln_tau,
            &self.re_z_t_n_s_per_m,
            &self.im_z_t_over_omega_kg,
        ]
    }

    fn as_array_mut(&mut self) -> [&mut T; 5] {
        [
            &mut self.ln_sigma_t,
            &mut self.ln_contact_area,
            &mut self.ln_tau,
            &mut self.re_z_t_n_s_per_m,
            &mut self.im_z_t_over_omega_kg,
        ]
    }
}

/// Estimate of a quantity from one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    value: f64,
    std: f64,
}

impl Estimate {
    /// Makes an estimate; `None` if the value is unknown, or its standard error unknown or zero.
    #[must_use]
    pub fn new(value: f64, std: f64) -> Option<Self> {
        let is_known = value.is_finite() && std.is_finite() && std > 0.0;
        is_known.then_some(Self { value, std })
    }
}

/// A trial of a participant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckedTrial {
    /// Settings.
    pub condition: Condition,
    /// Estimates.
    pub estimates: Quantities<Option<Estimate>>,
}

/// Check of a participant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawCheck {
    /// Participant, as in the recordings.
    pub participant: String,
    /// Number of compared trials.
    pub n_trials: usize,
    /// Number of recordings without a usable fit by `trial`.
    pub n_left_out: usize,
    /// Conditions, in the order of their settings.
    pub conditions: Vec<ConditionRow>,
    /// Comparisons; empty if all conditions differ in several settings at once.
    pub comparisons: Vec<Comparison>,
}

/// Condition of a participant, with medians of the trials' settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ConditionRow {
    /// Settings.
    #[serde(flatten)]
    pub condition: Condition,
    /// Number of trials.
    pub n_trials: usize,
}

/// Comparison of the trials at two values of a setting, all other settings equal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// Setting.
    pub setting: Setting,
    /// Smaller value.
    pub lower: f64,
    /// Larger value.
    pub upper: f64,
    /// Differences; `None` with fewer than two trials of a condition.
    pub differences: Quantities<Option<Difference>>,
}

/// Difference of a quantity: at the larger value of the setting minus at the smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// Difference.
    pub value: f64,
    /// Standard error.
    pub std: f64,
    /// Degrees of freedom of the standard error.
    pub freedom: f64,
    /// 95 % interval, not adjusted for the number of comparisons.
    pub interval95: [f64; 2],
    /// Two-sided p-value.
    pub p: f64,
    /// p-value adjusted for the number of comparisons of this participant.
    pub p_adjusted: f64,
    /// Whether the adjusted p-value is at least 0.05.
    pub agrees: bool,
}

/// Compares the trials of a participant; `None` if all have the same settings.
#[must_use]
pub fn check(participant: &str, trials: &[CheckedTrial], n_left_out: usize) -> Option<LawCheck> {
    let grid = ConditionGrid::new(trials);
    let conditions = grid.conditions();
    if conditions.len() < 2 {
        return None;
    }
    let mut comparisons = Vec::new();
    for setting in Setting::ALL {
        let levels = &grid.levels[setting as usize];
        for lower in 0..levels.len() {
            comparisons.extend(
                (lower + 1..levels.len()).filter_map(|upper| grid.compare(setting, lower, upper)),
            );
        }
    }
    adjust(&mut comparisons);
    Some(LawCheck {
        participant: participant.to_owned(),
        n_trials: trials.len(),
        n_left_out,
        conditions,
        comparisons,
    })
}

/// Trials by condition.
struct ConditionGrid<'a> {
    trials: &'a [CheckedTrial],
    /// Medians of each setting's groups of values, increasing.
    levels: [Vec<f64>; 3],
    /// Groups of each trial's settings.
    cells: Vec<[usize; 3]>,
}

impl<'a> ConditionGrid<'a> {
    fn new(trials: &'a [CheckedTrial]) -> Self {
        let mut levels: [Vec<f64>; 3] = Default::default();
        let mut cells = vec![[0; 3]; trials.len()];
        for setting in Setting::ALL {
            let index = setting as usize;
            let value = |trial: usize| trials[trial].condition.as_array()[index];
            for group in groups(trials.len(), value, setting.least_ratio()) {
                for &trial in &group {
                    cells[trial][index] = levels[index].len();
                }
                levels[index].extend(statistics::median(group.into_iter().map(value)));
            }
        }
        Self {
            trials,
            levels,
            cells,
        }
    }

    fn conditions(&self) -> Vec<ConditionRow> {
        let distinct_cells: BTreeSet<_> = self.cells.iter().collect();
        let rows = distinct_cells.into_iter().map(|cell| ConditionRow {
            condition: Condition {
                drive_v: self.levels[0][cell[0]],
                modulation_hz: self.levels[1][cell[1]],
                carrier_hz: self.levels[2][cell[2]],
            },
            n_trials: self
                .cells
                .iter()
                .filter(|candidate| *candidate == cell)
                .count(),
        });
        rows.collect()
    }

    /// Compares two groups of a setting; `None` if no two conditions differ in this setting alone.
    fn compare(&self, setting: Setting, lower: usize, upper: usize) -> Option<Comparison> {
        let index = setting as usize;
        let cell_at = |mut cell: [usize; 3], level| {
            cell[index] = level;
            cell
        };
        let lower_cells: BTreeSet<[usize; 3]> = self
            .cells
            .iter()
            .filter(|cell| cell[index] == lower)
            .copied()
            .collect();
        let pairs = lower_cells
            .into_iter()
            .map(|cell| (cell, cell_at(cell, upper)));
        let pairs: Vec<_> = pairs
            .filter(|(_, upper)| self.cells.contains(upper))
            .collect();
        if pairs.is_empty() {
            return None;
        }
        let differences = Quantities::from_fn(|quantity| {
            let mean = |cell| {
                ConditionMean::new(
                    &self.estimates(cell, quantity),
                    setting.changes_calibration(),
                )
            };
            let means = pairs
                .iter()
                .filter_map(|(lower, upper)| Some((mean(*lower)?, mean(*upper)?)));
            difference(&means.collect::<Vec<_>>())
        });
        Some(Comparison {
            setting,
            lower: self.levels[index][lower],
            upper: self.levels[index][upper],
            differences,
        })
    }

    fn estimates(&self, cell: [usize; 3], quantity: usize) -> Vec<Estimate> {
        let trials = self.trials.iter().zip(&self.cells);
        trials
            .filter(|(_, trial_cell)| **trial_cell == cell)
            .filter_map(|(trial, _)| *trial.estimates.as_array()[quantity])
            .collect()
    }
}

/// Returns the numbers 0 to `n` in groups of increasing value; neighbours in a group differ by less than a factor of `ratio`.
fn groups(n: usize, value: impl Fn(usize) -> f64, ratio: f64) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
    let chunks = order.chunk_by(|&a, &b| value(b) < ratio * value(a));
    chunks.map(<[usize]>::to_vec).collect()
}

/// Mean over the trials of a condition.
struct ConditionMean {
    value: f64,
    variance: f64,
    n: f64,
}

impl ConditionMean {
    /// Returns the mean of trials that may scatter by more than their errors; `None` with too few of them. With
    /// `shared_errors`, its error is at least the trials' own.
    fn new(estimates: &[Estimate], shared_errors: bool) -> Option<Self> {
        if estimates.len() < FEWEST_TRIALS {
            return None;
        }
        let n = estimates.len() as f64;
        let fixed = weighted(estimates, 0.0);
        // Q = Σw (y − ȳ)² with w = 1/σ²: if the values scatter by τ² in addition, ⟨Q⟩ = n − 1 + τ² (Σw − Σw²/Σw).
        let between =
            (fixed.squares - (n - 1.0)) / (fixed.weights - fixed.squared_weights / fixed.weights);
        let random = weighted(estimates, between.max(0.0));
        let variance = (random.squares / (n - 1.0)).max(1.0) / random.weights;
        Some(Self {
            value: random.mean,
            variance: match shared_errors {
                true => variance.max(random.mean_std * random.mean_std),
                false => variance,
            },
            n,
        })
    }
}

/// Sums over estimates weighted by their precision.
struct WeightedSums {
    mean: f64,
    /// Weighted mean of the standard errors.
    mean_std: f64,
    weights: f64,
    squared_weights: f64,
    /// Weighted squares about the mean.
    squares: f64,
}

/// Weights estimates by their errors and the variance `between` them.
fn weighted(estimates: &[Estimate], between: f64) -> WeightedSums {
    let weight = |estimate: &Estimate| (estimate.std * estimate.std + between).recip();
    let sum = |term: &dyn Fn(&Estimate) -> f64| -> f64 {
        estimates
            .iter()
            .map(|estimate| weight(estimate) * term(estimate))
            .sum()
    };
    let weights = sum(&|_| 1.0);
    let mean = sum(&|estimate| estimate.value) / weights;
    WeightedSums {
        mean,
        mean_std: sum(&|estimate| estimate.std) / weights,
        weights,
        squared_weights: sum(&weight),
        squares: sum(&|estimate| (estimate.value - mean).powi(2)),
    }
}

/// Returns the mean difference of pairs of conditions, each weighted by its numbers of trials; not yet adjusted. `None` without a
/// pair.
fn difference(pairs: &[(ConditionMean, ConditionMean)]) -> Option<Difference> {
    let weight = |(lower, upper): &(ConditionMean, ConditionMean)| {
        (lower.n.recip() + upper.n.recip()).recip()
    };
    let weights: f64 = pairs.iter().map(weight).sum();
    let (mut value, mut variance, mut squared_variances) = (0.0, 0.0, 0.0);
    for pair in pairs {
        let share = weight(pair) / weights;
        let (lower, upper) = pair;
        value += share * (upper.value - lower.value);
        for mean in [lower, upper] {
            let term = share * share * mean.variance;
            variance += term;
            squared_variances += term * term / (mean.n - 1.0);
        }
    }
    let std = variance.sqrt();
    let freedom = variance * variance / squared_variances;
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let half_width = student.inverse_cdf(0.975) * std;
    let p = 2.0 * student.sf(value.abs() / std);
    Some(Difference {
        value,
        std,
        freedom,
        interval95: [value - half_width, value + half_width],
        p,
        p_adjusted: p,
        agrees: p >= LEVEL,
    })
}

/// Adjusts the p-values of all differences for their number (Holm 1979).
fn adjust(comparisons: &mut [Comparison]) {
    let differences = comparisons
        .iter_mut()
        .flat_map(|comparison| comparison.differences.as_array_mut());
    let mut differences: Vec<&mut Difference> = differences.flatten().collect();
    differences.sort_by(|a, b| a.p.total_cmp(&b.p));
    let mut least: f64 = 0.0;
    let remaining = (1..=differences.len()).rev();
    for (difference, remaining) in differences.into_iter().zip(remaining) {
        least = least.max((remaining as f64 * difference.p).min(1.0));
        difference.p_adjusted = least;
        difference.agrees = least >= LEVEL;
    }
}

#[cfg(test)]
mod tests;
