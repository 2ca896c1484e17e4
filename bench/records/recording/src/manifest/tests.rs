//! Tests of reading, writing and rejecting manifests.

use strict_toml::TomlError;

use super::*;

/// Example of the format's documentation, written by hand as in another laboratory.
const EXAMPLE: &str = r#"format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95

[channels.drive]              # voltage across the actuators
index = 0
volts_per_unit = 1.0

[channels.pickup]
index = 1
metres_per_unit = 2.0e-6
phase_rad = 0.0

[plate]
resonance_hz = 35000.0
modal_mass_kg = 0.008
force_factor_n_per_v = 0.13
centre_m = 0.0525

[[intervals]]
kind = "unloaded"
start_s = 0.2
end_s = 1.0

[[intervals]]
kind = "exploration"
direction = "left_to_right"
start_s = 1.4
end_s = 3.1
"#;

const BENCH_TABLES: &str = r#"
[standard_errors]
amplitude_relative = 0.004
impedance_relative = 0.006

[room]
pressure_hpa = 850.0

[participant]
id = "sub-01"
session = 1

[trial]
number = 3
attempt = 1
practice = false
condition = "6 Hz"
protocol = "huloux2021"
seed = 42

[hardware]
input_device = "hw:1,0"
output_device = "hw:1,0"
sample_rate_hz = 192000
sample_format = "i32"
channel_names = ["drive", "pickup"]
uncalibrated = true

[software]
name = "friction-bench"
version = "0.1.0"

[[clocks]]
of = "force_sensor"
drift_ppm = 4975.1
residual_s = 1.3e-5

[[events]]
kind = "gap"
sample = 1000
frames = 64
"#;

fn parse(text: &str) -> Result<Manifest, ManifestReadError> {
    Manifest::parse(text, "recording.toml")
}

fn full_manifest() -> Manifest {
    parse(&format!("{EXAMPLE}{BENCH_TABLES}")).unwrap()
}

#[test]
fn a_recording_made_elsewhere_needs_the_fixed_tables_only() {
    let manifest = parse(EXAMPLE).unwrap();
    assert_eq!(
        manifest.signals().unwrap().channels.pickup.metres_per_unit,
        2.0e-6
    );
    assert_eq!(
        manifest.intervals[1].kind,
        RecordedIntervalKind::Exploration(Direction::LeftToRight)
    );
    assert_eq!(manifest.trial, None);
}

#[test]
fn a_written_manifest_reads_back_with_the_same_bytes() {
    let mut manifest = full_manifest();
    // 0.1 + 0.2 and 1e-300 need every digit of a double.
    if let Streams::Signals(signals) = &mut manifest.streams {
        signals.plate.centre_m = 0.1 + 0.2;
        signals.channels.pickup.metres_per_unit = 1e-300;
    }
    let text = manifest.to_toml().unwrap();
    assert_eq!(parse(&text).unwrap(), manifest);
    assert_eq!(manifest.clone().to_toml().unwrap(), text);
}

#[test]
fn unknown_keys_are_named_with_line_and_nearest_key_in_every_table() {
    let full_text = format!("{EXAMPLE}{BENCH_TABLES}");
    for (right, wrong, nearest) in [
        ("carrier_hz =", "carier_hz =", "carrier_hz"),
        ("volts_per_unit", "volt_per_unit", "volts_per_unit"),
        ("phase_rad", "phase_deg", "phase_rad"),
        ("modal_mass_kg", "modal_mass_g", "modal_mass_kg"),
        ("end_s", "end_ms", "end_s"),
        ("amplitude_relative", "amplitude_um", "amplitude_relative"),
        ("pressure_hpa", "pressure_mbar", "pressure_hpa"),
        ("session = 1", "sesion = 1", "session"),
        ("condition", "conditions", "condition"),
        ("sample_format", "sample_fromat", "sample_format"),
        ("version =", "versoin =", "version"),
        ("residual_s", "residual_ms", "residual_s"),
        ("frames = 64", "frame = 64", "frames"),
    ] {
        let text = full_text.replacen(right, wrong, 1);
        let wrong_line = text.lines().position(|l| l.contains(wrong)).unwrap() + 1;
        match parse(&text).unwrap_err() {
            ManifestReadError::Toml(TomlError::UnknownKey {
                line, nearest: n, ..
            }) => assert_eq!((line, n.as_deref()), (wrong_line, Some(nearest)), "{wrong}"),
            other => panic!("{wrong}: {other}"),
        }
    }
}

const ORIGIN: &str = r#"
[origin.imported]
version = "0.1.0"
map = { file = "map.toml", sha256 = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08" }
interval_reasons = ["normal < 0.05 N for 0.3 s", "marks.csv, line 2"]

[[origin.imported.sources]]
file = "day 1/S01_T03.mat"
sha256 = "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752"
reader = "hdf5-reader 0.12.1"

[[origin.imported.found]]
name = "normal.offset_s"
value = -0.0042
error = 0.0003
unit = "s"
evidence = "residual of the friction over the shift"
"#;

#[test]
fn the_origin_of_an_import_reads_back_as_it_was_written() {
    assert!(!full_manifest().to_toml().unwrap().contains("origin"));
    let manifest = parse(&format!("{EXAMPLE}{BENCH_TABLES}{ORIGIN}")).unwrap();
    let origin = manifest.origin.as_ref().unwrap();
    let imported = origin.imported.as_ref().unwrap();
    assert_eq!(imported.sources[0].reader, "hdf5-reader 0.12.1");
    assert_eq!(imported.found[0].error, Some(0.0003));
    assert_eq!(imported.interval_reasons.len(), 2);
    assert_eq!(parse(&manifest.to_toml().unwrap()).unwrap(), manifest);
}

#[test]
fn an_invalid_origin_is_refused_with_its_line() {
    for (right, wrong, words) in [
        ("9f86d0", "9F86D0", "64 digits"),
        ("60303ae2", "60303ae", "64 digits"),
        ("\"0.1.0\"\nmap", "\"\"\nmap", "not empty"),
        ("\"hdf5-reader 0.12.1\"", "\" \"", "not empty"),
        ("value = -0.0042", "value = nan", "finite"),
        ("error = 0.0003", "error = -0.0003", "from 0"),
        ("evidence", "evidense", "evidence"),
        ("sources", "source", "sources"),
    ] {
        let text = format!("{EXAMPLE}{ORIGIN}").replacen(right, wrong, 1);
        assert!(text.contains(wrong), "{wrong}");
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.contains(words), "{wrong}: {error}");
        assert!(error.contains(", line "), "{wrong}: {error}");
    }
}

#[test]
fn a_recording_without_a_pressure_has_no_room() {
    let manifest = parse(EXAMPLE).unwrap();
    assert_eq!(manifest.room, None);
    assert!(!manifest.to_toml().unwrap().contains("room"));
    let room = full_manifest().room.unwrap();
    assert_eq!(room.ambient_pressure_pa(), 85_000.0);
}

#[test]
fn a_missing_key_is_named() {
    let error = parse(&EXAMPLE.replace("centre_m = 0.0525\n", "")).unwrap_err();
    assert!(error.to_string().contains("centre_m"), "{error}");
}

#[test]
fn every_rule_refuses_with_line_value_and_range() {
    let full_text = format!("{EXAMPLE}{BENCH_TABLES}");
    for (right, wrong, words) in [
        ("format = 1", "format = 2", "reads format 1 only"),
        ("carrier_hz = 35000.0", "carrier_hz = 0.0", "above 0"),
        ("modulation_hz = 6.0", "modulation_hz = -6.0", "from 0"),
        (
            "pressure_hpa = 850.0",
            "pressure_hpa = 499.9",
            "500 to 1100",
        ),
        (
            "pressure_hpa = 850.0",
            "pressure_hpa = 85000.0",
            "500 to 1100",
        ),
        (
            "modulation_index = 0.95",
            "modulation_index = 1.01",
            "0 to 1",
        ),
        (
            "modulation_index = 0.95",
            "modulation_index = nan",
            "0 to 1",
        ),
        (
            "volts_per_unit = 1.0",
            "volts_per_unit = 0.0",
            "other than 0",
        ),
        (
            "metres_per_unit = 2.0e-6",
            "metres_per_unit = inf",
            "other than 0",
        ),
        ("phase_rad = 0.0", "phase_rad = nan", "finite"),
        ("index = 1", "index = 0", "must differ"),
        ("resonance_hz = 35000.0", "resonance_hz = -1.0", "above 0"),
        ("modal_mass_kg = 0.008", "modal_mass_kg = 0.0", "above 0"),
        ("centre_m = 0.0525", "centre_m = inf", "finite"),
        ("start_s = 0.2", "start_s = -0.2", "from 0"),
        ("end_s = 3.1", "end_s = 1.4", "not after its start"),
        (
            "impedance_relative = 0.006",
            "impedance_relative = 6.0",
            "0 to 0.5",
        ),
        ("drift_ppm = 4975.1", "drift_ppm = nan", "finite"),
        ("residual_s = 1.3e-5", "residual_s = -1.3e-5", "from 0"),
        ("session = 1", "session = 0", "from 1"),
        ("attempt = 1", "attempt = 0", "from 1"),
        ("uncalibrated = true", "uncalibrated = false", "absent"),
        (
            "uncalibrated = true",
            "uncalibrated = true\nwaived = [\"estop\"]",
            "`hardware.waived_by` is absent",
        ),
        (
            "uncalibrated = true",
            "uncalibrated = true\nwaived_by = \"A. Tester\"",
            "`hardware.waived_by` is present",
        ),
    ] {
        assert!(full_text.contains(right), "{right}");
        let text = full_text.replacen(right, wrong, 1);
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.contains(words), "{wrong}: {error}");
        assert!(error.contains(", line "), "{wrong}: {error}");
    }
}

const FORCES: &str = r#"format = 1

[contact]
body = "other"

[[intervals]]
kind = "exploration"
direction = "left_to_right"
start_s = 1.4
end_s = 3.1
"#;

/// Returns the example without its lines from the one that begins with `from` to the one before `to`.
fn shortened(from: &str, to: &str) -> String {
    let (start, end) = (EXAMPLE.find(from).unwrap(), EXAMPLE.find(to).unwrap());
    [&EXAMPLE[..start], &EXAMPLE[end..]].concat()
}

#[test]
fn the_keys_tell_signals_envelopes_and_forces_apart() {
    assert!(parse(EXAMPLE).unwrap().signals().is_some());
    let envelopes = parse(&shortened("[channels.drive]", "[plate]")).unwrap();
    assert!(matches!(envelopes.streams, Streams::Envelopes(_)));
    assert_eq!(envelopes.carrier_hz(), Some(35_000.0));
    assert_eq!(envelopes.plate().unwrap().centre_m, 0.0525);
    let forces = parse(FORCES).unwrap();
    assert_eq!(forces.streams, Streams::Forces(None));
    assert_eq!((forces.plate(), forces.carrier_hz()), (None, None));
    assert_eq!(forces.contact.body, Body::Other);
    let stimulus = "format = 1\nmodulation_hz = 2.0\nmodulation_index = 1.0\n";
    let modulation = parse(&FORCES.replace("format = 1\n", stimulus))
        .unwrap()
        .modulation();
    assert_eq!(modulation.unwrap().frequency_hz, 2.0);
    let moving =
        parse(&EXAMPLE.replace("carrier_hz = 35000.0", "carrier_hz = \"follows\"")).unwrap();
    assert_eq!(moving.signals().unwrap().carrier, Carrier::Follows);
    assert_eq!(moving.carrier_hz(), None);
    for manifest in [envelopes, forces, moving] {
        assert_eq!(parse(&manifest.to_toml().unwrap()).unwrap(), manifest);
    }
}

#[test]
fn a_key_that_the_streams_need_is_named() {
    for (text, words) in [
        (
            shortened("carrier_hz", "modulation_hz"),
            "`carrier_hz` is missing",
        ),
        (
            shortened("modulation_hz", "modulation_index"),
            "`modulation_hz` is missing",
        ),
        (shortened("[plate]", "[[intervals]]"), "`plate` is missing"),
        (
            FORCES.replace("format = 1\n", "format = 1\nmodulation_hz = 2.0\n"),
            "`modulation_index` is missing",
        ),
        (
            FORCES.replace("format = 1\n", "format = 1\ncarrier_hz = 35e3\n"),
            "`modulation_hz` is missing",
        ),
        (
            shortened("[channels.drive]", "[plate]").replacen("35000.0", "\"follows\"", 1),
            "refer to one frequency",
        ),
        (
            EXAMPLE.replace("carrier_hz = 35000.0", "carrier_hz = \"moves\""),
            "\"follows\"",
        ),
        (FORCES.replace("\"other\"", "\"steel\""), "finger"),
    ] {
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn a_rate_that_a_header_cannot_hold_is_stated() {
    let text = EXAMPLE.replace(
        "[channels.drive]",
        "[channels]\nrate_hz = 136533.33333333334\n\n[channels.drive]",
    );
    let manifest = parse(&text).unwrap();
    assert_eq!(
        manifest.validate_audio(136_533, 2),
        Ok(136_533.333_333_333_34)
    );
    let error = manifest.validate_audio(136_532, 2).unwrap_err().to_string();
    assert!(error.contains("signals.wav has 136532 Hz"), "{error}");
    assert_eq!(parse(&manifest.to_toml().unwrap()).unwrap(), manifest);
}

#[test]
fn only_explorations_have_a_direction() {
    let missing_direction = EXAMPLE.replace("direction = \"left_to_right\"\n", "");
    assert!(
        parse(&missing_direction)
            .unwrap_err()
            .to_string()
            .contains("needs a `direction`")
    );
    let extra_direction = EXAMPLE.replace(
        "kind = \"unloaded\"\n",
        "kind = \"unloaded\"\ndirection = \"left_to_right\"\n",
    );
    assert!(
        parse(&extra_direction)
            .unwrap_err()
            .to_string()
            .contains("has no `direction`")
    );
}

#[test]
fn the_largest_seed_is_that_of_a_toml_integer() {
    let mut manifest = full_manifest();
    let mut set_seed = |seed| {
        if let Some(trial) = &mut manifest.trial {
            trial.seed = seed;
        }
        manifest.to_toml()
    };
    assert!(set_seed(MAX_SEED).is_ok());
    assert!(set_seed(MAX_SEED + 1).is_err());
}

#[test]
fn audio_must_fit_the_description() {
    let manifest = full_manifest();
    assert_eq!(manifest.validate_audio(192_000, 2), Ok(192_000.0));
    assert!(matches!(
        manifest.validate_audio(192_000, 1),
        Err(ManifestError::NoSuchChannel { index: 1, .. })
    ));
    assert!(matches!(
        manifest.validate_audio(192_000, 4),
        Err(ManifestError::ChannelNames { names: 2, .. })
    ));
    assert!(matches!(
        manifest.validate_audio(96_000, 2),
        Err(ManifestError::SampleRate { .. })
    ));
    let example = parse(EXAMPLE).unwrap();
    // 2 · (35 000 + 6) Hz is just too low; 1 Hz more is enough.
    let error = example.validate_audio(70_012, 2).unwrap_err();
    assert!(error.to_string().contains("= 70012 Hz"), "{error}");
    assert_eq!(example.validate_audio(70_013, 2), Ok(70_013.0));
}

const PROFILE: &str = "
[plate.profile]
positions_m = [0.005, 0.0525, 0.1]
ratios = [0.92, 1.0, 0.92]
";

fn profile_text() -> String {
    EXAMPLE.replace(
        "centre_m = 0.0525\n",
        &format!("centre_m = 0.0525\n{PROFILE}"),
    )
}

#[test]
fn a_profile_is_optional_and_reads_back_as_it_was_written() {
    assert_eq!(parse(EXAMPLE).unwrap().plate().unwrap().profile, None);
    assert!(
        !parse(EXAMPLE)
            .unwrap()
            .to_toml()
            .unwrap()
            .contains("profile")
    );
    let manifest = parse(&profile_text()).unwrap();
    let profile = manifest.plate().unwrap().profile.as_ref().unwrap();
    assert_eq!(profile.positions_m, [0.005, 0.0525, 0.1]);
    assert_eq!(profile.ratios, [0.92, 1.0, 0.92]);
    let text = format!("{}{BENCH_TABLES}", profile_text());
    let manifest = parse(&text).unwrap();
    assert_eq!(parse(&manifest.to_toml().unwrap()).unwrap(), manifest);
}

const ACROSS: &str = "
[plate.across]
wavelength_m = 0.022
standard_error_m = 3.0e-4
source = \"measured\"
";

fn across_text() -> String {
    let centre = "centre_m = 0.0525\n";
    EXAMPLE.replace(centre, &format!("{centre}{ACROSS}"))
}

#[test]
fn a_wavelength_across_is_optional_and_reads_back_as_it_was_written() {
    let manifest = parse(EXAMPLE).unwrap();
    assert_eq!(manifest.plate().unwrap().across, None);
    assert!(!manifest.to_toml().unwrap().contains("across"));
    let manifest = parse(&across_text()).unwrap();
    let across = manifest.plate().unwrap().across.unwrap();
    assert_eq!(across.wavelength_m, 0.022);
    assert_eq!(across.source, WavelengthSource::Measured);
    assert_eq!((across.crest_m, across.crest_standard_error_m), (0.0, 0.0));
    // A profile along the plate is another table.
    let crest = "crest_m = -0.0004\ncrest_standard_error_m = 1.0e-4\nsource";
    let text = across_text().replacen("source", crest, 1);
    let text = format!("{text}{PROFILE}{BENCH_TABLES}");
    let manifest = parse(&text).unwrap();
    assert!(manifest.plate().unwrap().profile.is_some());
    assert_eq!(manifest.plate().unwrap().across.unwrap().crest_m, -4e-4);
    assert_eq!(parse(&manifest.to_toml().unwrap()).unwrap(), manifest);
}

#[test]
fn an_invalid_wavelength_across_is_refused_with_its_line() {
    for (right, wrong, words) in [
        ("wavelength_m = 0.022", "wavelength_m = 0.0", "0.008 to 1"),
        ("wavelength_m = 0.022", "wavelength_m = nan", "0.008 to 1"),
        ("wavelength_m = 0.022", "wavelength_m = 22.0", "0.008 to 1"),
        (
            "wavelength_m = 0.022",
            "wavelength_m = 0.0079",
            "a fingertip is wider",
        ),
        ("error_m = 3.0e-4", "error_m = -3.0e-4", "0 to 0.011"),
        ("error_m = 3.0e-4", "error_m = 0.012", "0 to 0.011"),
        ("source", "crest_m = 0.003\nsource", "-0.00275 to 0.00275"),
        ("source", "crest_m = nan\nsource", "-0.00275 to 0.00275"),
        (
            "source",
            "crest_standard_error_m = -1e-4\nsource",
            "0 to 0.00275",
        ),
        ("\"measured\"", "\"guessed\"", "measured"),
        (
            "wavelength_m = 0.022",
            "wavelenght_m = 0.022",
            "wavelength_m",
        ),
    ] {
        let text = across_text().replacen(right, wrong, 1);
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.contains(words), "{wrong}: {error}");
        assert!(error.contains("line "), "{wrong}: {error}");
    }
}

#[test]
fn an_invalid_profile_is_refused_with_its_line() {
    let positions = "positions_m = [0.005, 0.0525, 0.1]";
    let ratios = "ratios = [0.92, 1.0, 0.92]";
    let long_list = format!("ratios = [{}]", "1.0, ".repeat(MAX_ENTRIES + 1));
    for (right, wrong) in [
        (positions, "positions_m = [0.005, 0.0525]"),
        (positions, "positions_m = []"),
        (positions, "positions_m = [0.005, nan, 0.1]"),
        (positions, "positions_m = [0.005, 0.0525, inf]"),
        (positions, "positions_m = [0.005, 0.1, 0.0525]"),
        (positions, "positions_m = [0.005, 0.0525, 0.0525]"),
        (positions, "positions_m = [0.005, 0.0525, 0.0525001]"),
        (ratios, "ratios = [0.92, 1.0]"),
        (ratios, "ratios = [0.92, 1.0, 0.19]"),
        (ratios, "ratios = [0.92, 1.0, 2.01]"),
        (ratios, "ratios = [0.92, 1.0, -1.0]"),
        (ratios, "ratios = [0.92, 1.0, nan]"),
        (ratios, &long_list),
    ] {
        let text = profile_text().replace(right, wrong);
        let error = parse(&text).unwrap_err();
        let has_line = matches!(error, ManifestReadError::Rule { line: Some(_), .. });
        assert!(has_line, "{wrong:.60}: {error:?}");
    }
    let single = profile_text()
        .replace(positions, "positions_m = [0.05]")
        .replace(ratios, "ratios = [1.0]");
    assert!(parse(&single).is_err());
    // The ranges include their ends.
    let [least, greatest] = PROFILE_RATIOS;
    let ends = format!("ratios = [{least:?}, 1.0, {greatest:?}]");
    assert!(parse(&profile_text().replace(ratios, &ends)).is_ok());
}

/// Regression test: the analysis ended with a panic where they overlapped.
#[test]
fn unloaded_intervals_are_in_order_and_apart() {
    let unloaded = |start_s: f64, end_s: f64| RecordedInterval {
        kind: RecordedIntervalKind::Unloaded,
        start_s,
        end_s,
    };
    let manifest = Manifest {
        intervals: [(5.0, 6.0), (0.5, 1.0), (0.2, 0.7), (5.5, 5.6), (2.0, 3.0)]
            .map(|(start_s, end_s)| unloaded(start_s, end_s))
            .to_vec(),
        ..parse(EXAMPLE).unwrap()
    };
    assert_eq!(manifest.unloaded_s(), [(0.2, 1.0), (2.0, 3.0), (5.0, 6.0)]);
}
