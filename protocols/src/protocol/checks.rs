//! The rules for a protocol's values, one function each.
//!
//! Ranges are this project's, wide enough for any study of friction modulation and narrow enough to catch a wrong
//! unit (50 for 50 mm/s, 35 for 35 kHz) or a slipped decimal point.

use super::definition::Protocol;
use super::drive::{Carrier, Condition, Drive};
use super::error::{BrokenRule, MIN_TRAVEL_M};
use super::raw::{RawCondition, RawProtocol};
use super::sections::Order;
use participants::PersonDetail;
use std::collections::BTreeSet;

type Checked = Result<(), BrokenRule>;

/// Checks every value of a protocol file and completes the drive of each condition.
///
/// # Errors
/// All broken rules, in the order of the file's tables.
pub(super) fn validate(raw: RawProtocol) -> Result<Protocol, Vec<BrokenRule>> {
    let (from_m, to_m) = (raw.exploration.from_m, raw.exploration.to_m);
    let mut rules = vec![
        file_name("name", &raw.name),
        raw.texts.require_showable().map_err(BrokenRule::from),
        asked_once(&raw.participant.ask),
    ];
    rules.extend(drive("drive", &raw.drive));
    let (conditions, condition_rules) = conditions(&raw.drive, raw.conditions);
    rules.extend(condition_rules);
    rules.extend([
        practice(raw.trials.practice),
        per_condition(raw.trials.per_condition),
        williams_size(raw.trials.order, conditions.len()),
        directions(raw.exploration.directions.len()),
        // A wrong end is one fault, although it makes the travel wrong too.
        slider_end("exploration.from_m", from_m)
            .and_then(|()| slider_end("exploration.to_m", to_m))
            .and_then(|()| travel(from_m, to_m))
            .and_then(|()| central(raw.selection.central_m, to_m - from_m)),
        speed(raw.exploration.speed_m_per_s),
        settle(raw.timing.settle_s),
        baseline(raw.timing.baseline_s),
        pause_length("timing.countdown_s", raw.timing.countdown_s),
        pause_length("timing.feedback_s", raw.timing.feedback_s),
        pause_length("timing.verdict_s", raw.timing.verdict_s),
        contact(raw.force.contact_n, raw.force.min_n),
        least_force(raw.force.min_n),
        greatest_force(raw.force.min_n, raw.force.max_n),
        rest_length(raw.rest.min_s),
        redo("redo.max_per_trial", raw.redo.max_per_trial),
        redo("redo.max_total", raw.redo.max_total),
        speed_tolerance(raw.selection.speed_tolerance),
        instance(raw.selection.instance_s),
        min_instances(raw.selection.min_instances),
        timeout("timeouts.lift_finger_s", raw.timeouts.lift_finger_s),
        timeout("timeouts.place_finger_s", raw.timeouts.place_finger_s),
        timeout("timeouts.analysis_s", raw.timeouts.analysis_s),
        drift_limit(raw.resonance_drift.limit_hz),
    ]);
    let broken: Vec<BrokenRule> = rules.into_iter().filter_map(Result::err).collect();
    if !broken.is_empty() {
        return Err(broken);
    }
    Ok(Protocol {
        name: raw.name,
        description: raw.description,
        citation: raw.citation,
        language: raw.language,
        texts: raw.texts,
        participant: raw.participant,
        conditions,
        trials: raw.trials,
        exploration: raw.exploration,
        timing: raw.timing,
        force: raw.force,
        rest: raw.rest,
        redo: raw.redo,
        selection: raw.selection,
        quality: raw.quality,
        timeouts: raw.timeouts,
        resonance_drift: raw.resonance_drift,
    })
}

fn check_range(key: &str, value: f64, low: f64, high: f64, unit: &str) -> Checked {
    Ok(strict_toml::require_range(key, value, low, high, unit)?)
}

fn check_count(key: &str, count: u64, low: u64, high: u64) -> Checked {
    Ok(strict_toml::count_within(key, count, low, high)?)
}

fn short_name(key: &str, name: &str) -> Checked {
    let is_allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_';
    if (1..=64).contains(&name.len()) && name.bytes().all(is_allowed) {
        return Ok(());
    }
    Err(BrokenRule::Name {
        key: key.to_owned(),
        name: name.to_owned(),
    })
}

/// Names of `.toml` files that a session or a recording contains in addition to its protocol: the copies of the
/// hardware file and of the calibration, and the manifest, which marks a folder as a recording.
const OTHER_FILES: [&str; 3] = ["bench", "calibration", "recording"];

/// Requires a file name that differs from all others in a session's folder, also on disks that ignore case.
fn file_name(key: &str, name: &str) -> Checked {
    if OTHER_FILES
        .iter()
        .any(|reserved| reserved.eq_ignore_ascii_case(name))
    {
        return Err(BrokenRule::ReservedName {
            key: key.to_owned(),
            name: name.to_owned(),
        });
    }
    short_name(key, name)
}

fn asked_once(details: &[PersonDetail]) -> Checked {
    let is_repeated = |i: &usize| details[..*i].contains(&details[*i]);
    match (0..details.len()).find(is_repeated) {
        Some(i) => Err(BrokenRule::AskedTwice { detail: details[i] }),
        None => Ok(()),
    }
}

fn drive(table: &str, drive: &Drive) -> [Checked; 4] {
    [
        carrier(&format!("{table}.carrier"), drive.carrier),
        mean_amplitude(&format!("{table}.mean_amplitude_v"), drive.mean_amplitude_v),
        modulation(&format!("{table}.modulation_hz"), drive.modulation_hz),
        index(&format!("{table}.modulation_index"), drive.modulation_index),
    ]
}

fn carrier(key: &str, carrier: Carrier) -> Checked {
    match carrier {
        Carrier::PlateResonance => Ok(()),
        Carrier::Hz(hz) => check_range(key, hz, 1e3, 200e3, "Hz"),
    }
}

/// Requires a plausible amplitude. The bench's own limits, compiled in and configured, are tighter and checked when it
/// is armed.
fn mean_amplitude(key: &str, volts: f64) -> Checked {
    check_range(key, volts, 0.0, 100.0, "V")
}

fn modulation(key: &str, hz: f64) -> Checked {
    check_range(key, hz, 0.1, 50.0, "Hz")
}

fn index(key: &str, index: f64) -> Checked {
    check_range(key, index, 0.0, 1.0, "")
}

/// Returns the conditions with their whole drives, and the results of their rules. A value inherited from `base` is
/// checked there only.
fn conditions(base: &Drive, raw: Vec<RawCondition>) -> (Vec<Condition>, Vec<Checked>) {
    let mut rules = vec![check_count("conditions", raw.len() as u64, 1, 64)];
    let mut names = BTreeSet::new();
    let conditions = raw.into_iter().enumerate().map(|(i, raw)| {
        let table = format!("conditions.{i}");
        let full_drive = Drive {
            carrier: raw.carrier.unwrap_or(base.carrier),
            mean_amplitude_v: raw.mean_amplitude_v.unwrap_or(base.mean_amplitude_v),
            modulation_hz: raw.modulation_hz.unwrap_or(base.modulation_hz),
            modulation_index: raw.modulation_index.unwrap_or(base.modulation_index),
        };
        rules.push(short_name(&format!("{table}.name"), &raw.name));
        rules.push(unique(&format!("{table}.name"), &raw.name, &mut names));
        let is_given = [
            raw.carrier.is_some(),
            raw.mean_amplitude_v.is_some(),
            raw.modulation_hz.is_some(),
            raw.modulation_index.is_some(),
        ];
        let checked = drive(&table, &full_drive).into_iter().zip(is_given);
        rules.extend(
            checked
                .filter(|(_, is_given)| *is_given)
                .map(|(rule, _)| rule),
        );
        Condition {
            name: raw.name,
            drive: full_drive,
        }
    });
    let conditions = conditions.collect();
    (conditions, rules)
}

fn unique(key: &str, name: &str, names: &mut BTreeSet<String>) -> Checked {
    if names.insert(name.to_owned()) {
        return Ok(());
    }
    Err(BrokenRule::RepeatedName {
        key: key.to_owned(),
        name: name.to_owned(),
    })
}

fn practice(trials: u32) -> Checked {
    check_count("trials.practice", u64::from(trials), 0, 100)
}

fn per_condition(trials: u32) -> Checked {
    check_count("trials.per_condition", u64::from(trials), 1, 1000)
}

fn williams_size(order: Order, conditions: usize) -> Checked {
    if order != Order::Counterbalanced || conditions >= 2 {
        return Ok(());
    }
    Err(BrokenRule::CounterbalancedSingle)
}

fn directions(explorations: usize) -> Checked {
    check_count("exploration.directions", explorations as u64, 1, 20)
}

fn slider_end(key: &str, position_m: f64) -> Checked {
    check_range(key, position_m, -1.0, 1.0, "m")
}

fn travel(from_m: f64, to_m: f64) -> Checked {
    if to_m - from_m >= MIN_TRAVEL_M {
        return Ok(());
    }
    Err(BrokenRule::Travel { from_m, to_m })
}

fn speed(m_per_s: f64) -> Checked {
    check_range("exploration.speed_m_per_s", m_per_s, 0.001, 1.0, "m/s")
}

fn settle(s: f64) -> Checked {
    check_range("timing.settle_s", s, 0.1, 60.0, "s")
}

fn baseline(s: f64) -> Checked {
    check_range("timing.baseline_s", s, 0.2, 60.0, "s")
}

fn pause_length(key: &str, s: f64) -> Checked {
    check_range(key, s, 0.0, 60.0, "s")
}

fn least_force(n: f64) -> Checked {
    check_range("force.min_n", n, 0.02, 20.0, "N")
}

fn greatest_force(min_n: f64, max_n: f64) -> Checked {
    if max_n > min_n {
        return check_range("force.max_n", max_n, 0.02, 20.0, "N");
    }
    Err(BrokenRule::EmptyBand { min_n, max_n })
}

fn contact(contact_n: f64, min_n: f64) -> Checked {
    if contact_n < min_n {
        return check_range("force.contact_n", contact_n, 0.01, 5.0, "N");
    }
    Err(BrokenRule::ContactInBand { contact_n, min_n })
}

fn rest_length(s: f64) -> Checked {
    check_range("rest.min_s", s, 0.0, 3600.0, "s")
}

fn redo(key: &str, times: u32) -> Checked {
    check_count(key, u64::from(times), 0, 1000)
}

fn central(central_m: f64, travel_m: f64) -> Checked {
    if central_m <= travel_m {
        return check_range("selection.central_m", central_m, 0.005, 2.0, "m");
    }
    Err(BrokenRule::CentralBeyondTravel {
        central_m,
        travel_m,
    })
}

fn speed_tolerance(part: f64) -> Checked {
    check_range("selection.speed_tolerance", part, 0.01, 0.9, "")
}

fn instance(s: f64) -> Checked {
    check_range("selection.instance_s", s, 0.005, 1.0, "s")
}

fn min_instances(n: u32) -> Checked {
    check_count("selection.min_instances", u64::from(n), 1, 1000)
}

fn timeout(key: &str, s: f64) -> Checked {
    check_range(key, s, 1.0, 3600.0, "s")
}

/// Requires a limit that the tracking can resolve and within reach of a new carrier.
fn drift_limit(hz: f64) -> Checked {
    check_range("resonance_drift.limit_hz", hz, 2.0, 50.0, "Hz")
}
