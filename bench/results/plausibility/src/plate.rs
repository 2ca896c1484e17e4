//! Scales, quantity and order of drive and pickup, by the answer of the free plate to its own modulation.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use force_alignment::TellingFactor;
use impedance::{Transient, ZmFrame};
use num_complex::Complex64;
use statistics::wrap_rad;

use crate::implausible::Implausible;
use crate::quantity::Quantity;

/// Smallest excess of the damping at small amplitudes that shows a finger, N·s/m, and in standard errors.
const SMALLEST_EXCESS_N_S_PER_M: f64 = 0.15;
const CERTAIN_ERRORS: f64 = 5.0;
/// Smallest growth of the damping from small to large amplitudes that is named, relative: actuators themselves lose some percent more.
const SMALLEST_GROWTH: f64 = 0.04;
/// Number of frames with a common error.
const CORRELATED_FRAMES: f64 = 20.0;
/// Largest distance of a phase from that of another quantity, rad.
const PHASE_RAD: f64 = 0.25;
/// Distance from a telling factor within which it may be the cause, relative: three standard errors of an assumed modal mass,
/// force factor and pickup.
const FACTOR_DISTANCE: f64 = 0.1;
/// Standard errors of a ratio within which a telling factor is its cause, and the least standard error, relative.
const FACTOR_ERRORS: f64 = 3.0;
const LEAST_RATIO_ERROR: f64 = 0.01;
/// Ratio of the scales, or its inverse, beyond which no number of the plate has a meaning.
const GREATEST_RATIO: f64 = 1.9;
/// Lead of the pickup beyond which the channels are exchanged, s: converters delay a channel by less.
const GREATEST_LEAD_S: f64 = 0.3e-3;
/// Fewest periods of the modulation by which a lead is read.
const FEWEST_PERIODS: f64 = 2.0;
/// Smallest share of the stated modulation that envelopes must have at its frequency: a triangle or a square has more.
const SMALLEST_SHARE: f64 = 0.5;
/// Smallest modulation of both envelopes relative to their means.
const SMALLEST_MODULATION: f64 = 0.1;

/// Returns the finding of a phase that must be added to the pickup's and that is that of another quantity.
#[must_use]
pub fn pickup_quantity(turn_rad: f64) -> Option<Implausible> {
    let is_near = |phase_rad: f64| wrap_rad(turn_rad - phase_rad).abs() < PHASE_RAD;
    let quantity = if is_near(-FRAC_PI_2) {
        Some(Quantity::Velocity)
    } else {
        is_near(PI).then_some(Quantity::Acceleration)
    };
    quantity.map(|quantity| Implausible::PickupQuantity { quantity })
}

/// Returns the finding of the scales by the free plate's answer to the modulation, which must be clear; `stated_error` is the
/// relative standard error that the recording states of the scale of impedances.
#[must_use]
pub fn plate_scale(transient: &Transient, stated_error: f64) -> Option<Implausible> {
    let ratio = transient.mass_ratio;
    let is_off = ratio.is_nan() || ratio.max(ratio.recip()) > GREATEST_RATIO;
    let error = transient.mass_error.hypot(stated_error);
    let tolerance = FACTOR_ERRORS * error.max(LEAST_RATIO_ERROR);
    let near = TellingFactor::of_ratio(ratio, FACTOR_DISTANCE);
    match TellingFactor::of_ratio(ratio, tolerance) {
        Some(factor) => Some(Implausible::ScaleFactor { ratio, factor }),
        None => (is_off || near.is_some()).then_some(Implausible::Scale { ratio, near }),
    }
}

/// Returns whether the response has a telling factor of a scale, or one that no delay of a channel makes. On a plate with this
/// damping a scale of force or displacement that is off has the same effect as a delay: of RMS values for peak, |M'|/M = √2 or
/// 1/√2, it is (2 m_p/b)(1 − 1/√2), which is 0.26 ms for m_p = 8 g and b = 18 N·s/m.
#[must_use]
pub fn is_of_scale(transient: &Transient, stated_error: f64) -> bool {
    let scale = plate_scale(transient, stated_error);
    scale.is_some_and(|scale| !matches!(scale, Implausible::Scale { near: Some(_), .. }))
}

/// Returns the finding of the envelopes of drive and pickup, by frames of the free plate: a modulation of another frequency, or a
/// pickup that leads, although a plate follows its drive.
#[must_use]
pub fn envelopes(
    frames: &[ZmFrame],
    modulation_hz: f64,
    modulation_index: f64,
) -> Option<Implausible> {
    let (first, last) = (frames.first()?, frames.last()?);
    let periods = ((last.time_s - first.time_s) * modulation_hz).floor();
    if periods.is_nan() || periods < FEWEST_PERIODS {
        return None;
    }
    let end_s = first.time_s + periods / modulation_hz;
    let clear = || {
        frames
            .iter()
            .filter(|frame| frame.mask.is_clear() && frame.time_s < end_s)
    };
    let n = clear().count() as f64;
    let tone = |envelope: fn(&ZmFrame) -> f64| {
        let mean = clear().map(envelope).sum::<f64>() / n;
        let turned = |frame: &ZmFrame| {
            (envelope(frame) - mean) * Complex64::cis(-TAU * modulation_hz * frame.time_s)
        };
        2.0 * clear().map(turned).sum::<Complex64>() / n / mean
    };
    let drive = tone(|frame| frame.drive_v.norm());
    let pickup = tone(|frame| frame.amplitude_m);
    let share = drive.norm();
    if share < SMALLEST_SHARE * modulation_index
        && pickup.norm() < SMALLEST_SHARE * modulation_index
    {
        return Some(Implausible::OtherModulation {
            stated_hz: modulation_hz,
            share,
        });
    }
    if share.min(pickup.norm()) < SMALLEST_MODULATION {
        return None;
    }
    let lead_s = (pickup * drive.conj()).arg() / (TAU * modulation_hz);
    (lead_s > GREATEST_LEAD_S).then_some(Implausible::ChannelsExchanged { lead_s })
}

/// Returns the finding of a damping without a finger that depends on the amplitude, although a plate alone has one: it falls where a
/// film lifts a finger, and grows where a channel or an amplifier is at its end, so that the plate moves less than the drive says.
#[must_use]
pub fn amplitude_dependence(frames: &[ZmFrame]) -> Option<Implausible> {
    let clear = || frames.iter().filter(|frame| frame.mask.is_clear());
    let mut amplitudes: Vec<f64> = clear().map(|frame| frame.amplitude_m).collect();
    amplitudes.sort_by(f64::total_cmp);
    let [low_m, high_m] = [0.25, 0.75].map(|share| statistics::quantile(&amplitudes, share));
    let (low_m, high_m) = (low_m?, high_m?);
    let damping = |is_taken: &dyn Fn(f64) -> bool| {
        let loaded = clear().filter(|frame| is_taken(frame.amplitude_m));
        let sums = loaded.fold((0.0, 0.0), |(weights, sum), frame| {
            let weight = frame.corrected_std_n_s_per_m.powi(-2);
            let is_usable = weight.is_finite() && frame.corrected_n_s_per_m.is_finite();
            let weight = if is_usable { weight } else { 0.0 };
            (
                weights + weight,
                sum + weight
                    * if is_usable {
                        frame.corrected_n_s_per_m.re
                    } else {
                        0.0
                    },
            )
        });
        (sums.1 / sums.0, CORRELATED_FRAMES / sums.0)
    };
    let ((low, low_variance), (high, high_variance)) =
        (damping(&|m| m < low_m), damping(&|m| m > high_m));
    let excess_n_s_per_m = low - high;
    let std = (low_variance + high_variance).sqrt();
    let least_n_s_per_m = SMALLEST_EXCESS_N_S_PER_M.max(CERTAIN_ERRORS * std);
    if excess_n_s_per_m > least_n_s_per_m {
        return Some(Implausible::FingerOnPlate { excess_n_s_per_m });
    }
    let growth = -excess_n_s_per_m / low;
    let is_certain = -excess_n_s_per_m > least_n_s_per_m && growth > SMALLEST_GROWTH;
    is_certain.then_some(Implausible::Compression { growth })
}

#[cfg(test)]
mod tests {
    use impedance::Mask;

    use super::*;

    fn transient(mass_ratio: f64) -> Transient {
        Transient {
            phase_rad: 0.0,
            phase_error_rad: 1e-3,
            delay_s: 0.0,
            delay_error_s: 1e-6,
            mass_ratio,
            mass_error: 1e-3,
            mass_angle_rad: 0.0,
            residual: 1e-3,
        }
    }

    #[test]
    fn a_response_with_a_telling_factor_is_that_of_a_scale() {
        for ratio in [2f64.sqrt(), 1.98, 0.7, 2.3] {
            assert!(is_of_scale(&transient(ratio), 0.0), "{ratio}");
        }
        for ratio in [1.05, 1.2, 1.3] {
            assert!(!is_of_scale(&transient(ratio), 0.0), "{ratio}");
        }
        // Within the stated error of the scales.
        assert!(is_of_scale(&transient(1.36), 0.02));
    }

    #[test]
    fn telling_factors_and_other_quantities_are_named() {
        assert_eq!(plate_scale(&transient(1.05), 0.005), None);
        for (ratio, words) in [
            (20.0, "20, as the gain"),
            (0.051, "1/20, as the gain"),
            (1.43, "√2, as RMS"),
            (0.49, "1/2, as peak-to-peak"),
            (2.9, "2√2, as peak-to-peak values in place of RMS"),
        ] {
            let found = plate_scale(&transient(ratio), 0.005).unwrap();
            assert!(found.to_string().contains(words), "{found}");
            assert!(found.spoils_estimates());
        }
        let far = plate_scale(&transient(1.0 / (TAU * 35e3)), 0.005).unwrap();
        assert!(
            matches!(far, Implausible::Scale { .. }) && far.spoils_plate(),
            "{far:?}"
        );
        assert_eq!(pickup_quantity(0.3), None);
        for (turn_rad, words) in [
            (-FRAC_PI_2, "a velocity"),
            (-PI, "an acceleration"),
            (3.1, "an acceleration"),
        ] {
            let found = pickup_quantity(turn_rad).unwrap();
            assert!(found.to_string().contains(words), "{found}");
        }
    }

    #[test]
    fn a_telling_factor_is_the_cause_within_the_errors_and_else_the_nearest() {
        let found = plate_scale(&transient(2.72), 0.005).unwrap();
        assert!(
            matches!(found, Implausible::Scale { near: Some(_), .. }) && found.spoils_estimates(),
            "{found:?}"
        );
        let words = "2√2 is a usual factor, and 4 % from it";
        assert!(found.to_string().contains(words), "{found}");
        let uncertain = plate_scale(&transient(2.72), 0.02).unwrap();
        assert!(
            matches!(uncertain, Implausible::ScaleFactor { .. }),
            "{uncertain:?}"
        );
        let other = plate_scale(&transient(3.5), 0.005).unwrap();
        assert_eq!(
            other,
            Implausible::Scale {
                ratio: 3.5,
                near: None
            }
        );
    }

    /// Frames of a plate alone at 2 kHz, with an envelope that is late and a damping that depends on the amplitude, N·s/m.
    fn frames(late_s: f64, damping: impl Fn(f64) -> f64) -> Vec<ZmFrame> {
        let frame = |step: u32| {
            let time_s = f64::from(step) / 2000.0;
            let envelope = |time_s: f64| 1.0 + 0.9 * (TAU * 6.0 * time_s).sin();
            let amplitude_m = 1e-6 * envelope(time_s - late_s);
            ZmFrame {
                sample: u64::from(step),
                time_s,
                mask: Mask::CLEAR,
                drive_v: Complex64::new(20.0 * envelope(time_s), 0.0),
                displacement_m: Complex64::ONE,
                amplitude_m,
                amplitude_rate_m_per_s: 0.0,
                amplitude_std_m: 1e-9,
                plain_n_s_per_m: Complex64::ONE,
                plain_std_n_s_per_m: 0.01,
                corrected_n_s_per_m: Complex64::new(damping(amplitude_m), 0.0),
                corrected_std_n_s_per_m: 0.01,
            }
        };
        (0..1600).map(frame).collect()
    }

    #[test]
    fn a_damping_that_depends_on_the_amplitude_is_a_finger_or_a_compression() {
        let found = |damping: fn(f64) -> f64| amplitude_dependence(&frames(0.0, damping));
        assert_eq!(found(|_| 7.0), None);
        assert_eq!(found(|amplitude_m| 7.0 + 0.1 * amplitude_m / 2e-6), None);
        assert!(matches!(
            found(|amplitude_m| 8.0 - amplitude_m / 2e-6),
            Some(Implausible::FingerOnPlate { .. })
        ));
        let Some(Implausible::Compression { growth }) =
            found(|amplitude_m| 7.0 + 1.2 * amplitude_m / 2e-6)
        else {
            panic!("no compression");
        };
        assert!((0.1..0.18).contains(&growth), "{growth}");
    }

    #[test]
    fn a_drive_that_follows_the_pickup_is_exchanged_with_it() {
        let frames = |late_s: f64| frames(late_s, |_| 1.0);
        assert_eq!(envelopes(&frames(2.3e-3), 6.0, 0.95), None);
        assert_eq!(
            envelopes(&frames(2.3e-3)[..400], 6.0, 0.95),
            None,
            "too short"
        );
        let found = envelopes(&frames(-2.3e-3), 6.0, 0.95);
        assert!(
            matches!(found, Some(Implausible::ChannelsExchanged { .. })),
            "{found:?}"
        );
    }
}
