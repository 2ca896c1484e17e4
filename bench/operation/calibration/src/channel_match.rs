//! Comparison of drive and pickup with their calibration, by one tone at the resonance of the bare plate.
//!
//! The ratio of pickup to drive is divided by the calibrated one. The inverse is Z_p now over Z_p at the calibration: 1 without
//! a change, with the detuning 2Q Δf/f₀ as its imaginary part. Any other value is matched against the known faults of channels.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// Largest relative change of the damping that is accepted.
const DAMPING: f64 = 0.1;
/// Largest accepted detuning, in half-bandwidths: a plate warms by some kelvin.
const DETUNING: f64 = 0.3;
/// Share of the calibrated signal below which the pickup is silent: a finger removes only half of the signal.
const SILENT: f64 = 0.02;
/// Largest slip considered, samples.
const SLIPS: i32 = 4;

/// The calibrated response and the constants needed to compare with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Envelope of the pickup over that of the drive at the resonance, sample units.
    pub ratio: Complex64,
    /// Frequency of the resonance and of the tone, Hz.
    pub resonance_hz: f64,
    /// Quality factor.
    pub quality: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
}

/// A difference of the channels from their calibration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ChannelFault {
    /// The cables of drive and pickup are on each other's inputs.
    #[error("drive and pickup are swapped: exchange their cables, or their indices in bench.toml")]
    Swapped,
    /// The pickup reads only crosstalk.
    #[error(
        "the pickup's input is silent, {share:.1e} of what was calibrated: its cable is out, or [channels.pickup] names another input"
    )]
    Silent {
        /// Ratio of the present level to the calibrated one.
        share: f64,
    },
    /// The pickup has the wrong polarity.
    #[error("the pickup is inverted: its wires are exchanged")]
    Inverted,
    /// One channel is late by whole samples.
    #[error(
        "the pickup has slipped by {samples:+} samples against the drive ({phase_rad:+.2} rad at the carrier): the sound layer does not keep the channels together; reopen the device, use a raw one, or calibrate the plate again"
    )]
    Slipped {
        /// Delay beyond the calibrated one, samples.
        samples: i32,
        /// Delay as a phase at the carrier, rad.
        phase_rad: f64,
    },
    /// The plate's resonance has shifted, or a finger or an object rests on the plate.
    #[error(
        "the plate answers as if its resonance had moved by {shift_hz:+.1} Hz and its damping by {damping_percent:+.0} %: a finger rests on it, or it has drifted; clear it, then calibrate the plate again"
    )]
    Loaded {
        /// Apparent shift, Hz.
        shift_hz: f64,
        /// Apparent change of damping, %.
        damping_percent: f64,
    },
    /// The response has a different magnitude, but the same phase.
    #[error(
        "the pickup reads {ratio:.2} times what was calibrated: a gain was changed, or a finger rests on the plate"
    )]
    Gain {
        /// Ratio of the present level to the calibrated one.
        ratio: f64,
    },
}

/// Returns the distance from the calibrated response; values up to 1 are accepted.
fn distance(relative: Complex64) -> f64 {
    let impedance = relative.inv();
    if !impedance.is_finite() {
        return f64::INFINITY;
    }
    ((impedance.re - 1.0) / DAMPING)
        .abs()
        .max((impedance.im / DETUNING).abs())
}

/// Compares a measured ratio of pickup to drive, in sample units.
///
/// # Errors
/// [`ChannelFault`] with the most likely fault.
pub fn compare(measured: Complex64, expected: Expected) -> Result<(), ChannelFault> {
    let relative = measured / expected.ratio;
    if distance(relative) <= 1.0 {
        return Ok(());
    }
    let share = relative.norm();
    if share < SILENT {
        return Err(ChannelFault::Silent { share });
    }
    let turn = TAU * expected.resonance_hz / expected.rate_hz;
    let slipped = (-SLIPS..=SLIPS).filter(|&k| k != 0).map(|samples| {
        let phase_rad = -turn * f64::from(samples);
        let fault = ChannelFault::Slipped { samples, phase_rad };
        (distance(relative * Complex64::cis(-phase_rad)), fault)
    });
    let alternatives = [
        (
            distance(measured.inv() / expected.ratio),
            ChannelFault::Swapped,
        ),
        (distance(-relative), ChannelFault::Inverted),
    ];
    let likeliest = alternatives
        .into_iter()
        .chain(slipped)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((misfit, fault)) = likeliest
        && misfit <= 1.0
    {
        return Err(fault);
    }
    let impedance = relative.inv();
    Err(if impedance.im.abs() > DETUNING && impedance.re > 0.0 {
        ChannelFault::Loaded {
            shift_hz: -impedance.im * expected.resonance_hz / (2.0 * expected.quality),
            damping_percent: 100.0 * (impedance.re - 1.0),
        }
    } else {
        ChannelFault::Gain {
            ratio: relative.norm(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Expected {
        Expected {
            ratio: Complex64::from_polar(0.7, -2.0),
            resonance_hz: 35e3,
            quality: 250.0,
            rate_hz: 192e3,
        }
    }

    #[test]
    fn a_small_drift_passes() {
        let e = expected();
        for impedance in [
            Complex64::ONE,
            Complex64::new(1.05, 0.2),
            Complex64::new(0.95, -0.25),
        ] {
            assert_eq!(compare(e.ratio / impedance, e), Ok(()));
        }
    }

    #[test]
    fn each_fault_has_its_name() {
        let e = expected();
        assert_eq!(compare(e.ratio.inv(), e), Err(ChannelFault::Swapped));
        assert_eq!(compare(-e.ratio, e), Err(ChannelFault::Inverted));
        for samples in [-2, -1, 1, 2] {
            let late = Complex64::cis(-TAU * 35e3 / 192e3 * f64::from(samples));
            let fault = compare(e.ratio * late * 1.02, e).unwrap_err();
            assert!(
                matches!(fault, ChannelFault::Slipped { samples: k, .. } if k == samples),
                "{samples}: {fault}"
            );
        }
        let finger = (Complex64::new(7.0, 0.0) + Complex64::new(0.47, 3.16)) / 7.0;
        assert!(matches!(
            compare(e.ratio / finger, e),
            Err(ChannelFault::Loaded { shift_hz, .. }) if shift_hz < -20.0
        ));
        assert!(matches!(
            compare(e.ratio * 1e-4, e),
            Err(ChannelFault::Silent { .. })
        ));
        assert!(matches!(
            compare(e.ratio * 0.5, e),
            Err(ChannelFault::Gain { ratio }) if (ratio - 0.5).abs() < 1e-12
        ));
    }
}
