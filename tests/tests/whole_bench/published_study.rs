//! Recomputation of the numbers and figures of `analyze` from its tables by pandas and scipy, without this project's code.

use std::path::Path;
use std::process::Command;

use attempts::find;
use bench_tests::program::{bench, python, workspace};
use bench_tests::session::{finish, text, write_demo_protocol};
use correlations::Coefficient;
use published_statistics::cluster_test;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

/// Greatest relative difference between two computations of a number.
const TOLERANCE: f64 = 1e-6;

fn script(name: &str, arguments: &[&Path]) -> Value {
    let script = workspace().join("tests/python").join(name);
    let output = finish(Command::new(python()).arg(script).args(arguments));
    assert!(output.status.success(), "{}", text(&output));
    serde_json::from_slice(&output.stdout).expect("the script prints JSON")
}

/// Runs the Python lines of the handbook's chapter where the folders `tables` and `my-arrays` are.
fn run_handbook_lines(folder: &Path) {
    let chapter = workspace().join("docs/handbook/src/your-recordings.md");
    let chapter = std::fs::read_to_string(chapter).expect("the chapter");
    let blocks = chapter.split("```python\n").skip(1);
    let lines: String = blocks
        .filter_map(|block| block.split("```").next())
        .collect();
    let output = finish(
        Command::new(python())
            .args(["-c", &lines])
            .current_dir(folder),
    );
    assert!(output.status.success(), "{lines}{}", text(&output));
    let printed = String::from_utf8_lossy(&output.stdout);
    for part in ["fall_of_mu_low95", "sub-03", " m/N", " at 350"] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
}

/// Makes parts of the study in `folder` for two laboratories, and compares the answers to the handbook's questions with those of
/// pandas.
fn ask_laboratories(folder: &Path) {
    let mut copy = Command::new("cp");
    copy.args(["-r", "study/sub-03", "lyon"])
        .current_dir(folder);
    assert!(finish(&mut copy).status.success());
    for (lab, recordings) in [("oslo", "study"), ("lyon", "lyon")] {
        let mut command = bench();
        command
            .args(["analyze", "--each", recordings, "--out", "parts"])
            .args(["--lab", lab])
            .current_dir(folder);
        let output = finish(&mut command);
        assert!(output.status.success(), "{}", text(&output));
    }
    let mut command = Command::new(python());
    command
        .arg(workspace().join("tests/python/laboratories.py"))
        .arg(workspace().join("docs/handbook/src/many-recordings.md"))
        .arg("tables/instances.parquet")
        .args(["oslo=sub-01,sub-03", "lyon=sub-03"])
        .current_dir(folder);
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", text(&output));
    let found: Value = serde_json::from_slice(&output.stdout).expect("the script prints JSON");
    let [answers, expected] =
        ["answers", "expected"].map(|key| found[key].as_array().expect("answers"));
    assert_eq!(answers.len(), expected.len() + 1, "{found}");
    for (answer, expected) in answers.iter().zip(expected) {
        require_close(answer, expected);
    }
    let worst = answers.last().and_then(Value::as_array);
    assert!(worst.is_some_and(|rows| rows.len() == 5), "{found}");
    for lab in ["oslo", "lyon"] {
        assert!(
            found["printed"]
                .as_str()
                .is_some_and(|text| text.contains(lab))
        );
    }
    let falls = std::fs::read_to_string(folder.join("falls.csv")).expect("falls.csv");
    assert_eq!(falls.lines().count(), 1 + 6, "{falls}");
}

/// Compares two values, numbers within [`TOLERANCE`].
fn require_close(found: &Value, expected: &Value) {
    match (found, expected) {
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
            for (found, expected) in found.iter().zip(expected) {
                require_close(found, expected);
            }
        }
        (Value::Object(found), Value::Object(expected)) => {
            assert!(found.keys().eq(expected.keys()), "{found:?} {expected:?}");
            for (found, expected) in found.values().zip(expected.values()) {
                require_close(found, expected);
            }
        }
        (Value::Number(found), Value::Number(expected)) => {
            let [found, expected] = [found, expected].map(|number| number.as_f64().expect("real"));
            let difference = (found - expected).abs();
            assert!(
                difference <= TOLERANCE * expected.abs(),
                "{found} {expected}"
            );
        }
        _ => assert_eq!(found, expected),
    }
}

#[test]
fn pandas_and_scipy_find_every_row_and_every_point_in_the_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let protocol = write_demo_protocol(
        path,
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 2"),
        ],
    );
    let study = path.join("study");
    for number in 1..=3 {
        let participant = format!("sub-{number:02}");
        let mut command = bench();
        command
            .args([
                "run",
                "--mock",
                "population",
                "--headless",
                "--speed",
                "max",
            ])
            .args(["--seed", &number.to_string(), "--participant", &participant])
            .args(["--consent-by", "A. Tester", "--protocol"])
            .arg(&protocol)
            .arg("--study")
            .arg(&study);
        let output = finish(&mut command);
        assert!(output.status.success(), "{}", text(&output));
    }
    // One of them on a plate declared as uneven.
    for recording in find::recordings(&[study.join("sub-03")], false).unwrap() {
        let manifest = recording.join("recording.toml");
        let profile =
            "\n[plate.profile]\npositions_m = [0.005, 0.05, 0.1]\nratios = [0.9, 1.01, 0.95]\n";
        let text = std::fs::read_to_string(&manifest).unwrap() + profile;
        std::fs::write(manifest, text).unwrap();
    }
    let reason = "glove worn";
    let mut command = bench();
    command
        .args(["exclude", "sub-02", "--because", reason])
        .args(["--by", "A. Tester", "--study"])
        .arg(&study);
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", text(&output));
    let mut command = bench();
    command
        .args(["analyze", "--table-csv"])
        .arg(&study)
        .arg("--tables")
        .arg(path.join("tables"))
        .arg("--figures")
        .arg(path.join("figures"));
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", text(&output));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains(reason), "{errors}");
    let mut command = bench();
    command
        .args(["export", "--as", "npz", "--no-signals"])
        .arg(&study)
        .arg("--to")
        .arg(path.join("my-arrays"));
    let exported = finish(&mut command);
    assert!(exported.status.success(), "{}", text(&exported));
    run_handbook_lines(path);
    ask_laboratories(path);
    let table = path.join("table.csv");
    std::fs::write(&table, &output.stdout).unwrap();

    let results = script(
        "published_study.py",
        &[&path.join("tables"), &table, &path.join("figures")],
    );
    assert_eq!(results["people"], serde_json::json!(["sub-01", "sub-03"]));
    assert!(results["rows"].as_u64().unwrap() >= 100, "{results}");
    assert!(results["compared"].as_u64().unwrap() >= 200, "{results}");
    assert!(results["apart"].as_f64().unwrap() < TOLERANCE, "{results}");
}

/// Tests on made-up tables of 14 people with ten trials each and an individual level per person.
#[test]
fn every_arrangement_of_signs_gives_the_clustered_p_values() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..3 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut x, mut y, mut people) = (Vec::new(), Vec::new(), Vec::new());
        let mut rows = String::from("x,y,person\n");
        for person in 0..14 {
            let level: [f64; 2] = [rng.random(), rng.random()];
            for _ in 0..10 {
                let noise: [f64; 2] = [rng.random(), rng.random()];
                x.push(level[0] + noise[0]);
                y.push(level[1] + noise[1] + 0.3 * noise[0]);
                people.push(person);
                let [.., last_x] = x[..] else { unreachable!() };
                rows += &format!("{last_x},{},{person}\n", y[y.len() - 1]);
            }
        }
        let table = folder.path().join("pairs.csv");
        std::fs::write(&table, rows).unwrap();
        let results = script("clustered.py", &[&table]);
        for (name, coefficient) in [
            ("pearson", Coefficient::Pearson),
            ("spearman", Coefficient::Spearman),
        ] {
            let test = cluster_test::test(coefficient, &x, &y, &people).unwrap();
            let (p, reference_p) = (test.p.unwrap(), results[name].as_f64().unwrap());
            assert!(
                (p - reference_p).abs() < TOLERANCE,
                "{name}: {p} and {reference_p}"
            );
            assert_eq!(test.people, 14);
        }
    }
}
