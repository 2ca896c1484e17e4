//! Lines of the normal force in bins of a feature of the film.

use num_complex::Complex64;

/// Share of a bin's variance of the normal force that is added to it, so that a constant force has no slope.
const RIDGE: f64 = 1e-3;

/// Observation in a bin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Observation {
    pub(crate) bin: usize,
    pub(crate) value: Complex64,
    pub(crate) normal: f64,
    pub(crate) weight: f64,
}

/// Bins with equal numbers of the values from which they were made.
#[derive(Debug, Clone)]
pub(crate) struct Bins {
    edges: Vec<f64>,
}

impl Bins {
    pub(crate) fn new(mut values: Vec<f64>, count: usize) -> Self {
        values.sort_by(f64::total_cmp);
        let edge = |bin: usize| statistics::quantile(&values, bin as f64 / count as f64);
        Self {
            edges: (1..count).filter_map(edge).collect(),
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.edges.len() + 1
    }

    pub(crate) fn index(&self, value: f64) -> usize {
        self.edges.partition_point(|edge| *edge <= value)
    }
}

/// Weighted sums of a bin.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    w: f64,
    n: f64,
    nn: f64,
    y: Complex64,
    ny: Complex64,
    yy: f64,
}

impl Sums {
    fn take(&mut self, seen: &Observation) {
        let Observation {
            value,
            normal,
            weight,
            ..
        } = *seen;
        self.w += weight;
        self.n += weight * normal;
        self.nn += weight * normal * normal;
        self.y += weight * value;
        self.ny += weight * normal * value;
        self.yy += weight * value.norm_sqr();
    }

    /// Returns mean normal force, mean value, and slope of the line.
    fn line(&self, ridge: f64) -> (f64, Complex64, Complex64) {
        if self.w <= 0.0 {
            return (0.0, Complex64::ZERO, Complex64::ZERO);
        }
        let (mean_n, mean_y) = (self.n / self.w, self.y / self.w);
        let spread = self.nn / self.w - mean_n * mean_n + ridge;
        let shared = self.ny / self.w - mean_n * mean_y;
        let slope = if spread > 0.0 {
            shared / spread
        } else {
            Complex64::ZERO
        };
        (mean_n, mean_y, slope)
    }
}

/// Lines fitted to observations.
pub(crate) struct Lines {
    lines: Vec<(f64, Complex64, Complex64)>,
    /// Sum of squares about each bin's mean: without any force.
    pub(crate) without_force: f64,
}

impl Lines {
    pub(crate) fn fit(observations: &[Observation], bins: usize) -> Self {
        let mut sums = vec![Sums::default(); bins];
        let mut all = Sums::default();
        for seen in observations {
            sums[seen.bin].take(seen);
            all.take(seen);
        }
        let mean = all.n / all.w.max(f64::MIN_POSITIVE);
        let ridge = RIDGE * (all.nn / all.w.max(f64::MIN_POSITIVE) - mean * mean).max(0.0);
        let rest = |bin: &Sums| bin.yy - bin.y.norm_sqr() / bin.w.max(f64::MIN_POSITIVE);
        Self {
            without_force: sums.iter().map(rest).sum(),
            lines: sums.iter().map(|bin| bin.line(ridge)).collect(),
        }
    }

    /// Returns the residual of an observation, weighted to unit variance.
    pub(crate) fn residual(&self, seen: &Observation) -> Complex64 {
        let (mean_n, mean_y, slope) = self.lines[seen.bin];
        seen.weight.sqrt() * (seen.value - mean_y - slope * (seen.normal - mean_n))
    }

    pub(crate) fn squares(&self, observations: &[Observation]) -> f64 {
        observations
            .iter()
            .map(|seen| self.residual(seen).norm_sqr())
            .sum()
    }
}
