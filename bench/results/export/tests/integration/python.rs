//! Python with numpy and scipy, and the BIDS validator in it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// Reads the export of the small study by the script's function for its format, which compares it with the recording.
pub fn open(format: &str, export: &Path, recording: &Path) {
    let python = python();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/integration/open_export.py");
    let output = finish(
        Command::new(&python)
            .arg(script)
            .arg(format)
            .arg(export)
            .arg(recording),
    );
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    if format == "bids" {
        validate(&python, export);
    }
}

/// Runs the validator, if `./dev test` could install it.
fn validate(python: &Path, dataset: &Path) {
    let validator = python.with_file_name("bids-validator-deno");
    // `./dev test` reports that it could not install it.
    if !validator.is_file() {
        return;
    }
    let output = finish(
        Command::new(&validator)
            .args(["--format", "json", "--max-rows=-1"])
            .arg(dataset),
    );
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let issues = found["issues"]["issues"].as_array().unwrap().iter();
    let errors: Vec<&Value> = issues
        .filter(|issue| issue["severity"] == "error")
        .collect();
    assert!(errors.is_empty(), "{errors:#?}");
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(found["summary"]["subjects"].as_array().unwrap().len(), 4);
}

fn python() -> PathBuf {
    let path = env::var_os("FRICTION_BENCH_PYTHON").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/python/bin/python"),
        PathBuf::from,
    );
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with numpy and scipy",
        path.display()
    );
    path
}

fn finish(command: &mut Command) -> Output {
    command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

fn text(output: &Output) -> String {
    let (out, error) = (&output.stdout, &output.stderr);
    String::from_utf8_lossy(out).into_owned() + &String::from_utf8_lossy(error)
}
