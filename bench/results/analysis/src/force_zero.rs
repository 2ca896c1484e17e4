//! Zero of the force sensor, read from the recording itself.
//!
//! A sensor's zero drifts by some mN/min with its temperature, and a session is calibrated once. Where the plate's impedance is
//! that of the free plate, no finger presses on it, so the forces read there are the zero. It is read in each such stretch,
//! before, between and after explorations, and is a straight line from one stretch to the next:
//!
//! ```text
//! F(t) = F_read(t) − F_0(t),  F_0(t) = (1 − w) F_0,j + w F_0,j+1,  w = (t − t_j)/(t_j+1 − t_j)
//! ```
//!
//! Only estimates use it. The safety watch, the limits and the recording keep the sensor's own readings, because a zero read
//! while something rests on the plate would hide its weight (docs/decisions/0039).

use impedance::ZmFrame;
use num_complex::Complex64;
use recording::ForceRow;
use recording::manifest::StandardErrors;
use serde::{Deserialize, Serialize};
use statistics::median;

use crate::flaw::Flaw;
use crate::measurements::Measurements;
pub use plausibility::zero_stretch::{Axes, Axis, ZeroReading};
use plausibility::zero_stretch::{
    CERTAIN_ERRORS, FEWEST_BLOCKS, FreeBlock, mean_force, read_stretch,
};

/// Length of a block that is free or not, s: short compared with a touch, and many frames.
const BLOCK_S: f64 = 0.1;
/// Share of a change of the free plate's impedance that is followed from one block to the next.
pub const FOLLOWED: f64 = 0.1;
/// Fewest clear frames of a block.
const FEWEST_FRAMES: usize = 40;
/// Largest difference of a free plate's impedance from that of the last second, N·s/m; a finger adds more from 0.15 N on.
pub const FREE_N_S_PER_M: f64 = 0.3;
/// Blocks next to a touch that are left out: a finger that lifts off still presses with some mN for 0.1 s.
const MARGIN_BLOCKS: usize = 2;
/// Largest zero, N, three times what a session may begin with: beyond it, something may rest on the plate.
pub const GREATEST_ZERO_N: f64 = 0.15;
/// Zero of the force sensor beyond which a warning states it, N.
const REPORTED_ZERO_N: f64 = 0.010;
/// Change of an axis within a recording beyond which it is a flaw, N: a drift of 5 mN/min makes 1 mN in the longest trial, and 10 mN
/// of the lateral axis change the friction under 0.5 N by 0.02.
const GREATEST_CHANGES_N: [(Axis, f64); 2] = [(Axis::Normal, 0.005), (Axis::Lateral, 0.010)];

/// Number of frames with a common error: 10 ms of interference or touch (an assumption of this project). White noise is independent
/// from frame to frame, so that its error is stated 4.5 times too large.
const CORRELATED_FRAMES: f64 = 20.0;

/// Zero of the force sensor over a recording; empty if it was read nowhere.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceZero {
    /// Readings in time order.
    pub readings: Vec<ZeroReading>,
}

impl ForceZero {
    /// Reads the zero of a recording with these intervals without a finger, s. A stretch in which the normal axis reads more than
    /// 0.15 N is left out: something may rest on the plate.
    pub fn read(record: &Measurements, unloaded_s: &[(f64, f64)]) -> Self {
        let Some(z_p) = typical_impedance(record, unloaded_s) else {
            return Self::default();
        };
        let mut blocks = free_blocks(&record.frames, z_p);
        // A film at a large amplitude carries a finger so well that the plate hardly feels it.
        blocks.retain(|block| {
            mean_force(&record.force, (block.start_s, block.end_s))
                .is_none_or(|force| force.normal_n.abs() <= GREATEST_ZERO_N)
        });
        let stretches = blocks.chunk_by(|block, next| next.index == block.index + 1);
        let readings = stretches.filter_map(|stretch| {
            let is_first = stretch.first()?.index == 0;
            let is_last = stretch.last()?.is_last;
            // At an end of the recording a short stretch is all there is; a finger that is lifting off is not steady.
            let least = stretch.len().saturating_sub(FEWEST_BLOCKS);
            let margin = |is_end: bool, is_other_end: bool| match (is_end, is_other_end) {
                (true, _) => 0,
                (false, true) => MARGIN_BLOCKS.min(least),
                (false, false) => MARGIN_BLOCKS,
            };
            let start = margin(is_first, is_last);
            let end = stretch.len().saturating_sub(margin(is_last, is_first));
            read_stretch(&record.force, stretch.get(start..end)?, GREATEST_ZERO_N)
        });
        Self {
            readings: readings.collect(),
        }
    }

    /// Reads the zero of forces without an impedance in these intervals without a finger, s. One in which the normal axis reads more
    /// than `greatest_n` is left out.
    pub fn of_intervals(rows: &[ForceRow], unloaded_s: &[(f64, f64)], greatest_n: f64) -> Self {
        let reading = |(start_s, end_s): &(f64, f64)| {
            let count = ((end_s - start_s) / BLOCK_S).floor().max(0.0) as usize;
            let block = |index: usize| FreeBlock {
                index,
                is_last: index + 1 == count,
                start_s: start_s + index as f64 * BLOCK_S,
                end_s: start_s + (index + 1) as f64 * BLOCK_S,
            };
            let blocks: Vec<FreeBlock> = (0..count).map(block).collect();
            read_stretch(rows, &blocks, greatest_n)
        };
        let mut readings: Vec<ZeroReading> = unloaded_s.iter().filter_map(reading).collect();
        readings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Self { readings }
    }

    /// Returns a record with its forces against the zero in the data before `end_s`, and that zero: for an exploration that ends
    /// then, evaluated before later data arrive.
    pub fn tare(
        record: &Measurements,
        unloaded_s: &[(f64, f64)],
        end_s: f64,
    ) -> (Measurements, Self) {
        let frames = record.frames.partition_point(|frame| frame.time_s < end_s);
        let rows = record.force.partition_point(|row| row.time_s < end_s);
        let earlier = Measurements {
            frames: record.frames[..frames].to_vec(),
            force: record.force[..rows].to_vec(),
            ..Measurements::default()
        };
        let zero = Self::read(&earlier, unloaded_s);
        let mut record = record.clone();
        zero.subtract(&mut record.force);
        (record, zero)
    }

    /// Returns the zero at `time_s`, on the line between the stretches about it and constant beyond them, N.
    pub fn at(&self, time_s: f64) -> Axes {
        self.interpolate(time_s, |reading| reading.zero, |a, b| a + b)
    }

    /// Returns the standard error of the zero at `time_s`, N: of one stretch, or of the line between two.
    pub fn std_at(&self, time_s: f64) -> Axes {
        self.interpolate(time_s, |reading| reading.std, f64::hypot)
    }

    fn interpolate(
        &self,
        time_s: f64,
        value: impl Fn(&ZeroReading) -> Axes,
        sum: impl Fn(f64, f64) -> f64,
    ) -> Axes {
        let next = self
            .readings
            .partition_point(|reading| reading.time_s < time_s);
        let later = self.readings.get(next);
        let earlier = next.checked_sub(1).map(|index| &self.readings[index]);
        match (earlier, later) {
            (Some(earlier), Some(later)) => {
                let weight = (time_s - earlier.time_s) / (later.time_s - earlier.time_s);
                let line = |a: f64, b: f64| sum((1.0 - weight) * a, weight * b);
                value(earlier).combine(value(later), line)
            }
            (Some(reading), None) | (None, Some(reading)) => value(reading),
            (None, None) => Axes::default(),
        }
    }

    /// Subtracts the zero from the readings.
    pub fn subtract(&self, rows: &mut [ForceRow]) {
        if self.readings.is_empty() {
            return;
        }
        for row in rows {
            let zero = self.at(row.time_s);
            row.normal_n -= zero.normal_n;
            row.lateral_n -= zero.lateral_n;
        }
    }

    /// Returns the standard errors of the constants with the zero's among those of the forces. With the root mean square of δ and the
    /// mean normal force N over the `touch`, an error δ of the normal zero acts as a relative one of δ/N, and one of the lateral zero
    /// as a crosstalk of δ/N, since both add the same to every friction.
    pub fn standard_errors(&self, stated: StandardErrors, touch: &[ForceRow]) -> StandardErrors {
        let n = touch.len() as f64;
        if touch.is_empty() {
            return stated;
        }
        let mean_n = touch.iter().map(|row| row.normal_n.abs()).sum::<f64>() / n;
        let relative = |std: fn(Axes) -> f64, stated_n: f64| {
            let squares = touch.iter().map(|row| std(self.std_at(row.time_s)).powi(2));
            (squares.sum::<f64>() / n).sqrt().hypot(stated_n) / mean_n
        };
        let normal = relative(|std| std.normal_n, stated.normal_zero_n);
        let lateral = relative(|std| std.lateral_n, stated.lateral_zero_n);
        let with_zero = |stated: f64, zero: f64| {
            let sum = stated.hypot(zero);
            if sum.is_finite() { sum } else { stated }
        };
        StandardErrors {
            normal_force_relative: with_zero(stated.normal_force_relative, normal),
            lateral_per_normal: with_zero(stated.lateral_per_normal, lateral),
            ..stated
        }
    }

    /// Returns the flaw of a zero that is large, and of one that moves by more than its errors during the recording.
    pub fn flaws(&self) -> impl Iterator<Item = Flaw> + use<> {
        let zero = self.largest();
        let (normal_n, lateral_n) = (zero.normal_n, zero.lateral_n);
        let is_large = normal_n.abs().max(lateral_n.abs()) > REPORTED_ZERO_N;
        let size_flaw = is_large.then_some(Flaw::ForceZero {
            normal_n,
            lateral_n,
        });
        let moves = |(axis, greatest_n): (Axis, f64)| {
            let (change_n, std_n) = self.largest_change(axis)?;
            let is_certain = change_n.abs() > greatest_n.max(CERTAIN_ERRORS * std_n);
            is_certain.then_some(Flaw::ForceZeroMoves { change_n, axis })
        };
        let change_flaws = GREATEST_CHANGES_N.map(moves);
        size_flaw
            .into_iter()
            .chain(change_flaws.into_iter().flatten())
            .chain(self.drift())
    }

    /// Returns the flaw of a zero that drifts in the only stretch that shows it, with a large change over all forces.
    fn drift(&self) -> Option<Flaw> {
        let [reading] = self.readings[..] else {
            return None;
        };
        let drift = |axis: Axis| axis.of(reading.drift_n_per_s);
        let larger = |a: &Axis, b: &Axis| drift(*a).abs().total_cmp(&drift(*b).abs());
        let axis = { [Axis::Lateral, Axis::Normal].into_iter() }.max_by(larger)?;
        let drift_n_per_s = drift(axis);
        (drift_n_per_s != 0.0).then_some(Flaw::ForceZeroDrifts {
            axis,
            drift_n_per_s,
        })
    }

    /// Returns the largest zero of each axis by magnitude, N.
    pub fn largest(&self) -> Axes {
        let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let zeros = self.readings.iter().map(|reading| reading.zero);
        zeros.fold(Axes::default(), |a, b| a.combine(b, larger))
    }

    /// Returns the largest change of an axis between two neighbouring stretches, N, and its standard error, N.
    pub fn largest_change(&self, axis: Axis) -> Option<(f64, f64)> {
        let changes = self.readings.windows(2).map(|pair| {
            let change_n = axis.of(pair[1].zero) - axis.of(pair[0].zero);
            (change_n, axis.of(pair[0].std).hypot(axis.of(pair[1].std)))
        });
        changes.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
    }
}

/// Returns the median impedance of the clear frames in the intervals, N·s/m, which a short touch does not move.
fn typical_impedance(record: &Measurements, intervals_s: &[(f64, f64)]) -> Option<Complex64> {
    let is_inside = |frame: &&ZmFrame| {
        let mut intervals = intervals_s.iter();
        intervals.any(|(start_s, end_s)| (*start_s..=*end_s).contains(&frame.time_s))
    };
    let clear_frames = record.frames.iter().filter(|frame| frame.mask.is_clear());
    let impedances: Vec<Complex64> = clear_frames
        .filter(is_inside)
        .map(|frame| frame.corrected_n_s_per_m)
        .collect();
    if impedances.len() < FEWEST_FRAMES {
        return None;
    }
    let middle = |part: fn(&Complex64) -> f64| median(impedances.iter().map(part));
    Some(Complex64::new(middle(|z| z.re)?, middle(|z| z.im)?))
}

/// Returns the blocks in which the impedance is the free plate's, which may change slowly from `z_p`, its first value.
fn free_blocks(frames: &[ZmFrame], mut z_p: Complex64) -> Vec<FreeBlock> {
    let [first, .., last] = frames else {
        return Vec::new();
    };
    let index_of = |frame: &ZmFrame| ((frame.time_s - first.time_s) / BLOCK_S) as usize;
    // A block that the end cuts short shows nothing.
    let count = ((last.time_s - first.time_s) / BLOCK_S).round() as usize;
    let mut free = Vec::new();
    let blocks = frames.chunk_by(|frame, next| index_of(frame) == index_of(next));
    for block in blocks.take_while(|block| index_of(&block[0]) < count) {
        let Some((z_m, std)) = mean_impedance(block) else {
            continue;
        };
        if (z_m - z_p).norm() + std > FREE_N_S_PER_M {
            continue;
        }
        // Over a second: a warming plate is followed, a finger that lands is not.
        z_p += FOLLOWED * (z_m - z_p);
        let index = index_of(&block[0]);
        free.push(FreeBlock {
            index,
            is_last: index + 1 == count,
            start_s: block[0].time_s,
            end_s: block[block.len() - 1].time_s,
        });
    }
    free
}

/// Returns the mean impedance of a block's clear frames weighted by |x̃_p|², and its standard error, N·s/m.
fn mean_impedance(block: &[ZmFrame]) -> Option<(Complex64, f64)> {
    let clear_frames = || block.iter().filter(|frame| frame.mask.is_clear());
    let count = clear_frames().count();
    let weights: f64 = clear_frames().map(|frame| frame.amplitude_m.powi(2)).sum();
    if count < FEWEST_FRAMES || weights <= 0.0 {
        return None;
    }
    let weighted = clear_frames().map(|f| f.corrected_n_s_per_m * f.amplitude_m.powi(2));
    let mean = weighted.sum::<Complex64>() / weights;
    let squares =
        clear_frames().map(|f| (f.corrected_n_s_per_m - mean).norm_sqr() * f.amplitude_m.powi(2));
    let variance = squares.sum::<f64>() / weights;
    let std = (variance * CORRELATED_FRAMES / count as f64).sqrt();
    mean.is_finite().then_some((mean, std))
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::tests::measured;

    /// Six seconds of a plate of 7 N·s/m with a finger from 2 to 4 s that adds `finger`, and the forces that the sensor reads.
    fn record(finger: Complex64, force: impl Fn(f64) -> Axes) -> Measurements {
        let impedance = |time_s: f64| {
            let is_touched = (2.0..4.0).contains(&time_s);
            let noise = Complex64::new(0.02, -0.02) * (1e3 * time_s).sin();
            7.0 + noise + if is_touched { finger } else { Complex64::ZERO }
        };
        measured(6.0, impedance, |time_s| {
            let force = force(time_s);
            (force.normal_n, force.lateral_n)
        })
    }

    const FINGER: Complex64 = Complex64::new(0.5, -1.5);

    /// Zero at `time_s` plus a finger of 0.6 N that lands within 50 ms and lifts off as fast.
    fn touch(time_s: f64, zero: Axes) -> Axes {
        let weight = ((time_s - 1.95) / 0.05).min((4.05 - time_s) / 0.05);
        let finger_n = 0.6 * weight.clamp(0.0, 1.0);
        Axes {
            normal_n: zero.normal_n + finger_n,
            lateral_n: zero.lateral_n - 0.5 * finger_n,
        }
    }

    fn drifting(time_s: f64) -> Axes {
        Axes {
            normal_n: 0.045 + 0.001 * time_s,
            lateral_n: -0.01,
        }
    }

    #[test]
    fn forces_are_taken_against_the_zero_before_and_after_the_finger() {
        let mut record = record(FINGER, |time_s| touch(time_s, drifting(time_s)));
        let zero = ForceZero::read(&record, &[(0.2, 1.2)]);
        assert_eq!(zero.readings.len(), 2, "{zero:?}");
        for time_s in [1.0, 3.0, 5.0] {
            let (read, truth) = (zero.at(time_s), drifting(time_s));
            assert_relative_eq!(read.normal_n, truth.normal_n, epsilon = 1e-4);
            assert_relative_eq!(read.lateral_n, truth.lateral_n, epsilon = 1e-9);
        }
        zero.subtract(&mut record.force);
        assert_relative_eq!(record.normal_n(3.0).unwrap(), 0.6, epsilon = 1e-4);
        // Beyond the last stretch the zero is constant.
        assert_eq!(zero.at(5.9), zero.at(7.0));
    }

    #[test]
    fn a_zero_is_read_where_it_drifts_and_where_the_recording_ends_soon_after_the_finger() {
        let fast = |time_s: f64| Axes {
            normal_n: 0.015 * (time_s - 1.0),
            lateral_n: 0.0,
        };
        let zero = ForceZero::read(
            &record(FINGER, |time_s| touch(time_s, fast(time_s))),
            &[(0.2, 1.2)],
        );
        assert_eq!(zero.readings.len(), 2, "{zero:?}");
        assert_relative_eq!(zero.at(3.0).normal_n, fast(3.0).normal_n, epsilon = 1e-3);

        let moved = |time_s: f64| Axes {
            normal_n: if time_s < 3.0 { 0.0 } else { 0.04 },
            lateral_n: 0.0,
        };
        for (end_s, is_read) in [(4.33, true), (4.15, false)] {
            let mut record = record(FINGER, |time_s| touch(time_s, moved(time_s)));
            let is_kept = |time_s: f64| time_s < end_s && !(0.5..0.9).contains(&time_s);
            record.frames.retain(|frame| is_kept(frame.time_s));
            record.force.retain(|row| row.time_s < end_s);
            let zero = ForceZero::read(&record, &[(0.2, 1.2)]);
            // Before and after the lost frames, and at the end.
            assert_eq!(zero.readings.len() == 3, is_read, "{end_s} s: {zero:?}");
            let change = zero.largest_change(Axis::Normal);
            assert_eq!(
                change.is_some_and(|(change_n, _)| (change_n - 0.04).abs() < 2e-3),
                is_read,
                "{end_s} s: {zero:?}"
            );
        }
    }

    #[test]
    fn without_an_impedance_the_zero_is_that_of_the_intervals() {
        let rows = record(FINGER, |time_s| touch(time_s, drifting(time_s))).force;
        let unloaded_s = [(5.0, 5.9), (0.2, 1.2)];
        let zero = ForceZero::of_intervals(&rows, &unloaded_s, GREATEST_ZERO_N);
        assert_eq!(zero.readings.len(), 2, "{zero:?}");
        for time_s in [1.0, 3.0, 5.0] {
            let (read, truth) = (zero.at(time_s), drifting(time_s));
            assert_relative_eq!(read.normal_n, truth.normal_n, epsilon = 1e-4);
            assert_relative_eq!(read.lateral_n, truth.lateral_n, epsilon = 1e-9);
        }
        // A finger is no zero, and a tenth of a second is too short for one.
        for intervals_s in [[(2.5, 3.5)], [(0.2, 0.3)]] {
            let zero = ForceZero::of_intervals(&rows, &intervals_s, GREATEST_ZERO_N);
            assert_eq!(zero, ForceZero::default());
        }
        let of_any_body = ForceZero::of_intervals(&rows, &[(2.5, 3.5)], f64::INFINITY);
        assert_eq!(of_any_body.readings.len(), 1);
    }

    #[test]
    fn an_exploration_is_evaluated_with_the_zero_before_its_end() {
        let record = record(FINGER, |time_s| touch(time_s, drifting(time_s)));
        for end_s in [3.0, 4.0] {
            let (tared_record, zero) = ForceZero::tare(&record, &[(0.2, 1.2)], end_s);
            let [reading] = zero.readings[..] else {
                panic!("one stretch: {zero:?}");
            };
            assert!(reading.time_s < 2.0, "{reading:?}");
            // The drift since then is not known yet.
            let normal_n = tared_record.normal_n(3.0).unwrap();
            assert_relative_eq!(normal_n, 0.6, epsilon = 3e-3);
            assert_eq!(tared_record.frames, record.frames);
        }
    }

    #[test]
    fn a_large_zero_is_reported_and_a_sudden_change_too() {
        let moved = |time_s: f64| Axes {
            normal_n: if time_s < 3.0 { 0.002 } else { 0.03 },
            lateral_n: 0.0,
        };
        let flaws_of = |zero: &dyn Fn(f64) -> Axes| -> Vec<Flaw> {
            let record = record(FINGER, |time_s| touch(time_s, zero(time_s)));
            ForceZero::read(&record, &[(0.2, 1.2)]).flaws().collect()
        };
        let flaws = flaws_of(&moved);
        assert!(
            matches!(
                flaws[..],
                [Flaw::ForceZero { .. }, Flaw::ForceZeroMoves { .. }]
            ),
            "{flaws:?}"
        );
        let still = |normal_n: f64| {
            move |_: f64| Axes {
                normal_n,
                lateral_n: 0.0,
            }
        };
        assert!(matches!(
            flaws_of(&still(0.045))[..],
            [Flaw::ForceZero { .. }]
        ));
        assert!(flaws_of(&still(0.005)).is_empty());
        let moved_sideways = |time_s: f64| Axes {
            normal_n: 0.0,
            lateral_n: if time_s < 3.0 { -0.015 } else { 0.015 },
        };
        let flaws = flaws_of(&moved_sideways);
        let is_lateral = |flaw: &Flaw| {
            matches!(
                flaw,
                Flaw::ForceZeroMoves {
                    axis: Axis::Lateral,
                    ..
                }
            )
        };
        assert!(flaws.iter().any(is_lateral), "{flaws:?}");
    }

    #[test]
    fn a_zero_that_drifts_in_the_only_stretch_is_a_flaw() {
        let row = |n: u32, drift_n_per_s: f64| {
            let time_s = f64::from(n) * 1e-3;
            ForceRow {
                time_s,
                normal_n: 0.001 * (7.7 * f64::from(n)).sin(),
                lateral_n: drift_n_per_s * time_s + 0.001 * (5.3 * f64::from(n)).cos(),
            }
        };
        let flaws = |drift_n_per_s: f64, unloaded_s: &[(f64, f64)]| -> Vec<Flaw> {
            let rows: Vec<ForceRow> = (0..5000).map(|n| row(n, drift_n_per_s)).collect();
            let zero = ForceZero::of_intervals(&rows, unloaded_s, GREATEST_ZERO_N);
            zero.flaws().collect()
        };
        let is_drift = |flaw: &Flaw| match flaw {
            Flaw::ForceZeroDrifts {
                axis,
                drift_n_per_s,
            } => *axis == Axis::Lateral && (drift_n_per_s - 0.02).abs() < 1e-3,
            _ => false,
        };
        assert!(flaws(0.02, &[(0.0, 1.0)]).iter().any(is_drift));
        assert!(flaws(0.002, &[(0.0, 1.0)]).is_empty());
        // Between two stretches the zero is known.
        let known = flaws(0.02, &[(0.0, 1.0), (4.0, 5.0)]);
        assert!(!known.iter().any(is_drift), "{known:?}");
    }

    #[test]
    fn a_finger_that_lands_and_lifts_off_slowly_is_not_part_of_the_zero() {
        // Impedance and force rise and fall within half a second.
        let weight = |time_s: f64| {
            ((time_s - 1.5) / 0.5)
                .min((4.5 - time_s) / 0.5)
                .clamp(0.0, 1.0)
        };
        let mut record = record(Complex64::ZERO, |time_s| Axes {
            normal_n: 0.01 + 0.6 * weight(time_s),
            lateral_n: 0.0,
        });
        for frame in &mut record.frames {
            frame.corrected_n_s_per_m += FINGER * weight(frame.time_s);
        }
        let zero = ForceZero::read(&record, &[(0.2, 1.2)]);
        assert!(!zero.readings.is_empty());
        for time_s in [1.0, 3.0, 5.0] {
            assert_relative_eq!(zero.at(time_s).normal_n, 0.01, epsilon = 5e-4);
        }
    }

    /// Where the film carries most of the finger, its impedance is that of the free plate to 0.3 N·s/m.
    #[test]
    fn a_levitated_finger_that_lifts_off_is_not_part_of_the_zero() {
        let weight = |time_s: f64| ((4.45 - time_s) / 0.2).clamp(0.0, 1.0).powi(2);
        let mut record = record(Complex64::ZERO, |time_s| Axes {
            normal_n: 0.004
                + if time_s > 2.0 {
                    0.6 * weight(time_s)
                } else {
                    0.0
                },
            lateral_n: 0.0,
        });
        for frame in &mut record.frames {
            let on_plate = (2.0..4.2).contains(&frame.time_s);
            frame.corrected_n_s_per_m += if on_plate { FINGER } else { Complex64::ZERO };
        }
        let zero = ForceZero::read(&record, &[(0.2, 1.2)]);
        assert_eq!(zero.readings.len(), 2, "{zero:?}");
        for reading in &zero.readings {
            assert_relative_eq!(reading.zero.normal_n, 0.004, epsilon = 2e-4);
        }
    }

    /// Regression test: of a finger that the film carries all the time, the impedance is that of the free plate throughout, and its
    /// force was the median of the whole recording, too large for a zero.
    #[test]
    fn a_finger_that_the_plate_hardly_feels_does_not_hide_the_zero() {
        let hardly_felt = Complex64::new(0.05, -0.1);
        let zero = Axes {
            normal_n: -0.038,
            lateral_n: 0.01,
        };
        let record = record(hardly_felt, |time_s| touch(time_s, zero));
        let read = ForceZero::read(&record, &[(0.2, 1.2)]);
        assert_eq!(read.readings.len(), 2, "{read:?}");
        for reading in &read.readings {
            assert_relative_eq!(reading.zero.normal_n, zero.normal_n, epsilon = 1e-6);
        }
    }

    /// Hazard of a tare: a weight on the plate would be taken for the zero.
    #[test]
    fn a_finger_that_never_leaves_is_not_taken_for_the_zero() {
        let resting = |_| Axes {
            normal_n: 0.4,
            lateral_n: 0.0,
        };
        let record = record(Complex64::ZERO, resting);
        assert_eq!(
            ForceZero::read(&record, &[(0.2, 1.2)]),
            ForceZero::default()
        );
    }

    #[test]
    fn without_an_unloaded_interval_or_readings_there_is_no_zero() {
        let mut record = record(FINGER, |time_s| touch(time_s, drifting(time_s)));
        assert_eq!(ForceZero::read(&record, &[]), ForceZero::default());
        for row in &mut record.force {
            row.normal_n = f64::NAN;
        }
        assert_eq!(
            ForceZero::read(&record, &[(0.2, 1.2)]),
            ForceZero::default()
        );
        assert_eq!(
            ForceZero::read(&Measurements::default(), &[(0.2, 1.2)]),
            ForceZero::default()
        );
    }

    #[test]
    fn the_zeros_error_is_relative_to_the_force_of_the_touch() {
        let noise_n = |time_s: f64| 0.004 * (917.0 * time_s).sin();
        let record = record(FINGER, |time_s| {
            let zero = Axes {
                normal_n: noise_n(time_s),
                lateral_n: 0.0,
            };
            touch(time_s, zero)
        });
        let zero = ForceZero::read(&record, &[(0.2, 1.2)]);
        let touch = record.force_under_finger(&[(2.0, 4.0)], 0.1);
        let stated = StandardErrors {
            normal_zero_n: 0.012,
            ..StandardErrors::default()
        };
        let errors = zero.standard_errors(stated, &touch);
        assert_relative_eq!(errors.normal_force_relative, 0.02, max_relative = 0.05);
        let measured = zero.standard_errors(StandardErrors::default(), &touch);
        assert!(
            (1e-6..0.002).contains(&measured.normal_force_relative),
            "{measured:?}"
        );
        assert_eq!(zero.standard_errors(stated, &[]), stated);
        let lateral = StandardErrors {
            lateral_zero_n: 0.012,
            ..StandardErrors::default()
        };
        let errors = zero.standard_errors(lateral, &touch);
        assert_relative_eq!(errors.lateral_per_normal, 0.02, max_relative = 0.05);
        assert!(errors.lateral_force_relative.abs() < 1e-12);
    }
}
