//! Constants of the recordings: dates of measurement, age and values.

use config::{CalibrationFile, Quantity};
use jiff::Timestamp;
use maud::{Markup, html};
use recording::Manifest;
use recording::manifest::RecordedSignals;
use study::sessions::CALIBRATION_FILE;

use crate::content::{RecordingEntry, ReportContent};
use crate::number::{NumberFormat, count_text, date, significant};

const S_PER_DAY: f64 = 86_400.0;
const DAYS: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 1,
};

/// Calibration, and the sessions that used it.
struct CalibrationUse {
    hash: String,
    file: CalibrationFile,
    /// Start of the first session with it.
    first_start: Option<Timestamp>,
    sessions: usize,
}

pub(crate) fn calibration(
    content: &ReportContent<'_>,
    recordings: &[RecordingEntry<'_>],
) -> Markup {
    let (uses, errors) = calibration_uses(content);
    let n_uncalibrated = recordings
        .iter()
        .filter(|recording| recording.result.uncalibrated)
        .count();
    html! {
        @if n_uncalibrated > 0 {
            p.alert {
                (count_text(n_uncalibrated, "recording was", "recordings were"))
                " made without a calibration: their constants are those of the configuration, and were not measured."
            }
        }
        @for reason in &errors { p.alert { "A session's copy of its calibration cannot be read: " (reason) } }
        @for calibration_use in &uses { (calibration_table(calibration_use)) }
        (constants(recordings))
    }
}

fn calibration_uses(content: &ReportContent<'_>) -> (Vec<CalibrationUse>, Vec<String>) {
    let (mut uses, mut errors) = (Vec::<CalibrationUse>::new(), Vec::new());
    for (folder, session) in &content.sessions.list {
        let Ok(session) = session else { continue };
        let Some(text) = content.sessions.calibrations.get(folder) else {
            continue;
        };
        let path = folder.join(CALIBRATION_FILE);
        let calibration = text.as_ref().map_err(String::clone).and_then(|text| {
            CalibrationFile::parse(text, &path).map_err(|error| error.to_string())
        });
        let (file, hash) = match calibration {
            Ok(calibration) => calibration,
            Err(reason) => {
                errors.push(reason);
                continue;
            }
        };
        let start = session
            .start
            .as_ref()
            .and_then(|start| start.time.parse().ok());
        match uses.iter_mut().find(|entry| entry.hash == hash) {
            Some(entry) => {
                entry.sessions += 1;
                entry.first_start = entry.first_start.into_iter().chain(start).min();
            }
            None => uses.push(CalibrationUse {
                hash,
                file,
                first_start: start,
                sessions: 1,
            }),
        }
    }
    (uses, errors)
}

/// Part of a calibration: its name, its date, its quantities by name.
type Part<'a> = (&'static str, Timestamp, Vec<(&'static str, &'a Quantity)>);

fn calibration_table(calibration_use: &CalibrationUse) -> Markup {
    let file = &calibration_use.file;
    let mut parts: Vec<Part<'_>> = Vec::new();
    if let Some(pickup) = &file.pickup {
        let mut values = vec![
            ("sensitivity", &pickup.metres_per_unit),
            ("offset", &pickup.offset),
        ];
        values.extend(pickup.phase_rad.as_ref().map(|phase| ("phase", phase)));
        parts.push(("pickup", pickup.measured.date, values));
    }
    if let Some(plate) = &file.plate {
        let mut values = vec![
            ("resonance", &plate.resonance_hz),
            ("quality factor", &plate.quality),
            ("damping", &plate.damping_n_s_per_m),
            ("stiffness", &plate.stiffness_n_per_m),
            ("force factor", &plate.force_factor_n_per_v),
            ("phase of the pickup", &plate.pickup_phase_rad),
        ];
        values.extend(
            plate
                .force_phase_rad
                .as_ref()
                .map(|phase| ("phase of the force", phase)),
        );
        parts.push(("plate", plate.measured.date, values));
    }
    if let Some(profile) = &file.profile {
        let values = vec![(
            "largest deviation along the plate",
            &profile.largest_departure,
        )];
        parts.push(("amplitude along the plate", profile.measured.date, values));
    }
    if let Some(across) = &file.across {
        let values = [
            ("wavelength", &across.wavelength_m),
            ("crest from the finger's line", &across.crest_m),
        ];
        let values = values
            .into_iter()
            .filter_map(|(name, value)| Some((name, value.as_ref()?)));
        parts.push((
            "amplitude across the plate",
            across.measured.date,
            values.collect(),
        ));
    }
    if let Some(force) = &file.force {
        let values = vec![
            ("normal per normal", &force.normal_per_normal),
            ("normal per lateral", &force.normal_per_lateral),
            ("lateral per normal", &force.lateral_per_normal),
            ("lateral per lateral", &force.lateral_per_lateral),
            ("normal tare", &force.normal_tare),
            ("lateral tare", &force.lateral_tare),
        ];
        parts.push(("force sensor", force.measured.date, values));
    }
    if let Some(channels) = &file.channels {
        let values = vec![
            ("round trip", &channels.round_trip),
            ("latency", &channels.latency),
        ];
        parts.push(("channels", channels.measured.date, values));
    }
    let age = |measurement_date: Timestamp| {
        let first_start = calibration_use.first_start?;
        Some(first_start.duration_since(measurement_date).as_secs_f64() / S_PER_DAY)
    };
    html! {
        h3 { "Calibration " code { (calibration_use.hash.chars().take(12).collect::<String>()) } }
        p.note {
            "Used in " (count_text(calibration_use.sessions, "session", "sessions")) ". Age: days before the first session."
        }
        div.wide { table {
            thead { tr {
                th { "Part" } th { "Measured on" } th.n { "Age (days)" } th { "Quantity" } th.n { "Value ± standard error" }
                th { "Unit" }
            } }
            tbody { @for (part, measurement_date, values) in &parts {
                @for (index, (name, quantity)) in values.iter().enumerate() {
                    tr.first[index == 0] {
                        @if index == 0 {
                            th scope="row" rowspan=(values.len()) { (part) }
                            td rowspan=(values.len()) { (date(*measurement_date)) }
                            td.n rowspan=(values.len()) { (DAYS.value(age(*measurement_date))) }
                        }
                        td { (name) }
                        td.n { (constant_text(quantity.value)) " ± " (significant(Some(quantity.standard_error))) }
                        td { (quantity.unit) }
                    }
                }
            } }
        } }
    }
}

/// Returns a constant with seven significant digits.
fn constant_text(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e8).contains(&size) {
        let text = format!("{value:.6e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        return format!("{mantissa}e{exponent}").replace('-', "−");
    }
    let decimals = if size < 1.0 {
        7
    } else {
        6_usize.saturating_sub(size.log10() as usize)
    };
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    text.replace('-', "−")
}

/// Returns the constants of a recording, each with its name and unit.
fn manifest_constants(manifest: &Manifest) -> Vec<(&'static str, f64, &'static str)> {
    let mut constants = Vec::new();
    if let Some(RecordedSignals { channels, .. }) = manifest.signals() {
        constants.extend([
            (
                "drive, volts per sample value",
                channels.drive.volts_per_unit,
                "V",
            ),
            (
                "pickup, displacement per sample value",
                channels.pickup.metres_per_unit,
                "m",
            ),
            ("pickup, phase", channels.pickup.phase_rad, "rad"),
        ]);
    }
    if let Some(plate) = manifest.plate() {
        constants.extend([
            ("plate, resonance", plate.resonance_hz, "Hz"),
            ("plate, modal mass", plate.modal_mass_kg, "kg"),
            ("plate, force factor", plate.force_factor_n_per_v, "N/V"),
        ]);
    }
    if let Some(errors) = &manifest.standard_errors {
        let percent = 100.0;
        constants.extend([
            (
                "error of amplitudes",
                percent * errors.amplitude_relative,
                "%",
            ),
            (
                "error of impedances",
                percent * errors.impedance_relative,
                "%",
            ),
            (
                "error of the pickup's phase",
                errors.pickup_phase_rad,
                "rad",
            ),
            (
                "error of normal forces",
                percent * errors.normal_force_relative,
                "%",
            ),
            (
                "error of lateral forces",
                percent * errors.lateral_force_relative,
                "%",
            ),
            (
                "error of lateral forces, of the normal force",
                percent * errors.lateral_per_normal,
                "%",
            ),
        ]);
    }
    constants
}

/// Constant of the recordings: its name, its unit, its values, each with the number of recordings that have it.
type Constant = (&'static str, &'static str, Vec<(f64, usize)>);

/// Returns the constants stated in the recordings, which the analysis uses.
fn constants(recordings: &[RecordingEntry<'_>]) -> Markup {
    let mut constants: Vec<Constant> = Vec::new();
    for manifest in recordings.iter().filter_map(|recording| recording.manifest) {
        for (name, value, unit) in manifest_constants(manifest) {
            let index = match constants.iter().position(|constant| constant.0 == name) {
                Some(index) => index,
                None => {
                    constants.push((name, unit, Vec::new()));
                    constants.len() - 1
                }
            };
            let values = &mut constants[index].2;
            match values.iter_mut().find(|(entry, _)| *entry == value) {
                Some((_, n)) => *n += 1,
                None => values.push((value, 1)),
            }
        }
    }
    html! {
        h3 { "Constants that the recordings state" }
        @if constants.is_empty() { p { "None could be read." } } @else {
            div.wide { table {
                thead { tr { th { "Constant" } th.n { "Value" } th { "Unit" } th.n { "Recordings" } } }
                tbody { @for (name, unit, values) in &constants {
                    @for (index, (value, n)) in values.iter().enumerate() {
                        tr.first[index == 0] {
                            @if index == 0 { th scope="row" rowspan=(values.len()) { (name) } }
                            td.n { (constant_text(*value)) } td { (unit) } td.n { (n) }
                        }
                    }
                } }
            } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_have_seven_digits_without_trailing_zeros() {
        assert_eq!(constant_text(35_000.0), "35000");
        assert_eq!(constant_text(34_998.126_49), "34998.13");
        assert_eq!(constant_text(5e-6), "5e−6");
        assert_eq!(constant_text(-1.234_567_89e-7), "−1.234568e−7");
        assert_eq!(constant_text(0.008), "0.008");
        assert_eq!(constant_text(0.0), "0");
        assert_eq!(constant_text(350_000_000.0), "3.5e8");
        assert_eq!(constant_text(20_000_000.0), "20000000");
    }
}
