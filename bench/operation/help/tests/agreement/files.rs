//! Shipped files and their readers.

use std::fs;
use std::path::{Path, PathBuf};

use config::{CalibrationFile, Config, ConfigError, Identity};
use mock_world::scenario::{Scenario, ScenarioError};
use protocols::{Protocol, ProtocolError};
use recording::manifest::{Manifest, ManifestReadError};
use strict_toml::TomlError;
use toml::Table;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn table(text: &str) -> Table {
    text.parse().unwrap()
}

/// Returns the TOML files below a folder with names accepted by `wanted`.
fn files_below(folder: &str, is_wanted: impl Fn(&str) -> bool) -> Vec<(String, Table)> {
    let mut files = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".toml") && is_wanted(&name) {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path.display().to_string(), table(&text)));
            }
        }
    }
    files.sort_by(|a, b| a.0.cmp(&b.0));
    files
}

/// Returns the shipped files of a kind, with their names.
pub fn shipped_files(name: &str) -> Vec<(String, Table)> {
    let seed = |name: &str| name.starts_with("sound");
    match name {
        "bench" => {
            let mock = table(config::rigs::MOCK_BENCH);
            let mut files = vec![
                ("mock-bench.toml".to_owned(), mock.clone()),
                ("template".to_owned(), table(config::TEMPLATE)),
                (
                    "whole template".to_owned(),
                    table(&config::whole_template()),
                ),
            ];
            // Changes of the simulated bench for other sensors.
            for (sensor, force) in [
                ("channels", config::rigs::MOCK_BENCH_CHANNELS),
                ("netft", config::rigs::MOCK_BENCH_NETFT),
                ("field-box", config::rigs::MOCK_BENCH_FIELD_BOX),
            ] {
                let mut variant = mock.clone();
                variant.extend(table(&format!("[force]\n{force}")));
                files.push((format!("mock-bench-{sensor}.toml"), variant));
            }
            files.extend(files_below("fuzz/seeds/config", seed));
            files
        }
        "calibration" => {
            // No calibration is shipped: a bench that was never calibrated has an empty one.
            let config = Config::parse(config::TEMPLATE, "template").unwrap();
            let identity = Identity::from_config(&config, "in".to_owned(), "out".to_owned());
            let text = CalibrationFile::new(identity).to_text().unwrap();
            vec![("of nothing".to_owned(), table(&text))]
        }
        "protocol" => {
            let all = |name: &str| name != "Cargo.toml" && name != "clippy.toml";
            let mut files = files_below("protocols", all);
            files.extend(files_below("tests/protocols", all));
            files.extend(files_below("fuzz/seeds/protocol", seed));
            files
        }
        "scenario" => {
            let mut files = files_below("mock-hw/world/scenarios", |_| true);
            files.extend(files_below("fuzz/seeds/scenario", seed));
            files
        }
        "recording" => {
            let mut files = files_below("bench/tests/data", |name| name == "recording.toml");
            files.extend(files_below("fuzz/seeds/manifest", seed));
            files
        }
        name => panic!("{name}"),
    }
}

/// Returns the reader's error for a file's keys and types, without the rules for its values.
fn structure(name: &str, table: &Table) -> Result<(), TomlError> {
    let text = table.to_string();
    match name {
        "bench" => match Config::parse(&text, name) {
            Err(ConfigError::Toml(error)) => Err(error),
            _ => Ok(()),
        },
        // The first line is read before the rest.
        "calibration" => {
            let mut table = table.clone();
            let hash = table.remove("sha256");
            let hash = hash.as_ref().and_then(toml::Value::as_str);
            let missing = || TomlError::MissingKey {
                file: name.to_owned(),
                table: None,
                key: "sha256".to_owned(),
            };
            let is_hash = hash.is_some_and(|hash| hash.len() == 64);
            strict_toml::parse::<CalibrationFile>(&table.to_string(), name)?;
            if is_hash { Ok(()) } else { Err(missing()) }
        }
        "protocol" => match Protocol::parse(&text, name) {
            Err(error) => match error.faults() {
                [ProtocolError::Toml(error), ..] => Err(error.clone()),
                _ => Ok(()),
            },
            Ok(_) => Ok(()),
        },
        "scenario" => match Scenario::parse(&text, name) {
            Err(ScenarioError::Toml(error)) => Err(error),
            _ => Ok(()),
        },
        "recording" => match Manifest::parse(&text, name) {
            Err(ManifestReadError::Toml(error)) => Err(error),
            _ => Ok(()),
        },
        name => panic!("{name}"),
    }
}

/// Returns whether the reader accepts a file's keys and types.
pub fn accepts_structure(name: &str, table: &Table) -> bool {
    structure(name, table).is_ok()
}

/// Returns the keys that the reader allows in the table with the unknown key `0`.
pub fn unknown_key(name: &str, table: &Table) -> Vec<String> {
    match structure(name, table) {
        Err(TomlError::UnknownKey { key, known, .. }) if key == "0" => known,
        result => panic!("{name}: {result:?}\n{table}"),
    }
}
