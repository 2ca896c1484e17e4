//! The course that a plate's impedance takes while fingers come and go, from where it was read without one.
//!
//! Two things move a plate within a trial: the room, steadily, and the warmth of a finger, by first-order kinetics: it grows
//! while the finger lies on the plate and wears off with the same time constant T, as does what is left of touches before the
//! recording. Z_p is then z0 + ż t + w W(t; T) + h exp(−t/T): linear but for T, which is summed over, each T weighted by how well
//! it explains what was read (Bayes). Both parts of Z_p share the warmth, but not quite T: stiffness and losses answer to other
//! depths of the plate and its glue. So the damping's T may be another by a factor, which is summed over too.

use nalgebra::{DMatrix, DVector, Matrix4, Vector4};

/// Median time constant of a finger's warmth, s, and the standard deviation of its logarithm (an assumption: 95 % between 1 and
/// 70 s; a touch of some seconds does not tell the longest apart).
const WARMTH_S: f64 = 8.0;
const WARMTH_LN_STD: f64 = 1.1;
/// Time constants that are summed over: between which, s, and how many.
const TIME_CONSTANTS_S: [f64; 2] = [0.7, 120.0];
const TIME_CONSTANTS: usize = 24;
/// Factors from the reactance's T to the damping's, and their weights: of a logarithm with a standard deviation of 0.3 (an
/// assumption), by Gauss and Hermite's three points.
const DAMPING_RATIOS: [(f64, f64); 3] =
    [(0.594_7, 1.0 / 6.0), (1.0, 2.0 / 3.0), (1.681_4, 1.0 / 6.0)];
/// Times that the sum goes closer where one time constant has nearly all the weight.
const CLOSER: usize = 4;
const NEARLY_ALL: f64 = 0.5;

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
/// Columns that each T adds to a factor of the covariance: those of two parts, and one for how far it lies from all.
const COLUMNS: usize = 2 * PARTS + 1;

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

/// Returns both parts at `times_s`.
#[must_use]
pub fn predicted(parts: &[Part<'_>; 2], touches: Touches<'_>, times_s: &[f64]) -> Predicted {
    let since_s = parts[0].free.first().map_or(0.0, |of| of.time_s);
    let explained = |ln_t: f64, (ratio, likely): (f64, f64)| {
        let course = |t_s| Course {
            t_s,
            since_s,
            touches,
        };
        let t_s = ln_t.exp();
        let apart = (t_s / WARMTH_S).ln() / WARMTH_LN_STD;
        let ln_likely = f64::ln(likely) - 0.5 * apart * apart;
        predict(
            &[course(ratio * t_s), course(t_s)],
            parts,
            times_s,
            ln_likely,
        )
    };
    let mut range = TIME_CONSTANTS_S.map(f64::ln);
    let mut each: Vec<Weighed> = Vec::new();
    for _ in 0..=CLOSER {
        let spacing = (range[1] - range[0]) / (TIME_CONSTANTS - 1) as f64;
        each = (0..TIME_CONSTANTS)
            .map(|k| range[0] + spacing * k as f64)
            .flat_map(|ln_t| DAMPING_RATIOS.map(|ratio| explained(ln_t, ratio)))
            .collect();
        let most = each
            .iter()
            .map(|of| of.weight)
            .fold(f64::NEG_INFINITY, f64::max);
        for of in &mut each {
            of.weight = (of.weight - most).exp();
        }
        let total: f64 = each.iter().map(|of| of.weight).sum();
        for of in &mut each {
            of.weight /= total;
        }
        let of_time = |of: &[Weighed]| of.iter().map(|of| of.weight).sum::<f64>();
        let best = each
            .chunks(DAMPING_RATIOS.len())
            .position(|of| of_time(of) > NEARLY_ALL);
        let Some(best) = best else { break };
        let middle = range[0] + spacing * best as f64;
        range = [middle - spacing, middle + spacing];
    }
    let n = 2 * times_s.len();
    let mut mean = DVector::zeros(n);
    for of in &each {
        mean += &of.mean * of.weight;
    }
    let mut factor = DMatrix::zeros(n, each.len() * COLUMNS);
    for (place, of) in each.iter().enumerate() {
        let mut columns = factor.columns_mut(place * COLUMNS, COLUMNS);
        columns
            .columns_mut(0, COLUMNS - 1)
            .copy_from(&(&of.factor * of.weight.sqrt()));
        columns
            .column_mut(COLUMNS - 1)
            .copy_from(&((&of.mean - &mean) * of.weight.sqrt()));
    }
    Predicted { mean, factor }
}

/// Both parts for one T.
struct Weighed {
    /// Logarithm of how likely this T is, and then its part of the sum.
    weight: f64,
    mean: DVector<f64>,
    /// The covariance is this times its transpose.
    factor: DMatrix<f64>,
}

/// The shapes of what moves a plate, for one T.
struct Course<'a> {
    t_s: f64,
    since_s: f64,
    touches: Touches<'a>,
}

/// Predicts each part by its course, which is as likely beforehand as stated.
fn predict(
    courses: &[Course<'_>; 2],
    parts: &[Part<'_>; 2],
    times_s: &[f64],
    ln_likely: f64,
) -> Weighed {
    let n = times_s.len();
    let mut weighed = Weighed {
        weight: ln_likely,
        mean: DVector::zeros(2 * n),
        factor: DMatrix::zeros(2 * n, COLUMNS - 1),
    };
    for (place, (course, part)) in courses.iter().zip(parts).enumerate() {
        let rows = DMatrix::from_fn(n, PARTS, |index, part| course.row(times_s[index])[part]);
        let free = course.explain(part.free, part.stds);
        weighed.weight += free.ln_evidence;
        // Readings that scatter more about the course than their errors say are worth less.
        let freedom = part.free.len().saturating_sub(PARTS).max(1) as f64;
        let excess = (free.squares / freedom).max(1.0);
        weighed
            .mean
            .rows_mut(place * n, n)
            .copy_from(&(&rows * free.at));
        if let Some(factor) = free.covariance.cholesky() {
            weighed
                .factor
                .view_mut((place * n, place * PARTS), (n, PARTS))
                .copy_from(&(&rows * factor.l() * excess.sqrt()));
        }
    }
    weighed
}

impl Course<'_> {
    fn explain(&self, readings: &[Reading], stds: CourseStds) -> Explained {
        let stds = [stds.size, stds.per_s, stds.size, stds.size];
        let prior = Vector4::from(stds.map(|std| std.powi(-2)));
        let mut precision = Matrix4::from_diagonal(&prior);
        let mut along = Vector4::zeros();
        for reading in readings {
            let row = self.row(reading.time_s);
            let weight = reading.std.powi(-2);
            precision += row * row.transpose() * weight;
            along += row * (reading.value * weight);
        }
        let covariance = precision.try_inverse().unwrap_or_else(Matrix4::zeros);
        let at = covariance * along;
        let squares: f64 = readings
            .iter()
            .map(|of| ((self.row(of.time_s).dot(&at) - of.value) / of.std).powi(2))
            .sum();
        let likely = squares + at.component_mul(&at).dot(&prior);
        Explained {
            at,
            covariance,
            ln_evidence: -0.5 * (likely + precision.determinant().ln()),
            squares,
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

    /// A part that hardly shows T learns it from the other.
    #[test]
    fn both_parts_share_a_time_constant() {
        let read_of = |w: f64, std: f64| read(|time_s| w * warmth(time_s, 2.0, &TOUCHES), std);
        let (damping, reactance) = (read_of(0.3, 3e-3), read_of(-2.0, 1e-3));
        let alone = predicted(&[part(&damping), part(&damping)], &TOUCHES, &[2.5]);
        let told = predicted(&[part(&damping), part(&reactance)], &TOUCHES, &[2.5]);
        assert!(told.variance(0) < 0.5 * alone.variance(0));
        let truth = 0.3 * warmth(2.5, 2.0, &TOUCHES);
        let std = told.variance(0).sqrt();
        assert!(
            (told.mean[0] - truth).abs() < 3.0 * std,
            "{} of {truth}",
            told.mean[0]
        );
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
