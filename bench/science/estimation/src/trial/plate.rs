//! Prior of the plate's impedance at the instances, from readings without a finger.
//!
//! `plate_course` predicts the offset Δ = Z_p − Z_p(unloaded interval) at the n instances, 2n numbers with mean m and
//! covariance K = F Fᵀ. The largest five principal components of K are shared parameters of the trial, of unit variance; the
//! remainder is each instance's own. With W = diag(10 for damping, 1 for reactance) and the singular value decomposition
//! W F = U Λ Rᵀ,
//!
//! ```text
//! Δ = m + Σ_(k≤5) s_k W⁻¹ u_k λ_k + own,   s_k ~ N(0, 1)
//! own damping:    variance K_jj − Σ_k (W⁻¹ u_k λ_k)_j² + (q c_j)² + (10⁻⁴ N·s/m)²
//! own reactance:  the scatter of the fitted reactances about the course
//! ```
//!
//! where c_j is the distance of the predicted damping from the straight line between the two readings around instance j, and q
//! the fraction by which such a course may be wrong: 0.03, and more if the fitted reactances scatter more.

use super::layout::COURSES;
use super::prior::TrialPriors;
use contact::plate_course::{self, CourseStds, ImpedancePart, Prediction, Reading};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

/// Plate impedance read without a finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateReference {
    /// Time, s.
    pub time_s: f64,
    /// Z_p, N·s/m.
    pub z_p_n_s_per_m: Complex64,
    /// Standard error of each part, N·s/m.
    pub std_n_s_per_m: f64,
}

/// Readings of the plate during a recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlateReadings {
    /// Readings without a finger, in order of time.
    pub references: Vec<PlateReference>,
    /// Begin and end of each touch, in order, s.
    pub touches_s: Vec<(f64, f64)>,
}

/// Prior standard deviation of the change, N·s/m per second: three hertz per second for a plate of 8 g, and 2.5 % of the
/// published plate's damping per minute.
const REACTANCE_PER_S: f64 = 0.3;
const DAMPING_PER_S: f64 = 0.003;
/// Deviation of a single instance from the course, as a fraction of the course's deviation from the straight line between two
/// references: the diffusion of heat is not of first order.
const COURSE_DEVIATION: f64 = 0.03;
/// Smallest standard deviation of an instance's damping about the common course, N·s/m.
const MIN_DAMPING_STD_N_S_PER_M: f64 = 1e-4;
/// Standard deviation of an instance's reactance about the common course before any is fitted, N·s/m: a tenth of a hertz.
const INITIAL_STD_N_S_PER_M: f64 = 0.01;
/// Smallest standard deviation of the fitted reactances, N·s/m: three hundredths of a hertz.
const MIN_REACTANCE_STD_N_S_PER_M: f64 = 3e-3;
/// Weight of damping errors relative to reactance errors; the reactance is also observed under the finger.
const DAMPING_WEIGHT: f64 = 10.0;

/// Largest deviation of a plate from its course, as a fraction of its change along the course, and the smallest such limit,
/// N·s/m: half a hertz. A larger deviation does not come from the plate: the finger follows another law.
const MAX_DEVIATION: f64 = 0.1;
const MIN_DEVIATION_N_S_PER_M: f64 = 0.05;

/// Deviation of the reactances of a trial from their course, and of the course from 0, RMS over the instances, N·s/m.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlateDeviation {
    pub(super) deviation_n_s_per_m: f64,
    pub(super) course_n_s_per_m: f64,
}

impl PlateDeviation {
    pub(super) fn is_misfit(&self) -> bool {
        self.deviation_n_s_per_m
            > MIN_DEVIATION_N_S_PER_M.max(MAX_DEVIATION * self.course_n_s_per_m)
    }
}

/// Prior of the plate's offset at an instance, from the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OffsetPrior {
    /// Mean of the offset; 0 without readings.
    mean: Complex64,
    /// Change of the offset by each course, N·s/m.
    pub(super) by_course: [Complex64; COURSES],
    /// Standard deviation of the reactance's offset about its course, N·s/m.
    pub(super) reactance_std: f64,
    /// Standard deviation of the damping's offset about its course, N·s/m; `None` without a later reference, because a changed
    /// damping then cannot be distinguished from a constant one.
    pub(super) damping_std: Option<f64>,
}

impl OffsetPrior {
    fn unknown(priors: &TrialPriors) -> Self {
        Self {
            mean: Complex64::ZERO,
            by_course: [Complex64::ZERO; COURSES],
            reactance_std: priors.plate_reactance_std_n_s_per_m,
            damping_std: None,
        }
    }

    /// Returns the offset for the given coefficients of the courses, N·s/m.
    pub(super) fn value(&self, courses: &[f64]) -> Complex64 {
        let deviations = self.by_course.iter().zip(courses);
        self.mean
            + deviations
                .map(|(slope, course)| slope * course)
                .sum::<Complex64>()
    }
}

/// Returns the priors at `times_s`, as offsets from the plate of the unloaded interval. Reactances `estimates` at these times
/// determine the plate's scatter about the course.
pub(super) fn offsets(
    times_s: &[f64],
    readings: &PlateReadings,
    z_p: Complex64,
    priors: &TrialPriors,
    estimates: Option<&[f64]>,
) -> Vec<OffsetPrior> {
    let mut offsets = vec![OffsetPrior::unknown(priors); times_s.len()];
    let lines = times_s.iter().map(|&time_s| readings.line(time_s, z_p));
    let (known_indices, line): (Vec<usize>, Vec<Complex64>) = lines
        .enumerate()
        .filter_map(|(index, line)| Some((index, line?)))
        .unzip();
    if known_indices.is_empty() {
        return offsets;
    }
    let known_times_s: Vec<f64> = known_indices.iter().map(|&index| times_s[index]).collect();
    let course = readings.predict(z_p, priors, &known_times_s);
    let deviations = match estimates {
        None => Deviations::INITIAL,
        Some(estimates) => {
            let reactances = known_indices.iter().map(|&index| estimates[index]);
            Deviations::estimate(&course, &line, &reactances.collect::<Vec<f64>>())
        }
    };
    let by_course = directions(&course);
    for (place, &index) in known_indices.iter().enumerate() {
        offsets[index] = OffsetPrior {
            mean: Complex64::new(course.mean[place], course.mean[line.len() + place]),
            by_course: by_course[place],
            reactance_std: deviations.reactance_std,
            damping_std: Some(deviations.damping_std(
                course.variance(place),
                &by_course[place],
                course.mean[place] - line[place].re,
            )),
        };
    }
    offsets
}

impl PlateReadings {
    /// Returns the offset on the straight line between the readings before and after a time; `None` outside the readings.
    fn line(&self, time_s: f64, z_p: Complex64) -> Option<Complex64> {
        let references = &self.references;
        let next = references.partition_point(|reference| reference.time_s < time_s);
        let (last, next) = (references.get(next.checked_sub(1)?)?, references.get(next)?);
        let share = (time_s - last.time_s) / (next.time_s - last.time_s);
        Some(last.z_p_n_s_per_m - z_p + (next.z_p_n_s_per_m - last.z_p_n_s_per_m) * share)
    }

    /// Predicts the course of the offset, damping before reactance.
    fn predict(&self, z_p: Complex64, priors: &TrialPriors, times_s: &[f64]) -> Prediction {
        let part_readings = |component: fn(Complex64) -> f64| -> Vec<Reading> {
            let references = self.references.iter();
            references
                .map(|reference| Reading {
                    time_s: reference.time_s,
                    value: component(reference.z_p_n_s_per_m - z_p),
                    std: reference.std_n_s_per_m,
                })
                .collect()
        };
        let (dampings, reactances) = (part_readings(|z| z.re), part_readings(|z| z.im));
        let parts = [
            ImpedancePart {
                readings: &dampings,
                stds: CourseStds {
                    size: priors.plate_damping_std_n_s_per_m,
                    per_s: DAMPING_PER_S,
                },
            },
            ImpedancePart {
                readings: &reactances,
                stds: CourseStds {
                    size: priors.plate_reactance_std_n_s_per_m,
                    per_s: REACTANCE_PER_S,
                },
            },
        ];
        plate_course::predict(&parts, &self.touches_s, times_s)
    }
}

/// Deviations of single instances from the predicted course.
struct Deviations {
    /// Standard deviation of the reactance, N·s/m.
    reactance_std: f64,
    /// Fraction q by which the course's distance from the straight line may be wrong.
    fraction: f64,
}

impl Deviations {
    /// Deviations before any reactance is fitted.
    const INITIAL: Self = Self {
        reactance_std: INITIAL_STD_N_S_PER_M,
        fraction: COURSE_DEVIATION,
    };

    /// Estimates the deviations from fitted reactances.
    fn estimate(course: &Prediction, line: &[Complex64], reactances: &[f64]) -> Self {
        let n = line.len();
        let predicted = |place: usize| course.mean[n + place];
        let deviation = DVector::from_fn(n, |place, _| reactances[place] - predicted(place));
        let reactance_std = scatter_about(course, deviation);
        let curvature: f64 = (0..n)
            .map(|place| (predicted(place) - line[place].im).powi(2))
            .sum();
        let curvature = (curvature / n as f64)
            .sqrt()
            .max(MIN_REACTANCE_STD_N_S_PER_M);
        // q = 0.03 + √(std² − min²)/(RMS distance of the predicted reactance from the straight line).
        let excess = (reactance_std * reactance_std - MIN_REACTANCE_STD_N_S_PER_M.powi(2)).sqrt();
        Self {
            reactance_std,
            fraction: COURSE_DEVIATION + excess / curvature,
        }
    }

    /// Returns the standard deviation of an instance's damping about the common courses, given its predicted variance, and its
    /// predicted distance `curvature` from the straight line.
    fn damping_std(&self, variance: f64, by_course: &[Complex64; COURSES], curvature: f64) -> f64 {
        let common_variance: f64 = by_course.iter().map(|slope| slope.re * slope.re).sum();
        let std = (variance - common_variance).max(0.0).sqrt();
        std.hypot(self.fraction * curvature)
            .hypot(MIN_DAMPING_STD_N_S_PER_M)
    }
}

/// Returns the RMS scatter of reactances about the course fitted to them; `deviation` is that from the likely course.
fn scatter_about(course: &Prediction, deviation: DVector<f64>) -> f64 {
    let n = deviation.len();
    let course_factor = course.factor.rows(n, n);
    let variance = MIN_REACTANCE_STD_N_S_PER_M.powi(2);
    // Deviations d = k + e with Cov k = K and Cov e = v: the estimate of k is K (K + v)⁻¹d, its residual v (K + v)⁻¹d.
    let residuals = (course_factor * course_factor.transpose()
        + DMatrix::identity(n, n) * variance)
        .cholesky()
        .map_or_else(
            || deviation.clone(),
            |factor| factor.solve(&deviation) * variance,
        );
    let scatter = (residuals.norm_squared() / n as f64).sqrt();
    scatter.max(MIN_REACTANCE_STD_N_S_PER_M)
}

/// Returns the [`COURSES`] in which the plate is least certain, as their effect on each instance.
fn directions(course: &Prediction) -> Vec<[Complex64; COURSES]> {
    let n = course.mean.len() / 2;
    let weight = |row: usize| if row < n { DAMPING_WEIGHT } else { 1.0 };
    let mut weighted_factor = course.factor.clone();
    for (row, mut values) in weighted_factor.row_iter_mut().enumerate() {
        values *= weight(row);
    }
    // Singular values come in descending order.
    let svd = weighted_factor.svd(true, false);
    let effect = |row: usize, course: usize| {
        let std = svd.singular_values.get(course);
        std.zip(svd.u.as_ref())
            .map_or(0.0, |(std, u)| std * u[(row, course)] / weight(row))
    };
    (0..n)
        .map(|place| {
            std::array::from_fn(|course| {
                Complex64::new(effect(place, course), effect(n + place, course))
            })
        })
        .collect()
}
