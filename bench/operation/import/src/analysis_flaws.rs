//! Flaws of a converted recording that its analysis will name, in terms of the map.

use std::path::Path;

use analysis::Settings;
use analysis::flaw::Flaw;
use analysis::recording_analysis;
use plausibility::{Implausible, LARGEST_N};

use crate::refusal::ImportRefusal;
use crate::series::Samples;
use crate::tare;

/// Delay of forces with stated times from which on they are refused, s: intervals and the pickup's phase were found with these times.
const REFUSED_S: f64 = 0.01;
/// The same for the rate of their clock, ppm.
const REFUSED_PPM: f64 = 1e4;

/// Keys of the map that scale the electrical half.
const ELECTRICAL: &str =
    "drive.volts_per_unit, pickup.metres_per_unit and pickup.quantity, and [plate]";

/// Returns the flaws of the recording in `folder` that its map may have caused; none if it cannot be read yet.
fn flaws(folder: &Path) -> Vec<Flaw> {
    let flaws = recording_analysis::flaws(folder, &Settings::default());
    let is_of_map = |flaw: &Flaw| {
        matches!(
            flaw,
            Flaw::Implausible(_)
                | Flaw::ZeroTail { .. }
                | Flaw::HeldTail { .. }
                | Flaw::ElsewhereInTime { .. }
                | Flaw::Sparse { .. }
                | Flaw::CarrierElsewhere { .. }
                | Flaw::PickupPhase { .. }
                | Flaw::PickupLate { .. }
                | Flaw::PlateMass { .. }
                | Flaw::PlateReactance { .. }
        )
    };
    let flaws = flaws.unwrap_or_default();
    flaws.into_iter().filter(is_of_map).collect()
}

/// Returns the flaws of the recording in `folder` in words, each with the keys of the map that it may lie in.
pub(crate) fn remarks(folder: &Path) -> Vec<String> {
    flaws(folder).iter().map(words).collect()
}

/// Requires that forces with stated times act when contact and friction show it.
pub(crate) fn require_times(folder: &Path) -> Result<Vec<String>, ImportRefusal> {
    let flaws = flaws(folder);
    let deviation = |flaw: &Flaw| match flaw {
        Flaw::Implausible(Implausible::ForcesLate {
            late_s,
            half_width95_s,
        }) if late_s.abs() > REFUSED_S => Some(format!(
            "come {:.1} ± {:.1} ms {}",
            1e3 * late_s.abs(),
            1e3 * half_width95_s,
            if *late_s > 0.0 { "late" } else { "early" }
        )),
        Flaw::Implausible(Implausible::ForcesClock {
            ppm,
            half_width95_ppm,
        }) if ppm.abs() > REFUSED_PPM => Some(format!(
            "are on a clock that is {:.0} ± {half_width95_ppm:.0} ppm {}",
            ppm.abs(),
            if *ppm > 0.0 { "slow" } else { "fast" }
        )),
        _ => None,
    };
    match flaws.iter().find_map(deviation) {
        Some(deviation) => Err(ImportRefusal::ForceTimes { deviation }),
        None => Ok(flaws.iter().map(words).collect()),
    }
}

/// Returns the refusal of a value that cannot be found, with the flaws of the recording as the map has it, which may be the cause: those
/// that need no times of the forces, if there are any. `explorations` states how they were found, in words.
pub(crate) fn refusal(
    refusal: ImportRefusal,
    folder: &Path,
    explorations: Option<&str>,
) -> ImportRefusal {
    let ImportRefusal::NotFound { key, reason } = refusal else {
        return refusal;
    };
    let reason = match explorations {
        Some(explorations) => format!("{reason}; {explorations}"),
        None => reason,
    };
    let flaws = flaws(folder);
    let mut certain = flaws.clone();
    certain.retain(|flaw| !needs_times(flaw));
    let shown = if certain.is_empty() { flaws } else { certain };
    let flaws: Vec<String> = shown.iter().map(words).collect();
    match flaws.is_empty() {
        true => ImportRefusal::NotFound { key, reason },
        false => ImportRefusal::Misread {
            key,
            reason,
            flaws: flaws.join("; "),
        },
    }
}

/// Returns whether a flaw is one of forces while the finger slides, which needs their times.
fn needs_times(flaw: &Flaw) -> bool {
    let Flaw::Implausible(implausible) = flaw else {
        return false;
    };
    matches!(
        implausible,
        Implausible::Friction { .. }
            | Implausible::Crosstalk { .. }
            | Implausible::LateralSign
            | Implausible::LateralUnsigned
            | Implausible::LateralLag { .. }
            | Implausible::LateralAlone { .. }
            | Implausible::StrokesZero { .. }
            | Implausible::ExchangedByStrokes { .. }
            | Implausible::FrictionDiffers { .. }
            | Implausible::FrictionLag { .. }
            | Implausible::FrictionUnlike { .. }
            | Implausible::ForcesLate { .. }
            | Implausible::ForcesClock { .. }
            | Implausible::ForcesUnclear { .. }
            | Implausible::ForcesUnplaced { .. }
            | Implausible::PositionsLate { .. }
            | Implausible::Backwards
            | Implausible::OffCentre { .. }
            | Implausible::OtherSpeed { .. }
            | Implausible::Light { .. }
            | Implausible::SmallForces { .. }
            | Implausible::ContactArea { .. }
            | Implausible::Amplitude { .. }
    )
}

/// Returns the refusal of a tare for which no stretch without contact was found.
pub(crate) fn untared(key: &'static str, normal: Option<&Samples>) -> ImportRefusal {
    let reason = "no stretch is without contact by the rule or the marks of [intervals]".to_owned();
    let greatest_n = normal.map_or(0.0, |samples| {
        let sizes = samples.values.iter().map(|value| value.abs());
        let sizes = sizes.filter(|size| size.is_finite());
        let mut sizes: Vec<f64> = sizes.collect();
        sizes.sort_by(f64::total_cmp);
        statistics::quantile(&sizes, 0.95).unwrap_or(0.0)
    });
    let rest_n = normal.and_then(tare::resting_level).unwrap_or_default();
    let flaw = if greatest_n > LARGEST_N {
        Implausible::Size {
            normal_n: greatest_n,
        }
    } else if rest_n.abs() > tare::REST_N {
        Implausible::Untared { normal_n: rest_n }
    } else {
        return ImportRefusal::NotFound { key, reason };
    };
    ImportRefusal::Misread {
        key,
        reason,
        flaws: words(&flaw.into()),
    }
}

/// Returns a flaw in words, with the keys of the map that it may lie in.
fn words(flaw: &Flaw) -> String {
    match keys(flaw) {
        Some(keys) => format!("{flaw} (in the map: {keys})"),
        None => flaw.to_string(),
    }
}

/// Returns the keys of the map that a flaw may lie in, with what to write; `None` if the map has no part in it.
fn keys(flaw: &Flaw) -> Option<&'static str> {
    let Flaw::Implausible(implausible) = flaw else {
        return match flaw {
            Flaw::ElsewhereInTime { .. } => {
                Some("time, seconds_per_unit or offset_s of that stream")
            }
            Flaw::CarrierElsewhere { .. } => Some("carrier.hz or drive.rate_hz"),
            Flaw::PickupPhase { .. } | Flaw::PickupLate { .. } => Some(
                "pickup.phase_rad and pickup.quantity, drive.volts_per_unit, pickup.metres_per_unit, [plate]",
            ),
            Flaw::PlateMass { .. } | Flaw::PlateReactance { .. } => Some(ELECTRICAL),
            _ => None,
        };
    };
    Some(match implausible {
        Implausible::Size { .. }
        | Implausible::Light { .. }
        | Implausible::SmallForces { .. }
        | Implausible::Friction { .. }
        | Implausible::ContactArea { .. } => "newtons_per_unit of [normal] and [lateral]",
        Implausible::Sign { .. } => "turn the sign of normal.newtons_per_unit",
        Implausible::LateralSign => "turn the sign of lateral.newtons_per_unit",
        Implausible::Untared { .. } => "normal.tare = \"no contact\"",
        Implausible::FingerUnloaded { .. } | Implausible::FingerOnPlate { .. } => {
            "intervals.unloaded, or the marks"
        }
        Implausible::Exchanged { .. }
        | Implausible::ExchangedByStrokes { .. }
        | Implausible::LateralAlone { .. } => "exchange from of [normal] and [lateral]",
        Implausible::LateralLag { .. } => "rate_hz or time and offset_s of [lateral]",
        Implausible::PositionJumps { .. } => "position.wrap_bits",
        Implausible::Alike => "name another array in from of [normal] or [lateral]",
        Implausible::ForcesLate { .. }
        | Implausible::ForcesClock { .. }
        | Implausible::ForcesUnclear { .. }
        | Implausible::ForcesUnplaced { .. } => "rate_hz or time, offset_s and ppm of [normal]",
        Implausible::StrokesZero { .. } => "lateral.tare = \"symmetric strokes\"",
        Implausible::PositionUnit { .. } | Implausible::OtherSpeed { .. } => {
            "position.metres_per_unit"
        }
        Implausible::Backwards => "turn the sign of position.metres_per_unit",
        Implausible::OffCentre { .. } => "plate.centre_m and position.metres_per_unit",
        Implausible::ChannelsExchanged { .. } => "exchange from of [drive] and [pickup]",
        Implausible::PickupQuantity { .. } => "pickup.quantity",
        Implausible::OtherModulation { .. } => "modulation.hz or drive.rate_hz",
        Implausible::Carrier { .. } => "carrier.hz and plate.resonance_hz",
        Implausible::Amplitude { .. }
        | Implausible::LargeAmplitude { .. }
        | Implausible::ScaleFactor { .. }
        | Implausible::Scale { .. } => ELECTRICAL,
        _ => return None,
    })
}
