//! Jumps of a channel's level against the other's: a gain or range that was changed, or a loose contact.
//!
//! With the ratio r = |Ũ|/|x̃| of the levels and the period T of the modulation, the growth
//!
//! ```text
//! g(t) = ln r(t) − ln r(t − T)
//! ```
//!
//! is 0 under a steady finger, whatever the modulation does within the period, and jumps by the change of the gain. Straight lines are
//! fitted to g on either side of a time t, over [`SIDE_S`] and apart from the [`TRANSITION_S`] next to t, in which the plate and the
//! demodulator answer; their difference at t is the jump. A gain changes the levels of all amplitudes alike, so that g keeps its level
//! for the period before and after; a finger that lands or lifts off changes those at small amplitudes most. A period after the jump, g
//! jumps back, where ln r does not. The growth of ln |Ũ| tells which channel it is.

use impedance::ZmFrame;
use statistics::{StraightLine, quantile};

use crate::channel::Channel;
use crate::largest_drive::largest_drive_v;

/// Time of either side, and of the transition next to the jump, s.
const SIDE_S: f64 = 0.012;
const TRANSITION_S: f64 = 0.003;
/// Step of the time, s.
const STEP_S: f64 = 0.001;
/// Smallest drive of a frame, as a share of the largest.
const SMALLEST_SHARE: f64 = 0.02;
/// Smallest share of a side's time in which there are frames.
const COVERED: f64 = 0.8;
/// Smallest jump, also as a multiple of the scatter about the lines and of the change along them.
const SMALLEST: f64 = 0.14;
const CLEAR: f64 = 8.0;
const STEEP: f64 = 3.0;
/// Greatest range of the levels of g within a period, as a share of the jump, and smallest share of a period in which there are frames.
const FLAT: f64 = 0.4;
const SEEN: f64 = 0.5;
/// Greatest part of the jump that the channel which keeps its level may have.
const KEPT: f64 = 0.4;
/// Share of its largest level beyond which a channel is driven, share of the level that it then has below which the other is dead, and
/// shortest time for which it is so, and for which it is not, s.
const ALIVE: f64 = 0.3;
const DEAD: f64 = 0.01;
const LONG_S: f64 = 0.1;
/// Time in place of the period of a drive that is not modulated, s.
const ANY_PERIOD_S: f64 = 0.1;

/// Jump of a channel's level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LevelJump {
    /// Channel that jumps.
    pub channel: Channel,
    /// Its time, s.
    pub at_s: f64,
    /// Ratio of the level after it to that before it.
    pub ratio: f64,
}

/// Frame with the growth of its levels within a period.
#[derive(Debug, Clone, Copy)]
struct Growth {
    time_s: f64,
    /// ln r.
    level: f64,
    /// Growth of ln r.
    ratio: f64,
    /// Growth of ln |Ũ|.
    drive: f64,
}

/// Returns the largest jump of a channel's level, of frames in order of time.
#[must_use]
pub(crate) fn largest_level_jump(
    frames: &[ZmFrame],
    modulation_hz: Option<f64>,
) -> Option<LevelJump> {
    let frame_s = frame_s(frames)?;
    let period_s = modulation_hz.map_or(ANY_PERIOD_S, f64::recip);
    let growths = growths(frames, frame_s, period_s)?;
    let fewest = COVERED * SIDE_S / frame_s;
    let stride = (STEP_S / frame_s).round().max(1.0) as usize;
    { growths.iter().step_by(stride) }
        .filter_map(|at| jump(&growths, at.time_s, fewest, period_s))
        .max_by(|a, b| a.ratio.ln().abs().total_cmp(&b.ratio.ln().abs()))
}

/// Returns the time at which a channel goes dead while the other goes on.
#[must_use]
pub(crate) fn dead_channel(frames: &[ZmFrame]) -> Option<LevelJump> {
    let frame_s = frame_s(frames)?;
    let levels: Vec<(f64, [f64; 2])> = { frames.iter() }
        .map(|frame| {
            (
                frame.time_s,
                [frame.drive_v.norm(), frame.displacement_m.norm()],
            )
        })
        .filter(|(_, levels)| levels.iter().all(|level| level.is_finite()))
        .collect();
    let largest: [f64; 2] = [0, 1].map(|channel: usize| {
        let level = levels.iter().map(|(_, levels)| levels[channel]);
        level.fold(0.0, f64::max)
    });
    [(Channel::Drive, 0, 1), (Channel::Pickup, 1, 0)]
        .into_iter()
        .find_map(|(channel, own, other)| {
            let share = |levels: &[f64; 2], channel: usize| levels[channel] / largest[channel];
            let alive =
                { levels.iter().copied() }.filter(|(_, levels)| share(levels, other) > ALIVE);
            let is_dead = |levels: &[f64; 2]| share(levels, own) < DEAD * share(levels, other);
            let (dead, living): (Vec<(f64, [f64; 2])>, Vec<_>) =
                alive.partition(|(_, levels)| is_dead(levels));
            let is_long = |count: usize| count as f64 * frame_s > LONG_S;
            (is_long(dead.len()) && is_long(living.len())).then(|| LevelJump {
                channel,
                at_s: dead[0].0,
                ratio: 0.0,
            })
        })
}

fn frame_s(frames: &[ZmFrame]) -> Option<f64> {
    { frames.windows(2) }
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .reduce(f64::min)
}

/// Returns the growths of the frames that are driven, and were a period before.
fn growths(frames: &[ZmFrame], frame_s: f64, period_s: f64) -> Option<Vec<Growth>> {
    let largest_v = largest_drive_v(frames)?;
    let is_driven = |frame: &ZmFrame| {
        frame.mask.is_clear() && frame.drive_v.norm() > SMALLEST_SHARE * largest_v
    };
    let growth = |now: &ZmFrame| {
        let before_s = now.time_s - period_s;
        let index = frames.partition_point(|frame| frame.time_s < before_s - 0.5 * frame_s);
        let before = frames.get(index)?;
        let is_there = (before.time_s - before_s).abs() <= 0.6 * frame_s;
        if !is_there || !is_driven(now) || !is_driven(before) {
            return None;
        }
        let ratio = |frame: &ZmFrame| (frame.drive_v.norm() / frame.displacement_m.norm()).ln();
        Some(Growth {
            time_s: now.time_s,
            level: ratio(now),
            ratio: ratio(now) - ratio(before),
            drive: (now.drive_v.norm() / before.drive_v.norm()).ln(),
        })
    };
    Some(frames.iter().filter_map(growth).collect())
}

/// Returns the jump at a time or a period before it, if g jumps there; each side has `fewest` frames or more.
fn jump(growths: &[Growth], at_s: f64, fewest: f64, period_s: f64) -> Option<LevelJump> {
    let stretch = |from_s: f64, to_s: f64| {
        let index = |time_s: f64| growths.partition_point(|growth| growth.time_s < time_s);
        growths.get(index(from_s)..index(to_s))
    };
    let side =
        |from_s: f64, to_s: f64| stretch(from_s, to_s).filter(|side| side.len() as f64 >= fewest);
    let before = side(at_s - TRANSITION_S - SIDE_S, at_s - TRANSITION_S)?;
    let after = side(at_s + TRANSITION_S, at_s + TRANSITION_S + SIDE_S)?;
    let lines = |value: fn(&Growth) -> f64| {
        let line = |side: &[Growth]| {
            let points = side
                .iter()
                .map(|growth| (growth.time_s - at_s, value(growth)));
            StraightLine::fit(&points.collect::<Vec<_>>())
        };
        Some((line(before)?, line(after)?))
    };
    let step = |(before, after): (StraightLine, StraightLine)| after.at(0.0) - before.at(0.0);
    let ratio = lines(|growth| growth.ratio)?;
    let mut size = step(ratio);
    let scatter = ratio.0.residual.max(ratio.1.residual);
    let change = SIDE_S * ratio.0.slope.abs().max(ratio.1.slope.abs());
    if size.abs() < SMALLEST.max(CLEAR * scatter).max(STEEP * change) {
        return None;
    }
    let whole_s = period_s - 2.0 * TRANSITION_S;
    let is_flat = |from_s: f64| {
        let period = stretch(from_s, from_s + whole_s)?;
        let mut levels: Vec<f64> = period.iter().map(|growth| growth.ratio).collect();
        levels.sort_by(f64::total_cmp);
        let range = quantile(&levels, 0.9)? - quantile(&levels, 0.1)?;
        let is_seen = levels.len() as f64 >= SEEN * whole_s / SIDE_S * fewest;
        Some(is_seen && range < FLAT * size.abs())
    };
    if !is_flat(at_s - TRANSITION_S - whole_s)? || !is_flat(at_s + TRANSITION_S)? {
        return None;
    }
    let mut drive = step(lines(|growth| growth.drive)?);
    let level = step(lines(|growth| growth.level)?);
    let is_back = (level - size).abs() > level.abs();
    if is_back {
        (size, drive) = (-size, -drive);
    }
    // Of a jump s of ln r, the drive jumps by s, or the pickup by −s.
    let kept = KEPT * size.abs();
    let (channel, jump) = if drive.abs() < kept {
        (Channel::Pickup, -size)
    } else if (drive - size).abs() < kept {
        (Channel::Drive, size)
    } else {
        return None;
    };
    Some(LevelJump {
        channel,
        at_s: if is_back { at_s - period_s } else { at_s },
        ratio: jump.exp(),
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use impedance::Mask;
    use num_complex::Complex64;

    use super::*;

    /// Frames at 2 kHz of a drive modulated at 6 Hz, and of a pickup that follows it by `pickup(time_s, drive)`.
    fn frames(drive: fn(f64) -> f64, pickup: fn(f64, f64) -> f64) -> Vec<ZmFrame> {
        let frame = |step: u32| {
            let time_s = f64::from(step) / 2000.0;
            let envelope_v = 20.0 * (1.0 + 0.95 * (TAU * 6.0 * time_s).sin());
            let drive_v = drive(time_s) * envelope_v;
            let displacement_m = 1e-7 * pickup(time_s, envelope_v);
            ZmFrame {
                sample: u64::from(step),
                time_s,
                mask: Mask::CLEAR,
                drive_v: Complex64::from_polar(drive_v, 0.4),
                displacement_m: Complex64::from_polar(displacement_m, -1.1),
                amplitude_m: displacement_m,
                amplitude_rate_m_per_s: 0.0,
                amplitude_std_m: 1e-9,
                plain_n_s_per_m: Complex64::ONE,
                plain_std_n_s_per_m: 0.01,
                corrected_n_s_per_m: Complex64::ONE,
                corrected_std_n_s_per_m: 0.01,
            }
        };
        (0..6000).map(frame).collect()
    }

    fn step(time_s: f64, from_s: f64, factor: f64) -> f64 {
        if time_s < from_s { 1.0 } else { factor }
    }

    #[test]
    fn a_gain_that_changes_is_found_with_its_channel() {
        let found = level_jump_of(&frames(|_| 1.0, |t, v| v * step(t, 1.04, 1.25)));
        assert_eq!(found.channel, Channel::Pickup);
        assert!((found.ratio - 1.25).abs() < 0.02, "{found:?}");
        assert!((found.at_s - 1.04).abs() <= TRANSITION_S, "{found:?}");
        let found = level_jump_of(&frames(|t| step(t, 2.03, 0.1), |_, v| v));
        assert_eq!(found.channel, Channel::Drive);
        assert!((found.ratio - 0.1).abs() < 0.01, "{found:?}");
    }

    fn level_jump_of(frames: &[ZmFrame]) -> LevelJump {
        largest_level_jump(frames, Some(6.0)).unwrap()
    }

    #[test]
    fn a_channel_that_goes_dead_is_found_and_a_drive_that_is_switched_off_not() {
        let dead = dead_channel(&frames(|_| 1.0, |t, v| v * step(t, 1.04, 1e-4))).unwrap();
        assert_eq!((dead.channel, dead.ratio), (Channel::Pickup, 0.0));
        assert!((1.03..1.2).contains(&dead.at_s), "{dead:?}");
        let dead = dead_channel(&frames(|t| step(t, 2.03, 0.0), |_, v| v)).unwrap();
        assert_eq!(dead.channel, Channel::Drive);
        let off = frames(|t| step(t, 2.03, 0.0), |t, v| v * step(t, 2.03, 1e-3));
        assert_eq!(dead_channel(&off), None);
        assert_eq!(dead_channel(&frames(|_| 1.0, |_, v| v)), None);
        assert_eq!(dead_channel(&[]), None);
    }

    #[test]
    fn a_drive_that_jumps_with_its_plate_and_a_finger_that_lands_are_no_jump() {
        // The plate answers with another ratio at another amplitude, as under a finger.
        let both = frames(|t| step(t, 1.04, 2.0), |t, v| v * step(t, 1.04, 2.4));
        assert_eq!(largest_level_jump(&both, Some(6.0)), None);
        // A landing within 2 ms, of a finger that is carried at large amplitudes.
        let carried = frames(
            |_| 1.0,
            |t, v| v / (1.0 + (step(t, 1.04, 2.0) - 1.0) * 0.4 * (1.0 - v / 39.0)),
        );
        assert_eq!(largest_level_jump(&carried, Some(6.0)), None);
        // A landing within 20 ms.
        let lands = frames(
            |_| 1.0,
            |t, v| v / (1.0 + ((t - 1.04) / 5e-3).tanh()).mul_add(0.25, 1.0),
        );
        assert_eq!(largest_level_jump(&lands, Some(6.0)), None);
        assert_eq!(
            largest_level_jump(&frames(|_| 1.0, |_, v| v), Some(6.0)),
            None
        );
    }
}
