//! Drive and pickup among channels with a carrier.

use crate::carrier::{CLIPPED, Carrier};
use crate::names::Role;
use crate::portrait::VectorPortrait;
use crate::units::UnitMeaning;

/// Two channels with a carrier, and the evidence which of them is the drive.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DrivePair {
    /// Index of the drive among the channels given.
    pub drive: usize,
    /// Index of the pickup.
    pub pickup: usize,
    /// Evidence, in words.
    pub evidence: String,
    /// Whether the evidence is clear.
    pub is_sure: bool,
}

/// Least delay of a pickup's envelope that is evidence, s: the envelope of a plate of quality Q follows by Q/(π f0).
const LEAST_DELAY_S: f64 = 5e-5;
/// Delay that no difference of two cables or filters has, s.
const CLEAR_DELAY_S: f64 = 3e-4;
/// Least spread of a level that is evidence, relative to the level, and its ratio to the other's.
const LEAST_SPREAD: f64 = 0.04;
const SPREAD_RATIO: f64 = 2.0;
/// Ratio of harmonics that is evidence: the plate passes fewer of them.
const DISTORTION_RATIO: f64 = 4.0;
/// Least evidence that is clear, in units of a name.
const CLEAR: f64 = 2.0;

/// A reason to take the first of two channels for the drive, or, with a negative weight, the second.
struct Evidence {
    weight: f64,
    text: String,
}

/// Finds drive and pickup; `None` with fewer than two channels.
pub(crate) fn drive_pair(channels: &[(&VectorPortrait, &Carrier)]) -> Option<DrivePair> {
    let mut best: Option<(f64, DrivePair)> = None;
    for first in 0..channels.len() {
        for second in first + 1..channels.len() {
            let (a, b) = (channels[first], channels[second]);
            // A pair has one carrier and one length.
            let is_pair = a.0.length == b.0.length
                && (a.1.frequency_hz / b.1.frequency_hz - 1.0).abs() < 1e-3;
            if !is_pair {
                continue;
            }
            let evidence = evidence(a, b);
            let sum: f64 = evidence.iter().map(|evidence| evidence.weight).sum();
            let (drive, pickup) = if sum >= 0.0 {
                (first, second)
            } else {
                (second, first)
            };
            let is_contradicted = evidence
                .iter()
                .any(|evidence| evidence.weight * sum < 0.0 && evidence.weight.abs() >= 1.0);
            let texts: Vec<String> = evidence.into_iter().map(|evidence| evidence.text).collect();
            let evidence = match texts.is_empty() {
                true => {
                    "nothing tells drive from pickup: taken in the order of the file".to_owned()
                }
                false => texts.join("; "),
            };
            let is_clipped = a.1.clipped_share.max(b.1.clipped_share) > CLIPPED;
            let is_sure = sum.abs() >= CLEAR && !is_contradicted && !is_clipped;
            let found = DrivePair {
                drive,
                pickup,
                evidence,
                is_sure,
            };
            if best.as_ref().is_none_or(|(most, _)| sum.abs() > *most) {
                best = Some((sum.abs(), found));
            }
        }
    }
    let (_, mut pair) = best?;
    // A third channel with the carrier is a second pickup or a monitor.
    pair.is_sure &= channels.len() == 2 || pair.evidence.contains("named");
    Some(pair)
}

fn evidence(a: (&VectorPortrait, &Carrier), b: (&VectorPortrait, &Carrier)) -> Vec<Evidence> {
    let mut list = Vec::new();
    let (first, second) = (&a.0.name, &b.0.name);
    let mut add = |weight: f64, text: String| list.push(Evidence { weight, text });
    for (portrait, sign) in [(a.0, 1.0), (b.0, -1.0)] {
        match portrait.role() {
            Some((Role::Drive, word)) => add(
                2.0 * sign,
                format!("`{}` is named {word:?}, a drive", portrait.name),
            ),
            Some((Role::Pickup, word)) => add(
                -2.0 * sign,
                format!("`{}` is named {word:?}, a pickup", portrait.name),
            ),
            // A velocity at the carrier is that of a vibrometer.
            Some((Role::Velocity, word)) => add(
                -1.5 * sign,
                format!(
                    "`{}` is named {word:?}, a vibrometer's velocity",
                    portrait.name
                ),
            ),
            _ => {}
        }
        let is_motion = matches!(
            portrait.unit_meaning(),
            Some(
                UnitMeaning::Metres(_)
                    | UnitMeaning::MetresPerSecond(_)
                    | UnitMeaning::MetresPerSquareSecond(_)
            )
        );
        if is_motion {
            let unit = portrait.unit_text().unwrap_or_default();
            add(
                -2.0 * sign,
                format!("`{}` is in {unit}, a pickup's unit", portrait.name),
            );
        }
    }
    let delay = match (&a.1.modulation, &b.1.modulation) {
        (Some(earlier), Some(later)) if a.0.rate.is_some() => later.delay_s(earlier),
        _ => None,
    };
    if let Some(delay_s) = delay.filter(|delay_s| delay_s.abs() > LEAST_DELAY_S) {
        let (later, earlier) = if delay_s > 0.0 {
            (second, first)
        } else {
            (first, second)
        };
        let text = format!(
            "the envelope of `{later}` is {:.2} ms later than that of `{earlier}`, as a resonant plate's",
            1e3 * delay_s.abs()
        );
        let weight = if delay_s.abs() > CLEAR_DELAY_S {
            2.5
        } else {
            1.5
        };
        add(weight * delay_s.signum(), text);
    }
    let (spread, other) = (a.1.unsteadiness, b.1.unsteadiness);
    if spread.max(other) > LEAST_SPREAD && spread.max(other) > SPREAD_RATIO * spread.min(other) {
        let (looser, sign) = if other > spread {
            (second, 1.0)
        } else {
            (first, -1.0)
        };
        let text = format!(
            "the level of `{looser}` varies by {:.0} %, that of the other by {:.0} %: a finger damps the plate",
            100.0 * spread.max(other),
            100.0 * spread.min(other)
        );
        add(1.5 * sign, text);
    }
    if let (Some(harmonics), Some(other)) = (a.1.distortion, b.1.distortion)
        && harmonics.max(other) > 1e-3
        && harmonics.max(other) > DISTORTION_RATIO * harmonics.min(other)
    {
        let (purer, sign) = if other < harmonics {
            (second, 1.0)
        } else {
            (first, -1.0)
        };
        add(
            0.5 * sign,
            format!("`{purer}` has fewer harmonics, as the plate's motion"),
        );
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periodicity::Periodicity;
    use crate::portrait::{RateOrigin, StatedRate};

    fn portrait(name: &str) -> VectorPortrait {
        VectorPortrait {
            name: name.to_owned(),
            length: 1_000,
            rate: Some(StatedRate {
                hz: 192e3,
                origin: RateOrigin::File,
            }),
            ..VectorPortrait::default()
        }
    }

    fn carrier(delay_s: f64, unsteadiness: f64) -> Carrier {
        let phase_rad = statistics::wrap_rad(-std::f64::consts::TAU * 6.0 * delay_s);
        Carrier {
            frequency_hz: 35e3,
            amplitude: 1.0,
            modulation: Some(Periodicity {
                frequency_hz: 6.0,
                index: 0.95,
                phase_rad,
            }),
            unsteadiness,
            distortion: None,
            clipped_share: 0.0,
        }
    }

    #[test]
    fn the_later_envelope_that_a_finger_damps_is_the_pickup() {
        let (a, b) = (portrait("ch0"), portrait("ch1"));
        for (channels, drive) in [
            ([(&a, &carrier(0.0, 0.01)), (&b, &carrier(9e-4, 0.3))], 0),
            ([(&a, &carrier(9e-4, 0.3)), (&b, &carrier(0.0, 0.01))], 1),
        ] {
            let pair = drive_pair(&channels).unwrap();
            assert_eq!(
                (pair.drive, pair.pickup, pair.is_sure),
                (drive, 1 - drive, true),
                "{pair:?}"
            );
            assert!(pair.evidence.contains("0.90 ms later"), "{pair:?}");
        }
    }

    #[test]
    fn names_decide_and_contradictions_are_doubted() {
        let (a, b) = (portrait("ldv"), portrait("U"));
        let pair = drive_pair(&[(&a, &carrier(9e-4, 0.3)), (&b, &carrier(0.0, 0.01))]).unwrap();
        assert_eq!((pair.drive, pair.is_sure), (1, true), "{pair:?}");
        let pair = drive_pair(&[(&a, &carrier(0.0, 0.01)), (&b, &carrier(9e-4, 0.3))]).unwrap();
        assert!(!pair.is_sure, "{pair:?}");
        let pair = drive_pair(&[
            (&portrait("a"), &carrier(0.0, 0.01)),
            (&portrait("b"), &carrier(0.0, 0.01)),
        ])
        .unwrap();
        assert!(
            !pair.is_sure && pair.evidence.contains("order of the file"),
            "{pair:?}"
        );
        assert_eq!(drive_pair(&[(&a, &carrier(0.0, 0.0))]), None);
    }
}
