//! Tests that the template of `bench.toml` is complete and correct.

use super::*;

#[test]
fn the_template_parses_with_its_optional_keys_and_without() {
    let config = Config::parse(TEMPLATE, "template").unwrap();
    assert_eq!(config.safety, Safety::default());
    assert!(config.safety.waived.is_empty());
    let full = Config::parse(&whole_template(), "template").unwrap();
    assert_eq!(
        full.safety.waived,
        [HardwareStop::Estop, HardwareStop::Heartbeat]
    );
}

#[test]
fn an_optional_key_stands_there_with_its_default() {
    let config = Config::parse(TEMPLATE, "template").unwrap();
    let full = Config::parse(&whole_template(), "template").unwrap();
    // Examples for keys without a default.
    let expected = Config {
        audio: Audio {
            buffer_frames: full.audio.buffer_frames,
            ..config.audio
        },
        safety: Safety {
            waived: full.safety.waived.clone(),
            waived_by: full.safety.waived_by.clone(),
            dead_man: full.safety.dead_man,
            ..config.safety
        },
        limits: Limits {
            audible_carrier_because: full.limits.audible_carrier_because.clone(),
            unchecked_volts_because: full.limits.unchecked_volts_because.clone(),
            ..config.limits
        },
        force: config.force.clone().map(|force| Force {
            range_n: full.force.as_ref().and_then(|force| force.range_n),
            ..force
        }),
        gpio: full.gpio.clone(),
        room: full.room,
        plate: Plate {
            width_m: full.plate.width_m,
            thickness_m: full.plate.thickness_m,
            wavelength_across_m: full.plate.wavelength_across_m,
            wavelength_across_relative_error: full.plate.wavelength_across_relative_error,
            ..config.plate
        },
        field_box: full.field_box.clone(),
        nidaqmx: full.nidaqmx.clone(),
        calibration: CalibrationRules {
            gravity_m_per_s2: full.calibration.gravity_m_per_s2,
            ..config.calibration
        },
        ..config
    };
    assert_eq!(full, expected);
}

#[test]
fn every_key_stands_in_the_template() {
    let text = whole_template();
    let tables = [
        "audio",
        "output",
        "channels.drive",
        "channels.pickup",
        "plate",
        "room",
        "limits",
        "safety",
        "force",
        "force.channels",
        "force.netft",
        "force.field_box",
        "encoder",
        "gpio",
        "field_box",
        "nidaqmx",
        "sound",
        "calibration",
    ];
    let mut keys = 0;
    for table in tables {
        let header = text
            .lines()
            .find(|line| line.starts_with(&format!("[{table}]")))
            .unwrap_or_else(|| panic!("no [{table}]"));
        let unknown_key = text.replacen(header, &format!("{header}\nunknown_key = 0"), 1);
        let error = Config::parse(&unknown_key, "template").unwrap_err();
        let ConfigError::Toml(strict_toml::TomlError::UnknownKey { known, .. }) = error else {
            panic!("[{table}]: {error:?}");
        };
        for key in known {
            let path = format!("{table}.{key}");
            assert!(strict_toml::line_of(&text, &path).is_some(), "no {path}");
            keys += 1;
        }
    }
    let unknown_key = format!("unknown_key = 0\n{text}");
    let error = Config::parse(&unknown_key, "template").unwrap_err();
    let ConfigError::Toml(strict_toml::TomlError::UnknownKey { known, .. }) = error else {
        panic!("{error:?}");
    };
    for key in known {
        assert!(strict_toml::line_of(&text, &key).is_some(), "no {key}");
        let is_table = tables
            .iter()
            .any(|table| table.split('.').next() == Some(key.as_str()));
        assert!(is_table || key == "format", "{key} is not looked into");
    }
    assert!(keys > 60, "{keys}");
}
