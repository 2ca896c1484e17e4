//! Delay of the forces by contact and self-sensed normal force.
//!
//! With the finger's impedance ΔZ = Z_m − Z_p, the film's state by the amplitude |x̃_p|, and the normal force F at the delay d:
//!
//! ```text
//! ΔZ(t) = a_k + b_k F(t + d + r (t − t_c)) + e,   k the bin of |x̃_p(t − τ)|
//! ```
//!
//! Without contact ΔZ is 0, and under contact it grows with F in each bin. The least weighted sum of e² over d and r places the
//! forces: at landing, at lift-off, and at each minimum of the amplitude.

use impedance::ZmFrame;
use num_complex::Complex64;

use crate::bins::{Bins, Lines, Observation};
use crate::film::{CurvePoint, Film};
use crate::grid::ForceGrid;

/// Greatest delay that is searched, s.
const GREATEST_DELAY_S: f64 = 1.5;
/// Step of the delay, s.
const STEP_S: f64 = 0.01;
/// Greatest deviation of the rate that is searched.
const GREATEST_RATE: f64 = 0.02;
/// Slip over the recording from one rate to the next, s.
const RATE_STEP_S: f64 = 0.04;
/// Most steps from a rate to a better one.
const MOST_STEPS: usize = 200;
/// Rate of the frames that are used, Hz.
const FRAME_RATE_HZ: f64 = 200.0;
/// Bins of the amplitude.
const BINS: usize = 24;
/// Time by which the impedance follows the amplitude, s: by the lag of the film's gap and of the plate's answer.
const FILM_LAG_S: f64 = 1.8e-3;
/// Scatter of the impedance that no noise explains, N·s/m.
const MODEL_N_S_PER_M: f64 = 0.03;
/// Time over which residuals are alike, s.
const CORRELATED_S: f64 = 0.02;
/// Difference of χ² beyond which a delay is excluded.
const EXCLUDED: f64 = 16.0;
/// Smallest share of the frames that must have forces.
const COVERED: f64 = 0.6;
/// Smallest variance that the forces explain at a delay, as a share of the most that they explain at any. Without it, a delay that
/// takes landing and lift-off out of the forces' reach has a small residual: the drift of the plate, which any step of the force
/// explains.
const LEAST_EXPLAINED: f64 = 0.5;
/// Largest share of the variance that the forces may leave unexplained if there is a contact.
const GREATEST_RESIDUAL: f64 = 0.9;

/// Delay at the centre of a recording, and rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shift {
    /// Delay of the forces at the centre, s.
    pub delay_s: f64,
    /// Growth of the delay with time.
    pub rate: f64,
}

impl Shift {
    /// Returns the stated time of the force at the time `time_s` of the drive's clock.
    pub(crate) fn stated_s(self, time_s: f64, centre_s: f64) -> f64 {
        time_s + self.delay_s + self.rate * (time_s - centre_s)
    }
}

/// Result of the search.
#[derive(Debug, Clone, Copy)]
pub struct ContactFit {
    /// Best delay and rate.
    pub shift: Shift,
    /// Least and greatest delay that are not excluded, s.
    pub range_s: (f64, f64),
    /// Residual there.
    pub residual: f64,
}

/// How well the forces explain the impedance at a delay and rate.
#[derive(Debug, Clone, Copy)]
struct Explanation {
    /// Share of the variance that they leave unexplained.
    residual: f64,
    /// Variance that they explain, summed over the frames.
    explained: f64,
}

/// Frame of the film.
#[derive(Debug, Clone, Copy)]
struct Seen {
    time_s: f64,
    bin: usize,
    finger: Complex64,
    weight: f64,
}

/// Search of the delay by contact.
#[derive(Debug)]
pub struct ContactSearch<'a> {
    grid: &'a ForceGrid,
    frames: Vec<Seen>,
    bins: usize,
    centre_s: f64,
    length_s: f64,
    /// Independent values among the frames.
    independent: f64,
}

impl<'a> ContactSearch<'a> {
    /// Prepares the search; `None` with too few frames.
    #[must_use]
    pub fn new(film: &Film<'_>, grid: &'a ForceGrid) -> Option<Self> {
        let (centre_s, length_s) = crate::film::centre_and_length(film)?;
        let [first, second, ..] = film.frames else {
            return None;
        };
        let interval_s = second.time_s - first.time_s;
        let stride = (1.0 / (FRAME_RATE_HZ * interval_s)).round().max(1.0) as usize;
        let lag = (FILM_LAG_S / interval_s).round() as usize;
        let is_clear =
            |frame: &ZmFrame| frame.mask.is_clear() && frame.corrected_n_s_per_m.is_finite();
        // Each frame with the amplitude by which the film was driven.
        let driven = film.frames.iter().zip(film.frames.iter().skip(lag));
        let clear = driven.filter(|(earlier, frame)| earlier.mask.is_clear() && is_clear(frame));
        let clear: Vec<(f64, &ZmFrame)> = clear
            .step_by(stride)
            .map(|(earlier, frame)| (earlier.amplitude_m, frame))
            .collect();
        if clear.len() < 4 * BINS {
            return None;
        }
        let bins = Bins::new(
            clear.iter().map(|(amplitude_m, _)| *amplitude_m).collect(),
            BINS,
        );
        let frames = clear.iter().map(|(amplitude_m, frame)| Seen {
            time_s: frame.time_s,
            bin: bins.index(*amplitude_m),
            finger: frame.corrected_n_s_per_m - film.z_p_n_s_per_m,
            weight: (frame.corrected_std_n_s_per_m.powi(2) + MODEL_N_S_PER_M.powi(2)).recip(),
        });
        let frames: Vec<Seen> = frames.filter(|frame| frame.weight.is_finite()).collect();
        let covered_s = frames.len() as f64 * stride as f64 * interval_s;
        Some(Self {
            grid,
            bins: bins.count(),
            frames,
            centre_s,
            length_s,
            independent: covered_s / CORRELATED_S,
        })
    }

    /// Returns how well the forces explain the impedance; `None` without forces.
    fn explanation(&self, shift: Shift) -> Option<Explanation> {
        let observations: Vec<Observation> = self
            .frames
            .iter()
            .filter_map(|frame| {
                let (normal, _) = self.grid.at(shift.stated_s(frame.time_s, self.centre_s))?;
                Some(Observation {
                    bin: frame.bin,
                    value: frame.finger,
                    normal,
                    weight: frame.weight,
                })
            })
            .collect();
        if (observations.len() as f64) < COVERED * self.frames.len() as f64 {
            return None;
        }
        let lines = Lines::fit(&observations, self.bins);
        let squares = lines.squares(&observations);
        Some(Explanation {
            residual: squares / lines.without_force,
            explained: lines.without_force - squares,
        })
    }

    /// Returns the share of the variance that the forces leave unexplained; NaN without forces.
    fn residual(&self, shift: Shift) -> f64 {
        let explanation = self.explanation(shift);
        explanation.map_or(f64::NAN, |explanation| explanation.residual)
    }

    /// Returns the residual over all delays at a rate; NaN where the forces cover too little of the recording to tell.
    #[must_use]
    pub fn curve(&self, rate: f64) -> Vec<CurvePoint> {
        let steps = (GREATEST_DELAY_S / STEP_S) as i32;
        let delays_s = (-steps..=steps).map(|step| f64::from(step) * STEP_S);
        let rated: Vec<(f64, Option<Explanation>)> = delays_s
            .map(|delay_s| (delay_s, self.explanation(Shift { delay_s, rate })))
            .collect();
        let explanations = rated.iter().filter_map(|(_, explanation)| *explanation);
        let most = explanations
            .map(|explanation| explanation.explained)
            .fold(0.0, f64::max);
        let point = |(delay_s, explanation): (f64, Option<Explanation>)| CurvePoint {
            delay_s,
            residual: explanation
                .filter(|explanation| explanation.explained >= LEAST_EXPLAINED * most)
                .map_or(f64::NAN, |explanation| explanation.residual),
        };
        rated.into_iter().map(point).collect()
    }

    /// Returns the best delay and rate; `None` if the impedance follows the normal force at none.
    #[must_use]
    pub fn best(&self) -> Option<ContactFit> {
        let start = crate::least::least(&self.curve(0.0))?;
        let start = Shift {
            delay_s: start.delay_s,
            rate: 0.0,
        };
        let shift = self.climb(start);
        let curve = self.curve(shift.rate);
        let best = crate::least::least(&curve)?;
        if best.residual.is_nan() || best.residual > GREATEST_RESIDUAL {
            return None;
        }
        let excluded = best.residual * (1.0 + EXCLUDED / self.independent);
        let allowed = curve.iter().filter(|point| point.residual <= excluded);
        let range_s = allowed.fold((best.delay_s, best.delay_s), |(low, high), point| {
            (low.min(point.delay_s), high.max(point.delay_s))
        });
        Some(ContactFit {
            shift: Shift {
                delay_s: best.delay_s,
                rate: shift.rate,
            },
            range_s: (range_s.0 - STEP_S, range_s.1 + STEP_S),
            residual: best.residual,
        })
    }

    /// Steps from one rate and delay to the best neighbouring one, while there is a better one.
    fn climb(&self, mut here: Shift) -> Shift {
        let rate_step = RATE_STEP_S / self.length_s;
        let Some(start) = self.explanation(here) else {
            return here;
        };
        let mut residual = start.residual;
        for _ in 0..MOST_STEPS {
            let neighbours = [-1.0, 1.0].into_iter().flat_map(|rate_steps| {
                [-1.0, 0.0, 1.0].map(|steps| Shift {
                    delay_s: here.delay_s + steps * STEP_S,
                    rate: here.rate + rate_steps * rate_step,
                })
            });
            let allowed = neighbours.filter(|shift| shift.rate.abs() <= GREATEST_RATE + rate_step);
            let rated = allowed.filter_map(|shift| Some((shift, self.explanation(shift)?)));
            let better = rated
                .filter(|(_, other)| other.explained >= LEAST_EXPLAINED * start.explained)
                .map(|(shift, other)| (shift, other.residual))
                .filter(|rated| rated.1 < residual);
            let Some(best) = better.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            (here, residual) = best;
        }
        here
    }

    /// Returns by how much χ² grows from the best delay to another one.
    pub(crate) fn growth(&self, delay_s: f64, best: &ContactFit) -> f64 {
        self.independent * (self.ratio(delay_s, best.shift) - 1.0)
    }

    /// Returns the residual at another delay, as a multiple of that at the best one.
    #[must_use]
    pub fn ratio(&self, delay_s: f64, best: Shift) -> f64 {
        let other = Shift { delay_s, ..best };
        self.residual(other) / self.residual(best)
    }
}
