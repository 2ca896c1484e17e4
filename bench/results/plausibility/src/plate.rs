//! Scales, quantity and order of drive and pickup, by the answer of the free plate to its own modulation.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use force_alignment::TellingFactor;
use impedance::{Transient, ZmFrame};
use num_complex::Complex64;
use statistics::wrap_rad;

use crate::Implausible;

/// Largest distance of a phase from that of another quantity, rad.
const PHASE_RAD: f64 = 0.25;
/// Tolerance of a telling factor, relative: three standard errors of an assumed modal mass, force factor and pickup.
const FACTOR_TOLERANCE: f64 = 0.1;
/// Ratio of the scales, or its inverse, beyond which no number of the plate has a meaning.
const GREATEST_RATIO: f64 = 1.9;
/// Lead of the pickup beyond which the channels are exchanged, s: converters delay a channel by less.
const GREATEST_LEAD_S: f64 = 0.3e-3;
/// Fewest periods of the modulation by which a lead is read.
const FEWEST_PERIODS: f64 = 2.0;
/// Smallest modulation of both envelopes relative to their means.
const SMALLEST_MODULATION: f64 = 0.1;

/// Quantity that a pickup may read in place of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A velocity, which leads by a quarter of a turn.
    Velocity,
    /// An acceleration, or a displacement of the other sign.
    Acceleration,
}

impl Quantity {
    pub(crate) fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => (
                "a velocity",
                "divide metres_per_unit by 2π·carrier_hz and take π/2 from phase_rad",
            ),
            Self::Acceleration => (
                "an acceleration, or of a displacement of the other sign",
                "divide metres_per_unit by (2π·carrier_hz)² if it is one, and take π from phase_rad",
            ),
        }
    }
}

/// Returns the findings of the free plate's answer to the modulation; `transient` must be clear.
#[must_use]
pub fn plate(transient: &Transient) -> Vec<Implausible> {
    let is_near = |phase_rad: f64| wrap_rad(transient.phase_rad - phase_rad).abs() < PHASE_RAD;
    let quantity = if is_near(-FRAC_PI_2) {
        Some(Quantity::Velocity)
    } else {
        is_near(PI).then_some(Quantity::Acceleration)
    };
    let ratio = transient.mass_ratio;
    let factor = TellingFactor::of_ratio(ratio, FACTOR_TOLERANCE);
    let is_off = ratio.is_nan() || ratio.max(ratio.recip()) > GREATEST_RATIO;
    let quantity = quantity.map(|quantity| Implausible::PickupQuantity { quantity });
    let scale = match factor {
        Some(factor) => Some(Implausible::ScaleFactor { ratio, factor }),
        None => is_off.then_some(Implausible::Scale { ratio }),
    };
    quantity.into_iter().chain(scale).collect()
}

/// Returns the finding of a pickup whose envelope leads that of the drive, by frames of the free plate: a plate follows its drive.
#[must_use]
pub fn channel_order(frames: &[ZmFrame], modulation_hz: f64) -> Option<Implausible> {
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
    if drive.norm().min(pickup.norm()) < SMALLEST_MODULATION {
        return None;
    }
    let lead_s = (pickup * drive.conj()).arg() / (TAU * modulation_hz);
    (lead_s > GREATEST_LEAD_S).then_some(Implausible::ChannelsExchanged { lead_s })
}

#[cfg(test)]
mod tests {
    use impedance::Mask;

    use super::*;

    fn transient(phase_rad: f64, mass_ratio: f64) -> Transient {
        Transient {
            phase_rad,
            phase_error_rad: 1e-3,
            delay_s: 0.0,
            delay_error_s: 1e-6,
            mass_ratio,
            residual: 1e-3,
        }
    }

    #[test]
    fn telling_factors_and_other_quantities_are_named() {
        assert_eq!(plate(&transient(0.1, 1.05)), []);
        for (ratio, words) in [
            (20.0, "20, as the gain"),
            (0.051, "1/20, as the gain"),
            (1.43, "1.41, as RMS"),
            (0.49, "1/2, as peak-to-peak"),
            (2.9, "2.83, as peak-to-peak values in place of RMS"),
        ] {
            let [found] = &plate(&transient(0.0, ratio))[..] else {
                panic!("{ratio}");
            };
            assert!(found.to_string().contains(words), "{found}");
            assert!(found.spoils_estimates());
        }
        let found = plate(&transient(-FRAC_PI_2, 1.0 / (TAU * 35e3)));
        assert!(found[0].to_string().contains("a velocity"), "{found:?}");
        assert!(found.iter().any(Implausible::spoils_estimates));
    }

    #[test]
    fn a_drive_that_follows_the_pickup_is_exchanged_with_it() {
        let frames = |late_s: f64| -> Vec<ZmFrame> {
            let frame = |step: u32| {
                let time_s = f64::from(step) / 2000.0;
                let envelope = |time_s: f64| 1.0 + 0.9 * (TAU * 6.0 * time_s).sin();
                ZmFrame {
                    sample: u64::from(step),
                    time_s,
                    mask: Mask::CLEAR,
                    drive_v: Complex64::new(20.0 * envelope(time_s), 0.0),
                    displacement_m: Complex64::ONE,
                    amplitude_m: 1e-6 * envelope(time_s - late_s),
                    amplitude_rate_m_per_s: 0.0,
                    amplitude_std_m: 1e-9,
                    plain_n_s_per_m: Complex64::ONE,
                    plain_std_n_s_per_m: 0.01,
                    corrected_n_s_per_m: Complex64::ONE,
                    corrected_std_n_s_per_m: 0.01,
                }
            };
            (0..1600).map(frame).collect()
        };
        assert_eq!(channel_order(&frames(2.3e-3), 6.0), None);
        assert_eq!(
            channel_order(&frames(2.3e-3)[..400], 6.0),
            None,
            "too short"
        );
        let found = channel_order(&frames(-2.3e-3), 6.0);
        assert!(
            matches!(found, Some(Implausible::ChannelsExchanged { .. })),
            "{found:?}"
        );
    }
}
