//! Jumps of the modulation's phase: missing or doubled samples that hold whole periods of the carrier, whose phase goes on.
//!
//! Over one period T of the modulation at ω, the envelope e has the phasor
//!
//! ```text
//! c(t) = Σ (e − ē) e^(−iωt') over t < t' < t + T
//! ```
//!
//! whose phase is the same at each t, apart from an error of ω. Where a time δ is missing, it grows by ωδ from one period to the next.

use std::f64::consts::TAU;

use impedance::ZmFrame;
use num_complex::Complex64;
use statistics::median;

use crate::largest_drive::largest_drive_v;

/// Smallest drive of a frame that is driven, as a share of the largest, and longest time below it within a stretch, s.
const SMALLEST_SHARE: f64 = 0.01;
const LONGEST_DIP_S: f64 = 0.2;
/// Time at either end of a stretch in which the drive begins and ends, s.
const RAMP_S: f64 = 0.15;
/// Fewest periods of a stretch, and steps of a period.
const FEWEST_PERIODS: f64 = 5.0;
const STEPS: usize = 8;
/// Smallest depth of the modulation.
const SMALLEST_DEPTH: f64 = 0.1;
/// Smallest jump, rad, and largest change within the period before and after it, relative to the jump.
const SMALLEST_RAD: f64 = 0.1;
const STEADY: f64 = 0.3;

/// Jump of the modulation's phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModulationJump {
    /// Time of it, s, within a sixteenth of a period.
    pub at_s: f64,
    /// Jump of the phase as a time within some 15 %, s, apart from whole periods: positive where time is missing.
    pub jump_s: f64,
}

/// Returns the largest jump of the modulation's phase, of frames in order of time.
#[must_use]
pub(crate) fn modulation_jump(frames: &[ZmFrame], modulation_hz: f64) -> Option<ModulationJump> {
    let largest_v = largest_drive_v(frames)?;
    let driven: Vec<(f64, f64)> = frames
        .iter()
        .map(|frame| (frame.time_s, frame.drive_v.norm()))
        .filter(|(_, drive_v)| *drive_v > SMALLEST_SHARE * largest_v)
        .collect();
    let stretches = driven.chunk_by(|frame, next| next.0 - frame.0 < LONGEST_DIP_S);
    let jumps = stretches.filter_map(|stretch| largest_jump(stretch, modulation_hz));
    jumps.max_by(|a, b| a.jump_s.abs().total_cmp(&b.jump_s.abs()))
}

/// Returns the largest jump in a stretch of times, s, and envelopes.
fn largest_jump(stretch: &[(f64, f64)], modulation_hz: f64) -> Option<ModulationJump> {
    let (start_s, end_s) = (stretch.first()?.0 + RAMP_S, stretch.last()?.0 - RAMP_S);
    let (period_s, omega) = (1.0 / modulation_hz, TAU * modulation_hz);
    if (end_s - start_s) / period_s < FEWEST_PERIODS || !period_s.is_finite() {
        return None;
    }
    // Sums up to each frame: of the envelope, of the phasor, and of their product.
    let mut sums = vec![(0.0, Complex64::ZERO, Complex64::ZERO)];
    for (time_s, envelope) in stretch {
        let phasor = Complex64::cis(-omega * time_s);
        let (sum, phasors, product) = sums[sums.len() - 1];
        sums.push((
            sum + envelope,
            phasors + phasor,
            product + envelope * phasor,
        ));
    }
    let index = |time_s: f64| stretch.partition_point(|frame| frame.0 < time_s);
    let phasor = |from_s: f64| {
        let (first, end) = (index(from_s), index(from_s + period_s));
        let n = (end - first) as f64;
        let mean = (sums[end].0 - sums[first].0) / n;
        let product = (sums[end].2 - sums[first].2) - mean * (sums[end].1 - sums[first].1);
        let depth = 2.0 * product.norm() / (n * mean);
        (depth > SMALLEST_DEPTH).then_some(product)
    };
    let step_s = period_s / STEPS as f64;
    let count = ((end_s - period_s - start_s) / step_s) as usize;
    let phasors: Vec<Option<Complex64>> = (0..=count)
        .map(|step| phasor(start_s + step as f64 * step_s))
        .collect();
    let turns: Vec<Option<f64>> = (0..phasors.len().saturating_sub(STEPS))
        .map(|step| Some((phasors[step + STEPS]? * phasors[step]?.conj()).arg()))
        .collect();
    let usual = median(turns.iter().copied().flatten())?;
    let beyond = |step: usize| turns.get(step).copied().flatten().map(|turn| turn - usual);
    let is_steady = |step: Option<usize>, jump: f64| {
        step.and_then(beyond)
            .is_none_or(|turn| turn.abs() < STEADY * jump.abs())
    };
    let jumps = (0..turns.len()).filter_map(|step| {
        let jump = beyond(step).filter(|jump| jump.abs() > SMALLEST_RAD)?;
        let is_jump =
            is_steady(step.checked_sub(STEPS), jump) && is_steady(Some(step + STEPS), jump);
        is_jump.then(|| ModulationJump {
            at_s: start_s + (step + STEPS) as f64 * step_s,
            jump_s: jump / omega,
        })
    });
    jumps.max_by(|a, b| a.jump_s.abs().total_cmp(&b.jump_s.abs()))
}

#[cfg(test)]
mod tests {
    use impedance::Mask;

    use super::*;

    /// Frames at 2 kHz of a drive from 0.5 to 4 s whose modulation is `lost_s` further from 2 s on.
    fn frames(lost_s: f64, index: f64, triangle: bool) -> Vec<ZmFrame> {
        let frame = |step: u32| {
            let time_s = f64::from(step) / 2000.0;
            let source_s = if time_s < 2.0 {
                time_s
            } else {
                time_s + lost_s
            };
            let wave = (TAU * 6.03 * source_s).sin();
            let wave = if triangle { wave.asin() / 1.571 } else { wave };
            let is_on = (0.5..4.0).contains(&time_s);
            let envelope = if is_on {
                20.0 * (1.0 + index * wave)
            } else {
                0.0
            };
            ZmFrame {
                sample: u64::from(step),
                time_s,
                mask: Mask::CLEAR,
                drive_v: Complex64::new(envelope, 0.0),
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
        (0..10_000).map(frame).collect()
    }

    #[test]
    fn time_that_is_missing_or_doubled_is_found() {
        for (lost_s, index, triangle) in [
            (0.01, 0.95, false),
            (0.05, 0.5, false),
            (-0.02, 0.95, true),
            (0.06, 1.0, false),
        ] {
            let jump = modulation_jump(&frames(lost_s, index, triangle), 6.0);
            let is_found = jump.is_some_and(|jump| {
                (jump.jump_s - lost_s).abs() < 0.15 * lost_s.abs() && (jump.at_s - 2.0).abs() < 0.1
            });
            assert!(is_found, "{lost_s} s: {jump:?}");
        }
    }

    #[test]
    fn a_steady_modulation_or_none_does_not_jump() {
        for (index, triangle) in [(0.95, false), (1.0, false), (0.5, true), (0.0, false)] {
            assert_eq!(modulation_jump(&frames(0.0, index, triangle), 6.0), None);
        }
        assert_eq!(modulation_jump(&frames(0.01, 0.0, false), 6.0), None);
        assert_eq!(modulation_jump(&[], 6.0), None);
        assert_eq!(modulation_jump(&frames(0.01, 0.9, false), 0.0), None);
    }
}
