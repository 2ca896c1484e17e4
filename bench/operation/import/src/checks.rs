//! Mistakes that show while importing, each refused by name.

use std::f64::consts::TAU;

use import_map::{Carrier, ImportMap, Modulation, Quantity, Rate, TimeBase};
use recording::manifest::FoundValue;

use crate::readings::{DriveTime, Readings};
use crate::refusal::ImportRefusal;
use crate::series::Samples;
use crate::survey::{CarrierFrequency, Envelope};
use metrology::drive_modulation::{FoundModulation, HarmonicFit, ModulationError, harmonic_fit};

/// Difference from which on a carrier is another, Hz; two clocks differ by less.
const OTHER_CARRIER_HZ: f64 = 10.0;
/// Relative difference from which on a modulation is another.
const OTHER_MODULATION: f64 = 0.02;
/// Relative difference from which on streams that were recorded together do not last alike.
const OTHER_LENGTH: f64 = 0.02;
/// Time for which forces go on after the drive from which on the drive may be cut off, s.
const LONGEST_AFTER_S: f64 = 0.5;
/// Lead of the pickup's amplitude from which on drive and pickup are exchanged, s, and in standard errors.
const LEAD_S: f64 = 0.1e-3;
const LEAD_ERRORS: f64 = 5.0;

/// Compares carrier and modulation of the map with those of the drive; returns carrier, modulation's frequency and index.
pub(crate) fn tone(
    (carrier, modulation): (Carrier, Modulation),
    (measured, modulated): (
        Option<CarrierFrequency>,
        Result<FoundModulation, ModulationError>,
    ),
    rate_hz: f64,
    found: &mut Vec<FoundValue>,
) -> Result<[f64; 3], ImportRefusal> {
    let is_modulated = modulated.ok().filter(|modulated| modulated.index > 0.0);
    let unmodulated = |key| match modulated {
        Err(reason) => ImportRefusal::Undriven { key, reason },
        Ok(_) => ImportRefusal::NoModulation { key },
    };
    if let (Carrier::Constant(Quantity::Stated(stated_hz)), Some(measured)) = (carrier, measured) {
        let factor = measured.hz / stated_hz;
        let modulation_factor = modulation
            .hz
            .stated()
            .zip(is_modulated)
            .map(|(stated, found)| found.hz / stated);
        if (measured.hz - stated_hz).abs() > OTHER_CARRIER_HZ {
            return Err(match modulation_factor {
                Some(other)
                    if (other / factor - 1.0).abs() < OTHER_MODULATION
                        && (factor - 1.0).abs() > OTHER_MODULATION =>
                {
                    ImportRefusal::DriveRate {
                        stated_hz: rate_hz,
                        factor,
                        meant_hz: rate_hz / factor,
                    }
                }
                _ => ImportRefusal::Carrier {
                    stated_hz,
                    found_hz: measured.hz,
                },
            });
        }
    }
    if let (Carrier::Constant(_), Some(measured)) = (carrier, measured)
        && measured.range_hz > 2.0 * OTHER_CARRIER_HZ
    {
        return Err(ImportRefusal::CarrierMoves {
            range_hz: measured.range_hz,
        });
    }
    let carrier_hz = match (carrier, measured) {
        (Carrier::Constant(Quantity::Stated(hz)), _) => hz,
        (Carrier::Follows, Some(measured)) => measured.hz,
        (Carrier::Constant(Quantity::Found), Some(measured)) => {
            found.push(FoundValue {
                name: "carrier.hz".to_owned(),
                value: measured.hz,
                error: Some(measured.error_hz),
                unit: "Hz".to_owned(),
                evidence:
                    "rotation of the drive's envelope about the strongest tone of its spectrum"
                        .to_owned(),
            });
            measured.hz
        }
        (_, None) => {
            return Err(ImportRefusal::NotFound {
                key: "carrier.hz",
                reason: "the drive is on for too short a time".to_owned(),
            });
        }
    };
    let modulation_hz = match (modulation.hz, is_modulated) {
        (Quantity::Stated(stated_hz), Some(modulated))
            if stated_hz > 0.0
                && modulated.index > 0.02
                && (modulated.hz / stated_hz - 1.0).abs() > OTHER_MODULATION
                && (modulated.hz - stated_hz).abs() > 5.0 * modulated.hz_error =>
        {
            return Err(ImportRefusal::Modulation {
                stated_hz,
                found_hz: modulated.hz,
            });
        }
        (Quantity::Stated(hz), _) => hz,
        (Quantity::Found, Some(modulated)) => {
            found.push(FoundValue {
                name: "modulation.hz".to_owned(),
                value: modulated.hz,
                error: Some(modulated.hz_error),
                unit: "Hz".to_owned(),
                evidence: "least squares of the drive's amplitude".to_owned(),
            });
            modulated.hz
        }
        (Quantity::Found, None) => return Err(unmodulated("hz")),
    };
    let index = match (modulation.index, is_modulated) {
        (Quantity::Stated(index), _) => index,
        (Quantity::Found, Some(modulated)) => {
            found.push(FoundValue {
                name: "modulation.index".to_owned(),
                value: modulated.index.min(1.0),
                error: Some(modulated.index_error),
                unit: String::new(),
                evidence: "least squares of the drive's amplitude".to_owned(),
            });
            modulated.index.min(1.0)
        }
        (Quantity::Found, None) => return Err(unmodulated("index")),
    };
    Ok([carrier_hz, modulation_hz, index])
}

/// Refuses a drive that follows the pickup: the plate's amplitude follows its voltage by 2 m/b, some milliseconds.
pub(crate) fn exchanged(
    [drive, pickup]: [&Envelope; 2],
    modulation_hz: f64,
    unloaded_s: &[(f64, f64)],
) -> Result<(), ImportRefusal> {
    if modulation_hz <= 0.0 {
        return Ok(());
    }
    let step_s = drive.step_s;
    let count = drive.values.len().min(pickup.values.len());
    let stretches: Vec<(f64, f64)> = match unloaded_s {
        [] => vec![(drive.time_s(0), drive.time_s(count))],
        stretches => stretches.to_vec(),
    };
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut leads = Vec::new();
    for (from_s, to_s) in stretches {
        let index =
            |time_s: f64| (((time_s - drive.first_s) / step_s).ceil().max(0.0) as usize).min(count);
        // Whole periods, so that the mean does not leak into the harmonic.
        let periods = ((to_s - from_s) * modulation_hz).floor();
        if periods < 1.0 {
            continue;
        }
        let range = index(from_s)..index(from_s + periods / modulation_hz);
        let amplitude = |channel: &Envelope| -> Vec<f64> {
            channel.values[range.clone()]
                .iter()
                .map(|value| value.norm())
                .collect()
        };
        let fits =
            [drive, pickup].map(|channel| harmonic_fit(&amplitude(channel), step_s, modulation_hz));
        let n = range.len() as f64;
        // Phase error of a harmonic in noise; that of 20 values is alike.
        let error = |fit: HarmonicFit| {
            (2.0 * fit.residual / n / (n / 20.0).max(1.0)).sqrt() / fit.amplitude
        };
        if fits
            .iter()
            .any(|fit| fit.amplitude.is_nan() || fit.amplitude <= 0.05 * fit.mean)
        {
            continue;
        }
        let lead_rad =
            (fits[1].phase_rad - fits[0].phase_rad + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        let variance = fits
            .into_iter()
            .map(|fit| error(fit).powi(2))
            .sum::<f64>()
            .max(1e-12);
        sum += lead_rad / variance;
        weight += 1.0 / variance;
        leads.push(lead_rad);
    }
    if weight == 0.0 {
        return Ok(());
    }
    let omega = TAU * modulation_hz;
    let (lead_s, error_s) = (sum / weight / omega, weight.powf(-0.5) / omega);
    let agree = leads.iter().all(|lead| *lead > 0.0);
    if agree && lead_s > LEAD_S && lead_s > LEAD_ERRORS * error_s {
        return Err(ImportRefusal::Exchanged {
            lag_ms: 1e3 * lead_s,
        });
    }
    Ok(())
}

/// Requires that forces and positions overlap the drive; returns a sentence for a user if the forces go on for long after it.
pub(crate) fn overlap(
    readings: &Readings,
    drive: DriveTime,
) -> Result<Option<String>, ImportRefusal> {
    let streams = [
        ("normal", &readings.normal),
        ("lateral", &readings.lateral),
        ("position", &readings.position),
    ];
    for (stream, samples) in streams {
        let Some(samples) = samples else { continue };
        let (from_s, to_s) = (samples.drive_s(0), samples.drive_s(samples.len() - 1));
        if to_s < 0.0 || from_s > drive.duration_s {
            let origin_s = samples.origin_s(drive.first_s);
            return Err(ImportRefusal::Apart {
                stream,
                span_s: (from_s + origin_s, to_s + origin_s),
                drive_s: (origin_s, origin_s + drive.duration_s),
                offset_s: samples.clock.offset_s + origin_s - from_s,
            });
        }
    }
    let after_s = readings.normal.as_ref().map_or(0.0, |normal| {
        normal.drive_s(normal.len() - 1) - drive.duration_s
    });
    Ok((after_s > LONGEST_AFTER_S).then(|| {
        format!(
            "the forces go on for {after_s:.2} s after the last sample of the drive, and are left out there: compare the length of the drive \
             with the original"
        )
    }))
}

/// Returns the remark about a position that lasts longer or shorter than drive and forces, which agree.
pub(crate) fn position_rate(
    map: &ImportMap,
    readings: &Readings,
    drive: DriveTime,
) -> Option<String> {
    let TimeBase::Rate(_) = map.position.as_ref()?.time else {
        return None;
    };
    let duration_s = |samples: &Samples| samples.drive_s(samples.len() - 1) - samples.drive_s(0);
    let position = readings.position.as_ref()?;
    let (position_s, force_s) = (duration_s(position), duration_s(readings.normal.as_ref()?));
    let differs = |length_s: f64| (position_s / length_s - 1.0).abs() > OTHER_LENGTH;
    let agree = (force_s / drive.duration_s - 1.0).abs() < OTHER_LENGTH / 2.0;
    (agree && differs(drive.duration_s)).then(|| {
        format!(
            "position lasts {position_s:.2} s, and drive and forces last {:.2} s: if it was recorded as long, position.rate_hz is {} Hz",
            drive.duration_s,
            statistics::significant((position.len() as f64 / drive.duration_s).round())
        )
    })
}

/// Refuses a rate of the forces with which they last a multiple of the drive, if the friction shows it.
pub(crate) fn force_rate(
    map: &ImportMap,
    readings: &Readings,
    modulation_hz: f64,
    drive: DriveTime,
) -> Result<(), ImportRefusal> {
    let (Some(normal), Some(lateral)) = (&map.normal, &readings.lateral) else {
        return Ok(());
    };
    let TimeBase::Rate(Rate::Hz(stated_hz)) = normal.time else {
        return Ok(());
    };
    let length_s = lateral.drive_s(lateral.len() - 1) - lateral.drive_s(0);
    let factor = drive.duration_s / length_s;
    if (0.9..1.1).contains(&factor) || modulation_hz <= 0.0 {
        return Ok(());
    }
    // Stretched by the factor, the forces are as long as the drive.
    let [as_stated, as_meant] =
        [modulation_hz, modulation_hz * factor].map(|hz| line_amplitude(lateral, hz));
    if as_meant > 5.0 * as_stated {
        return Err(ImportRefusal::ForceRate {
            stated_hz,
            factor,
            meant_hz: stated_hz / factor,
        });
    }
    Ok(())
}

/// Returns the amplitude of a line in a force, in which slower changes are left out.
fn line_amplitude(force: &Samples, hz: f64) -> f64 {
    let (time_s, values) = force.coarse();
    let count = values.len();
    if count < 4 {
        return 0.0;
    }
    let step_s = (time_s[count - 1] - time_s[0]) / (count - 1) as f64;
    let period = ((1.0 / (hz * step_s)).round() as usize).max(2);
    let mut amplitudes: Vec<f64> = values
        .chunks_exact(3 * period)
        .map(|part| harmonic_fit(part, step_s, hz).amplitude)
        .filter(|amplitude| amplitude.is_finite())
        .collect();
    amplitudes.sort_by(f64::total_cmp);
    amplitudes
        .get(amplitudes.len() * 3 / 4)
        .copied()
        .unwrap_or(0.0)
}

/// Returns the middle between the ends of the finger's travel, m; 0 without positions.
pub(crate) fn middle_of_travel(readings: &Readings, notes: &mut Vec<String>) -> f64 {
    let Some(position) = &readings.position else {
        return 0.0;
    };
    let strokes = readings.intervals.strokes();
    let (time_s, places) = position.coarse();
    let is_in_stroke = |time_s: f64| {
        strokes
            .iter()
            .any(|(_, from_s, to_s)| (*from_s..=*to_s).contains(&time_s))
    };
    let range = |all: bool| {
        let pairs = time_s
            .iter()
            .zip(&places)
            .filter(|(time_s, place)| place.is_finite() && (all || is_in_stroke(**time_s)));
        pairs.fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), (_, place)| (low.min(*place), high.max(*place)),
        )
    };
    let (low, high) = match range(strokes.is_empty()) {
        (low, high) if low <= high => (low, high),
        _ => range(true),
    };
    if low > high {
        return 0.0;
    }
    let middle_m = 0.5 * (low + high);
    notes.push(format!("the plate's centre is at {middle_m:.4} m, the middle of the travel from {low:.4} to {high:.4} m"));
    middle_m
}
