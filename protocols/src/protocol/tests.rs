use super::*;
use crate::rules::SelectionRules;
use crate::trial::Direction;
use participant_texts::{Language, Texts};
use participants::PersonDetail;
use strict_toml::{InFile, OutOfRange, TomlError};

fn text() -> &'static str {
    built_in("huloux2021").unwrap()
}

fn edit(from: &str, to: &str) -> Result<Protocol, ProtocolError> {
    assert!(text().contains(from), "{from}");
    Protocol::parse(&text().replace(from, to), "p.toml")
}

/// Returns the first rule that a text breaks.
fn rule(result: Result<Protocol, ProtocolError>) -> InFile<BrokenRule> {
    match result.as_ref().map_err(ProtocolError::faults) {
        Err([ProtocolError::Rule(error), ..]) => error.clone(),
        _ => panic!("{result:?}"),
    }
}

/// Hazard 11.
#[test]
fn the_published_protocol_is_the_published_one() {
    let p = Protocol::parse(text(), "huloux2021.toml").unwrap();
    assert_eq!(p.conditions.len(), 1);
    let drive = p.conditions[0].drive;
    assert_eq!(drive.carrier, Carrier::PlateResonance);
    assert_eq!((drive.modulation_hz, drive.modulation_index), (6.0, 0.95));
    assert_eq!(p.exploration.speed_m_per_s, 0.050);
    assert_eq!(p.exploration.directions.len(), 2);
    assert_eq!((p.force.min_n, p.force.max_n), (0.5, 0.8));
    assert_eq!(p.selection.min_instances, 5);
    assert_eq!(p.planned_trials() - p.trials.practice, 10);
    let published = SelectionRules::published(0.0525);
    assert_eq!(p.selection_rules(0.0525), published);
}

#[test]
fn the_consistency_protocol_combines_two_drive_levels_with_two_modulation_frequencies() {
    let p = Protocol::parse(built_in("consistency").unwrap(), "consistency.toml").unwrap();
    let drives = p.conditions.iter().map(|condition| condition.drive);
    let settings: Vec<_> = drives
        .map(|drive| (drive.mean_amplitude_v, drive.modulation_hz))
        .collect();
    assert_eq!(
        settings,
        [(12.0, 3.0), (12.0, 6.0), (24.0, 3.0), (24.0, 6.0)]
    );
    assert!(p.follows_resonance());
    assert_eq!(p.trials.order, Order::Randomised);
    // Slow enough for the verdict's instances at the lower frequency: rising stretches within the central part, both ways.
    let central_s = p.selection.central_m / p.exploration.speed_m_per_s;
    let stretches = (central_s * 3.0).floor() as u32 * p.exploration.directions.len() as u32;
    assert!(stretches > p.selection.min_instances, "{stretches}");
    assert!(p.driving_time().hour_s < 720.0);
}

#[test]
fn every_built_in_protocol_reads_under_its_own_name() {
    for (name, text) in BUILT_IN {
        assert_eq!(Protocol::parse(text, name).unwrap().name, name);
    }
    assert_eq!(built_in("none"), None);
}

fn range(key: &str, value: f64, low: f64, high: f64, unit: &str) -> BrokenRule {
    BrokenRule::OutOfRange(OutOfRange {
        key: key.to_owned(),
        value,
        low,
        high,
        unit: unit.to_owned(),
    })
}

fn reserved_name(name: &str) -> BrokenRule {
    BrokenRule::ReservedName {
        key: "name".to_owned(),
        name: name.to_owned(),
    }
}

/// Returns for each rule a line, an accepted and a rejected replacement of it, and the rule that the rejected one breaks.
fn rules() -> Vec<(&'static str, &'static str, &'static str, BrokenRule)> {
    vec![
        (
            "name = \"huloux2021\"",
            "name = \"my_study-2\"",
            "name = \"../x\"",
            BrokenRule::Name {
                key: "name".to_owned(),
                name: "../x".to_owned(),
            },
        ),
        // Fault 44.
        (
            "name = \"huloux2021\"",
            "name = \"bench-2\"",
            "name = \"bench\"",
            reserved_name("bench"),
        ),
        (
            "name = \"huloux2021\"",
            "name = \"recordings\"",
            "name = \"recording\"",
            reserved_name("recording"),
        ),
        (
            "name = \"huloux2021\"",
            "name = \"calibrations\"",
            "name = \"Calibration\"",
            reserved_name("Calibration"),
        ),
        (
            "ask = [\"age\", \"sex\", \"handedness\"]",
            "ask = [\"sex\"]",
            "ask = [\"age\", \"sex\", \"age\"]",
            BrokenRule::AskedTwice {
                detail: PersonDetail::Age,
            },
        ),
        (
            "limit_hz = 5.0 ",
            "limit_hz = 50.0 ",
            "limit_hz = 1.5 ",
            range("resonance_drift.limit_hz", 1.5, 2.0, 50.0, "Hz"),
        ),
        (
            "carrier = \"plate resonance\"",
            "carrier = 35000",
            "carrier = 35",
            range("drive.carrier", 35.0, 1000.0, 200000.0, "Hz"),
        ),
        (
            "mean_amplitude_v = 24.0",
            "mean_amplitude_v = 0",
            "mean_amplitude_v = 240.0",
            range("drive.mean_amplitude_v", 240.0, 0.0, 100.0, "V"),
        ),
        (
            "modulation_hz = 6.0",
            "modulation_hz = 50",
            "modulation_hz = 0.0",
            range("drive.modulation_hz", 0.0, 0.1, 50.0, "Hz"),
        ),
        (
            "modulation_index = 0.95",
            "modulation_index = 1.0",
            "modulation_index = 95",
            range("drive.modulation_index", 95.0, 0.0, 1.0, ""),
        ),
        (
            "name = \"am-6hz-95\"",
            "name = \"a\"\nmodulation_hz = 2.0",
            "name = \"a\"\nmodulation_hz = 200.0",
            range("conditions.0.modulation_hz", 200.0, 0.1, 50.0, "Hz"),
        ),
        (
            "name = \"am-6hz-95\"",
            "name = \"a\"\n[[conditions]]\nname = \"b\"",
            "name = \"a\"\n[[conditions]]\nname = \"a\"",
            BrokenRule::RepeatedName {
                key: "conditions.1.name".to_owned(),
                name: "a".to_owned(),
            },
        ),
        (
            "name = \"am-6hz-95\"",
            "name = \"a\"",
            "name = \"A b\"",
            BrokenRule::Name {
                key: "conditions.0.name".to_owned(),
                name: "A b".to_owned(),
            },
        ),
        (
            "practice = 2",
            "practice = 0",
            "practice = 101",
            range("trials.practice", 101.0, 0.0, 100.0, ""),
        ),
        (
            "per_condition = 10",
            "per_condition = 1",
            "per_condition = 0",
            range("trials.per_condition", 0.0, 1.0, 1000.0, ""),
        ),
        (
            "order = \"fixed\"",
            "order = \"randomised\"",
            "order = \"counterbalanced\"",
            BrokenRule::CounterbalancedSingle,
        ),
        (
            "directions = [\"left_to_right\", \"right_to_left\"]",
            "directions = [\"left_to_right\"]",
            "directions = []",
            range("exploration.directions", 0.0, 1.0, 20.0, ""),
        ),
        (
            "from_m = 0.010",
            "from_m = -0.04",
            "from_m = -10",
            range("exploration.from_m", -10.0, -1.0, 1.0, "m"),
        ),
        (
            "to_m = 0.095",
            "to_m = 0.1",
            "to_m = 95.0",
            range("exploration.to_m", 95.0, -1.0, 1.0, "m"),
        ),
        (
            "to_m = 0.095",
            "to_m = 0.09",
            "to_m = 0.005",
            BrokenRule::Travel {
                from_m: 0.010,
                to_m: 0.005,
            },
        ),
        (
            "speed_m_per_s = 0.050",
            "speed_m_per_s = 0.1",
            "speed_m_per_s = 50",
            range("exploration.speed_m_per_s", 50.0, 0.001, 1.0, "m/s"),
        ),
        (
            "settle_s = 0.2",
            "settle_s = 1",
            "settle_s = 0",
            range("timing.settle_s", 0.0, 0.1, 60.0, "s"),
        ),
        (
            "baseline_s = 0.8",
            "baseline_s = 2",
            "baseline_s = 0.1",
            range("timing.baseline_s", 0.1, 0.2, 60.0, "s"),
        ),
        (
            "countdown_s = 3.0",
            "countdown_s = 0",
            "countdown_s = -1",
            range("timing.countdown_s", -1.0, 0.0, 60.0, "s"),
        ),
        (
            "feedback_s = 3.0",
            "feedback_s = 0",
            "feedback_s = -0.5",
            range("timing.feedback_s", -0.5, 0.0, 60.0, "s"),
        ),
        (
            "verdict_s = 2.0",
            "verdict_s = 0",
            "verdict_s = inf",
            range("timing.verdict_s", f64::INFINITY, 0.0, 60.0, "s"),
        ),
        (
            "min_n = 0.5",
            "min_n = 0.3",
            "min_n = 0.05",
            BrokenRule::ContactInBand {
                contact_n: 0.1,
                min_n: 0.05,
            },
        ),
        (
            "max_n = 0.8",
            "max_n = 0.9",
            "max_n = 0.4",
            BrokenRule::EmptyBand {
                min_n: 0.5,
                max_n: 0.4,
            },
        ),
        (
            "max_n = 0.8",
            "max_n = 20",
            "max_n = 800",
            range("force.max_n", 800.0, 0.02, 20.0, "N"),
        ),
        (
            "contact_n = 0.1",
            "contact_n = 0.05",
            "contact_n = 0.001",
            range("force.contact_n", 0.001, 0.01, 5.0, "N"),
        ),
        (
            "min_s = 60.0",
            "min_s = 0",
            "min_s = 60000",
            range("rest.min_s", 60000.0, 0.0, 3600.0, "s"),
        ),
        (
            "max_per_trial = 3",
            "max_per_trial = 0",
            "max_per_trial = 1001",
            range("redo.max_per_trial", 1001.0, 0.0, 1000.0, ""),
        ),
        (
            "central_m = 0.060",
            "central_m = 0.085",
            "central_m = 0.1",
            BrokenRule::CentralBeyondTravel {
                central_m: 0.1,
                travel_m: 0.095 - 0.010,
            },
        ),
        (
            "speed_tolerance = 0.25",
            "speed_tolerance = 0.1",
            "speed_tolerance = 25",
            range("selection.speed_tolerance", 25.0, 0.01, 0.9, ""),
        ),
        (
            "instance_s = 0.060",
            "instance_s = 0.03",
            "instance_s = 60",
            range("selection.instance_s", 60.0, 0.005, 1.0, "s"),
        ),
        (
            "place_finger_s = 60.0",
            "place_finger_s = 1",
            "place_finger_s = 0.5",
            range("timeouts.place_finger_s", 0.5, 1.0, 3600.0, "s"),
        ),
    ]
}

#[test]
fn each_rule_accepts_and_rejects_and_names_key_value_and_limit() {
    for (line, good, bad, broken) in rules() {
        edit(line, good).unwrap_or_else(|error| panic!("{good}: {error}"));
        let error = rule(edit(line, bad));
        assert_eq!(error.error, broken, "{bad}");
        assert!(error.line.is_some(), "{bad}");
    }
}

#[test]
fn not_a_number_is_outside_every_range() {
    let error = rule(edit("feedback_s = 3.0", "feedback_s = nan"));
    assert!(
        matches!(&error.error, BrokenRule::OutOfRange(limit) if limit.value.is_nan()),
        "{error}"
    );
}

#[test]
fn a_range_error_names_the_line() {
    let error = rule(edit("speed_m_per_s = 0.050", "speed_m_per_s = 50"));
    let line = 1 + text()
        .lines()
        .position(|l| l.starts_with("speed_m_per_s"))
        .unwrap();
    assert_eq!(error.line, Some(line));
    assert_eq!(
        error.to_string(),
        format!(
            "p.toml, line {line}: exploration.speed_m_per_s = 50 m/s is outside the allowed range of 0.001 to 1 m/s"
        )
    );
}

#[test]
fn a_condition_overrides_the_named_keys_and_keeps_the_rest() {
    let p = edit(
        "name = \"am-6hz-95\"",
        "name = \"slow\"\nmodulation_hz = 2\ncarrier = 30e3",
    )
    .unwrap();
    let drive = p.conditions[0].drive;
    assert_eq!(
        (drive.modulation_hz, drive.carrier),
        (2.0, Carrier::Hz(30e3))
    );
    assert_eq!(
        (drive.mean_amplitude_v, drive.modulation_index),
        (24.0, 0.95)
    );
    assert!((drive.peak_amplitude_v() - 46.8).abs() < 1e-12);
}

fn toml(result: Result<Protocol, ProtocolError>) -> TomlError {
    match result {
        Err(ProtocolError::Toml(error)) => error,
        result => panic!("{result:?}"),
    }
}

#[test]
fn another_word_for_the_carrier_is_an_error_with_the_allowed_values() {
    let error = toml(edit("\"plate resonance\"", "\"resonance\""));
    let TomlError::WrongType { key, expected, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(key.as_deref(), Some("drive.carrier"));
    assert_eq!(expected, "\"plate resonance\" or a number in Hz");
}

/// Fault 33.
#[test]
fn a_quoted_number_and_a_number_with_a_unit_say_what_to_write() {
    let error = toml(edit("\"plate resonance\"", "\"35000\""));
    assert!(
        matches!(&error, TomlError::QuotedNumber { key: Some(key), .. } if key == "drive.carrier"),
        "{error:?}"
    );
    let error = toml(edit("modulation_hz = 6.0", "modulation_hz = 6.0 Hz"));
    assert!(
        matches!(
            &error,
            TomlError::NumberWithUnit { key: Some(key), value, .. }
                if key == "drive.modulation_hz" && value == "6.0 Hz"
        ),
        "{error:?}"
    );
}

/// Fault 33.
#[test]
fn a_typing_error_names_the_nearest_key() {
    let error = toml(edit("baseline_s", "base_line_s"));
    assert!(
        matches!(&error, TomlError::UnknownKey { nearest: Some(nearest), .. } if nearest == "baseline_s"),
        "{error:?}"
    );
}

/// Fault 33.
#[test]
fn a_missing_section_is_named() {
    let error = toml(edit("[quality]", ""));
    // Its three keys are then those of the table before it.
    assert!(
        matches!(&error, TomlError::Several(keys) if keys.len() == 3),
        "{error:?}"
    );
    let cut = text().find("[selection]").unwrap();
    assert_eq!(
        toml(Protocol::parse(&text()[..cut], "p.toml")),
        TomlError::MissingKey {
            file: "p.toml".to_owned(),
            table: None,
            key: "selection".to_owned()
        }
    );
}

#[test]
fn all_faults_of_a_file_are_named_together() {
    let wrong = text()
        .replace("name = \"huloux2021\"\n", "")
        .replace("per_condition = 10", "per_condition = 0")
        .replace("order = \"fixed\"", "ordr = \"fixed\"")
        .replace("modulation_index = 0.95", "modulation_index = 95")
        .replace("every_trials = 5 ", "every_trials = \"5\" ")
        .replace("min_n = 0.5\n", "");
    let error = Protocol::parse(&wrong, "p.toml").unwrap_err().to_string();
    for fault in [
        "unknown key `ordr`, did you mean `order`?",
        "\"5\" is text",
        "p.toml: key `name` is missing",
        "p.toml, table [force]: key `min_n` is missing",
        "drive.modulation_index = 95 is outside",
    ] {
        assert!(error.contains(fault), "{fault} is not in:\n{error}");
    }
    // The keys of a table with a stand-in are not judged.
    assert_eq!(error.lines().count(), 5, "{error}");
}

#[test]
fn one_wrong_end_of_the_slider_is_one_fault() {
    let error = edit("to_m = 0.095", "to_m = 95").unwrap_err();
    assert_eq!(error.faults().len(), 1, "{error}");
}

#[test]
fn keys_that_no_study_varies_may_be_left_out() {
    let mut short = text().to_owned();
    for (table, next) in [
        ("[timing]", "[force]"),
        ("[redo]", "[selection]"),
        ("[quality]", "[resonance_drift]"),
    ] {
        let (start, end) = (short.find(table).unwrap(), short.find(next).unwrap());
        short.replace_range(start..end, "");
    }
    let lines: Vec<&str> = short.lines().collect();
    let without_citation: Vec<&str> = lines
        .into_iter()
        .filter(|line| !line.starts_with("citation"))
        .collect();
    let short = Protocol::parse(&without_citation.join("\n"), "p.toml").unwrap();
    let whole = Protocol::parse(text(), "p.toml").unwrap();
    assert_eq!(short.timing, whole.timing);
    assert_eq!(short.redo, whole.redo);
    assert_eq!(short.timeouts, whole.timeouts);
    assert_eq!(short.quality, whole.quality);
    assert_eq!(short.citation, "");
    let part = edit("countdown_s = 3.0\n", "").unwrap();
    assert_eq!(part.timing, whole.timing);
}

#[test]
fn the_template_is_a_protocol_whose_comments_state_the_defaults() {
    let protocol = Protocol::parse(TEMPLATE, "template.toml").unwrap();
    assert_eq!(protocol.name, "my-protocol");
    let enabled: String = TEMPLATE
        .lines()
        .map(|line| line.strip_prefix("#= ").unwrap_or(line).to_owned() + "\n")
        .collect();
    assert_eq!(
        Protocol::parse(&enabled, "template.toml").unwrap(),
        protocol
    );
    // Every key that a protocol may have, apart from its own texts, is in the template.
    let mut value = serde_json::to_value(&protocol).unwrap();
    value.as_object_mut().unwrap().remove("texts");
    value["drive"] = value["conditions"][0]["drive"].take();
    for (table, keys) in value.as_object().unwrap() {
        let names = keys
            .as_object()
            .map_or_else(|| vec![table], |keys| keys.keys().collect());
        for name in names.into_iter().filter(|name| *name != "conditions") {
            let is_there = enabled
                .lines()
                .any(|line| line.starts_with(&format!("{name} = ")));
            assert!(is_there, "{table}.{name}");
        }
    }
}

/// Older protocols without this section are still read.
#[test]
fn a_new_carrier_is_asked_for_unless_the_protocol_takes_it() {
    let (head, section) = text().split_once("[resonance_drift]").unwrap();
    let protocol = Protocol::parse(head, "p.toml").unwrap();
    assert_eq!(protocol.resonance_drift, ResonanceDrift::default());
    assert_eq!(protocol.resonance_drift.new_carrier, NewCarrier::Ask);
    assert!(protocol.follows_resonance());
    let automatic = format!("{head}[resonance_drift]\nnew_carrier = \"auto\"");
    let automatic = Protocol::parse(&automatic, "p.toml").unwrap();
    assert_eq!(automatic.resonance_drift.new_carrier, NewCarrier::Auto);
    assert!(section.contains("\"ask\""));
    toml(edit("new_carrier = \"ask\"", "new_carrier = \"always\""));
    toml(edit("new_carrier = \"ask\"", "new_carier = \"ask\""));
    let fixed_carrier = edit("\"plate resonance\"", "35000").unwrap();
    assert!(!fixed_carrier.follows_resonance());
}

#[test]
fn nothing_is_asked_about_participants_unless_a_protocol_asks() {
    assert_eq!(
        Protocol::parse(text(), "p.toml").unwrap().participant.ask,
        PersonDetail::ALL
    );
    let section_start = text().find("[participant]").unwrap();
    let section_end = text().find("[drive]").unwrap();
    let silent = format!("{}{}", &text()[..section_start], &text()[section_end..]);
    let silent = Protocol::parse(&silent, "p.toml").unwrap();
    assert!(silent.participant.ask.is_empty());
    assert!(
        Protocol::parse(built_in("demo").unwrap(), "demo.toml")
            .unwrap()
            .participant
            .ask
            .is_empty()
    );
    // A name cannot be asked for.
    assert!(matches!(
        toml(edit("\"age\", \"sex\"", "\"name\"")),
        TomlError::UnknownValue { .. }
    ));
}

#[test]
fn a_slider_that_leaves_the_plate_is_refused() {
    let plate_length_m = 0.105;
    let on_plate = |from_m: f64, to_m: f64| {
        let mut protocol = Protocol::parse(text(), "p.toml").unwrap();
        protocol.exploration.from_m = from_m;
        protocol.exploration.to_m = to_m;
        protocol.require_on_plate(plate_length_m)
    };
    assert_eq!(on_plate(0.010, 0.095), Ok(()));
    assert_eq!(on_plate(0.0, 0.105), Ok(()));
    for (from_m, to_m) in [(-0.001, 0.095), (0.2, 0.3)] {
        assert_eq!(
            on_plate(from_m, to_m),
            Err(OffPlateError::From {
                from_m,
                plate_length_m
            })
        );
    }
    let error = on_plate(0.010, 0.95).unwrap_err();
    assert_eq!(
        error,
        OffPlateError::To {
            to_m: 0.95,
            plate_length_m
        }
    );
    assert_eq!(error.key(), "exploration.to_m");
    assert_eq!(
        error.to_string(),
        "exploration.to_m = 0.95 m is not on the plate, which reaches from 0 to plate.length_m = 0.105 m"
    );
    let protocol = Protocol::parse(text(), "p.toml").unwrap();
    assert!(protocol.require_on_plate(f64::NAN).is_err());
}

#[test]
fn the_slider_rests_at_its_ends() {
    let p = Protocol::parse(text(), "huloux2021.toml").unwrap();
    let slider = p.exploration.slider(Direction::RightToLeft);
    assert_eq!(slider.position_m(-1.0), 0.095);
    assert_eq!(slider.position_m(slider.duration_s() + 1.0), 0.010);
    assert!((slider.position_m(1.0) - 0.045).abs() < 1e-12);
}

#[test]
fn a_protocol_chooses_a_language_and_replaces_texts() {
    let text = built_in("demo").unwrap();
    let english = Protocol::parse(text, "p.toml").unwrap();
    assert_eq!(english.texts(), Texts::in_language(Language::En).clone());
    let german = format!("language = \"de\"\n{text}\n[texts]\nfollow_slider = \"Los!\"\n");
    let texts = Protocol::parse(&german, "p.toml").unwrap().texts();
    assert_eq!(texts.follow_slider, "Los!");
    assert_eq!(texts.wait, "Bitte warten");
    for (line, misspelling) in [
        ("language = \"fr\"", "language = \"french\""),
        ("[texts]\nwait = \"?\"", "[texts]\nwiat = \"?\""),
    ] {
        let edited = |line: &str| match line.starts_with('[') {
            true => format!("{text}\n{line}\n"),
            false => format!("{line}\n{text}"),
        };
        assert!(Protocol::parse(&edited(line), "p.toml").is_ok());
        let result = Protocol::parse(&edited(misspelling), "p.toml");
        assert!(matches!(result, Err(ProtocolError::Toml(_))), "{result:?}");
    }
    let empty = format!("{text}\n[texts]\nwait = \"\"\n");
    let message = rule(Protocol::parse(&empty, "p.toml")).to_string();
    assert!(message.contains("texts.wait = \"\""), "{message}");
}
