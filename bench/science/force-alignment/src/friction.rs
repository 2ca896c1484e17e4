//! Delay and rate of the forces by the friction's dependence on the amplitude.
//!
//! In each slide, with the lateral force L and the normal force F at the stated time t + d + r (t − t_c):
//!
//! ```text
//! L(t) = a_k + b_k F(t) + e,   k the bin of |x̃_p(t)|
//! ```
//!
//! d and r are those of the least sum of e² at which |a_k| falls with k. Friction and impedance both follow the amplitude late, by the lag of the film's gap;
//! the lag with which the impedance follows it is read in the same way, and subtracted. By up to 2 ms more, the skin and a sensor's
//! lateral axis follow the film. A recording cannot distinguish this time from a delay of the clock: its middle is subtracted
//! and its width is in the error.

use impedance::ZmFrame;
use num_complex::Complex64;

use crate::bins::{Bins, Lines, Observation};
use crate::contact::{ContactFit, ContactSearch, Shift};
use crate::film::{CurvePoint, Estimate, Film, Unaligned, centre_and_length, joint_rate};
use crate::grid::ForceGrid;
use crate::least::{least, minima};

/// Bins of the amplitude.
const BINS: usize = 32;
/// Step of the delay, s, and of a first scan.
const STEP_S: f64 = 1e-3;
const SCAN_STEP_S: f64 = 3e-3;
/// Time by which the range of delays is extended in one step, s.
const EXTENSION_S: f64 = 0.02;
/// Shortest slides together, s.
const SHORTEST_S: f64 = 0.5;
/// Share of a slide at each end that is left out, in which the finger starts and stops.
const END_SHARE: f64 = 0.12;
/// Slip at the ends of the slides from one rate to the next, s, and greatest deviation from the rate by contact.
const RATE_STEP_S: f64 = 4e-3;
const RATE_REACH_S: f64 = 0.06;
/// Change of the lags of film, skin and sensor over half the slides, s: they follow the gap, which drifts with the force.
const LAG_DRIFT_S: f64 = 0.05e-3;
/// Shortest time over which scores are summed, s: a whole number of periods, so that those of whole periods cancel alike.
const SCORE_BLOCK_S: f64 = 0.1;
/// Greatest share by which lines follow their observations.
const GREATEST_LEVERAGE: f64 = 0.5;
/// Most steps to the least squares.
const MOST_DESCENTS: usize = 6;
/// Steps of the derivatives, s: of the delay, and of the slip at either end of the slides.
const DERIVATIVE_S: f64 = 0.5e-3;
/// Greatest share of the friction's variance that the amplitude may leave unexplained.
const GREATEST_RESIDUAL: f64 = 0.6;
/// Time over which residuals are alike, s.
const CORRELATED_S: f64 = 0.02;
/// Difference of the contact's χ² beyond which a delay is excluded.
const EXCLUDED: f64 = 25.0;
/// Ratio of residuals of friction that a repetition of the modulation may make.
const ALIKE: f64 = 10.0;
/// Ratio of residuals of friction from which the smaller one is right although the contact prefers the other.
const DECISIVE: f64 = 2.0;
/// Ratio of residuals of the contact from which it decides, whatever friction shows: slides that lie elsewhere on the clock of the
/// forces hide the friction of the right delay.
const CONTRADICTED: f64 = 10.0;
/// Distance between minima that are two, s.
const APART_S: f64 = 0.01;
/// Smallest range of the amplitude of which friction shows a delay, relative: without a modulation, any delay explains its noise.
const LEAST_CHANGE: f64 = 0.3;
/// Greatest deviation of the rate: clocks differ by less, and a few periods of other times are explained by any.
const GREATEST_RATE: f64 = 0.03;
/// Greatest lag of the film that is searched, s.
const GREATEST_LAG_S: f64 = 8e-3;
/// Time by which the impedance follows the gap, s: the finger's impedance is read through the plate's response.
const IMPEDANCE_LAG: Estimate = Estimate {
    value: 0.7e-3,
    std: 0.2e-3,
};
/// Lag of the film before it is read, s: 0.5 to 2 ms.
const FILM_LAG: Estimate = Estimate {
    value: 1.1e-3,
    std: 0.5e-3,
};
/// Time by which friction follows the gap, s: skin and lateral axis, 0 to 2 ms.
const LATERAL_LAG: Estimate = Estimate {
    value: 0.8e-3,
    std: 0.55e-3,
};

/// Frame of a slide.
#[derive(Debug, Clone, Copy)]
struct Seen {
    time_s: f64,
    amplitude_m: f64,
    finger: Complex64,
    weight: f64,
    bin: usize,
}

/// Slides of a recording.
#[derive(Debug)]
pub struct Slides<'a> {
    grid: &'a ForceGrid,
    slides: Vec<Vec<Seen>>,
    centre_s: f64,
    length_s: f64,
    interval_s: f64,
    period_s: f64,
}

/// Delay and rate with their errors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrictionFit {
    pub(crate) shift: Shift,
    pub(crate) delay_s: Estimate,
    pub(crate) random_std_s: f64,
    pub(crate) rate: Estimate,
}

impl<'a> Slides<'a> {
    /// Takes the frames of the slides; `None` if they are too few.
    #[must_use]
    pub fn new(film: &Film<'_>, grid: &'a ForceGrid) -> Option<Self> {
        let (centre_s, length_s) = centre_and_length(film)?;
        let [first, second, ..] = film.frames else {
            return None;
        };
        let interval_s = second.time_s - first.time_s;
        let seen = |frame: &ZmFrame| Seen {
            time_s: frame.time_s,
            amplitude_m: frame.amplitude_m,
            finger: frame.corrected_n_s_per_m - film.z_p_n_s_per_m,
            weight: (frame.corrected_std_n_s_per_m.powi(2) + 0.05f64.powi(2)).recip(),
            bin: 0,
        };
        let slides = film.slides_s.iter().filter_map(|&(start_s, end_s)| {
            let margin_s = END_SHARE * (end_s - start_s);
            let start = film
                .frames
                .partition_point(|frame| frame.time_s < start_s + margin_s);
            let end = film
                .frames
                .partition_point(|frame| frame.time_s < end_s - margin_s);
            let frames = film.frames.get(start..end)?.iter();
            let clear = frames
                .filter(|frame| frame.mask.is_clear() && frame.corrected_n_s_per_m.is_finite());
            let mut slide: Vec<Seen> = clear.map(seen).collect();
            let bins = Bins::new(slide.iter().map(|frame| frame.amplitude_m).collect(), BINS);
            for frame in &mut slide {
                frame.bin = bins.index(frame.amplitude_m);
            }
            (slide.len() >= 8 * BINS).then_some(slide)
        });
        let slides: Vec<Vec<Seen>> = slides.collect();
        let frames: usize = slides.iter().map(Vec::len).sum();
        (frames as f64 * interval_s >= SHORTEST_S).then_some(Self {
            grid,
            slides,
            centre_s,
            length_s,
            interval_s,
            period_s: film.modulation_hz.recip(),
        })
    }

    /// Returns the time at which delays are stated, s.
    #[must_use]
    pub fn centre_s(&self) -> f64 {
        self.centre_s
    }

    /// Returns the time from the first to the last slide, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.length_s
    }

    /// Returns the observations of friction in a slide, each with its time, s.
    fn friction(&self, slide: &[Seen], shift: Shift) -> (Vec<f64>, Vec<Observation>) {
        let seen = slide.iter().filter_map(|frame| {
            let (normal, lateral) = self.grid.at(shift.stated_s(frame.time_s, self.centre_s))?;
            let value = Complex64::new(lateral, 0.0);
            Some((
                frame.time_s,
                Observation {
                    bin: frame.bin,
                    value,
                    normal,
                    weight: 1.0,
                },
            ))
        });
        seen.unzip()
    }

    /// Returns the mean over the slides of the share of the friction's variance that the amplitude leaves unexplained.
    fn residual(&self, shift: Shift) -> f64 {
        let shares = self.slides.iter().filter_map(|slide| {
            let (_, observations) = self.friction(slide, shift);
            (2 * observations.len() > slide.len()).then(|| {
                let n = observations.len() as f64;
                let mean = observations.iter().map(|seen| seen.value.re).sum::<f64>() / n;
                let total: f64 = observations
                    .iter()
                    .map(|seen| (seen.value.re - mean).powi(2))
                    .sum();
                let lines = Lines::fit(&observations, BINS);
                // Half a period away, friction would grow with the amplitude.
                if lines.grows() {
                    return 1.0;
                }
                lines.squares(&observations) / total
            })
        });
        let shares: Vec<f64> = shares.filter(|share| share.is_finite()).collect();
        if 2 * shares.len() <= self.slides.len() {
            return f64::NAN;
        }
        shares.iter().sum::<f64>() / shares.len() as f64
    }

    fn scan(&self, (from_s, to_s): (f64, f64), step_s: f64, rate: f64) -> Vec<CurvePoint> {
        let steps = ((to_s - from_s) / step_s).ceil().max(0.0) as usize;
        let point = |step: usize| {
            let delay_s = from_s + step as f64 * step_s;
            CurvePoint {
                delay_s,
                residual: self.residual(Shift { delay_s, rate }),
            }
        };
        (0..=steps).map(point).collect()
    }

    /// Returns the residual over the range of delays that the contact allows, extended by at most half a period until the least
    /// residual is not at an end: at low modulation frequencies the contact may exclude a delay that friction shows clearly.
    fn around_minimum(&self, range_s: (f64, f64), rate: f64) -> Vec<CurvePoint> {
        let (mut from_s, mut to_s) = range_s;
        let mut curve = self.scan((from_s, to_s), STEP_S, rate);
        let extensions = (0.5 * self.period_s / EXTENSION_S).ceil() as usize;
        for _ in 0..extensions {
            let least = curve
                .iter()
                .map(|point| point.residual)
                .fold(f64::INFINITY, f64::min);
            let is_least = |end: Option<&CurvePoint>| end.is_some_and(|end| end.residual <= least);
            if is_least(curve.first()) {
                from_s -= EXTENSION_S;
            } else if is_least(curve.last()) {
                to_s += EXTENSION_S;
            } else {
                break;
            }
            curve = self.scan((from_s, to_s), STEP_S, rate);
        }
        curve
    }

    /// Returns whether the amplitude changes, so that friction can follow it.
    fn is_modulated(&self) -> bool {
        let frames = self.slides.iter().flatten();
        let mut amplitudes_m: Vec<f64> = frames.map(|frame| frame.amplitude_m).collect();
        amplitudes_m.sort_by(f64::total_cmp);
        let quantile_m = |share| statistics::quantile(&amplitudes_m, share).unwrap_or_default();
        quantile_m(0.9) - quantile_m(0.1) > LEAST_CHANGE * quantile_m(0.9)
    }

    /// Finds delay and rate within the range that the contact allows.
    pub(crate) fn fit(
        &self,
        search: &ContactSearch<'_>,
        contact: &ContactFit,
    ) -> Result<FrictionFit, Unaligned> {
        if !self.is_modulated() {
            return Err(Unaligned::Steady);
        }
        // Over slides far apart a rate is a delay of each: the best of all rates is where the search begins.
        let steps = (RATE_REACH_S / RATE_STEP_S) as i32;
        let rate_step = 2.0 * RATE_STEP_S / self.length_s;
        let rates = (-steps..=steps).map(|step| contact.shift.rate + f64::from(step) * rate_step);
        let scans = rates.chain([0.0]).filter_map(|rate| {
            let curve = self.scan(contact.range_s, SCAN_STEP_S, rate);
            least(&curve).map(|best| (rate, best.residual))
        });
        let rate = scans
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(contact.shift.rate, |scan| scan.0);
        let mut shift = Shift {
            rate,
            ..contact.shift
        };
        let curve = self.around_minimum(contact.range_s, rate);
        let best = least(&curve).ok_or(Unaligned::TooShort)?;
        if best.residual.is_nan() || best.residual > GREATEST_RESIDUAL {
            return Err(Unaligned::NoFriction);
        }
        // Friction repeats with the modulation: of its minima, contact decides.
        let greatest = GREATEST_RESIDUAL.min(ALIKE * best.residual);
        let repeats = |point: &CurvePoint| point.residual <= greatest;
        let alike = minima(&curve).into_iter().filter(repeats);
        let mut candidates: Vec<(f64, CurvePoint)> = alike
            .map(|point| (search.growth(point.delay_s, contact), point))
            .collect();
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (least_growth, best) = candidates.first().copied().unwrap_or((0.0, best));
        let is_apart = |rival: &CurvePoint| (rival.delay_s - best.delay_s).abs() > APART_S;
        let mut rivals = candidates.iter().filter(|(_, rival)| is_apart(rival));
        if let Some((_, rival)) = rivals.find(|(growth, _)| *growth <= least_growth + EXCLUDED) {
            return Err(Unaligned::Ambiguous {
                first_s: best.delay_s,
                second_s: rival.delay_s,
            });
        }
        shift.delay_s = best.delay_s;
        let found = self.refined(shift);
        // The contact may allow no delay near that of clocks that agree, where friction is explained far better.
        let agreeing = self.refined(Shift {
            delay_s: FILM_LAG.value + LATERAL_LAG.value,
            rate: 0.0,
        });
        let is_better = DECISIVE * self.residual(agreeing.0) < self.residual(found.0)
            && search.ratio(agreeing.0.delay_s, contact.shift) < CONTRADICTED;
        let (shift, random, rate_std) = if is_better { agreeing } else { found };
        if shift.rate.abs() > GREATEST_RATE {
            return Err(Unaligned::NoFriction);
        }
        let lag = self.film_lag(shift);
        let total = [random, lag.std, LATERAL_LAG.std]
            .into_iter()
            .fold(0.0, f64::hypot);
        Ok(FrictionFit {
            shift,
            delay_s: Estimate {
                value: shift.delay_s - lag.value - LATERAL_LAG.value,
                std: total,
            },
            random_std_s: random,
            rate: Estimate {
                value: shift.rate,
                std: rate_std,
            },
        })
    }

    /// Returns the least residual near a shift, with the standard errors of its delay and rate.
    fn refined(&self, shift: Shift) -> (Shift, f64, f64) {
        let mut shift = self.refined_rate(shift);
        let near = self.scan(
            (shift.delay_s - 5.0 * STEP_S, shift.delay_s + 5.0 * STEP_S),
            STEP_S,
            shift.rate,
        );
        if let Some(best) = least(&near) {
            shift.delay_s = best.delay_s;
        }
        self.descend(shift)
    }

    /// Number of independent values.
    fn independent(&self) -> f64 {
        let frames: usize = self.slides.iter().map(Vec::len).sum();
        frames as f64 * self.interval_s / CORRELATED_S
    }

    fn refined_rate(&self, shift: Shift) -> Shift {
        let rate_step = RATE_STEP_S / self.length_s;
        let shifts = (-3..=3).map(|step| Shift {
            rate: shift.rate + f64::from(step) * rate_step,
            ..shift
        });
        let rated = shifts
            .map(|shift| (shift, self.residual(shift)))
            .filter(|rated| rated.1.is_finite());
        rated
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(shift, |rated| rated.0)
    }

    /// Returns the residuals of all slides, each with its time, s.
    fn residuals(&self, shift: Shift) -> Vec<(f64, f64)> {
        let mut all = Vec::new();
        for slide in &self.slides {
            let (times_s, observations) = self.friction(slide, shift);
            let lines = Lines::fit(&observations, BINS);
            let residuals = observations.iter().map(|seen| lines.residual(seen).re);
            all.extend(times_s.into_iter().zip(residuals));
        }
        all
    }

    /// Descends to the least squares by Gauss and Newton, and returns the standard errors of delay and rate: those of the scores
    /// summed over whole periods of the modulation, so that errors may be alike within a period, with the factor of Student's t
    /// for few sums, over the share of the errors that residuals show (MacKinnon & White 1985, HC3). The rate's includes the drift of the lags, which a recording cannot distinguish from it.
    fn descend(&self, mut shift: Shift) -> (Shift, f64, f64) {
        let mut errors = (f64::INFINITY, f64::INFINITY);
        let rate_step = 2.0 * DERIVATIVE_S / self.length_s;
        let block_s = self.period_s * (SCORE_BLOCK_S / self.period_s).ceil();
        for _ in 0..MOST_DESCENTS {
            let here = self.residuals(shift);
            let slope = |delay_s: f64, rate: f64| {
                let [later, earlier] = [1.0, -1.0].map(|sign| {
                    self.residuals(Shift {
                        delay_s: shift.delay_s + sign * delay_s,
                        rate: shift.rate + sign * rate,
                    })
                });
                let is_alike = later.len() == here.len() && earlier.len() == here.len();
                let pairs = later.iter().zip(&earlier);
                let slopes = pairs.map(|(later, earlier)| 0.5 * (later.1 - earlier.1));
                (is_alike && !here.is_empty()).then(|| slopes.collect::<Vec<f64>>())
            };
            let slopes = slope(DERIVATIVE_S, 0.0).zip(slope(0.0, rate_step));
            let Some((by_delay, by_rate)) = slopes else {
                break;
            };
            let mut information = [0.0; 3];
            let mut gradient = [0.0; 2];
            let mut scores: Vec<(usize, [f64; 2])> = Vec::new();
            for (index, &(time_s, residual)) in here.iter().enumerate() {
                // In steps of the derivatives.
                let j = [by_delay[index], by_rate[index]];
                information[0] += j[0] * j[0];
                information[1] += j[0] * j[1];
                information[2] += j[1] * j[1];
                let score = [j[0] * residual, j[1] * residual];
                gradient[0] += score[0];
                gradient[1] += score[1];
                let key = self.block(time_s, block_s);
                match scores.last_mut() {
                    Some((last, sums)) if *last == key => {
                        sums[0] += score[0];
                        sums[1] += score[1];
                    }
                    _ => scores.push((key, score)),
                }
            }
            let determinant = information[0] * information[2] - information[1].powi(2);
            if determinant.is_nan() || determinant <= 0.0 {
                break;
            }
            let solve = |vector: [f64; 2]| {
                [
                    DERIVATIVE_S * (information[2] * vector[0] - information[1] * vector[1])
                        / determinant,
                    rate_step * (information[0] * vector[1] - information[1] * vector[0])
                        / determinant,
                ]
            };
            let n = scores.len() as f64;
            let mean = [gradient[0] / n, gradient[1] / n];
            let spread = scores.iter().fold([0.0; 2], |sum, (_, score)| {
                let influence = solve([score[0] - mean[0], score[1] - mean[1]]);
                [sum[0] + influence[0].powi(2), sum[1] + influence[1].powi(2)]
            });
            let freedom = (n - 2.0).max(1.0);
            let widening = student_widening(freedom) / (1.0 - self.leverage());
            let std = |spread: f64| widening * (n / freedom * spread).sqrt();
            let drift = 2.0 * LAG_DRIFT_S / self.length_s;
            errors = (std(spread[0]), std(spread[1]).hypot(drift));
            let step = solve(gradient);
            let most_rate = 2.0 * STEP_S / self.length_s;
            let next = Shift {
                delay_s: shift.delay_s - step[0].clamp(-STEP_S, STEP_S),
                rate: shift.rate - step[1].clamp(-most_rate, most_rate),
            };
            if squares(&self.residuals(next)) >= squares(&here) {
                break;
            }
            shift = next;
        }
        (shift, errors.0, errors.1)
    }

    /// Returns the share by which the lines of the bins follow their own observations, which makes residuals smaller than errors: each
    /// has two parameters, and the amplitude crosses a bin twice a period.
    fn leverage(&self) -> f64 {
        let frames: usize = self.slides.iter().map(Vec::len).sum();
        let slide_s = frames as f64 * self.interval_s / self.slides.len() as f64;
        (self.period_s / slide_s).min(GREATEST_LEVERAGE)
    }

    /// Returns the number of the block of `block_s` to which a time belongs: blocks begin with each slide, and what remains at its
    /// end belongs to the last whole one.
    fn block(&self, time_s: f64, block_s: f64) -> usize {
        let mut first = 0;
        for slide in &self.slides {
            let (Some(start), Some(end)) = (slide.first(), slide.last()) else {
                continue;
            };
            let blocks = (((end.time_s - start.time_s) / block_s) as usize).max(1);
            if time_s <= end.time_s {
                let passed = (time_s - start.time_s).max(0.0) / block_s;
                return first + (passed as usize).min(blocks - 1);
            }
            first += blocks;
        }
        first
    }

    /// Returns the time by which the film follows the amplitude, s, from that of the impedance.
    fn film_lag(&self, shift: Shift) -> Estimate {
        let steps = (GREATEST_LAG_S / STEP_S) as i32;
        let curve = (-4..=2 * steps).map(|half_step| {
            let delay_s = 0.5 * STEP_S * f64::from(half_step);
            CurvePoint {
                delay_s,
                residual: self.impedance_residual(shift, delay_s),
            }
        });
        let curve: Vec<CurvePoint> = curve.collect();
        let Some(best) = least(&curve) else {
            return FILM_LAG;
        };
        // By the curvature of χ².
        let worse = curve
            .iter()
            .filter(|point| point.residual > best.residual * (1.0 + 4.0 / self.independent()));
        let nearest = worse
            .map(|point| (point.delay_s - best.delay_s).abs())
            .fold(f64::INFINITY, f64::min);
        let read = Estimate {
            value: best.delay_s - IMPEDANCE_LAG.value,
            std: (0.5 * nearest).hypot(IMPEDANCE_LAG.std),
        };
        joint_rate(&[read, FILM_LAG]).unwrap_or(FILM_LAG)
    }

    /// Returns the share of the impedance's variance that amplitude `lag_s` earlier and normal force leave unexplained.
    fn impedance_residual(&self, shift: Shift, lag_s: f64) -> f64 {
        let shares = self.slides.iter().map(|slide| {
            let places = lag_s / self.interval_s;
            let observations: Vec<Observation> = (0..slide.len())
                .filter_map(|index| {
                    let late = interpolated(slide, index, places)?;
                    let (normal, _) = self.grid.at(shift.stated_s(late.time_s, self.centre_s))?;
                    Some(Observation {
                        bin: slide[index].bin,
                        value: late.finger,
                        normal,
                        weight: late.weight,
                    })
                })
                .collect();
            let lines = Lines::fit(&observations, BINS);
            let total = observations
                .iter()
                .fold((0.0, Complex64::ZERO, 0.0), |sum, seen| {
                    let w = seen.weight;
                    (
                        sum.0 + w,
                        sum.1 + w * seen.value,
                        sum.2 + w * seen.value.norm_sqr(),
                    )
                });
            lines.squares(&observations) / (total.2 - total.1.norm_sqr() / total.0)
        });
        shares.sum::<f64>() / self.slides.len() as f64
    }

    /// Returns the residual over delays of three modulation periods, and its minima but the least.
    pub(crate) fn curve(&self, shift: Shift) -> (Vec<CurvePoint>, Vec<CurvePoint>) {
        let reach_s = (1.5 * self.period_s).min(0.6);
        let curve = self.scan(
            (shift.delay_s - reach_s, shift.delay_s + reach_s),
            2.0 * STEP_S,
            shift.rate,
        );
        let others = minima(&curve).into_iter();
        let others =
            others.filter(|rival| (rival.delay_s - shift.delay_s).abs() > 0.5 * self.period_s);
        (curve, others.collect())
    }
}

/// Returns the sum of the squared residuals.
fn squares(residuals: &[(f64, f64)]) -> f64 {
    residuals
        .iter()
        .map(|(_, residual)| residual * residual)
        .sum()
}

/// Returns the ratio of the quantiles at 97.5 % of Student's t and of the normal distribution, to second order in the inverse
/// of the degrees of freedom (Abramowitz and Stegun, 26.7.5).
fn student_widening(freedom: f64) -> f64 {
    let z2 = statistics::NORMAL_95.powi(2);
    let second = (5.0 * z2 * z2 + 16.0 * z2 + 3.0) / 96.0;
    1.0 + (0.25 * (z2 + 1.0) + second / freedom) / freedom
}

/// Returns the finger's impedance `places` frames after the one at `index`, between the frames about it.
fn interpolated(slide: &[Seen], index: usize, places: f64) -> Option<Seen> {
    let place = index as f64 + places;
    let low = place.floor();
    if low < 0.0 {
        return None;
    }
    let (first, second) = (slide.get(low as usize)?, slide.get(low as usize + 1)?);
    let share = place - low;
    Some(Seen {
        time_s: first.time_s + share * (second.time_s - first.time_s),
        finger: first.finger + share * (second.finger - first.finger),
        weight: first.weight.min(second.weight),
        ..*first
    })
}
