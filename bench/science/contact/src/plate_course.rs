//! Course of a plate's impedance while fingers come and go, predicted from readings without a finger.
//!
//! Two effects move a plate within a trial: the room, at a steady rate, and the warmth of a finger, with first-order kinetics.
//! Warmth grows while the finger lies on the plate and decays with the same time constant T, as does the remainder from touches
//! before the recording. Then Z_p = z0 + ż t + w W(t; T) + h exp(−t/T), linear except in T. The prediction sums over T, each
//! weighted by how well it explains the readings (Bayes). Both parts of Z_p share the warmth, but not exactly T: stiffness and
//! losses respond at different depths of the plate and its glue. The damping's T may thus differ, and is summed over too.
//!
//! Unknowns of a part are β = (z0, ż, w, h) and T; data are its readings y_j ± s_j at t_j, with t counted from the first and
//! rows φ = (1, t, W, e^(−t/T)):
//!
//! ```text
//! dW/dt = (1 − W)/T under a finger, −W/T without
//! y_j = φ_jᵀβ + ε_j,  ε_j ~ N(0, s_j²),  β ~ N(0, Π⁻¹),  Π = diag(1/size², 1/per_s², 1/warmth², 1/warmth²)
//! P = Σ φ_j φ_jᵀ/s_j² + Π,  b = Σ φ_j y_j/s_j²,  β̂ = P⁻¹b,  Cov β = P⁻¹
//! ln p(y | T) = −½ ln|P| + ½ ln|Π| − ½ [Σ (y_j − φ_jᵀβ̂)²/s_j² + β̂ᵀΠβ̂] + const
//! ```
//!
//! The last line, linear regression with a normal prior (Bishop 2006, Eq. 3.86), is summed over the candidate sizes of the
//! warmth (β̂ and P are those of the likeliest) and multiplied by the priors ln T ~ N(ln 8 s, 1.1²) of the reactance and
//! ln T_damping − ln T ~ N(0, 0.3²). Grids even in ln T narrow around the likely T. The prediction is the mixture over all
//! pairs of T: its mean Σ w m and, by the law of total covariance, Σ w (C + (m − Σ w m)(m − Σ w m)ᵀ).

use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix4, OMatrix, SMatrix, Vector4};

/// Median time constant of a finger's warmth, s, and the standard deviation of its logarithm (an assumption: 95 % between 1 and
/// 70 s; a touch of some seconds does not distinguish the longest).
const WARMTH_S: f64 = 8.0;
const WARMTH_LN_STD: f64 = 1.1;
/// Limits, s, and number of the time constants of each part in the sum.
const TIME_CONSTANTS_S: [f64; 2] = [0.7, 120.0];
const TIME_CONSTANTS: usize = 24;
/// Candidate sizes of the warmth as fractions of the stated size, equally likely a priori.
const SIZES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Standard deviation of the logarithm of the ratio of the damping's T to the reactance's (an assumption).
const DAMPING_RATIO_LN_STD: f64 = 0.3;
/// Number of grid refinements.
const REFINEMENTS: usize = 6;
/// Weight below which a time constant is excluded from a refined grid.
const MIN_GRID_WEIGHT: f64 = 1e-4;

/// Reading with its time and standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time_s: f64,
    /// Value read, in the part's own unit.
    pub value: f64,
    /// Standard error of the value.
    pub std: f64,
}

/// Number of parameters of a part.
const PART_PARAMETERS: usize = 4;
/// Weight below which a pair of time constants is left out of the sum.
const MIN_PAIR_WEIGHT: f64 = 1e-9;

/// Prior standard deviations of a part's initial value, of the effect of a long touch, and of the change per second; their
/// means are 0.
#[derive(Debug, Clone, Copy)]
pub struct CourseStds {
    /// Standard deviation of the initial value, and of the effect of a long touch.
    pub size: f64,
    /// Standard deviation of the change per second.
    pub per_s: f64,
}

/// Begin and end of each touch of the plate by a finger in order, s.
pub type Touches<'a> = &'a [(f64, f64)];

/// A part of Z_p, real or imaginary.
pub struct ImpedancePart<'a> {
    /// Readings without a finger.
    pub readings: &'a [Reading],
    /// Prior standard deviations.
    pub stds: CourseStds,
}

/// Both parts of Z_p at some times, all values of the first part before those of the second.
pub struct Prediction {
    /// Mean at each time.
    pub mean: DVector<f64>,
    /// Factor of the covariance, which is its product with its transpose; the number of columns does not grow with the times.
    pub factor: DMatrix<f64>,
}

impl Prediction {
    /// Returns the variance at an index.
    #[must_use]
    pub fn variance(&self, index: usize) -> f64 {
        self.factor.row(index).norm_squared()
    }
}

/// Fit of a part with one T.
struct PartFit {
    /// Estimates of z0, ż, w and h, and their covariance.
    parameters: Vector4<f64>,
    covariance: Matrix4<f64>,
    /// Logarithm of the probability of the readings, up to a constant common to all T.
    ln_evidence: f64,
    /// Σ ((read − fitted)/std)².
    squares: f64,
}

/// Normal equations of a part's parameters for one T.
#[derive(Default)]
struct NormalEquations {
    precision: Matrix4<f64>,
    right_side: Vector4<f64>,
    squares: f64,
}

impl NormalEquations {
    fn add(&mut self, row: Vector4<f64>, reading: &Reading) {
        let weight = reading.std.powi(-2);
        self.precision += row * row.transpose() * weight;
        self.right_side += row * (reading.value * weight);
        self.squares += reading.value.powi(2) * weight;
    }

    /// Solves the normal equations for a prior standard deviation `warmth` of the warmth.
    fn solve(&self, stds: CourseStds, warmth: f64) -> PartFit {
        let stds = Vector4::new(stds.size, stds.per_s, warmth, warmth);
        let prior = stds.map(|std| std.powi(-2));
        let precision = self.precision + Matrix4::from_diagonal(&prior);
        // Scale to a unit diagonal, because long courses span many orders of magnitude.
        let scale = precision.diagonal().map(|entry| entry.sqrt().recip());
        let scaling = Matrix4::from_diagonal(&scale);
        let Some(factor) = (scaling * precision * scaling).cholesky() else {
            // Return the prior, with less evidence than any solution.
            return PartFit {
                parameters: Vector4::zeros(),
                covariance: Matrix4::from_diagonal(&stds.map(|std| std * std)),
                ln_evidence: f64::MIN,
                squares: self.squares,
            };
        };
        let covariance = scaling * factor.inverse() * scaling;
        let parameters = covariance * self.right_side;
        // Σ (y − φᵀβ̂)²/s² = Σ y²/s² − 2 β̂ᵀb + β̂ᵀ(Σ φφᵀ/s²)β̂.
        let squares = self.squares - 2.0 * parameters.dot(&self.right_side)
            + parameters.dot(&(self.precision * parameters));
        let cost = squares + parameters.component_mul(&parameters).dot(&prior);
        let ln_product = |values: &Vector4<f64>| values.map(f64::ln).sum();
        PartFit {
            parameters,
            covariance,
            // P = D⁻¹L LᵀD⁻¹ with the scaling D: −½ ln|P| = Σ ln D_ii − Σ ln L_ii, and ½ ln|Π| = −Σ ln std.
            ln_evidence: ln_product(&scale)
                - ln_product(&factor.l_dirty().diagonal())
                - ln_product(&stds)
                - 0.5 * cost,
            squares: squares.max(0.0),
        }
    }
}

/// Predicts both parts at `times_s`.
#[must_use]
pub fn predict(
    parts: &[ImpedancePart<'_>; 2],
    touches: Touches<'_>,
    times_s: &[f64],
) -> Prediction {
    let start_s = parts[0]
        .readings
        .first()
        .map_or(0.0, |reading| reading.time_s);
    let readings = [0, 1].map(|part: usize| -> Vec<Reading> {
        let free = parts[part].readings.iter();
        free.filter(|reading| reading.value.is_finite())
            .copied()
            .collect()
    });
    let courses_on = |grid: Grid| {
        grid.ln_t().map(|ln_t| Course {
            t_s: ln_t.exp(),
            start_s,
            touches,
        })
    };
    let pair_weights = |grids: &[Grid; 2]| {
        let ln_evidence = |part: usize| {
            let stds = parts[part].stds;
            courses_on(grids[part]).map(|course| course.explain(&readings[part], stds).ln_evidence)
        };
        pairs(grids, &[ln_evidence(0), ln_evidence(1)])
    };
    let mut grids = [Grid(TIME_CONSTANTS_S.map(f64::ln)); 2];
    let mut weights = pair_weights(&grids);
    for _ in 0..REFINEMENTS {
        let refinements = [0, 1].map(|part| grids[part].refine(&part_weights(&weights, part)));
        if refinements == [None; 2] {
            break;
        }
        grids = [0, 1].map(|part| refinements[part].unwrap_or(grids[part]));
        weights = pair_weights(&grids);
    }
    let predictions = [0, 1].map(|part| {
        courses_on(grids[part])
            .map(|course| course.predict(&readings[part], parts[part].stds, times_s))
    });
    sum(&weights, &predictions)
}

/// Logarithms of time constants in s, evenly spaced between two limits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid([f64; 2]);

impl Grid {
    fn spacing(self) -> f64 {
        (self.0[1] - self.0[0]) / (TIME_CONSTANTS - 1) as f64
    }

    fn ln_t(self) -> [f64; TIME_CONSTANTS] {
        std::array::from_fn(|k| self.0[0] + self.spacing() * k as f64)
    }

    /// Returns a grid around the likely time constants; `None` if it would not be much narrower.
    fn refine(self, weights: &[f64; TIME_CONSTANTS]) -> Option<Self> {
        let is_likely = |weight: &f64| *weight > MIN_GRID_WEIGHT;
        let first = weights.iter().position(is_likely)?;
        let last = weights.iter().rposition(is_likely)?;
        let ln_t = self.ln_t();
        let limits = [ln_t[first] - self.spacing(), ln_t[last] + self.spacing()];
        let is_narrow = 2 * (last - first + 2) < TIME_CONSTANTS;
        is_narrow.then_some(Self(limits))
    }
}

/// Weight of each pair of time constants: a row for each of the first part, the damping, a column for each of the second.
type Pairs = SMatrix<f64, TIME_CONSTANTS, TIME_CONSTANTS>;

/// Returns the weights of the pairs from the evidence of each part's readings.
fn pairs(grids: &[Grid; 2], ln_evidence: &[[f64; TIME_CONSTANTS]; 2]) -> Pairs {
    let [damping_ln_t, reactance_ln_t] = grids.map(Grid::ln_t);
    let ln_weights = Pairs::from_fn(|row, column| {
        let deviation = (reactance_ln_t[column] - WARMTH_S.ln()) / WARMTH_LN_STD;
        let ratio = (damping_ln_t[row] - reactance_ln_t[column]) / DAMPING_RATIO_LN_STD;
        ln_evidence[0][row] + ln_evidence[1][column] - 0.5 * (deviation * deviation + ratio * ratio)
    });
    let max = ln_weights.max();
    let weights = ln_weights.map(|ln_weight| (ln_weight - max).exp());
    weights / weights.sum()
}

/// Returns the weight of each time constant of a part.
fn part_weights(pairs: &Pairs, part: usize) -> [f64; TIME_CONSTANTS] {
    std::array::from_fn(|k| match part {
        0 => pairs.row(k).sum(),
        _ => pairs.column(k).sum(),
    })
}

/// Sums the predictions over all pairs, with their deviation from the common mean in the covariance.
fn sum(pairs: &Pairs, predictions: &[[PartPrediction; TIME_CONSTANTS]; 2]) -> Prediction {
    let n = predictions[0][0].mean.len();
    let mut mean = DVector::zeros(2 * n);
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for (part, predictions) in predictions.iter().enumerate() {
        let mut part_mean = mean.rows_mut(part * n, n);
        for (prediction, weight) in predictions.iter().zip(part_weights(pairs, part)) {
            part_mean.axpy(weight, &prediction.mean, 1.0);
            if weight > MIN_PAIR_WEIGHT {
                columns.extend(prediction.factor.column_iter().map(|column| {
                    let mut full_column = DVector::zeros(2 * n);
                    full_column
                        .rows_mut(part * n, n)
                        .axpy(weight.sqrt(), &column, 0.0);
                    full_column
                }));
            }
        }
    }
    for (row, damping) in predictions[0].iter().enumerate() {
        for (column, reactance) in predictions[1].iter().enumerate() {
            let weight = pairs[(row, column)];
            if weight > MIN_PAIR_WEIGHT {
                let mut deviation = -&mean;
                deviation.rows_mut(0, n).axpy(1.0, &damping.mean, 1.0);
                deviation.rows_mut(n, n).axpy(1.0, &reactance.mean, 1.0);
                columns.push(deviation * weight.sqrt());
            }
        }
    }
    Prediction {
        mean,
        factor: DMatrix::from_columns(&columns),
    }
}

/// Prediction of a part at some times for one T.
struct PartPrediction {
    mean: DVector<f64>,
    /// Factor of the covariance, which is its product with its transpose.
    factor: OMatrix<f64, Dyn, Const<PART_PARAMETERS>>,
}

/// Basis functions of the course for one T.
struct Course<'a> {
    t_s: f64,
    start_s: f64,
    touches: Touches<'a>,
}

impl Course<'_> {
    /// Fits the readings with the evidence summed over all sizes of the warmth: a single size would favour a T that turns a
    /// small change into warmth of that size.
    fn explain(&self, readings: &[Reading], stds: CourseStds) -> PartFit {
        let mut normal = NormalEquations::default();
        for reading in readings {
            normal.add(self.row(reading.time_s), reading);
        }
        let fits = SIZES.map(|fraction| normal.solve(stds, fraction * stds.size));
        let max = fits
            .iter()
            .map(|fit| fit.ln_evidence)
            .fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = fits.iter().map(|fit| (fit.ln_evidence - max).exp()).sum();
        let best = fits
            .into_iter()
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence));
        let best = best.expect("there are sizes");
        PartFit {
            ln_evidence: max + sum.ln(),
            ..best
        }
    }

    fn predict(&self, readings: &[Reading], stds: CourseStds, times_s: &[f64]) -> PartPrediction {
        let rows =
            OMatrix::<f64, Dyn, Const<PART_PARAMETERS>>::from_fn(times_s.len(), |index, part| {
                self.row(times_s[index])[part]
            });
        let fit = self.explain(readings, stds);
        // Scale the errors up if the readings scatter about the course by more than their own errors: χ² per degree of freedom
        // above 1 multiplies the covariance (Birge 1932).
        let freedom = readings.len().saturating_sub(PART_PARAMETERS).max(1) as f64;
        let excess = (fit.squares / freedom).max(1.0);
        PartPrediction {
            mean: &rows * fit.parameters,
            factor: match fit.covariance.cholesky() {
                Some(factor) => rows * factor.l() * excess.sqrt(),
                None => rows * 0.0,
            },
        }
    }

    /// Returns the derivatives of the part at a time by its parameters.
    fn row(&self, time_s: f64) -> Vector4<f64> {
        let elapsed_s = time_s - self.start_s;
        let decay = (-elapsed_s / self.t_s).exp();
        Vector4::new(
            1.0,
            elapsed_s,
            warmth(time_s, self.t_s, self.touches),
            decay,
        )
    }
}

/// Returns the warmth at a time as a fraction, 0 to 1, of that of a long touch.
fn warmth(time_s: f64, t_s: f64, touches: Touches<'_>) -> f64 {
    let (mut share, mut last_s) = (0.0f64, f64::NEG_INFINITY);
    for &(begin_s, end_s) in touches {
        if time_s <= begin_s {
            break;
        }
        share *= ((last_s - begin_s) / t_s).exp();
        let stop_s = end_s.min(time_s);
        // Under a finger 1 − W decays with T, without one W does.
        share = 1.0 + (share - 1.0) * ((begin_s - stop_s) / t_s).exp();
        last_s = stop_s;
    }
    share * ((last_s - time_s) / t_s).exp()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    const TOUCHES: [(f64, f64); 2] = [(1.0, 4.0), (6.0, 9.0)];
    const STDS: CourseStds = CourseStds {
        size: 1.0,
        per_s: 0.1,
    };

    /// Integrates in steps of 0.1 ms, independent of the closed form.
    fn integrate(duration_s: f64, t_s: f64) -> f64 {
        let mut share = 0.0;
        for step in 0..(duration_s * 1e4).round() as u32 {
            let time_s = (f64::from(step) + 0.5) * 1e-4;
            let is_touched = TOUCHES
                .iter()
                .any(|(begin_s, end_s)| (*begin_s..*end_s).contains(&time_s));
            share += (f64::from(u8::from(is_touched)) - share) / t_s * 1e-4;
        }
        share
    }

    #[test]
    fn warmth_grows_under_a_finger_and_decays_after_it() {
        assert_eq!(warmth(0.5, 3.0, &TOUCHES), 0.0);
        assert_eq!(warmth(5.0, 3.0, &[]), 0.0);
        for t_s in [0.8, 5.0, 60.0] {
            for time_s in [1.5, 3.9, 4.0, 5.0, 7.5, 12.0] {
                assert_relative_eq!(
                    warmth(time_s, t_s, &TOUCHES),
                    integrate(time_s, t_s),
                    epsilon = 1e-4
                );
            }
        }
    }

    fn readings(value_at: impl Fn(f64) -> f64, std: f64) -> Vec<Reading> {
        let times_s = [0.1, 0.3, 0.5, 0.7, 0.9, 4.2, 4.4, 5.0, 5.8, 9.2, 9.4];
        times_s
            .map(|time_s| Reading {
                time_s,
                value: value_at(time_s),
                std,
            })
            .to_vec()
    }

    fn part(readings: &[Reading]) -> ImpedancePart<'_> {
        ImpedancePart {
            readings,
            stds: STDS,
        }
    }

    #[test]
    fn readings_without_a_finger_predict_the_plate_under_it() {
        for (t_s, per_s, remainder) in [(2.0, 2e-3, 0.0), (6.0, -1e-3, 0.05), (20.0, 0.0, -0.1)] {
            let course = |time_s: f64| {
                let cooling = remainder * (-time_s / t_s).exp();
                0.02 + per_s * time_s + 0.3 * warmth(time_s, t_s, &TOUCHES) + cooling
            };
            let free = readings(course, 1e-4);
            let times_s = [1.5, 2.5, 3.5, 7.0, 8.5];
            let prediction = predict(&[part(&free), part(&free)], &TOUCHES, &times_s);
            for (index, time_s) in times_s.into_iter().enumerate() {
                let std = prediction.variance(index).sqrt();
                let error = prediction.mean[index] - course(time_s);
                assert!(error.abs() < 3.0 * std, "{t_s} {time_s}: {error} of {std}");
                assert!(std < 1e-2, "{t_s} {time_s}: {std}");
            }
        }
    }

    /// A part with a single reading after a touch does not determine T, and takes it from the other part.
    #[test]
    fn both_parts_share_a_time_constant() {
        let readings_with = |w: f64| readings(|time_s| w * warmth(time_s, 2.0, &TOUCHES), 1e-3);
        let (mut damping, reactance) = (readings_with(0.3), readings_with(-2.0));
        damping.retain(|reading| reading.time_s < 4.3);
        let single = predict(&[part(&damping), part(&damping)], &TOUCHES, &[2.5]);
        let joint = predict(&[part(&damping), part(&reactance)], &TOUCHES, &[2.5]);
        let truth = 0.3 * warmth(2.5, 2.0, &TOUCHES);
        let error = |prediction: &Prediction| (prediction.mean[0] - truth).abs();
        assert!(error(&joint) < 0.5 * error(&single));
        assert!(error(&joint) < 3.0 * joint.variance(0).sqrt());
    }

    /// A recording of twenty minutes and readings that are not finite still give a prediction.
    #[test]
    fn long_courses_and_invalid_readings_are_predicted() {
        let touches: Vec<(f64, f64)> = (0..120)
            .map(|k| f64::from(k) * 10.0 + 2.0)
            .map(|begin_s| (begin_s, begin_s + 6.0))
            .collect();
        let free: Vec<Reading> = (0..1200)
            .map(|k| f64::from(k) + 0.5)
            .map(|time_s| Reading {
                time_s,
                value: 0.3 * warmth(time_s, 5.0, &touches),
                std: 1e-4,
            })
            .collect();
        let invalid = [Reading {
            time_s: 1.0,
            value: f64::NAN,
            std: 1e-4,
        }];
        let prediction = predict(&[part(&free), part(&free)], &touches, &[1005.0]);
        assert_relative_eq!(
            prediction.mean[0],
            0.3 * warmth(1005.0, 5.0, &touches),
            epsilon = 1e-3
        );
        assert!(prediction.variance(0).is_finite());
        let prior = predict(&[part(&invalid), part(&invalid)], &TOUCHES, &[2.5]);
        assert_eq!(prior.mean.len(), 2);
    }

    /// Readings that do not follow such a course give a prediction with larger errors.
    #[test]
    fn irregular_readings_widen_the_prediction() {
        let std = |free: &[Reading]| {
            let prediction = predict(&[part(free), part(free)], &TOUCHES, &[2.5]);
            prediction.variance(0).sqrt()
        };
        let regular = std(&readings(|_| 0.1, 1e-4));
        let irregular = std(&readings(|time_s| 0.1 + 0.01 * (7.0 * time_s).sin(), 1e-4));
        assert!(irregular > 20.0 * regular, "{irregular} {regular}");
    }
}
