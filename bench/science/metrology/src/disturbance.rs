//! Disturbances of a channel: a constant offset, mains hum, foreign tones.

use std::fmt;

use crate::spectrum::{Peak, Spectrum};

/// Highest frequency at which a tone counts as mains hum, Hz.
const HUM_HZ: f64 = 1e3;
/// Distance from a multiple of the mains frequency within which a tone counts as that harmonic, Hz.
const MAINS_WIDTH_HZ: f64 = 3.0;
/// Distance from the carrier within which a tone falls into the envelope's band, Hz.
const ENVELOPE_BAND_HZ: f64 = 2.5e3;
/// Distance from the carrier within which modulation, ramps and the finger move it, Hz.
const MOVED_HZ: f64 = 400.0;
/// Highest harmonic of the carrier that an amplifier generates.
const HARMONICS: u32 = 9;
/// Largest number of disturbances reported for a channel: one source has many harmonics.
const MOST: usize = 5;
/// Amplitude, relative to full scale, from which on an offset, hum or a tone outside the carrier's band is reported: the signal
/// loses a hundredth of the range. An assumption.
const OUT_OF_BAND: f64 = 0.01;
/// Amplitude of a tone in the carrier's band from which on it is reported, relative to full scale and to the carrier: it biases
/// the impedance by the same fraction. Assumptions.
const BAND_AMPLITUDE: f64 = 1e-3;
const BAND_CARRIER_SHARE: f64 = 0.01;

/// Sort of a disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// A constant offset.
    Offset,
    /// The mains or one of its harmonics.
    Hum,
    /// A tone within the envelope's band, which demodulation cannot reject.
    InBand,
    /// A tone elsewhere.
    OutOfBand,
}

impl Sort {
    /// Returns the sort of a tone on a channel with its drive at `carrier_hz`.
    #[must_use]
    pub fn of_tone(hz: f64, carrier_hz: f64) -> Self {
        let is_mains = |mains_hz: f64| {
            let multiple = (hz / mains_hz).round();
            multiple >= 1.0 && (hz - multiple * mains_hz).abs() < MAINS_WIDTH_HZ
        };
        if hz < HUM_HZ && (is_mains(50.0) || is_mains(60.0)) {
            Self::Hum
        } else if (hz - carrier_hz).abs() < ENVELOPE_BAND_HZ {
            Self::InBand
        } else {
            Self::OutOfBand
        }
    }
}

/// A disturbance of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Sort of the disturbance.
    pub sort: Sort,
    /// Frequency, Hz; 0 for an offset.
    pub frequency_hz: f64,
    /// Size of the offset, or peak amplitude of the tone, relative to full scale.
    pub amplitude: f64,
}

impl Disturbance {
    /// Returns whether both come from the same source.
    #[must_use]
    pub fn is_again(&self, other: &Self) -> bool {
        self.sort == other.sort
            && (self.frequency_hz - other.frequency_hz).abs() < 2.0 * MAINS_WIDTH_HZ
    }
}

impl fmt::Display for Disturbance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (hz, level_db) = (self.frequency_hz, 20.0 * self.amplitude.log10());
        match self.sort {
            Sort::Offset => write!(
                f,
                "a constant offset of {:.3} of full scale",
                self.amplitude
            ),
            Sort::Hum => write!(f, "mains hum at {hz:.0} Hz, {level_db:.0} dB of full scale"),
            Sort::InBand => write!(
                f,
                "a foreign tone in the carrier's band at {hz:.0} Hz, {level_db:.0} dB of full scale, which biases Z_m"
            ),
            Sort::OutOfBand => write!(
                f,
                "a foreign tone at {hz:.0} Hz, {level_db:.0} dB of full scale"
            ),
        }
    }
}

/// Returns the disturbances of a channel with its drive, if any, at `carrier_hz`: the offset first, then tones by
/// amplitude, at most five.
///
/// ```
/// use metrology::disturbance::{Sort, disturbances};
/// use metrology::spectrum::Spectrum;
/// use std::f64::consts::TAU;
///
/// let hum: Vec<f32> = (0..48_000)
///     .map(|n| (0.02 * (TAU * 50.0 * f64::from(n) / 192e3).sin()) as f32)
///     .collect();
/// let spectrum = Spectrum::read(&hum, 1, 0, 192e3, 10.0)?;
/// let found = disturbances(&spectrum, 35e3, 192e3);
/// assert_eq!(found.len(), 1);
/// assert_eq!(found[0].sort, Sort::Hum);
/// assert_eq!(found[0].to_string(), "mains hum at 50 Hz, -34 dB of full scale");
/// # Ok::<(), metrology::spectrum::SpectrumError>(())
/// ```
#[must_use]
pub fn disturbances(spectrum: &Spectrum, carrier_hz: f64, sample_rate_hz: f64) -> Vec<Disturbance> {
    let peaks = spectrum.peaks();
    let carrier = peaks
        .iter()
        .find(|peak| (peak.frequency_hz - carrier_hz).abs() < 2.0 * spectrum.resolution_hz())
        .map_or(0.0, |peak| peak.amplitude);
    let is_driven = carrier > BAND_AMPLITUDE;
    let harmonics: Vec<f64> = (1..=HARMONICS)
        .map(|order| folded(carrier_hz * f64::from(order), sample_rate_hz))
        .collect();
    let is_carrier = |tone: &Peak| {
        let near = |hz: &f64| (tone.frequency_hz - hz).abs() < MOVED_HZ;
        is_driven && harmonics.iter().any(near)
    };
    let offset = Disturbance {
        sort: Sort::Offset,
        frequency_hz: 0.0,
        amplitude: spectrum.mean.abs(),
    };
    let tones = peaks.iter().filter(|tone| !is_carrier(tone));
    let tones = tones.map(|tone| Disturbance {
        sort: Sort::of_tone(tone.frequency_hz, carrier_hz),
        frequency_hz: tone.frequency_hz,
        amplitude: tone.amplitude,
    });
    let counts = |disturbance: &Disturbance| {
        let least = match disturbance.sort {
            Sort::InBand => BAND_AMPLITUDE.max(BAND_CARRIER_SHARE * carrier),
            _ => OUT_OF_BAND,
        };
        disturbance.amplitude > least
    };
    std::iter::once(offset)
        .chain(tones)
        .filter(counts)
        .take(MOST)
        .collect()
}

/// Returns the frequency at which a tone appears after sampling.
fn folded(hz: f64, sample_rate_hz: f64) -> f64 {
    (hz - sample_rate_hz * (hz / sample_rate_hz).round()).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    const RATE_HZ: f64 = 192e3;

    /// A quarter of a second of a driven, distorted and noisy channel, with these tones.
    fn disturbances_of(
        drive: f64,
        modulation_hz: f64,
        offset: f64,
        tones: &[(f64, f64)],
    ) -> Vec<Disturbance> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(12);
        let samples: Vec<f32> = (0..48_000)
            .map(|n| {
                let t = f64::from(n) / RATE_HZ;
                let envelope = drive * (1.0 + 0.95 * (TAU * modulation_hz * t).sin());
                let carrier = envelope * (TAU * 35e3 * t).cos();
                let noise: f64 = StandardNormal.sample(&mut rng);
                let foreign = tones.iter().map(|(hz, a)| a * (TAU * hz * t + 1.0).sin());
                let distorted = carrier + 0.2 * carrier.powi(2) + 0.2 * carrier.powi(3);
                (offset + distorted + 1e-5 * noise + foreign.sum::<f64>()) as f32
            })
            .collect();
        let spectrum = Spectrum::read(&samples, 1, 0, RATE_HZ, 10.0).unwrap();
        disturbances(&spectrum, 35e3, RATE_HZ)
    }

    /// Fault 12.
    #[test]
    fn offset_hum_and_foreign_tones_are_named_beside_the_drive_and_in_silence() {
        for (drive, modulation_hz) in [(0.0, 0.0), (0.2, 6.0), (0.2, 20.0)] {
            // The square of the drive adds an offset.
            let offset = 0.06;
            for (hz, amplitude, sort) in [
                (50.0, 0.02, Sort::Hum),
                (60.0, 0.02, Sort::Hum),
                (150.0, 0.02, Sort::Hum),
                (440.0, 0.02, Sort::OutOfBand),
                (12_345.0, 0.02, Sort::OutOfBand),
                (33_200.0, 0.008, Sort::InBand),
                (35_700.0, 0.008, Sort::InBand),
                (80_000.0, 0.02, Sort::OutOfBand),
            ] {
                let list = disturbances_of(drive, modulation_hz, offset, &[(hz, amplitude)]);
                let [first, tone] = list[..] else {
                    panic!("{hz} Hz under a drive of {drive}: {list:?}");
                };
                assert_eq!(first.sort, Sort::Offset);
                assert!((0.05..0.09).contains(&first.amplitude), "{first:?}");
                assert_eq!(tone.sort, sort, "{tone:?}");
                assert!((tone.frequency_hz - hz).abs() < 1.5, "{tone:?}");
                assert!((tone.amplitude / amplitude - 1.0).abs() < 0.05, "{tone:?}");
                assert!(tone.is_again(&tone) && !tone.is_again(&first));
            }
        }
    }

    #[test]
    fn a_clean_channel_and_small_tones_disturb_nobody() {
        let small = [(50.0, 0.008), (12_345.0, 0.008), (36_000.0, 0.0015)];
        assert_eq!(disturbances_of(0.0, 0.0, 0.0, &[]), []);
        assert_eq!(disturbances_of(0.2, 20.0, -0.011, &small), []);
    }

    #[test]
    fn tones_fold_at_half_the_rate() {
        for (hz, seen_hz) in [(35e3, 35e3), (105e3, 87e3), (175e3, 17e3), (210e3, 18e3)] {
            assert_eq!(folded(hz, RATE_HZ), seen_hz);
        }
    }
}
