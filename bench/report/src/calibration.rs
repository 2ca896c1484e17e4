//! Constants of the recordings: dates of measurement, age and values.

use std::path::Path;

use config::{CalibrationFile, Quantity};
use jiff::Timestamp;
use maud::{Markup, html};
use recording::Manifest;

use crate::content::{Content, Of};
use crate::number::{In, counted, date, significant};

/// Copy of the calibration in a session's folder.
const FILE: &str = "calibration.toml";
const S_PER_DAY: f64 = 86_400.0;
const DAYS: In = In {
    factor: 1.0,
    decimals: 1,
};

/// Calibration, and the sessions that used it.
struct Used {
    hash: String,
    file: CalibrationFile,
    /// Start of the first session with it.
    first: Option<Timestamp>,
    sessions: usize,
}

pub(crate) fn calibration(content: &Content<'_>, recordings: &[Of<'_>]) -> Markup {
    let (used, unreadable) = used(content);
    let uncalibrated = recordings.iter().filter(|of| of.is_uncalibrated()).count();
    html! {
        @if uncalibrated > 0 {
            p.alert {
                (counted(uncalibrated, "recording was", "recordings were"))
                " made without a calibration: their constants are those of the configuration, and were not measured."
            }
        }
        @for reason in &unreadable { p.alert { "A session's copy of its calibration cannot be read: " (reason) } }
        @for used in &used { (of_file(used)) }
        (constants(recordings))
    }
}

fn used(content: &Content<'_>) -> (Vec<Used>, Vec<String>) {
    let (mut used, mut unreadable) = (Vec::<Used>::new(), Vec::new());
    for (folder, session) in &content.sessions.list {
        let Ok(session) = session else { continue };
        let path = Path::new(folder).join(FILE);
        if !path.exists() {
            continue;
        }
        let (file, hash) = match CalibrationFile::read(&path) {
            Ok(read) => read,
            Err(error) => {
                unreadable.push(error.to_string());
                continue;
            }
        };
        let start = session.start.as_ref().and_then(|of| of.time.parse().ok());
        match used.iter_mut().find(|of| of.hash == hash) {
            Some(of) => {
                of.sessions += 1;
                of.first = of.first.into_iter().chain(start).min();
            }
            None => used.push(Used {
                hash,
                file,
                first: start,
                sessions: 1,
            }),
        }
    }
    (used, unreadable)
}

/// Part of a calibration: its name, its date, its quantities by name.
type Part<'a> = (&'static str, Timestamp, Vec<(&'static str, &'a Quantity)>);

fn of_file(used: &Used) -> Markup {
    let file = &used.file;
    let mut parts: Vec<Part<'_>> = Vec::new();
    if let Some(of) = &file.pickup {
        let mut values = vec![("sensitivity", &of.metres_per_unit), ("offset", &of.offset)];
        values.extend(of.phase_rad.as_ref().map(|phase| ("phase", phase)));
        parts.push(("pickup", of.measured.date, values));
    }
    if let Some(of) = &file.plate {
        let mut values = vec![
            ("resonance", &of.resonance_hz),
            ("quality factor", &of.quality),
            ("damping", &of.damping_n_s_per_m),
            ("stiffness", &of.stiffness_n_per_m),
            ("force factor", &of.force_factor_n_per_v),
            ("phase of the pickup", &of.pickup_phase_rad),
        ];
        values.extend(
            of.force_phase_rad
                .as_ref()
                .map(|phase| ("phase of the force", phase)),
        );
        parts.push(("plate", of.measured.date, values));
    }
    if let Some(of) = &file.profile {
        let values = vec![("largest departure along the plate", &of.largest_departure)];
        parts.push(("amplitude along the plate", of.measured.date, values));
    }
    if let Some(of) = &file.force {
        let values = vec![
            ("normal per normal", &of.normal_per_normal),
            ("normal per lateral", &of.normal_per_lateral),
            ("lateral per normal", &of.lateral_per_normal),
            ("lateral per lateral", &of.lateral_per_lateral),
            ("normal tare", &of.normal_tare),
            ("lateral tare", &of.lateral_tare),
        ];
        parts.push(("force sensor", of.measured.date, values));
    }
    if let Some(of) = &file.channels {
        let values = vec![("round trip", &of.round_trip), ("latency", &of.latency)];
        parts.push(("channels", of.measured.date, values));
    }
    let age = |measured: Timestamp| {
        let first = used.first?;
        Some(first.duration_since(measured).as_secs_f64() / S_PER_DAY)
    };
    html! {
        h3 { "Calibration " code { (used.hash.chars().take(12).collect::<String>()) } }
        p.note { "Used in " (counted(used.sessions, "session", "sessions")) ". Age: days before the first of them." }
        div.wide { table {
            thead { tr {
                th { "Part" } th { "Measured on" } th.n { "Age (days)" } th { "Quantity" } th.n { "Value ± standard error" }
                th { "Unit" }
            } }
            tbody { @for (part, measured, values) in &parts {
                @for (at, (name, quantity)) in values.iter().enumerate() {
                    tr.first[at == 0] {
                        @if at == 0 {
                            th scope="row" rowspan=(values.len()) { (part) }
                            td rowspan=(values.len()) { (date(*measured)) }
                            td.n rowspan=(values.len()) { (DAYS.value(age(*measured))) }
                        }
                        td { (name) }
                        td.n { (precise(quantity.value)) " ± " (significant(Some(quantity.standard_error))) }
                        td { (quantity.unit) }
                    }
                }
            } }
        } }
    }
}

/// Returns a constant with seven significant digits.
fn precise(value: f64) -> String {
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
fn of_manifest(manifest: &Manifest) -> Vec<(&'static str, f64, &'static str)> {
    let (channels, plate) = (&manifest.channels, &manifest.plate);
    let mut all = vec![
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
        ("plate, resonance", plate.resonance_hz, "Hz"),
        ("plate, modal mass", plate.modal_mass_kg, "kg"),
        ("plate, force factor", plate.force_factor_n_per_v, "N/V"),
    ];
    if let Some(errors) = &manifest.standard_errors {
        let percent = 100.0;
        all.extend([
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
        ]);
    }
    all
}

/// Constant of the recordings: its name, its unit, its values, each with the number of recordings that have it.
type Constant = (&'static str, &'static str, Vec<(f64, usize)>);

/// Returns the constants stated in the recordings, which the analysis uses.
fn constants(recordings: &[Of<'_>]) -> Markup {
    let mut each: Vec<Constant> = Vec::new();
    for manifest in recordings.iter().filter_map(|of| of.manifest) {
        for (name, value, unit) in of_manifest(manifest) {
            let at = match each.iter().position(|of| of.0 == name) {
                Some(at) => at,
                None => {
                    each.push((name, unit, Vec::new()));
                    each.len() - 1
                }
            };
            let values = &mut each[at].2;
            match values.iter_mut().find(|(known, _)| *known == value) {
                Some((_, n)) => *n += 1,
                None => values.push((value, 1)),
            }
        }
    }
    html! {
        h3 { "Constants that the recordings state" }
        @if each.is_empty() { p { "None could be read." } } @else {
            div.wide { table {
                thead { tr { th { "Constant" } th.n { "Value" } th { "Unit" } th.n { "Recordings" } } }
                tbody { @for (name, unit, values) in &each {
                    @for (at, (value, n)) in values.iter().enumerate() {
                        tr.first[at == 0] {
                            @if at == 0 { th scope="row" rowspan=(values.len()) { (name) } }
                            td.n { (precise(*value)) } td { (unit) } td.n { (n) }
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
    fn constants_keep_seven_digits_and_no_idle_zeros() {
        assert_eq!(precise(35_000.0), "35000");
        assert_eq!(precise(34_998.126_49), "34998.13");
        assert_eq!(precise(5e-6), "5e−6");
        assert_eq!(precise(-1.234_567_89e-7), "−1.234568e−7");
        assert_eq!(precise(0.008), "0.008");
        assert_eq!(precise(0.0), "0");
        assert_eq!(precise(350_000_000.0), "3.5e8");
        assert_eq!(precise(20_000_000.0), "20000000");
    }
}
