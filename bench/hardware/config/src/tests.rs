//! Ranges of the configuration: each key with accepted and rejected values.

use super::*;
use crate::Correction;

const BENCH: &str = rigs::MOCK_BENCH;

fn with_force(keys: &str) -> Result<Config, ConfigError> {
    let text = BENCH.replacen("[force]\n", &format!("[force]\n{keys}\n"), 1);
    Config::parse(&text, "bench.toml")
}

#[test]
fn every_number_of_a_plate_or_force_calibration_has_a_range() {
    for (key, accepted, rejected) in [
        ("clock_ppm", "0.0", "-1.0"),
        ("gravity_m_per_s2", "9.8128", "9.9"),
        ("force_rest_n", "0.001", "0.1"),
        ("force_nonlinearity", "0.02", "0.3"),
        ("force_error", "0.01", "0.0"),
        ("force_crosstalk", "0.1", "0.4"),
        ("force_noise_n_per_sqrt_hz", "1.0e-4", "1.0"),
        ("force_drift_n_per_min", "0.1", "2.0"),
        ("force_zero_return_n", "0.02", "0.0"),
    ] {
        let bench_with = |value: &str| {
            Config::parse(
                &format!("{BENCH}\n[calibration]\n{key} = {value}\n"),
                "bench.toml",
            )
        };
        assert!(bench_with(accepted).is_ok(), "{key}");
        let message = format!("{:#}", bench_with(rejected).unwrap_err());
        assert!(
            message.contains(&format!("calibration.{key}")) && message.contains("range"),
            "{message}"
        );
    }
}

/// Hazard 8.
#[test]
fn each_force_limit_has_its_range_and_a_default() {
    for key in ["max_normal_n", "max_lateral_n"] {
        let line = BENCH.lines().find(|line| line.starts_with(key)).unwrap();
        let bench_with = |text: &str| Config::parse(&BENCH.replace(line, text), "bench.toml");
        let refusal = |text: &str| format!("{:#}", bench_with(text).unwrap_err());
        assert_eq!(bench_with("").unwrap().safety.max_forces_n(), [3.0, 3.0]);
        for value in ["0.1", "1.5", "20.0"] {
            bench_with(&format!("{key} = {value}")).unwrap();
        }
        for value in ["0.0", "-3.0", "20.1", "nan"] {
            let message = refusal(&format!("{key} = {value}"));
            assert!(
                message.contains(&format!("safety.{key}")) && message.contains("0.1 to 20 N"),
                "{message}"
            );
        }
        let typo = refusal(&format!("{} = 3.0", key.replace("max", "mx")));
        assert!(typo.contains(&format!("`{key}`")), "{typo}");
    }
}

/// Hazard 19.
#[test]
fn a_force_matrix_that_could_hide_a_press_is_refused() {
    let config = with_force("matrix = [[1.1, 0.02], [-0.03, 0.9]]\ntare_n = [0.1, 0.2]");
    let force = config.unwrap().force.unwrap();
    assert_eq!(force.correction().tare_n, [0.1, 0.2]);
    assert_eq!(
        with_force("").unwrap().force.unwrap().correction(),
        Correction::default()
    );
    for (keys, word) in [
        ("matrix = [[0.1, 0.0], [0.0, 1.0]]", "force.matrix"),
        ("tare_n = [5.0, 0.0]", "safety.max_normal_n = 3"),
        ("tare_n = [0.0, -5.0]", "safety.max_lateral_n = 3"),
    ] {
        let message = format!("{:#}", with_force(keys).unwrap_err());
        assert!(message.contains(word), "{message}");
    }
}

/// Parses the simulated bench's description after `change`.
fn described(change: impl FnOnce(String) -> String) -> Result<Config, ConfigError> {
    Config::parse(&change(rigs::MOCK_BENCH.to_owned()), "bench.toml")
}

#[test]
fn each_limit_of_the_channels_has_its_range() {
    for (key, accepted, rejected) in [
        ("input_noise_units_per_sqrt_hz", "2e-7", "0.01"),
        ("crosstalk_db", "-80.0", "3.0"),
        ("input_nonlinearity", "0.001", "0.5"),
        ("delay_samples", "2.0", "0.0"),
        ("input_error", "1e-4", "0.2"),
    ] {
        let bench_with =
            |value: &str| described(|text| format!("{text}\n[calibration]\n{key} = {value}\n"));
        assert!(bench_with(accepted).is_ok(), "{key} = {accepted}");
        let error = format!("{:#}", bench_with(rejected).unwrap_err());
        assert!(error.contains(&format!("calibration.{key}")), "{error}");
        assert!(error.contains("outside the allowed range"), "{error}");
    }
}

#[test]
fn a_clip_level_is_a_part_of_full_scale() {
    for channel in ["drive", "pickup"] {
        let bench_with = |value: &str| {
            described(|text| {
                text.replacen(
                    &format!("[channels.{channel}]"),
                    &format!("[channels.{channel}]\nclip_units = {value}"),
                    1,
                )
                .replacen("   # voltage", "\n# voltage", 1)
            })
        };
        assert!(bench_with("0.5").is_ok(), "{channel}");
        let error = format!("{:#}", bench_with("1.5").unwrap_err());
        assert!(
            error.contains(&format!("channels.{channel}.clip_units")),
            "{error}"
        );
    }
}

/// Fault 33.
#[test]
fn what_is_refused_has_its_key_its_line_and_what_is_allowed() {
    let drive_v = BENCH.lines().find(|line| line.starts_with("drive_v"));
    let text = BENCH.replacen(drive_v.unwrap(), "drive_v = 1000.0", 1);
    let line = 1 + text
        .lines()
        .position(|line| line == "drive_v = 1000.0")
        .unwrap();
    let message = Config::parse(&text, "bench.toml").unwrap_err().to_string();
    for word in [
        &format!("bench.toml, line {line}: limits.drive_v = 1000 V"),
        "0 to 150 V",
    ] {
        assert!(message.contains(word), "no {word:?} in {message}");
    }
    for (section, key, value) in [
        ("force", "latency_s", "1.0"),
        ("force", "baud", "300"),
        ("safety", "readback_floor_v", "nan"),
        ("encoder", "origin_m", "inf"),
    ] {
        let line = |line: &&str| line.starts_with(&format!("{key} ="));
        let text = match BENCH.lines().find(line) {
            Some(line) => BENCH.replacen(line, &format!("{key} = {value}"), 1),
            None => BENCH.replacen(
                &format!("[{section}]\n"),
                &format!("[{section}]\n{key} = {value}\n"),
                1,
            ),
        };
        let message = Config::parse(&text, "bench.toml").unwrap_err().to_string();
        let key = format!("{section}.{key} = ");
        assert!(
            message.contains(", line ") && message.contains(&key),
            "{message}"
        );
    }
}

#[test]
fn the_ambient_pressure_is_optional_and_in_hectopascals() {
    let with_room = |table: &str| Config::parse(&format!("{BENCH}\n{table}\n"), "bench.toml");
    let config = with_room("").unwrap();
    assert_eq!(config.room.pressure_hpa, None);
    assert!(!config.to_toml().unwrap().contains("[room]"));
    for pressure_hpa in Room::PRESSURE_HPA {
        let config = with_room(&format!("[room]\npressure_hpa = {pressure_hpa:?}")).unwrap();
        assert_eq!(config.room.pressure_hpa, Some(pressure_hpa));
        let copy = Config::parse(&config.to_toml().unwrap(), "copy").unwrap();
        assert_eq!(copy, config);
    }
    for wrong in ["101325.0", "499.9", "nan"] {
        let error = with_room(&format!("[room]\npressure_hpa = {wrong}")).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("room.pressure_hpa"), "{message}");
        assert!(message.contains("500 to 1100 hPa"), "{message}");
    }
    let error = with_room("[room]\npresure_hpa = 950.0").unwrap_err();
    assert!(error.to_string().contains("pressure_hpa"), "{error}");
}

#[test]
fn a_session_replaces_the_ambient_pressure_of_the_configuration() {
    let text = format!("{BENCH}\n[room]\npressure_hpa = 950.0\n");
    let bench = Effective::uncalibrated(Config::parse(&text, "bench.toml").unwrap());
    let session = bench.clone().with_ambient_pressure("--pressure-hpa", 850.0);
    assert_eq!(session.unwrap().config().room.pressure_hpa, Some(850.0));
    let error = bench.with_ambient_pressure("--pressure-hpa", 1200.0);
    assert_eq!(
        error.unwrap_err().to_string(),
        "--pressure-hpa = 1200 hPa is outside the allowed range of 500 to 1100 hPa"
    );
}

fn with_safety(keys: &str) -> Result<Config, ConfigError> {
    let text = BENCH.replacen("[safety]\n", &format!("[safety]\n{keys}\n"), 1);
    Config::parse(&text, "bench.toml")
}

#[test]
fn a_waiver_needs_a_name_and_known_lines() {
    let waived = with_safety("waived = [\"estop\"]\nwaived_by = \"A. Tester\"")
        .unwrap()
        .safety;
    assert_eq!(waived.waiver_of(HardwareStop::Estop), Some("A. Tester"));
    assert_eq!(waived.waiver_of(HardwareStop::Heartbeat), None);
    for (keys, line_of) in [
        ("waived = [\"estop\"]", "waived"),
        ("waived = [\"estop\"]\nwaived_by = \" \"", "waived_by"),
        (
            "waived = [\"estop\", \"estop\"]\nwaived_by = \"A. Tester\"",
            "waived",
        ),
    ] {
        let ConfigError::Value { line, why, .. } = with_safety(keys).unwrap_err() else {
            panic!("{keys}");
        };
        let safety = 1 + BENCH.lines().position(|line| line == "[safety]").unwrap();
        let expected_line = safety + if line_of == "waived" { 1 } else { 2 };
        assert_eq!(line, Some(expected_line), "{keys}: {why}");
    }
    let unknown = with_safety("waived = [\"estopp\"]\nwaived_by = \"A. Tester\"").unwrap_err();
    let ConfigError::Toml(strict_toml::TomlError::UnknownValue {
        nearest, allowed, ..
    }) = unknown
    else {
        panic!("{unknown:?}");
    };
    assert_eq!(nearest.as_deref(), Some("estop"));
    assert_eq!(allowed, ["estop", "heartbeat"]);
}

#[test]
fn a_bench_without_a_waiver_is_written_as_before() {
    let text = Config::parse(BENCH, "bench.toml")
        .unwrap()
        .to_toml()
        .unwrap();
    assert!(!text.contains("waived"), "{text}");
    let waived = with_safety("waived = [\"heartbeat\"]\nwaived_by = \"A. Tester\"").unwrap();
    let reread = Config::parse(&waived.to_toml().unwrap(), "bench.toml").unwrap();
    assert_eq!(reread, waived);
}
