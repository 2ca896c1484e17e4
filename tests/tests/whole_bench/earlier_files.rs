//! Files of released versions (tests/fixtures), read by this version: the configuration parses, the study is whole, its
//! estimates are unchanged, and a session runs with the old calibration. Results of format 1 are found in those of format 2 as
//! docs/RECORDING.md states.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use bench_tests::program::{bench, find_program, workspace};
use bench_tests::session::{finish, require_consistent, require_whole, text};
use config::Config;
use serde_json::Value;
use tempfile::TempDir;

/// Greatest relative difference of a number from its value at release. The system computes exp and ln by instructions of the processor at
/// hand, which differ in the last bit, and the fits stop when they no longer improve: up to 6e-6 with and without fused
/// multiplication.
const DIFFERENCE: f64 = 2e-5;

/// The files of one version.
struct Files {
    version: String,
    folder: TempDir,
}

impl Files {
    /// Unpacks the files of every version.
    fn unpack_all() -> Vec<Self> {
        let fixtures = workspace().join("tests/fixtures");
        let entries = fs::read_dir(fixtures).unwrap();
        let versions = entries.map(|entry| entry.unwrap().path());
        let files: Vec<_> = versions
            .filter(|path| path.join("files.tar.xz").is_file())
            .map(|path| Self::unpack(&path))
            .collect();
        assert!(!files.is_empty());
        files
    }

    fn unpack(version: &Path) -> Self {
        find_program("xz");
        let folder = tempfile::tempdir().unwrap();
        let output = Command::new(find_program("tar"))
            .arg("-xJf")
            .arg(version.join("files.tar.xz"))
            .arg("-C")
            .arg(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output));
        let version = version.file_name().unwrap().to_string_lossy().into_owned();
        Self { version, folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }
}

/// Returns results of format 1 under the keys of format 2: their intervals take the published laws as true, and standard errors of
/// `trial` became total, so that these have no counterpart.
fn in_format_2(mut results: Value) -> Value {
    assert_eq!(results["format"], 1);
    results["format"] = Value::from(2);
    for recording in results["recordings"].as_array_mut().unwrap() {
        for instance in recording["instances"].as_array_mut().unwrap() {
            if let Some(trial) = instance.get_mut("trial").and_then(Value::as_object_mut) {
                trial.remove("std");
            }
        }
    }
    for part in ["recordings", "skin"] {
        rename_intervals(&mut results[part]);
    }
    results
}

fn rename_intervals(value: &mut Value) {
    match value {
        Value::Object(object) => {
            for name in ["interval95", "between_participants_ln_std_interval95"] {
                if let Some(interval) = object.remove(name) {
                    object.insert(format!("{name}_within_laws"), interval);
                }
            }
            object.values_mut().for_each(rename_intervals);
        }
        Value::Array(values) => values.iter_mut().for_each(rename_intervals),
        _ => {}
    }
}

#[test]
fn results_of_format_1_are_expected_under_the_keys_of_format_2() {
    let format_1 = serde_json::json!({
        "format": 1,
        "recordings": [{
            "instances": [{ "trial": { "mu0": 0.8, "std": { "mu0": 0.1 }, "interval95": { "mu0": [0.7, 0.9] } } }, {}],
            "trial": { "tau_s": 1e-3, "interval95": null },
        }],
        "skin": { "study": { "tau_s": { "mean": { "value": 1.0, "interval95": [0.9, 1.1] } } } },
        "law_check": [{ "interval95": [0.0, 1.0] }],
    });
    let format_2 = serde_json::json!({
        "format": 2,
        "recordings": [{
            "instances": [{ "trial": { "mu0": 0.8, "interval95_within_laws": { "mu0": [0.7, 0.9] } } }, {}],
            "trial": { "tau_s": 1e-3, "interval95_within_laws": null },
        }],
        "skin": { "study": { "tau_s": { "mean": { "value": 1.0, "interval95_within_laws": [0.9, 1.1] } } } },
        "law_check": [{ "interval95": [0.0, 1.0] }],
    });
    assert_eq!(in_format_2(format_1), format_2);
}

/// Adds the values of `released` that differ in `current`; additional values of `current` are allowed.
fn add_differences(
    released: &Value,
    current: Option<&Value>,
    path: &str,
    differences: &mut Vec<String>,
) {
    let missing = Value::Null;
    let current = current.unwrap_or(&missing);
    match (released, current) {
        (Value::Object(released), Value::Object(current)) => {
            for (key, value) in released.iter().filter(|(key, _)| *key != "path") {
                add_differences(
                    value,
                    current.get(key),
                    &format!("{path}.{key}"),
                    differences,
                );
            }
        }
        (Value::Array(released), Value::Array(current)) if released.len() == current.len() => {
            for (index, value) in released.iter().enumerate() {
                add_differences(
                    value,
                    current.get(index),
                    &format!("{path}[{index}]"),
                    differences,
                );
            }
        }
        (Value::Number(released), Value::Number(current)) => {
            let (released, current) = (released.as_f64().unwrap(), current.as_f64().unwrap());
            if (released - current).abs() > DIFFERENCE * released.abs() {
                differences.push(format!("{path}: {released} is now {current}"));
            }
        }
        _ if released == current => {}
        _ => differences.push(format!("{path}: {released} is now {current}")),
    }
}

#[test]
fn changed_values_are_found_and_new_ones_ignored() {
    let released = serde_json::json!({ "path": "a", "kept": 1.0, "text": "x", "list": [1.0, 2.0] });
    let current = serde_json::json!({ "path": "b", "kept": 1.0 + 1e-6, "text": "x", "list": [1.0, 2.0], "new": 3 });
    let mut differences = Vec::new();
    add_differences(&released, Some(&current), "", &mut differences);
    assert_eq!(differences, Vec::<String>::new());
    let current = serde_json::json!({ "kept": 1.0 + 1e-4, "list": [1.0] });
    add_differences(&released, Some(&current), "", &mut differences);
    let paths: Vec<_> = differences
        .iter()
        .filter_map(|line| line.split(':').next())
        .collect();
    assert_eq!(paths, [".kept", ".list", ".text"]);
}

#[test]
fn files_of_every_release_are_read() {
    for files in Files::unpack_all() {
        let version = &files.version;
        let configuration = fs::read_to_string(files.path("bench.toml")).unwrap();
        Config::parse(&configuration, "bench.toml")
            .unwrap_or_else(|error| panic!("{version}: {error}"));
        let study = files.path("study");
        require_consistent(&study);

        let results = files.path("now.json");
        let output = finish(
            bench()
                .arg("analyze")
                .arg(&study)
                .arg("--json")
                .arg(&results),
        );
        assert!(output.status.success(), "{version}: {}", text(&output));
        let mut differences = Vec::new();
        let (released, current) = (files.json("results.json"), files.json("now.json"));
        let released = match released["format"].as_u64() {
            Some(1) => in_format_2(released),
            _ => released,
        };
        add_differences(&released, Some(&current), "", &mut differences);
        assert!(
            differences.is_empty(),
            "{version}:\n{}",
            differences.join("\n")
        );

        // The third participant's session was killed.
        let mut resume = bench();
        resume
            .current_dir(files.folder.path())
            .args(["run", "--mock", "bench-unknown", "--seed", "7"])
            .args(["--config", "bench.toml", "--calibration"])
            .args(["calibration.toml", "--speed", "max", "--headless"])
            .args(["--protocol", "smallest.toml", "--study", "study"])
            .args(["--participant", "sub-03", "--consent-by", "A. Tester"])
            .arg("--resume");
        let output = finish(&mut resume);
        assert!(output.status.success(), "{version}: {}", text(&output));
        assert!(!text(&output).contains("UNCALIBRATED"), "{}", text(&output));
        require_whole(&study);
    }
}
