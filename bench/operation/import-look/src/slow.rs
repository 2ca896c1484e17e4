//! Signals without a carrier: forces with their steps at contact, positions, counts, levels.

use crate::excerpt::Excerpt;
use crate::periodicity::{Periodicity, periodicity};

/// A signal that leaves its level of rest and returns to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    /// Level of rest.
    pub rest: f64,
    /// Whether the level of rest is certain: the only one, or the one at the ends of the course or near zero and no other at the ends.
    pub is_rest_certain: bool,
    /// Largest excursion above rest.
    pub up: f64,
    /// Largest excursion below rest.
    pub down: f64,
    /// Number of departures from rest.
    pub count: usize,
    /// Balance of the excursions: 1 all up, −1 all down, 0 both ways alike.
    pub balance: f64,
    /// Oscillation away from rest, as of friction under a modulated film.
    pub modulation: Option<Periodicity>,
}

impl Steps {
    /// Returns whether the excursions have one sign, as those of a force that only presses.
    pub fn is_one_way(&self) -> bool {
        self.balance.abs() > 0.8
    }
}

/// A signal that moves smoothly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Travel {
    /// Distance from its least to its greatest value.
    pub range: f64,
    /// Number of strokes, each of more than half the range.
    pub strokes: usize,
}

/// Whole numbers that an encoder counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Counts {
    /// Movement of the unwrapped counts.
    pub travel: Travel,
    /// Number of bits after which the counts begin again.
    pub wrap_bits: Option<u32>,
}

/// Kinds of slow signals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Slow {
    /// Few different values.
    Levels(Vec<f64>),
    Counts(Counts),
    Travel(Travel),
    Steps(Steps),
    /// A sinusoid of an envelope's frequency.
    Oscillation(Periodicity),
    /// No other kind.
    Noise,
}

/// Most different values of a trigger.
const MOST_LEVELS: usize = 4;
/// Largest change within 50 ms of a moving finger, relative to the range of its movement.
const FASTEST_TRAVEL: f64 = 0.15;
/// Interval of that change, s, and as a part of the stretch where the rate is unknown.
const CHANGE_S: f64 = 0.05;
const CHANGE_PART: f64 = 0.005;
/// Excursion relative to the noise from which on it is a step.
const LEAST_STEP: f64 = 6.0;
/// Most levels that may be rest: a force that presses, or friction in either direction.
const MOST_REST_LEVELS: usize = 3;
/// Least distance of two levels, as a share of the range; most width of a less still one, as a multiple of the stillest one's or as a
/// share of the range.
const LEAST_APART: f64 = 0.3;
const MOST_UNSTILL: f64 = 10.0;
const STILL_SHARE: f64 = 0.05;
/// Greatest distance of a course's end from the level of rest, as a share of the range.
const END_SHARE: f64 = 0.2;
/// Share of the farthest level below which a level is clearly zero.
const CLEAR_ZERO: f64 = 0.2;
/// Highest frequency of a finger that goes to and fro, Hz, and most periods in a stretch where the rate is unknown.
const LOWEST_MODULATION_HZ: f64 = 2.0;
const MOST_STROKES: f64 = 15.0;
/// Range of a period in which a modulated signal rests, relative to its whole range, and least share of such periods.
const QUIET: f64 = 0.15;
const LEAST_REST: f64 = 0.08;
/// Number of blocks of a stretch.
const BLOCKS: usize = 8_192;
/// Spans by which a counter of so many bits begins again.
const WRAPS: [u32; 4] = [16, 24, 31, 32];

/// Returns the kind of a signal without a carrier.
pub(crate) fn slow(excerpt: &Excerpt, rate_hz: Option<f64>) -> Slow {
    if let Some(levels) = levels(excerpt) {
        return Slow::Levels(levels);
    }
    if let Some(counts) = counts(excerpt, rate_hz) {
        return Slow::Counts(counts);
    }
    let stretch = excerpt.longest();
    let blocks = Blocks::new(stretch);
    let interval_s = rate_hz.map(|rate| blocks.length as f64 / rate);
    if let Some(found) = periodicity(&blocks.means, interval_s.unwrap_or(blocks.length as f64)) {
        let lowest = match rate_hz {
            Some(_) => LOWEST_MODULATION_HZ,
            None => MOST_STROKES / stretch.len() as f64,
        };
        if found.frequency_hz > lowest {
            let period = 1.0 / (found.frequency_hz * interval_s.unwrap_or(blocks.length as f64));
            return match blocks.modulated_steps(period) {
                Some(steps) => Slow::Steps(Steps {
                    modulation: Some(found),
                    ..steps
                }),
                None => Slow::Oscillation(found),
            };
        }
    }
    let course: Vec<f64> = excerpt
        .course()
        .into_iter()
        .filter(|value| value.is_finite())
        .collect();
    let Some(travel) = travel(&blocks.means) else {
        return Slow::Noise;
    };
    if blocks.swiftness(interval_s) < FASTEST_TRAVEL {
        return Slow::Travel(travel);
    }
    match steps(&course, blocks.noise) {
        Some(steps) => Slow::Steps(steps),
        None => Slow::Noise,
    }
}

/// Means of equal blocks of a stretch.
struct Blocks {
    means: Vec<f64>,
    /// Values in each block.
    length: usize,
    /// Standard deviation of a mean by its neighbours.
    noise: f64,
}

impl Blocks {
    fn new(values: &[f64]) -> Self {
        let length = values.len().div_ceil(BLOCKS).max(1);
        let mut last = values
            .iter()
            .copied()
            .find(|value| value.is_finite())
            .unwrap_or_default();
        let mean = |block: &[f64]| {
            let finite = block.iter().filter(|value| value.is_finite());
            let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
            if count > 0.0 {
                last = sum / count;
            }
            last
        };
        let means: Vec<f64> = values.chunks(length).map(mean).collect();
        // Differences of the second order do not see a steady movement; their standard deviation is √6 that of a mean, and
        // their median magnitude 0.6745 of it.
        let curvatures = means.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
        let noise = statistics::median(curvatures).unwrap_or_default() / 0.6745 / 6.0_f64.sqrt();
        Self {
            means,
            length,
            noise,
        }
    }

    /// Returns the steps of a signal that oscillates in a part of the time and rests in another.
    fn modulated_steps(&self, period: f64) -> Option<Steps> {
        let whole = range(&self.means);
        let periods: Vec<&[f64]> = self
            .means
            .chunks((period.round() as usize).max(1))
            .collect();
        let quiet = periods
            .iter()
            .filter(|period| range(period) < QUIET * whole)
            .count();
        let rests = quiet as f64 / periods.len() as f64;
        let is_mixed = rests > LEAST_REST && rests < 1.0 - LEAST_REST;
        let means: Vec<f64> = periods
            .iter()
            .map(|period| period.iter().sum::<f64>() / period.len() as f64)
            .collect();
        let steps = is_mixed.then(|| steps(&means, self.noise))??;
        let excursion = |extreme: f64| (extreme - steps.rest).abs();
        let greatest = self.means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = self.means.iter().copied().fold(f64::INFINITY, f64::min);
        Some(Steps {
            up: excursion(greatest),
            down: excursion(least),
            ..steps
        })
    }

    /// Returns the largest change within 50 ms relative to the range.
    fn swiftness(&self, interval_s: Option<f64>) -> f64 {
        let blocks = match interval_s {
            Some(interval_s) => CHANGE_S / interval_s,
            None => CHANGE_PART * self.means.len() as f64,
        };
        let blocks = (blocks.round() as usize).clamp(1, self.means.len().saturating_sub(1).max(1));
        let changes = self
            .means
            .windows(blocks + 1)
            .map(|w| (w[blocks] - w[0]).abs());
        changes.fold(0.0, f64::max) / range(&self.means).max(f64::MIN_POSITIVE)
    }
}

fn range(values: &[f64]) -> f64 {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    greatest - least
}

fn levels(excerpt: &Excerpt) -> Option<Vec<f64>> {
    let mut levels: Vec<f64> = Vec::new();
    for value in excerpt.values().filter(|value| value.is_finite()) {
        if !levels.contains(&value) {
            levels.push(value);
        }
        if levels.len() > MOST_LEVELS {
            return None;
        }
    }
    levels.sort_by(f64::total_cmp);
    (excerpt.count() > 4 * MOST_LEVELS as u64).then_some(levels)
}

/// Returns the movement of an encoder's counts: whole numbers that change by little, but where they begin again.
fn counts(excerpt: &Excerpt, rate_hz: Option<f64>) -> Option<Counts> {
    let stretch = excerpt.longest();
    if stretch.iter().any(|value| value.fract() != 0.0) {
        return None;
    }
    let mut wrap_bits = None;
    let mut unwrapped = Vec::with_capacity(stretch.len());
    let mut offset = 0.0;
    for (i, value) in stretch.iter().enumerate() {
        if i > 0 {
            let change: f64 = value - stretch[i - 1];
            let is_wrap = |bits: &&u32| {
                (change.abs() - 2_f64.powi(**bits as i32)).abs() < 0.1 * 2_f64.powi(**bits as i32)
            };
            if let Some(bits) = WRAPS.iter().find(is_wrap) {
                wrap_bits = Some(*bits);
                offset -= change.signum() * 2_f64.powi(*bits as i32);
            }
        }
        unwrapped.push(value + offset);
    }
    let blocks = Blocks::new(&unwrapped);
    let largest = unwrapped
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .fold(0.0, f64::max);
    let travel = travel(&blocks.means)?;
    let is_smooth =
        blocks.swiftness(rate_hz.map(|rate| blocks.length as f64 / rate)) < FASTEST_TRAVEL;
    (is_smooth && travel.range > 50.0 && largest < 0.05 * travel.range)
        .then_some(Counts { travel, wrap_bits })
}

fn travel(means: &[f64]) -> Option<Travel> {
    let range = range(means);
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    // A stroke goes from a turning point to the next, where the way back is half the range.
    let (mut low, mut high, mut strokes, mut direction) = (means[0], means[0], 0, 0_i8);
    for &value in means {
        (low, high) = (low.min(value), high.max(value));
        if direction <= 0 && value - low > 0.5 * range {
            (direction, strokes, high) = (1, strokes + 1, value);
        } else if direction >= 0 && high - value > 0.5 * range {
            (direction, strokes, low) = (-1, strokes + 1, value);
        }
    }
    Some(Travel { range, strokes })
}

/// Returns the departures of a course from its level of rest; `None` where they do not stand out of the noise.
fn steps(course: &[f64], noise: f64) -> Option<Steps> {
    let mut sorted = course.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (rest, is_rest_certain) = rest(course, &sorted)?;
    let (up, down) = (sorted[sorted.len() - 1] - rest, rest - sorted[0]);
    let largest = up.max(down);
    if largest < LEAST_STEP * noise {
        return None;
    }
    let sum = |sign: f64| {
        course
            .iter()
            .map(|x| (sign * (x - rest) - 0.1 * largest).max(0.0))
            .sum::<f64>()
    };
    let (above, below) = (sum(1.0), sum(-1.0));
    let mut count = 0;
    let mut is_away = false;
    for x in course {
        let excursion = (x - rest).abs();
        if !is_away && excursion > 0.3 * largest {
            (is_away, count) = (true, count + 1);
        } else if is_away && excursion < 0.15 * largest {
            is_away = false;
        }
    }
    let balance = (above - below) / (above + below).max(f64::MIN_POSITIVE);
    Some(Steps {
        rest,
        is_rest_certain,
        up: up.max(0.0),
        down: down.max(0.0),
        count,
        balance,
        modulation: None,
    })
}

/// Returns the level of rest, and whether it is certain. A steady finger may be as still as a sensor at rest, and press for most of a
/// recording: of several levels, rest is the one at both ends of the course, or else the one near zero.
fn rest(course: &[f64], sorted: &[f64]) -> Option<(f64, bool)> {
    let tenth = (sorted.len() / 10).max(1);
    let starts = 0..sorted.len().checked_sub(tenth)?;
    let width = |start: usize| sorted[start + tenth] - sorted[start];
    let middle = |start: usize| 0.5 * (sorted[start] + sorted[start + tenth]);
    let stillest = |starts: &mut dyn Iterator<Item = usize>| {
        starts.min_by(|a, b| width(*a).total_cmp(&width(*b)))
    };
    let range = sorted[sorted.len() - 1] - sorted[0];
    let first = stillest(&mut starts.clone())?;
    let widest = (MOST_UNSTILL * width(first)).max(STILL_SHARE * range);
    let mut levels = vec![middle(first)];
    while levels.len() < MOST_REST_LEVELS {
        let is_apart = |start: &usize| {
            let is_far = |level: &f64| (middle(*start) - level).abs() > LEAST_APART * range;
            width(*start) <= widest && levels.iter().all(is_far)
        };
        let Some(next) = stillest(&mut starts.clone().filter(is_apart)) else {
            break;
        };
        levels.push(middle(next));
    }
    let nearest =
        |levels: &mut dyn Iterator<Item = f64>| levels.min_by(|a, b| a.abs().total_cmp(&b.abs()));
    if levels.len() == 1 {
        // Within one level the part nearest to zero, among those that are about as still.
        let still = starts.filter(|start| width(*start) <= 2.0 * width(first));
        return nearest(&mut still.map(middle)).map(|level| (level, true));
    }
    let is_at_both_ends = |level: &f64| {
        let mut ends = [course.first(), course.last()].into_iter().flatten();
        ends.all(|end| (end - level).abs() < END_SHARE * range)
    };
    let by_ends = levels.iter().copied().find(is_at_both_ends);
    let near = nearest(&mut levels.iter().copied())?;
    let farthest = levels
        .iter()
        .fold(0.0_f64, |most, level| most.max(level.abs()));
    let is_zero_clear = near.abs() < CLEAR_ZERO * farthest;
    Some(match by_ends {
        Some(level) => (level, level == near || !is_zero_clear),
        None => (near, is_zero_clear),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excerpt::Piece;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn kind(value: impl Fn(f64) -> f64) -> Slow {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let values: Vec<f64> = (0..100_000)
            .map(|n| value(f64::from(n) * 1e-4) + 1e-3 * random.random_range(-0.5..0.5))
            .collect();
        of_values(values)
    }

    fn of_values(values: Vec<f64>) -> Slow {
        let excerpt = Excerpt {
            length: values.len() as u64,
            pieces: vec![Piece { start: 0, values }],
        };
        slow(&excerpt, Some(10e3))
    }

    fn stroke(t: f64) -> f64 {
        let phase = (t - 2.0).rem_euclid(4.0);
        if (2.0..10.0).contains(&t) {
            if phase < 2.0 {
                0.03 * phase
            } else {
                0.03 * (4.0 - phase)
            }
        } else {
            0.0
        }
    }

    #[test]
    fn a_pressing_force_steps_one_way_and_a_lateral_one_both_ways() {
        let touch = |t: f64| f64::from((2.0..8.0).contains(&t));
        let Slow::Steps(normal) = kind(|t| -0.02 + 0.6 * touch(t)) else {
            panic!()
        };
        assert!(
            normal.is_one_way() && normal.balance > 0.0 && normal.count == 1,
            "{normal:?}"
        );
        assert!((normal.rest + 0.02).abs() < 0.01, "{normal:?}");
        let Slow::Steps(lateral) = kind(|t| {
            0.3 * touch(t)
                * if (t as u64).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
        }) else {
            panic!()
        };
        assert!(!lateral.is_one_way(), "{lateral:?}");
    }

    #[test]
    fn a_finger_that_presses_for_most_of_a_recording_is_not_at_rest() {
        let level = |at_rest: f64, at_contact: f64, from_s: f64, to_s: f64| {
            let touch = move |t: f64| (from_s..to_s).contains(&t);
            match kind(|t| if touch(t) { at_contact } else { at_rest }) {
                Slow::Steps(steps) => (steps.rest, steps.balance > 0.0, steps.is_rest_certain),
                other => panic!("{other:?}"),
            }
        };
        let near = |level: (f64, bool, bool), rest: f64, is_certain: bool| {
            assert!((level.0 - rest).abs() < 0.01, "{level:?}");
            assert_eq!(level.2, is_certain, "{level:?}");
            level.1
        };
        assert!(near(level(0.0, 0.62, 1.0, 9.0), 0.0, true));
        assert!(near(level(-0.4, 0.2, 1.0, 9.0), -0.4, true));
        assert!(!near(level(0.01, -0.62, 1.0, 9.5), 0.01, true));
        // A large offset that contact takes away: the ends know better than zero, and it is asked about.
        assert!(near(level(-0.62, 0.0, 1.0, 9.0), -0.62, false));
        // Recorded from the middle of a contact on.
        assert!(near(level(0.0, 0.62, 0.0, 7.0), 0.0, true));
        near(level(0.3, 0.9, 0.0, 7.0), 0.3, false);
    }

    #[test]
    fn friction_under_modulation_steps_and_oscillates() {
        let friction = |t: f64| match t {
            t if (1.0..3.0).contains(&t) => 0.4 + 0.35 * (std::f64::consts::TAU * 6.0 * t).sin(),
            t if (4.0..6.0).contains(&t) => -0.4 + 0.35 * (std::f64::consts::TAU * 6.0 * t).sin(),
            _ => 0.01,
        };
        let Slow::Steps(steps) = kind(friction) else {
            panic!()
        };
        assert!(
            (steps.modulation.unwrap().frequency_hz - 6.0).abs() < 0.1,
            "{steps:?}"
        );
        assert!(
            !steps.is_one_way() && steps.count == 2 && (steps.rest - 0.01).abs() < 0.01,
            "{steps:?}"
        );
        let Slow::Steps(steps) = kind(|t| friction(t).abs()) else {
            panic!()
        };
        assert!(steps.is_one_way(), "{steps:?}");
    }

    #[test]
    fn a_finger_travels_and_an_encoder_counts_it() {
        let Slow::Travel(travel) = kind(|t| 10.0 * stroke(t)) else {
            panic!()
        };
        assert!((travel.range - 0.6).abs() < 0.01, "{travel:?}");
        assert_eq!(travel.strokes, 4, "{travel:?}");
        let counted: Vec<f64> = (0..100_000)
            .map(|n| (stroke(f64::from(n) * 1e-4) / 5e-7).round() + 12_345.0)
            .collect();
        let wrapped: Vec<f64> = counted.iter().map(|c| c.rem_euclid(65_536.0)).collect();
        let Slow::Counts(counts) = of_values(counted) else {
            panic!()
        };
        assert_eq!(counts.wrap_bits, None);
        let Slow::Counts(counts) = of_values(wrapped) else {
            panic!()
        };
        assert_eq!(counts.wrap_bits, Some(16));
        assert!(
            (counts.travel.range - 120_000.0).abs() < 2_000.0,
            "{counts:?}"
        );
    }

    #[test]
    fn triggers_envelopes_and_noise_are_told_apart() {
        assert_eq!(
            of_values((0..1_000).map(|n| f64::from(n > 500)).collect()),
            Slow::Levels(vec![0.0, 1.0])
        );
        let Slow::Oscillation(found) =
            kind(|t| 2.0 + 1.8 * (std::f64::consts::TAU * 6.0 * t).sin())
        else {
            panic!()
        };
        assert!(
            (found.frequency_hz - 6.0).abs() < 0.05 && (found.index - 0.9).abs() < 0.02,
            "{found:?}"
        );
        assert_eq!(kind(|_| 0.0), Slow::Noise);
    }
}
