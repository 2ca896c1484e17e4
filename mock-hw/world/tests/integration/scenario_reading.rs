//! Scenarios are parsed strictly, survive writing, are found by name and draw their constants from the seed.

use mock_world::scenario::{
    ChannelSlip, ParticipantTable, Scenario, ScenarioError, SoundLayerTable, built_in,
    built_in_names,
};
use strict_toml::TomlError;

fn parse(text: &str) -> Result<Scenario, ScenarioError> {
    Scenario::parse(text, "test.toml")
}

/// Returns the key that is out of range, and its line.
fn out_of_range(text: &str) -> (String, Option<usize>) {
    match parse(text) {
        Err(ScenarioError::OutOfRange { line, range, .. }) => (range.key, line),
        result => panic!("{text}: {result:?}"),
    }
}

#[test]
fn an_empty_file_is_the_nominal_bench() {
    assert_eq!(parse(""), Ok(Scenario::default()));
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_key() {
    for (text, (line, wrong, right)) in [
        (
            "[plate]\nresonance_hz = 35000.0\nmodal_mas_kg = 0.008\n",
            (3, "modal_mas_kg", "modal_mass_kg"),
        ),
        ("[platte]\n", (1, "platte", "plate")),
        ("[sound_layer]\nrate = 48000.0\n", (2, "rate", "rate_hz")),
    ] {
        match parse(text) {
            Err(ScenarioError::Toml(TomlError::UnknownKey {
                file,
                line: at,
                key,
                nearest,
                ..
            })) => assert_eq!(
                (file.as_str(), at, key.as_str(), nearest.as_deref()),
                ("test.toml", line, wrong, Some(right))
            ),
            result => panic!("{text}: {result:?}"),
        }
    }
}

#[test]
fn a_wrong_type_is_named_with_its_line() {
    let error = parse("\n[plate]\nresonance_hz = \"high\"\n").unwrap_err();
    assert!(
        matches!(
            error,
            ScenarioError::Toml(TomlError::WrongType { line: 3, .. })
        ),
        "{error}"
    );
}

#[test]
fn a_number_out_of_range_names_file_line_key_value_and_range() {
    let error = parse("[participant]\nmu0 = 8.0\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "test.toml, line 2: participant.mu0 = 8 is outside the allowed range of 0.05 to 3"
    );
    let location = |key: &str, line| (key.to_owned(), Some(line));
    assert_eq!(
        out_of_range("[film]\nlag_s = nan\n"),
        location("film.lag_s", 2)
    );
    assert_eq!(
        out_of_range("\n[participant]\nz_t_n_s_per_m = [0.5, 0.1]\n"),
        location("participant.z_t_n_s_per_m (imaginary)", 3)
    );
    assert_eq!(
        out_of_range("[jitter]\nquality = [300.0, 200.0]\n"),
        location("jitter.quality", 2)
    );
}

#[test]
fn a_sound_layer_is_held_to_the_channels_of_the_converter() {
    let sound = "[converter]\ngains = [1.0, -2.0]\n[sound_layer]\nrate_hz = 48000.0\nanti_alias = false\n\
                 inputs = [1, 0]\nslip = { channel = 1, samples = 2, after_s = 3.0 }\n";
    let layer = parse(sound).unwrap().sound_layer;
    assert_eq!((layer.rate_hz, layer.inputs), (Some(48e3), vec![1, 0]));
    let slip = |channel: u8, samples: u8, after_s: f64| {
        format!(
            "[sound_layer]\nslip = {{ channel = {channel}, samples = {samples}, after_s = {after_s:?} }}\n"
        )
    };
    for (text, key) in [
        ("[converter]\ngains = [1.0, 200.0]\n", "converter.gains"),
        (
            "[converter]\ngains = [1, 1, 1, 1, 1]\n",
            "converter.gains (entries)",
        ),
        ("[sound_layer]\nrate_hz = 1000.0\n", "sound_layer.rate_hz"),
        ("[sound_layer]\ninputs = [4]\n", "sound_layer.inputs"),
        (
            "[sound_layer]\ninputs = [0, 1, 2, 3, 3]\n",
            "sound_layer.inputs (entries)",
        ),
        (&slip(9, 1, 1.0), "sound_layer.slip.channel"),
        (&slip(1, 0, 1.0), "sound_layer.slip.samples"),
        (&slip(1, 1, -1.0), "sound_layer.slip.after_s"),
    ] {
        assert_eq!(out_of_range(text), (key.to_owned(), Some(2)));
    }
}

#[test]
fn a_scenario_survives_writing_and_reading() {
    let scenario = Scenario {
        sound_layer: SoundLayerTable {
            rate_hz: Some(44_100.0),
            slip: Some(ChannelSlip {
                channel: 1,
                samples: 1,
                after_s: 2.0,
            }),
            ..SoundLayerTable::default()
        },
        participant: ParticipantTable {
            mu0: Some(0.9),
            z_t_n_s_per_m: Some([0.4, 3.0]),
            ..ParticipantTable::default()
        },
        ..Scenario::default()
    };
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(parse(&text).unwrap(), scenario);
}

#[test]
fn jitter_is_off_by_default_deterministic_and_within_its_limits() {
    let nominal = Scenario::default();
    assert_eq!(nominal.draw(7), nominal);
    let mut scenario = nominal.clone();
    scenario.jitter.enabled = true;
    assert_eq!(scenario.draw(7), scenario.draw(7));
    assert_ne!(scenario.draw(7), scenario.draw(8));
    assert_eq!(scenario.draw(7).draw(7), scenario.draw(7));
    for seed in 0..200 {
        let r = scenario.draw(seed);
        let q = r.plate.omega_rad_per_s() * r.plate.modal_mass_kg / r.plate.damping_n_s_per_m;
        assert!((150.0..=350.0).contains(&q));
        assert!((r.plate.resonance_hz - 35e3).abs() <= 300.0);
        assert!((r.pickup.metres_per_unit / 5.0e-6 - 1.0).abs() <= 0.2);
        assert!((r.pickup.phase_rad - 0.2).abs() <= 0.5);
        assert!((r.plate.force_factor_n_per_v / 0.13 - 1.0).abs() <= 0.2);
        assert!(
            r.converter
                .skew_samples
                .iter()
                .all(|s| (0.0..=1.0).contains(s))
        );
        let force = &r.force_sensor;
        for gain in [force.normal_gain, force.lateral_gain] {
            assert!((gain - 1.0).abs() <= 0.2);
        }
        for crosstalk in [force.lateral_to_normal, force.normal_to_lateral] {
            assert!(crosstalk.abs() <= 0.05);
        }
        for offset_n in [force.normal_offset_n, force.lateral_offset_n] {
            assert!(offset_n.abs() <= 0.03);
        }
        for drift in [force.normal_drift_n_per_min, force.lateral_drift_n_per_min] {
            assert!(drift.abs() <= 0.005);
        }
        assert!((0.0..=0.003).contains(&r.masses.pulley_friction));
    }
}

#[test]
fn every_built_in_scenario_reads() {
    for name in built_in_names() {
        assert!(!built_in(name).unwrap().purpose.is_empty(), "{name}");
    }
}

#[test]
fn an_unknown_name_suggests_the_nearest_one_also_by_a_part_of_it() {
    let suggestion = |name: &str| match built_in(name) {
        Err(ScenarioError::UnknownName { nearest, names, .. }) => {
            assert_eq!(names, built_in_names());
            nearest
        }
        result => panic!("{result:?}"),
    };
    assert_eq!(suggestion("nominl").as_deref(), Some("nominal"));
    assert_eq!(suggestion("late").as_deref(), Some("participant-late"));
    assert_eq!(suggestion("unknown").as_deref(), Some("bench-unknown"));
    assert_eq!(suggestion("adhesion").as_deref(), Some("laws/adhesion"));
    assert_eq!(
        suggestion("laws/film-leak").as_deref(),
        Some("laws/film-leaks")
    );
    assert_eq!(suggestion("xyzzy"), None);
    assert_eq!(
        built_in("nominl").unwrap_err().to_string(),
        format!(
            "unknown scenario `nominl`, did you mean `nominal`?; built-in scenarios: {}",
            built_in_names().join(", ")
        )
    );
}

#[test]
fn faults_are_read_and_written_and_invalid_ones_are_named_with_their_line() {
    use faults::{FaultKind, RehearsedFault, RehearsedFaultError};

    let text = "[[faults]]\nfault = \"press\"\nat_s = 5.0\nuntil_s = 6.0\nargument = 4.5\n";
    let scenario = parse(text).unwrap();
    let fault = RehearsedFault {
        fault: FaultKind::Press,
        at_s: 5.0,
        until_s: Some(6.0),
        argument: Some(4.5),
    };
    assert_eq!(scenario.faults, [fault]);
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(parse(&text).unwrap(), scenario);

    let fault_error = |text: &str| match parse(text) {
        Err(ScenarioError::Fault(error)) => (error.line, error.error),
        result => panic!("{text}: {result:?}"),
    };
    let (line, error) = fault_error(
        "[[faults]]\nfault = \"xrun\"\nat_s = 1.0\n[[faults]]\nfault = \"xrun\"\nat_s = -1.0\n",
    );
    assert!(
        matches!(error, RehearsedFaultError::OutOfRange(_)) && line == Some(6),
        "{error}"
    );
    let (line, error) = fault_error("[[faults]]\nfault = \"xrun\"\nat_s = 1.0\nuntil_s = 2.0\n");
    assert!(
        matches!(error, RehearsedFaultError::NoEnd { .. }) && line == Some(4),
        "{error}"
    );
    let (line, error) = fault_error("[[faults]]\nfault = \"nan\"\nat_s = nan\n");
    assert!(
        matches!(error, RehearsedFaultError::OutOfRange(_)) && line == Some(3),
        "{error}"
    );

    let overlap =
        "[[faults]]\nfault = \"estop\"\nat_s = 1.0\n[[faults]]\nfault = \"estop\"\nat_s = 2.0\n";
    assert!(matches!(parse(overlap), Err(ScenarioError::Overlap { .. })));
    let unknown = parse("[[faults]]\nfault = \"e-stop\"\nat_s = 1.0\n").unwrap_err();
    assert!(matches!(unknown, ScenarioError::Toml(_)), "{unknown:?}");
    assert!(unknown.to_string().contains("`estop`"), "{unknown}");
    let key = parse("[[faults]]\nfault = \"estop\"\nat = 1.0\n").unwrap_err();
    assert!(
        matches!(
            key,
            ScenarioError::Toml(TomlError::UnknownKey {
                nearest: Some(_),
                ..
            })
        ),
        "{key:?}"
    );
}
