//! The path from the generator to an input: whether the carrier comes back, and at its own frequency.
//!
//! Sound layers resample without a warning. A layer that filters removes the carrier. One that does not filter folds it to
//! |k·f′ ± f| about its own rate f′, and the frequency at which it comes back reveals the rate.

use crate::spectrum::Peak;

/// Response of the path to one tone.
#[derive(Clone, Debug, PartialEq)]
pub struct ToneAnswer {
    /// Frequency played, Hz.
    pub played_hz: f64,
    /// Amplitude at that frequency relative to the amplitude expected.
    pub share: f64,
    /// Tones that stood out while it was played, strongest first; amplitudes relative to the amplitude expected.
    pub peaks: Vec<Peak>,
}

/// Reasons why a path does not carry the carrier unchanged.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PathFault {
    /// The tone does not come back at any frequency.
    #[error(
        "nothing comes back: {share:.1e} of the played tone was read; is the amplifier on, its heartbeat wired, and \
         the cable in the input that [channels.drive] names?"
    )]
    Silent {
        /// Largest fraction of the played amplitude that came back.
        share: f64,
    },
    /// Low frequencies come back and the carrier does not.
    #[error(
        "the path is resampled: {passes_hz:.0} Hz comes back, {loses_hz:.0} Hz does not, as through a sound layer of {rate_hz:.0} Hz: use a raw device such as hw:…, set the server to the bench's rate, or look for an amplifier that ends there"
    )]
    Resampled {
        /// Highest tone below which all come back, Hz.
        passes_hz: f64,
        /// Lowest tone that does not, Hz.
        loses_hz: f64,
        /// Lowest common rate that is more than twice the frequency of every tone that still leaks through, Hz.
        rate_hz: f64,
    },
    /// The carrier comes back at another frequency.
    #[error(
        "the path is aliased: {played_hz:.0} Hz comes back at {heard_hz:.0} Hz, folded about a rate of {rate_hz:.0} Hz: a sound layer resamples without a filter; use a raw device such as hw:…, or set the server to the bench's rate"
    )]
    Aliased {
        /// Tone played, Hz.
        played_hz: f64,
        /// Frequency at which it came back, Hz.
        heard_hz: f64,
        /// Rate inferred from it, Hz.
        rate_hz: f64,
    },
}

/// Common rates of sound layers. If several explain the tones, the highest is named: folding about 48 kHz is
/// also folding about 16 kHz.
const COMMON_RATES_HZ: [f64; 11] = [
    192_000.0, 176_400.0, 96_000.0, 88_200.0, 48_000.0, 44_100.0, 32_000.0, 24_000.0, 22_050.0,
    16_000.0, 8_000.0,
];
/// Smallest fraction of a tone that counts as coming back.
pub const COMES_BACK: f64 = 0.3;
/// Smallest fraction of a filtered tone that still leaks through.
const SEEPS: f64 = 1e-3;
/// Smallest relative amplitude of an image that cannot come from a converter.
const IMAGE: f64 = 1e-2;

/// Judges the responses to tones: those within `band_hz` of the carrier, which must come back, and others below, which
/// show where a path ends. `resolution_hz` is that of the peaks' frequencies.
///
/// # Errors
/// [`PathFault`], with the frequencies that show it.
pub fn judge(
    answers: &[ToneAnswer],
    carrier_hz: f64,
    band_hz: f64,
    sample_rate_hz: f64,
    resolution_hz: f64,
) -> Result<(), PathFault> {
    let near: Vec<&ToneAnswer> = answers
        .iter()
        .filter(|answer| (answer.played_hz - carrier_hz).abs() <= band_hz)
        .collect();
    if let Some(fault) = aliased(&near, sample_rate_hz, resolution_hz) {
        return Err(fault);
    }
    if near.iter().all(|answer| answer.share >= COMES_BACK) {
        return Ok(());
    }
    let mut by_frequency: Vec<&ToneAnswer> = answers.iter().collect();
    by_frequency.sort_by(|a, b| a.played_hz.total_cmp(&b.played_hz));
    let lost = by_frequency
        .iter()
        .position(|answer| answer.share < COMES_BACK)
        .unwrap_or(by_frequency.len() - 1);
    if lost == 0 {
        let share = answers
            .iter()
            .map(|answer| answer.share)
            .fold(0.0, f64::max);
        return Err(PathFault::Silent { share });
    }
    let (passes_hz, loses_hz) = (
        by_frequency[lost - 1].played_hz,
        by_frequency[lost].played_hz,
    );
    // A filter begins below half its rate, so the tones that leak through beyond it determine the rate better.
    let seeps_hz = by_frequency
        .iter()
        .filter(|answer| answer.share >= SEEPS)
        .map(|answer| answer.played_hz)
        .fold(passes_hz, f64::max);
    Err(PathFault::Resampled {
        passes_hz,
        loses_hz,
        rate_hz: COMMON_RATES_HZ
            .iter()
            .rev()
            .find(|rate_hz| **rate_hz / 2.0 > seeps_hz)
            .copied()
            .unwrap_or(2.0 * loses_hz),
    })
}

/// Returns the fault if every tone is folded about one rate by the same law.
fn aliased(near: &[&ToneAnswer], sample_rate_hz: f64, resolution_hz: f64) -> Option<PathFault> {
    let first = near.first()?;
    let close = |a: f64, b: f64| (a - b).abs() <= resolution_hz;
    let strong = |answer: &ToneAnswer, at_hz: f64| {
        answer
            .peaks
            .iter()
            .any(|peak| peak.amplitude >= IMAGE && close(peak.frequency_hz, at_hz))
    };
    let lower = |rate_hz: &&f64| **rate_hz < 0.999 * sample_rate_hz;
    COMMON_RATES_HZ.iter().filter(lower).find_map(|&rate_hz| {
        let multiples = (sample_rate_hz / rate_hz) as u32 + 1;
        (1..=multiples)
            .flat_map(|k| [(k, 1.0), (k, -1.0)])
            .find_map(|(k, sign)| {
                let image = |hz: f64| (f64::from(k) * rate_hz + sign * hz).abs();
                let heard_hz = image(first.played_hz);
                let is_image = heard_hz < sample_rate_hz / 2.0 && !close(heard_hz, first.played_hz);
                let all_images = near
                    .iter()
                    .all(|answer| strong(answer, image(answer.played_hz)));
                (is_image && all_images).then_some(PathFault::Aliased {
                    played_hz: first.played_hz,
                    heard_hz,
                    rate_hz,
                })
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONES_HZ: [f64; 9] = [5e3, 10e3, 14e3, 18e3, 21e3, 23e3, 34.5e3, 35e3, 35.5e3];

    /// Judges a path that turns each tone into the pairs of frequency and relative amplitude of `law`.
    fn path(law: impl Fn(f64) -> Vec<(f64, f64)>) -> Result<(), PathFault> {
        let answers: Vec<ToneAnswer> = TONES_HZ
            .iter()
            .map(|&played_hz| {
                let tones = law(played_hz);
                let share = tones.iter().find(|(hz, _)| *hz == played_hz);
                ToneAnswer {
                    played_hz,
                    share: share.map_or(1e-6, |(_, share)| *share),
                    peaks: tones
                        .iter()
                        .map(|&(hz, amplitude)| Peak {
                            // Frequencies are read to a fraction of the resolution.
                            frequency_hz: hz + 6.0,
                            amplitude,
                        })
                        .collect(),
                }
            })
            .collect();
        judge(&answers, 35e3, 1e3, 192e3, 20.0)
    }

    #[test]
    fn a_raw_path_with_hum_and_distortion_passes() {
        assert_eq!(
            path(|hz| vec![(hz, 0.98), (50.0, 0.2), (2.0 * hz, 0.05), (13e3, 0.3)]),
            Ok(())
        );
    }

    /// Fault 1.
    #[test]
    fn a_filtered_path_is_named_with_its_rate() {
        for (rate_hz, passes) in [
            (48e3, 23e3),
            (44_100.0, 21e3),
            (32e3, 14e3),
            (22_050.0, 10e3),
        ] {
            let ends = |hz| {
                if hz < rate_hz / 2.0 {
                    vec![(hz, 0.9)]
                } else {
                    vec![]
                }
            };
            let Err(PathFault::Resampled {
                passes_hz,
                rate_hz: named,
                ..
            }) = path(ends)
            else {
                panic!("{rate_hz}");
            };
            assert_eq!((passes_hz, named), (passes, rate_hz));
        }
    }

    /// Fault 1.
    #[test]
    fn a_folded_carrier_is_named_with_the_rate_it_points_to() {
        for (rate_hz, image_hz) in [
            (48e3, 13.5e3),
            (44_100.0, 9.6e3),
            (32e3, 2.5e3),
            (24e3, 10.5e3),
        ] {
            let folds = |hz: f64| vec![((hz - rate_hz * (hz / rate_hz).round()).abs(), 0.9)];
            let Err(PathFault::Aliased {
                played_hz,
                heard_hz,
                rate_hz: suspect_hz,
            }) = path(folds)
            else {
                panic!("{rate_hz}");
            };
            assert_eq!((played_hz, suspect_hz), (34.5e3, rate_hz));
            assert!((heard_hz - image_hz).abs() < 1e-6, "{rate_hz}: {heard_hz}");
        }
    }

    #[test]
    fn images_in_addition_to_the_carrier_are_aliases_too() {
        let steps = |hz: f64| vec![(hz, 0.8), ((48e3 - hz).abs(), 0.4)];
        assert!(matches!(
            path(steps),
            Err(PathFault::Aliased { rate_hz: 48e3, .. })
        ));
    }

    #[test]
    fn silence_is_no_resampler() {
        assert!(matches!(path(|_| vec![]), Err(PathFault::Silent { .. })));
    }
}
