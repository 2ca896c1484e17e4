//! Prior of the plate's impedance at the instances, from readings without a finger.

use super::prior::TrialPriors;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use plate_course::{CourseStds, Part, Predicted, Reading};

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

/// Number of joint deviations of all offsets from their likely course.
pub(super) const COURSES: usize = 5;

/// Prior standard deviation of the change per second, N·s/m²: three hertz for a plate of 8 g, and 2.5 % of the published
/// plate's damping per minute.
const REACTANCE_PER_S: f64 = 0.3;
const DAMPING_PER_S: f64 = 0.003;
/// Deviation of a single instance from the course, as a fraction of the course's deviation from the straight line between two
/// references: the diffusion of heat is not of first order.
const ASTRAY: f64 = 0.03;
/// Smallest standard deviation of an instance's damping about the common course, N·s/m.
const LEAST_STD_N_S_PER_M: f64 = 1e-4;
/// Standard deviation of an instance's reactance about the common course before any is fitted, N·s/m: a tenth of a hertz.
const UNSEEN_STD_N_S_PER_M: f64 = 0.01;
/// Smallest standard deviation of the fitted reactances, N·s/m: three hundredths of a hertz.
const FOUND_STD_N_S_PER_M: f64 = 3e-3;
/// Weight of damping errors relative to reactance errors; the reactance is also observed under the finger.
const DAMPING_COUNTS: f64 = 10.0;

/// Largest deviation of a plate from its course, as a fraction of its change along the course, and the smallest such limit,
/// N·s/m: half a hertz. A larger deviation does not come from the plate: the finger follows another law.
const MOST_APART: f64 = 0.1;
const LEAST_APART_N_S_PER_M: f64 = 0.05;

/// Deviation of the reactances of a trial from their course, and of the course from 0, RMS over the instances, N·s/m.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlateApart {
    pub(super) apart_n_s_per_m: f64,
    pub(super) course_n_s_per_m: f64,
}

impl PlateApart {
    pub(super) fn is_misfit(&self) -> bool {
        self.apart_n_s_per_m > LEAST_APART_N_S_PER_M.max(MOST_APART * self.course_n_s_per_m)
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
    pub(super) fn on_course(&self, courses: &[f64]) -> Complex64 {
        let moved = self.by_course.iter().zip(courses);
        self.mean + moved.map(|(by, course)| by * course).sum::<Complex64>()
    }
}

/// Returns the priors at `times_s`, as offsets from the plate of the unloaded interval. Reactances `found` at these times
/// determine the plate's scatter about the course.
pub(super) fn offsets(
    times_s: &[f64],
    readings: &PlateReadings,
    z_p: Complex64,
    priors: &TrialPriors,
    found: Option<&[f64]>,
) -> Vec<OffsetPrior> {
    let mut offsets = vec![OffsetPrior::unknown(priors); times_s.len()];
    let references = &readings.references;
    let beside = |time_s: f64| {
        let after = references.partition_point(|of| of.time_s < time_s);
        Some((
            references.get(after.checked_sub(1)?)?,
            references.get(after)?,
        ))
    };
    let known: Vec<usize> = (0..times_s.len())
        .filter(|&index| beside(times_s[index]).is_some())
        .collect();
    let n = known.len();
    if n == 0 {
        return offsets;
    }
    let at_s: Vec<f64> = known.iter().map(|&index| times_s[index]).collect();
    let read = |part: fn(Complex64) -> f64| -> Vec<Reading> {
        let of = references.iter();
        of.map(|of| Reading {
            time_s: of.time_s,
            value: part(of.z_p_n_s_per_m - z_p),
            std: of.std_n_s_per_m,
        })
        .collect()
    };
    let (dampings, reactances) = (read(|z| z.re), read(|z| z.im));
    let part = |free, size, per_s| Part {
        free,
        stds: CourseStds { size, per_s },
    };
    let straight: Vec<Complex64> = at_s
        .iter()
        .filter_map(|&time_s| {
            let (last, next) = beside(time_s)?;
            let share = (time_s - last.time_s) / (next.time_s - last.time_s);
            Some(last.z_p_n_s_per_m - z_p + (next.z_p_n_s_per_m - last.z_p_n_s_per_m) * share)
        })
        .collect();
    let parts = [
        part(&dampings, priors.plate_damping_std_n_s_per_m, DAMPING_PER_S),
        part(
            &reactances,
            priors.plate_reactance_std_n_s_per_m,
            REACTANCE_PER_S,
        ),
    ];
    let course = plate_course::predicted(&parts, &readings.touches_s, &at_s);
    let (reactance_std, astray) = match found {
        None => (UNSEEN_STD_N_S_PER_M, ASTRAY),
        Some(found) => {
            let apart = DVector::from_fn(n, |at, _| found[known[at]] - course.mean[n + at]);
            let std = scatter_about(&course, apart);
            let bent: f64 = (0..n)
                .map(|at| (course.mean[n + at] - straight[at].im).powi(2))
                .sum();
            let bent = (bent / n as f64).sqrt().max(FOUND_STD_N_S_PER_M);
            let more = (std * std - FOUND_STD_N_S_PER_M.powi(2)).sqrt();
            (std, ASTRAY + more / bent)
        }
    };
    let by_course = directions(&course);
    for (place, &index) in known.iter().enumerate() {
        let variance = course.variance(place);
        let together: f64 = by_course[place].iter().map(|by| by.re * by.re).sum();
        let alone = (variance - together).max(0.0).sqrt();
        let bent = course.mean[place] - straight[place].re;
        offsets[index] = OffsetPrior {
            mean: Complex64::new(course.mean[place], course.mean[n + place]),
            by_course: by_course[place],
            reactance_std,
            damping_std: Some(alone.hypot(astray * bent).hypot(LEAST_STD_N_S_PER_M)),
        };
    }
    offsets
}

/// Returns the RMS scatter of reactances about the course fitted to them; `apart` is their deviation from the likely course.
fn scatter_about(course: &Predicted, apart: DVector<f64>) -> f64 {
    let n = apart.len();
    let of_course = course.factor.rows(n, n);
    let alone = FOUND_STD_N_S_PER_M.powi(2);
    let left = (of_course * of_course.transpose() + DMatrix::identity(n, n) * alone)
        .cholesky()
        .map_or_else(|| apart.clone(), |factor| factor.solve(&apart) * alone);
    let scatter = (left.norm_squared() / n as f64).sqrt();
    scatter.max(FOUND_STD_N_S_PER_M)
}

/// Returns the [`COURSES`] in which the plate is least certain, as their effect on each instance.
fn directions(course: &Predicted) -> Vec<[Complex64; COURSES]> {
    let n = course.mean.len() / 2;
    let counts = |row: usize| if row < n { DAMPING_COUNTS } else { 1.0 };
    let mut counted = course.factor.clone();
    for (row, mut values) in counted.row_iter_mut().enumerate() {
        values *= counts(row);
    }
    // Singular values come in descending order.
    let svd = counted.svd(true, false);
    let by = |row: usize, course: usize| {
        let std = svd.singular_values.get(course);
        std.zip(svd.u.as_ref())
            .map_or(0.0, |(std, u)| std * u[(row, course)] / counts(row))
    };
    (0..n)
        .map(|place| {
            std::array::from_fn(|course| Complex64::new(by(place, course), by(n + place, course)))
        })
        .collect()
}
