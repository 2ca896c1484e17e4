use super::*;

fn text() -> &'static str {
    built_in("huloux2021").unwrap()
}

fn with(from: &str, to: &str) -> Result<Protocol, ProtocolError> {
    assert!(text().contains(from), "{from}");
    Protocol::parse(&text().replace(from, to), "p.toml")
}

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
fn every_built_in_protocol_reads_under_its_own_name() {
    for (name, text) in BUILT_IN {
        assert_eq!(Protocol::parse(text, name).unwrap().name, name);
    }
    assert_eq!(built_in("none"), None);
}

/// Each rule: an accepted and a rejected replacement of a line, and the key and range that the message must name.
const RULES: [(&str, &str, &str, &str, &str); 31] = [
    (
        "name = \"huloux2021\"",
        "name = \"my_study-2\"",
        "name = \"../x\"",
        "`name`",
        "a-z, 0-9",
    ),
    (
        "carrier = \"plate resonance\"",
        "carrier = 35000",
        "carrier = 35",
        "`drive.carrier`",
        "1000 to 200000 Hz",
    ),
    (
        "mean_amplitude_v = 24.0",
        "mean_amplitude_v = 0",
        "mean_amplitude_v = 240.0",
        "`drive.mean_amplitude_v`",
        "0 to 100 V",
    ),
    (
        "modulation_hz = 6.0",
        "modulation_hz = 50",
        "modulation_hz = 0.0",
        "`drive.modulation_hz`",
        "0.1 to 50 Hz",
    ),
    (
        "modulation_index = 0.95",
        "modulation_index = 1.0",
        "modulation_index = 95",
        "`drive.modulation_index`",
        "0 to 1",
    ),
    (
        "name = \"am-6hz-95\"",
        "name = \"a\"\nmodulation_hz = 2.0",
        "name = \"a\"\nmodulation_hz = 200.0",
        "`conditions.0.modulation_hz`",
        "0.1 to 50 Hz",
    ),
    (
        "name = \"am-6hz-95\"",
        "name = \"a\"\n[[conditions]]\nname = \"b\"",
        "name = \"a\"\n[[conditions]]\nname = \"a\"",
        "`conditions.1.name`",
        "no other",
    ),
    (
        "name = \"am-6hz-95\"",
        "name = \"a\"",
        "name = \"A b\"",
        "`conditions.0.name`",
        "a-z, 0-9",
    ),
    (
        "practice = 2",
        "practice = 0",
        "practice = 101",
        "`trials.practice`",
        "0 to 100",
    ),
    (
        "per_condition = 10",
        "per_condition = 1",
        "per_condition = 0",
        "`trials.per_condition`",
        "1 to 1000",
    ),
    (
        "order = \"fixed\"",
        "order = \"randomised\"",
        "order = \"counterbalanced\"",
        "`trials.order`",
        "single condition",
    ),
    (
        "directions = [\"left_to_right\", \"right_to_left\"]",
        "directions = [\"left_to_right\"]",
        "directions = []",
        "`exploration.directions`",
        "1 to 20",
    ),
    (
        "from_m = 0.010",
        "from_m = -0.04",
        "from_m = -10",
        "`exploration.from_m`",
        "-1 to 1 m",
    ),
    (
        "to_m = 0.095",
        "to_m = 0.1",
        "to_m = 95.0",
        "`exploration.to_m`",
        "-1 to 1 m",
    ),
    (
        "to_m = 0.095",
        "to_m = 0.09",
        "to_m = 0.005",
        "`exploration.to_m`",
        "at least 0.01 m beyond",
    ),
    (
        "speed_m_per_s = 0.050",
        "speed_m_per_s = 0.1",
        "speed_m_per_s = 50",
        "`exploration.speed_m_per_s`",
        "0.001 to 1 m/s",
    ),
    (
        "settle_s = 0.2",
        "settle_s = 1",
        "settle_s = 0",
        "`timing.settle_s`",
        "0.1 to 60 s",
    ),
    (
        "baseline_s = 0.8",
        "baseline_s = 2",
        "baseline_s = 0.1",
        "`timing.baseline_s`",
        "0.2 to 60 s",
    ),
    (
        "countdown_s = 3.0",
        "countdown_s = 0",
        "countdown_s = -1",
        "`timing.countdown_s`",
        "0 to 60 s",
    ),
    (
        "feedback_s = 3.0",
        "feedback_s = 0",
        "feedback_s = nan",
        "`timing.feedback_s`",
        "0 to 60 s",
    ),
    (
        "verdict_s = 2.0",
        "verdict_s = 0",
        "verdict_s = inf",
        "`timing.verdict_s`",
        "0 to 60 s",
    ),
    (
        "min_n = 0.5",
        "min_n = 0.3",
        "min_n = 0.05",
        "`force.contact_n`",
        "less than `min_n` = 0.05 N",
    ),
    (
        "max_n = 0.8",
        "max_n = 0.9",
        "max_n = 0.4",
        "`force.max_n`",
        "more than `min_n` = 0.5 N",
    ),
    (
        "max_n = 0.8",
        "max_n = 20",
        "max_n = 800",
        "`force.max_n`",
        "0.02 to 20 N",
    ),
    (
        "contact_n = 0.1",
        "contact_n = 0.05",
        "contact_n = 0.001",
        "`force.contact_n`",
        "0.01 to 5 N",
    ),
    (
        "min_s = 60.0",
        "min_s = 0",
        "min_s = 60000",
        "`rest.min_s`",
        "0 to 3600 s",
    ),
    (
        "max_per_trial = 3",
        "max_per_trial = 0",
        "max_per_trial = 1001",
        "`redo.max_per_trial`",
        "0 to 1000",
    ),
    (
        "central_m = 0.060",
        "central_m = 0.085",
        "central_m = 0.1",
        "`selection.central_m`",
        "travel of 0.0850 m",
    ),
    (
        "speed_tolerance = 0.25",
        "speed_tolerance = 0.1",
        "speed_tolerance = 25",
        "`selection.speed_tolerance`",
        "0.01 to 0.9",
    ),
    (
        "instance_s = 0.060",
        "instance_s = 0.03",
        "instance_s = 60",
        "`selection.instance_s`",
        "0.005 to 1 s",
    ),
    (
        "place_finger_s = 60.0",
        "place_finger_s = 1",
        "place_finger_s = 0.5",
        "`timeouts.place_finger_s`",
        "1 to 3600 s",
    ),
];

#[test]
fn each_rule_accepts_and_rejects_and_names_key_and_range() {
    for (line, accepted, rejected, key, allowed) in RULES {
        with(line, accepted).unwrap_or_else(|error| panic!("{accepted}: {error}"));
        let error = with(line, rejected).expect_err(rejected);
        let message = error.to_string();
        assert!(message.contains(key), "{message} does not name {key}");
        assert!(
            message.contains(allowed),
            "{message} does not say {allowed}"
        );
        assert!(
            matches!(error, ProtocolError::Value { line: Some(_), .. }),
            "{message}"
        );
    }
}

#[test]
fn a_range_error_names_the_line() {
    let error = with("speed_m_per_s = 0.050", "speed_m_per_s = 50").unwrap_err();
    let line = 1 + text()
        .lines()
        .position(|l| l.starts_with("speed_m_per_s"))
        .unwrap();
    assert_eq!(
        error.to_string(),
        format!(
            "p.toml, line {line}: `exploration.speed_m_per_s` = 50 m/s is not allowed; allowed: 0.001 to 1 m/s"
        )
    );
}

#[test]
fn a_condition_overrides_what_it_names_and_keeps_the_rest() {
    let p = with(
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

#[test]
fn another_word_for_the_carrier_is_an_error_that_says_which_is_right() {
    let message = with("\"plate resonance\"", "\"resonance\"")
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("plate resonance") && message.contains("line "),
        "{message}"
    );
}

#[test]
fn a_typing_error_names_the_nearest_key() {
    let message = with("baseline_s", "base_line_s").unwrap_err().to_string();
    assert!(message.contains("did you mean `baseline_s`?"), "{message}");
}

#[test]
fn a_missing_section_is_named() {
    let message = with("[quality]", "").unwrap_err().to_string();
    assert!(
        message.contains("line") && message.contains("unknown key"),
        "{message}"
    );
    let cut = text().find("[timeouts]").unwrap();
    let message = Protocol::parse(&text()[..cut], "p.toml")
        .unwrap_err()
        .to_string();
    assert_eq!(message, "p.toml: key `timeouts` is missing");
}

#[test]
fn the_slider_rests_at_its_ends() {
    let p = Protocol::parse(text(), "huloux2021.toml").unwrap();
    let slider = p.exploration.slider(Direction::RightToLeft);
    assert_eq!(slider.position_m(-1.0), 0.095);
    assert_eq!(slider.position_m(slider.duration_s() + 1.0), 0.010);
    assert!((slider.position_m(1.0) - 0.045).abs() < 1e-12);
}
