//! Files of released versions (tests/fixtures), read by this version: the configuration parses, the study is whole, its
//! estimates are unchanged, and a session runs with the old calibration.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use bench_tests::program::{bench, installed, workspace};
use bench_tests::session::{finish, require_consistent, require_whole, text};
use config::Config;
use serde_json::Value;
use tempfile::TempDir;

/// Greatest relative difference of a number from its value at release. Processors may fuse multiplication and addition, and the
/// fits stop when they no longer improve.
const DIFFERENCE: f64 = 1e-6;

/// The files of one version.
struct Files {
    version: String,
    folder: TempDir,
}

impl Files {
    /// Unpacks the files of every version.
    fn all() -> Vec<Self> {
        let fixtures = workspace().join("tests/fixtures");
        let entries = fs::read_dir(fixtures).unwrap();
        let versions = entries.map(|entry| entry.unwrap().path());
        let files: Vec<_> = versions
            .filter(|path| path.is_dir())
            .map(|path| Self::unpacked(&path))
            .collect();
        assert!(!files.is_empty());
        files
    }

    fn unpacked(version: &Path) -> Self {
        installed("xz");
        let folder = tempfile::tempdir().unwrap();
        let unpacking = Command::new(installed("tar"))
            .arg("-xJf")
            .arg(version.join("files.tar.xz"))
            .arg("-C")
            .arg(folder.path())
            .output()
            .unwrap();
        assert!(unpacking.status.success(), "{}", text(&unpacking));
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

/// Adds the values of `then` that differ in `now`; additional values of `now` are allowed.
fn changed(then: &Value, now: Option<&Value>, place: &str, found: &mut Vec<String>) {
    let missing = Value::Null;
    let now = now.unwrap_or(&missing);
    match (then, now) {
        (Value::Object(then), Value::Object(now)) => {
            for (key, value) in then.iter().filter(|(key, _)| *key != "path") {
                changed(value, now.get(key), &format!("{place}.{key}"), found);
            }
        }
        (Value::Array(then), Value::Array(now)) if then.len() == now.len() => {
            for (index, value) in then.iter().enumerate() {
                changed(value, now.get(index), &format!("{place}[{index}]"), found);
            }
        }
        (Value::Number(then), Value::Number(now)) => {
            let (then, now) = (then.as_f64().unwrap(), now.as_f64().unwrap());
            if (then - now).abs() > DIFFERENCE * then.abs() {
                found.push(format!("{place}: {then} is now {now}"));
            }
        }
        _ if then == now => {}
        _ => found.push(format!("{place}: {then} is now {now}")),
    }
}

#[test]
fn what_has_changed_is_found_and_what_is_new_is_not() {
    let then = serde_json::json!({ "path": "a", "kept": 1.0, "text": "x", "list": [1.0, 2.0] });
    let now = serde_json::json!({ "path": "b", "kept": 1.0 + 1e-7, "text": "x", "list": [1.0, 2.0], "new": 3 });
    let mut found = Vec::new();
    changed(&then, Some(&now), "", &mut found);
    assert_eq!(found, Vec::<String>::new());
    let now = serde_json::json!({ "kept": 1.0 + 1e-5, "list": [1.0] });
    changed(&then, Some(&now), "", &mut found);
    let places: Vec<_> = found
        .iter()
        .filter_map(|line| line.split(':').next())
        .collect();
    assert_eq!(places, [".kept", ".list", ".text"]);
}

#[test]
fn files_of_every_release_are_read() {
    for files in Files::all() {
        let version = &files.version;
        let configuration = fs::read_to_string(files.path("bench.toml")).unwrap();
        Config::parse(&configuration, "bench.toml")
            .unwrap_or_else(|error| panic!("{version}: {error}"));
        let study = files.path("study");
        require_consistent(&study);

        let results = files.path("now.json");
        let analysis = finish(
            bench()
                .arg("analyze")
                .arg(&study)
                .arg("--json")
                .arg(&results),
        );
        assert!(analysis.status.success(), "{version}: {}", text(&analysis));
        let mut found = Vec::new();
        let (then, now) = (files.json("results.json"), files.json("now.json"));
        changed(&then, Some(&now), "", &mut found);
        assert!(found.is_empty(), "{version}:\n{}", found.join("\n"));

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
        let resumed = finish(&mut resume);
        assert!(resumed.status.success(), "{version}: {}", text(&resumed));
        assert!(
            !text(&resumed).contains("UNCALIBRATED"),
            "{}",
            text(&resumed)
        );
        require_whole(&study);
    }
}
