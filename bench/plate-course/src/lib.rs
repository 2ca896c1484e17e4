//! The course that a plate's impedance takes while fingers come and go, from where it was read without one.
//!
//! Two things move a plate within a trial: the room, steadily, and the warmth of a finger, by first-order kinetics: it grows
//! while the finger lies on the plate and wears off with the same time constant T, as does what is left of touches before the
//! recording. Z_p is then z0 + ż t + w W(t; T) + h exp(−t/T): linear but for T, which is summed over, each T weighted by how well
//! it explains what was read (Bayes). Both parts of Z_p share the warmth, but not quite T: stiffness and losses answer to other
//! depths of the plate and its glue. So the damping's T may be another, which is summed over too.

use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix4, OMatrix, SMatrix, Vector4};

/// Median time constant of a finger's warmth, s, and the standard deviation of its logarithm (an assumption: 95 % between 1 and
/// 70 s; a touch of some seconds does not tell the longest apart).
const WARMTH_S: f64 = 8.0;
const WARMTH_LN_STD: f64 = 1.1;
/// Time constants of each part that are summed over: between which, s, and how many.
const TIME_CONSTANTS_S: [f64; 2] = [0.7, 120.0];
const TIME_CONSTANTS: usize = 24;
/// Parts of the stated size that warmth may have, one as likely as the other.
const SIZES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Standard deviation of the logarithm of the damping's T over the reactance's (an assumption).
const DAMPING_RATIO_LN_STD: f64 = 0.3;
/// Times that the sum goes closer where few of them are likely.
const CLOSER: usize = 6;
/// A time constant that is less likely than this lies outside of those that are.
const HARDLY: f64 = 1e-4;

/// What was read, when, and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time_s: f64,
    /// What was read, in the part's own unit.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}

/// Number of parameters of a part.
const PARTS: usize = 4;
/// A pair of time constants that is less likely than this is left out of the sum.
const UNLIKELY: f64 = 1e-9;

/// Standard deviations beforehand of a part's value at first and of what a long touch makes of it, and of its change in a second;
/// their means are 0.
#[derive(Debug, Clone, Copy)]
pub struct CourseStds {
    /// Of the value at first, and of what a long touch makes of it.
    pub size: f64,
    /// Of its change in a second.
    pub per_s: f64,
}

/// When a finger lay on the plate: begin and end of each touch in order, s.
pub type Touches<'a> = &'a [(f64, f64)];

/// A part of Z_p, real or imaginary.
pub struct Part<'a> {
    /// What was read where no finger was.
    pub free: &'a [Reading],
    /// What is likely of it beforehand.
    pub stds: CourseStds,
}

/// Both parts of Z_p at some times, all of the first before all of the second.
pub struct Predicted {
    /// What is likely at each time.
    pub mean: DVector<f64>,
    /// The covariance is this times its transpose: its columns do not grow with the times.
    pub factor: DMatrix<f64>,
}

impl Predicted {
    /// Returns the variance at one of the places.
    #[must_use]
    pub fn variance(&self, place: usize) -> f64 {
        self.factor.row(place).norm_squared()
    }
}

/// A part explained with one T.
struct Explained {
    /// z0, ż, w and what is left of touches before, and their covariance.
    at: Vector4<f64>,
    covariance: Matrix4<f64>,
    /// Logarithm of the readings' probability, but for what all T share.
    ln_evidence: f64,
    /// Σ ((read − explained)/std)².
    squares: f64,
}

/// What readings tell of a part's parameters for one T: the normal equations.
#[derive(Default)]
struct Told {
    precision: Matrix4<f64>,
    along: Vector4<f64>,
    squares: f64,
}

impl Told {
    fn add(&mut self, row: Vector4<f64>, reading: &Reading) {
        let weight = reading.std.powi(-2);
        self.precision += row * row.transpose() * weight;
        self.along += row * (reading.value * weight);
        self.squares += reading.value.powi(2) * weight;
    }

    /// Explains them where the warmth is of such a size beforehand.
    fn explained(&self, stds: CourseStds, warmth: f64) -> Explained {
        let stds = Vector4::new(stds.size, stds.per_s, warmth, warmth);
        let prior = stds.map(|std| std.powi(-2));
        let precision = self.precision + Matrix4::from_diagonal(&prior);
        // Scaled to a unit diagonal: long courses span many orders.
        let scale = precision.diagonal().map(|of| of.sqrt().recip());
        let scaling = Matrix4::from_diagonal(&scale);
        let Some(factor) = (scaling * precision * scaling).cholesky() else {
            // What was likely beforehand, and less likely than whatever explains them.
            return Explained {
                at: Vector4::zeros(),
                covariance: Matrix4::from_diagonal(&stds.map(|std| std * std)),
                ln_evidence: f64::MIN,
                squares: self.squares,
            };
        };
        let covariance = scaling * factor.inverse() * scaling;
        let at = covariance * self.along;
        let squares = self.squares - 2.0 * at.dot(&self.along) + at.dot(&(self.precision * at));
        let likely = squares + at.component_mul(&at).dot(&prior);
        let ln = |of: &Vector4<f64>| of.map(f64::ln).sum();
        Explained {
            at,
            covariance,
            ln_evidence: ln(&scale) - ln(&factor.l_dirty().diagonal()) - ln(&stds) - 0.5 * likely,
            squares: squares.max(0.0),
        }
    }
}

/// Returns both parts at `times_s`.
#[must_use]
pub fn predicted(parts: &[Part<'_>; 2], touches: Touches<'_>, times_s: &[f64]) -> Predicted {
    let since_s = parts[0].free.first().map_or(0.0, |of| of.time_s);
    let read = [0, 1].map(|part: usize| -> Vec<Reading> {
        let free = parts[part].free.iter();
        free.filter(|of| of.value.is_finite()).copied().collect()
    });
    let on = |grid: Grid| {
        grid.ln_t().map(|ln_t| Course {
            t_s: ln_t.exp(),
            since_s,
            touches,
        })
    };
    let likely = |grids: &[Grid; 2]| {
        let ln_evidence = |part: usize| {
            let stds = parts[part].stds;
            on(grids[part]).map(|course| course.explain(&read[part], stds).ln_evidence)
        };
        pairs(grids, &[ln_evidence(0), ln_evidence(1)])
    };
    let mut grids = [Grid(TIME_CONSTANTS_S.map(f64::ln)); 2];
    let mut weights = likely(&grids);
    for _ in 0..CLOSER {
        let closer = [0, 1].map(|part| grids[part].closer(&of_part(&weights, part)));
        if closer == [None; 2] {
            break;
        }
        grids = [0, 1].map(|part| closer[part].unwrap_or(grids[part]));
        weights = likely(&grids);
    }
    let each = [0, 1].map(|part| {
        on(grids[part]).map(|course| course.predict(&read[part], parts[part].stds, times_s))
    });
    sum(&weights, &each)
}

/// Logarithms of time constants, in s, evenly apart between two.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid([f64; 2]);

impl Grid {
    fn spacing(self) -> f64 {
        (self.0[1] - self.0[0]) / (TIME_CONSTANTS - 1) as f64
    }

    fn ln_t(self) -> [f64; TIME_CONSTANTS] {
        std::array::from_fn(|k| self.0[0] + self.spacing() * k as f64)
    }

    /// Returns a grid about those that are likely; `None` where they are not much fewer than all.
    fn closer(self, weights: &[f64; TIME_CONSTANTS]) -> Option<Self> {
        let likely = |weight: &f64| *weight > HARDLY;
        let first = weights.iter().position(likely)?;
        let last = weights.iter().rposition(likely)?;
        let ln_t = self.ln_t();
        let about = [ln_t[first] - self.spacing(), ln_t[last] + self.spacing()];
        let few = 2 * (last - first + 2) < TIME_CONSTANTS;
        few.then_some(Self(about))
    }
}

/// How likely each pair of time constants is: a row for each of the first part, the damping, a column for each of the second.
type Pairs = SMatrix<f64, TIME_CONSTANTS, TIME_CONSTANTS>;

/// Returns how likely pairs are, of which each part's readings tell so much.
fn pairs(grids: &[Grid; 2], ln_evidence: &[[f64; TIME_CONSTANTS]; 2]) -> Pairs {
    let [of_damping, of_reactance] = grids.map(Grid::ln_t);
    let ln_likely = Pairs::from_fn(|row, column| {
        let apart = (of_reactance[column] - WARMTH_S.ln()) / WARMTH_LN_STD;
        let ratio = (of_damping[row] - of_reactance[column]) / DAMPING_RATIO_LN_STD;
        ln_evidence[0][row] + ln_evidence[1][column] - 0.5 * (apart * apart + ratio * ratio)
    });
    let most = ln_likely.max();
    let weights = ln_likely.map(|ln_likely| (ln_likely - most).exp());
    weights / weights.sum()
}

/// Returns how likely each time constant of a part is.
fn of_part(pairs: &Pairs, part: usize) -> [f64; TIME_CONSTANTS] {
    std::array::from_fn(|k| match part {
        0 => pairs.row(k).sum(),
        _ => pairs.column(k).sum(),
    })
}

/// Sums over all pairs: what each T predicts, and how far that lies from the mean of all.
fn sum(pairs: &Pairs, each: &[[PartPredicted; TIME_CONSTANTS]; 2]) -> Predicted {
    let n = each[0][0].mean.len();
    let mut mean = DVector::zeros(2 * n);
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for (part, each) in each.iter().enumerate() {
        let mut of_part_mean = mean.rows_mut(part * n, n);
        for (of, weight) in each.iter().zip(of_part(pairs, part)) {
            of_part_mean.axpy(weight, &of.mean, 1.0);
            if weight > UNLIKELY {
                columns.extend(of.factor.column_iter().map(|column| {
                    let mut whole = DVector::zeros(2 * n);
                    whole
                        .rows_mut(part * n, n)
                        .axpy(weight.sqrt(), &column, 0.0);
                    whole
                }));
            }
        }
    }
    for (row, damping) in each[0].iter().enumerate() {
        for (column, reactance) in each[1].iter().enumerate() {
            let weight = pairs[(row, column)];
            if weight > UNLIKELY {
                let mut apart = -&mean;
                apart.rows_mut(0, n).axpy(1.0, &damping.mean, 1.0);
                apart.rows_mut(n, n).axpy(1.0, &reactance.mean, 1.0);
                columns.push(apart * weight.sqrt());
            }
        }
    }
    Predicted {
        mean,
        factor: DMatrix::from_columns(&columns),
    }
}

/// A part at some times for one T.
struct PartPredicted {
    mean: DVector<f64>,
    /// The covariance is this times its transpose.
    factor: OMatrix<f64, Dyn, Const<PARTS>>,
}

/// The shapes of what moves a plate, for one T.
struct Course<'a> {
    t_s: f64,
    since_s: f64,
    touches: Touches<'a>,
}

impl Course<'_> {
    /// Explains the readings, whatever the size of the warmth: with one size alone, the T would be most likely that makes so
    /// much warmth of so little change.
    fn explain(&self, readings: &[Reading], stds: CourseStds) -> Explained {
        let mut told = Told::default();
        for of in readings {
            told.add(self.row(of.time_s), of);
        }
        let each = SIZES.map(|part| told.explained(stds, part * stds.size));
        let most = each
            .iter()
            .map(|of| of.ln_evidence)
            .fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = each.iter().map(|of| (of.ln_evidence - most).exp()).sum();
        let best = each
            .into_iter()
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence));
        let best = best.expect("there are sizes");
        Explained {
            ln_evidence: most + sum.ln(),
            ..best
        }
    }

    fn predict(&self, readings: &[Reading], stds: CourseStds, times_s: &[f64]) -> PartPredicted {
        let rows = OMatrix::<f64, Dyn, Const<PARTS>>::from_fn(times_s.len(), |index, part| {
            self.row(times_s[index])[part]
        });
        let free = self.explain(readings, stds);
        // Readings that scatter more about the course than their errors say are worth less.
        let freedom = readings.len().saturating_sub(PARTS).max(1) as f64;
        let excess = (free.squares / freedom).max(1.0);
        PartPredicted {
            mean: &rows * free.at,
            factor: match free.covariance.cholesky() {
                Some(factor) => rows * factor.l() * excess.sqrt(),
                None => rows * 0.0,
            },
        }
    }

    /// Returns by how much each parameter of a part moves it at a time.
    fn row(&self, time_s: f64) -> Vector4<f64> {
        let since_s = time_s - self.since_s;
        let left = (-since_s / self.t_s).exp();
        Vector4::new(1.0, since_s, warmth(time_s, self.t_s, self.touches), left)
    }
}

/// Returns the share, 0 to 1, of what a long touch makes of the plate.
fn warmth(time_s: f64, t_s: f64, touches: Touches<'_>) -> f64 {
    let (mut share, mut since_s) = (0.0f64, f64::NEG_INFINITY);
    for &(begin_s, end_s) in touches {
        if time_s <= begin_s {
            break;
        }
        share *= ((since_s - begin_s) / t_s).exp();
        let until_s = end_s.min(time_s);
        share = 1.0 + (share - 1.0) * ((begin_s - until_s) / t_s).exp();
        since_s = until_s;
    }
    share * ((since_s - time_s) / t_s).exp()
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

    /// Independent of the closed form: steps of a millisecond.
    fn stepped(until_s: f64, t_s: f64) -> f64 {
        let mut share = 0.0;
        for step in 0..(until_s * 1e4).round() as u32 {
            let time_s = (f64::from(step) + 0.5) * 1e-4;
            let on = TOUCHES
                .iter()
                .any(|(from, to)| (*from..*to).contains(&time_s));
            share += (f64::from(u8::from(on)) - share) / t_s * 1e-4;
        }
        share
    }

    #[test]
    fn warmth_grows_under_a_finger_and_wears_off_without() {
        assert_eq!(warmth(0.5, 3.0, &TOUCHES), 0.0);
        assert_eq!(warmth(5.0, 3.0, &[]), 0.0);
        for t_s in [0.8, 5.0, 60.0] {
            for time_s in [1.5, 3.9, 4.0, 5.0, 7.5, 12.0] {
                assert_relative_eq!(
                    warmth(time_s, t_s, &TOUCHES),
                    stepped(time_s, t_s),
                    epsilon = 1e-4
                );
            }
        }
    }

    fn read(of: impl Fn(f64) -> f64, std: f64) -> Vec<Reading> {
        let free = [0.1, 0.3, 0.5, 0.7, 0.9, 4.2, 4.4, 5.0, 5.8, 9.2, 9.4];
        free.map(|time_s| Reading {
            time_s,
            value: of(time_s),
            std,
        })
        .to_vec()
    }

    fn part(free: &[Reading]) -> Part<'_> {
        Part { free, stds: STDS }
    }

    #[test]
    fn what_was_read_beside_a_finger_tells_what_holds_under_it() {
        for (t_s, per_s, left) in [(2.0, 2e-3, 0.0), (6.0, -1e-3, 0.05), (20.0, 0.0, -0.1)] {
            let course = |time_s: f64| {
                let cooling = left * (-time_s / t_s).exp();
                0.02 + per_s * time_s + 0.3 * warmth(time_s, t_s, &TOUCHES) + cooling
            };
            let free = read(course, 1e-4);
            let times_s = [1.5, 2.5, 3.5, 7.0, 8.5];
            let found = predicted(&[part(&free), part(&free)], &TOUCHES, &times_s);
            for (index, time_s) in times_s.into_iter().enumerate() {
                let std = found.variance(index).sqrt();
                let apart = found.mean[index] - course(time_s);
                assert!(apart.abs() < 3.0 * std, "{t_s} {time_s}: {apart} of {std}");
                assert!(std < 1e-2, "{t_s} {time_s}: {std}");
            }
        }
    }

    /// A part that was read but once after a touch shows no T, and learns it from the other.
    #[test]
    fn both_parts_share_a_time_constant() {
        let read_of = |w: f64| read(|time_s| w * warmth(time_s, 2.0, &TOUCHES), 1e-3);
        let (mut damping, reactance) = (read_of(0.3), read_of(-2.0));
        damping.retain(|of| of.time_s < 4.3);
        let alone = predicted(&[part(&damping), part(&damping)], &TOUCHES, &[2.5]);
        let told = predicted(&[part(&damping), part(&reactance)], &TOUCHES, &[2.5]);
        let truth = 0.3 * warmth(2.5, 2.0, &TOUCHES);
        let apart = |of: &Predicted| (of.mean[0] - truth).abs();
        assert!(apart(&told) < 0.5 * apart(&alone));
        assert!(apart(&told) < 3.0 * told.variance(0).sqrt());
    }

    /// A recording of twenty minutes, and readings that are none, leave a prediction all the same.
    #[test]
    fn long_courses_and_broken_readings_are_predicted() {
        let touches: Vec<(f64, f64)> = (0..120)
            .map(|k| f64::from(k) * 10.0 + 2.0)
            .map(|from| (from, from + 6.0))
            .collect();
        let free: Vec<Reading> = (0..1200)
            .map(|k| f64::from(k) + 0.5)
            .map(|time_s| Reading {
                time_s,
                value: 0.3 * warmth(time_s, 5.0, &touches),
                std: 1e-4,
            })
            .collect();
        let broken = [Reading {
            time_s: 1.0,
            value: f64::NAN,
            std: 1e-4,
        }];
        let long = predicted(&[part(&free), part(&free)], &touches, &[1005.0]);
        assert_relative_eq!(
            long.mean[0],
            0.3 * warmth(1005.0, 5.0, &touches),
            epsilon = 1e-3
        );
        assert!(long.variance(0).is_finite());
        let none = predicted(&[part(&broken), part(&broken)], &TOUCHES, &[2.5]);
        assert_eq!(none.mean.len(), 2);
    }

    /// What follows no such course is not predicted with the errors of what was read.
    #[test]
    fn readings_astray_widen_the_prediction() {
        let std = |free: &[Reading]| {
            let found = predicted(&[part(free), part(free)], &TOUCHES, &[2.5]);
            found.variance(0).sqrt()
        };
        let still = std(&read(|_| 0.1, 1e-4));
        let astray = std(&read(|time_s| 0.1 + 0.01 * (7.0 * time_s).sin(), 1e-4));
        assert!(astray > 20.0 * still, "{astray} {still}");
    }
}
