//! Jumps of the drive's phase: samples that are missing or doubled.

use impedance::ZmFrame;
use num_complex::Complex64;
use statistics::median;

use crate::largest_drive::largest_drive_v;

/// Smallest drive of a frame that shows a phase, as a share of the largest.
const SMALLEST_SHARE: f64 = 0.2;
/// Number of frames before and after a jump, and the fewest of them.
const FRAMES: usize = 100;
const FEWEST: usize = 20;
/// Smallest jump, rad: a carrier that wanders by 10 Hz within a second turns by 0.1 rad in the frames about it.
const SMALLEST_RAD: f64 = 0.3;
/// Longest time between frames of one stretch, s: the modulation hides the drive for less.
const LONGEST_GAP_S: f64 = 0.2;
/// Greatest drift of a carrier of the converter's own clock, rad/s; its phase is known between stretches too.
const LOCKED_RAD_PER_S: f64 = 0.05;

/// Jump of the drive's phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PhaseJump {
    /// Last time before it, s.
    pub from_s: f64,
    /// First time after it, s.
    pub to_s: f64,
    /// Turn, rad.
    pub turn_rad: f64,
}

/// Returns the largest jump of the drive's phase against the carrier, of frames in order of time. A drive of another clock than the
/// converter's is compared within stretches alone.
#[must_use]
pub(crate) fn drive_jump(frames: &[ZmFrame]) -> Option<PhaseJump> {
    let largest_v = largest_drive_v(frames)?;
    let is_driven = |frame: &&ZmFrame| {
        frame.mask.is_clear() && frame.drive_v.norm() > SMALLEST_SHARE * largest_v
    };
    let driven: Vec<&ZmFrame> = frames.iter().filter(is_driven).collect();
    let pairs = || {
        driven
            .windows(2)
            .filter_map(|pair| Some((*pair.first()?, *pair.last()?)))
    };
    let drift = |(before, after): (&ZmFrame, &ZmFrame)| {
        (after.drive_v * before.drive_v.conj()).arg() / (after.time_s - before.time_s)
    };
    let step_s = median(pairs().map(|(before, after)| after.time_s - before.time_s))?;
    let neighbours = pairs().filter(|(before, after)| after.time_s - before.time_s < 1.5 * step_s);
    let drift_rad_per_s = median(neighbours.map(drift))?;
    let is_locked = drift_rad_per_s.abs() < LOCKED_RAD_PER_S;
    let stretches =
        driven.chunk_by(|frame, next| is_locked || next.time_s - frame.time_s < LONGEST_GAP_S);
    let jumps = stretches.filter_map(|stretch| largest_jump(stretch, drift_rad_per_s));
    let largest = jumps.max_by(|a, b| a.turn_rad.abs().total_cmp(&b.turn_rad.abs()))?;
    (largest.turn_rad.abs() > SMALLEST_RAD).then_some(largest)
}

/// Returns the largest difference of the phases before and after a frame, beyond the drift.
fn largest_jump(frames: &[&ZmFrame], drift_rad_per_s: f64) -> Option<PhaseJump> {
    let phasor = |frame: &ZmFrame| {
        frame.drive_v / frame.drive_v.norm() * Complex64::cis(-drift_rad_per_s * frame.time_s)
    };
    let sums = frames.iter().scan(Complex64::ZERO, |sum, frame| {
        *sum += phasor(frame);
        Some(*sum)
    });
    let sums: Vec<Complex64> = std::iter::once(Complex64::ZERO).chain(sums).collect();
    let jumps = (FEWEST..frames.len().saturating_sub(FEWEST)).filter_map(|index| {
        let (before, after) = (frames.get(index - 1)?, frames.get(index)?);
        let (start, end) = (
            index.saturating_sub(FRAMES),
            (index + FRAMES).min(frames.len()),
        );
        let earlier = sums.get(index)? - sums.get(start)?;
        let later = sums.get(end)? - sums.get(index)?;
        Some(PhaseJump {
            from_s: before.time_s,
            to_s: after.time_s,
            turn_rad: (later * earlier.conj()).arg(),
        })
    });
    jumps.max_by(|a, b| a.turn_rad.abs().total_cmp(&b.turn_rad.abs()))
}

#[cfg(test)]
mod tests {
    use impedance::Mask;

    use super::*;

    /// Frames at 2 kHz of two stretches with a modulated drive, which turns by `turn_rad` at `jump_s`.
    fn frames(drift_rad_per_s: f64, jump_s: f64, turn_rad: f64) -> Vec<ZmFrame> {
        let frame = |step: u32| {
            let time_s = f64::from(step) / 2000.0;
            let envelope_v = 20.0 * (1.0 + 0.95 * (37.7 * time_s).sin());
            let jump_rad = if time_s < jump_s { 0.0 } else { turn_rad };
            ZmFrame {
                sample: u64::from(step),
                time_s,
                mask: Mask::CLEAR,
                drive_v: Complex64::from_polar(
                    envelope_v,
                    0.4 + drift_rad_per_s * time_s + jump_rad,
                ),
                displacement_m: Complex64::ONE,
                amplitude_m: 1e-6,
                amplitude_rate_m_per_s: 0.0,
                amplitude_std_m: 1e-9,
                plain_n_s_per_m: Complex64::ONE,
                plain_std_n_s_per_m: 0.01,
                corrected_n_s_per_m: Complex64::ONE,
                corrected_std_n_s_per_m: 0.01,
            }
        };
        let stretches = (400..2000).chain(4800..8200);
        stretches.map(frame).collect()
    }

    #[test]
    fn lost_samples_turn_the_drive_within_a_stretch_and_between_stretches() {
        for drift in [0.0, 3.0, 30.0] {
            let found = drive_jump(&frames(drift, 3.1, -1.2)).unwrap();
            assert!((found.turn_rad + 1.2).abs() < 0.1, "{drift}: {found:?}");
            assert!((found.from_s - 3.1).abs() < 0.05, "{drift}: {found:?}");
        }
        let found = drive_jump(&frames(0.0, 1.7, 0.9)).unwrap();
        assert!(found.from_s < 1.0 && found.to_s > 2.3, "{found:?}");
        // Another clock: the phase after a second without frames is not known.
        assert_eq!(drive_jump(&frames(3.0, 1.7, 0.9)), None);
    }

    #[test]
    fn a_steady_drive_has_no_jump() {
        for drift in [0.0, 3.0, 30.0] {
            assert_eq!(drive_jump(&frames(drift, 3.1, 0.0)), None);
            assert_eq!(drive_jump(&frames(drift, 3.1, 0.1)), None);
        }
        assert_eq!(drive_jump(&[]), None);
    }
}
