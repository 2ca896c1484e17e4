//! The friction rig of other people, imported as forces alone: friction over time, and mean and contrast of each stroke, by numpy.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use bench_tests::campaign;
use bench_tests::program::{bench, python, workspace};
use bench_tests::session::{finish, text};
use serde_json::Value;

use super::results::RecordingResults;
use super::written::import;

/// Greatest relative difference of a friction and its mean, and greatest difference of a contrast.
const EQUAL: f64 = 1e-6;

/// Returns the column `mu` of the table of friction over time.
fn friction(tables: &Path) -> Vec<f64> {
    let table = std::fs::read_to_string(tables.join("friction.csv")).expect("a table");
    let mut lines = table.lines();
    let header = lines.next().expect("a header");
    let column = header.split(',').position(|name| name == "mu");
    let column = column.unwrap_or_else(|| panic!("no column mu in {header}"));
    let cell = |line: &str| line.split(',').nth(column).map(str::parse);
    let values = lines.map(|line| cell(line).expect("a cell").expect("a number"));
    values.collect()
}

/// Returns the greatest relative difference; NaN if a value is unknown.
fn difference(values: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(values.len(), expected.len());
    let pairs = values.iter().zip(expected);
    pairs
        .map(|(value, expected)| (value / expected - 1.0).abs())
        .fold(0.0, |greatest: f64, ratio| {
            if ratio > greatest || ratio.is_nan() {
                ratio
            } else {
                greatest
            }
        })
}

/// Returns the greatest difference; NaN if a value is unknown.
fn distance(values: &[f64], expected: &[f64]) -> f64 {
    let ratios: Vec<f64> = values
        .iter()
        .zip(expected)
        .map(|(a, b)| 1.0 + a - b)
        .collect();
    difference(&ratios, &vec![1.0; expected.len()])
}

fn numbers(values: &Value) -> Vec<f64> {
    let values = values.as_array().expect("an array").iter();
    values
        .map(|value| value.as_f64().expect("a number"))
        .collect()
}

#[test]
fn friction_of_a_rig_is_that_of_numpy() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = finish(
        Command::new(python())
            .arg(workspace().join("tests/python/rig_friction.py"))
            .arg(workspace().join("tests/fixtures/friction-rig/friction-rig.txt"))
            .arg(folder.path()),
    );
    assert!(output.status.success(), "{}", text(&output));
    let answers: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let mut greatest = [0.0_f64; 3];
    for (name, lowered) in [("plain", 0.0), ("stimulated", 0.3)] {
        let recording = import(folder.path(), &format!("{name}.toml"));
        let tables = folder.path().join("tables").join(name);
        let options = [OsStr::new("--tables"), tables.as_os_str()];
        let file = folder.path().join(name).with_extension("json");
        let results = RecordingResults::new(&recording, &file, &options);
        let strokes = answers[name].as_array().expect("strokes");
        let of_strokes = |key: &str| -> Vec<f64> {
            let values = strokes.iter().map(|stroke| stroke[key].as_f64());
            values.map(|value| value.expect("a number")).collect()
        };
        let explorations = |pointer: &str| -> Vec<f64> {
            let values = results.explorations().iter();
            let values = values.map(|exploration| exploration.pointer(pointer));
            values
                .map(|value| value.and_then(Value::as_f64).expect("a number"))
                .collect()
        };
        let mu: Vec<f64> = strokes
            .iter()
            .flat_map(|stroke| numbers(&stroke["mu"]))
            .collect();
        let contrasts = explorations("/stimulus/contrast");
        let differences = [
            difference(&friction(&tables), &mu),
            difference(&explorations("/mu"), &of_strokes("mean")),
            distance(&contrasts, &of_strokes("contrast")),
        ];
        assert!(
            differences.iter().all(|ratio| *ratio <= EQUAL),
            "{name}: {differences:?}"
        );
        let means = of_strokes("mean");
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let printed = text(&finish(bench().arg("analyze").arg(&recording)));
        assert!(
            printed.contains("explorations: mean (95 % interval)")
                && printed.contains(&format!("{mean:.3} (")),
            "{mean}: {printed}"
        );
        // That of the rig itself is not 0: its friction changes with the place.
        assert!(
            contrasts
                .iter()
                .all(|contrast| (contrast - lowered).abs() < 0.03),
            "{name}: {contrasts:?}"
        );
        for (greatest, ratio) in greatest.iter_mut().zip(differences) {
            *greatest = greatest.max(ratio);
        }
    }
    let [over_time, means, contrasts] = greatest;
    campaign::report(
        "friction of a rig as forces alone",
        1,
        &format!(
            "differences from numpy: mu over time {over_time:.1e}, its means {means:.1e}, contrasts {contrasts:.1e}"
        ),
    );
}
