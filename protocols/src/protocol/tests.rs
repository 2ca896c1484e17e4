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
