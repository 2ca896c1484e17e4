//! The Snakemake workflow over many recordings: one that cannot be read fails alone, is named, and is the only one analysed again.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use bench_tests::program::{friction_bench, python, workspace};
use bench_tests::session::{finish, text};

/// Number of recordings.
const RECORDINGS: usize = 40;

/// Makes recordings of forces alone, whose analysis takes milliseconds: the workflow does not look into them.
fn study(folder: &Path) {
    let rows = (0..2000).map(|n| {
        let time_s = f64::from(n) / 1000.0;
        let normal_n = 0.5 + 0.1 * (20.0 * time_s).sin();
        format!("{time_s},{normal_n},{}\n", 0.4 * normal_n)
    });
    let forces = String::from("time_s,normal_n,lateral_n\n") + &rows.collect::<String>();
    for trial in 1..=RECORDINGS {
        let recording = folder.join(format!("sub-01/ses-01/trial-{trial:03}_attempt-1"));
        fs::create_dir_all(&recording).unwrap();
        let description = format!(
            "format = 1\nparticipant = {{ id = \"sub-01\", session = 1 }}\ntrial = {{ number = {trial}, attempt = 1, practice = \
             false, condition = \"glass\", protocol = \"p\", seed = 1, end = \"completed\" }}\nintervals = [{{ kind = \
             \"exploration\", direction = \"left_to_right\", start_s = 0.2, end_s = 1.8 }}]\n"
        );
        fs::write(recording.join("recording.toml"), description).unwrap();
        fs::write(recording.join("force.csv"), &forces).unwrap();
    }
    fs::write(
        folder.join("dataset_description.json"),
        "{\"Name\":\"s\",\"DatasetType\":\"raw\",\"GeneratedBy\":[]}",
    )
    .unwrap();
}

/// Runs the workflow in `folder`; returns its output and the number of jobs with a part.
fn run(snakemake: &Path, folder: &Path) -> (Output, usize) {
    let workflow = workspace().join("workflow");
    let output = finish(
        Command::new(snakemake)
            .current_dir(folder)
            // Its caches belong to this test.
            .env("XDG_CACHE_HOME", folder.join("cache"))
            .arg("--snakefile")
            .arg(workflow.join("Snakefile"))
            .arg("--workflow-profile")
            .arg(workflow.join("profiles/local"))
            .arg("--config")
            .arg(format!("program={}", friction_bench().display()))
            .args(["studies=my study", "options=[\"--no-offset\"]"]),
    );
    let printed = text(&output);
    let failed = printed.matches("Error in rule part:").count();
    let jobs = printed.matches("rule part:").count() - failed;
    (output, jobs)
}

/// Returns the number of parts of the study.
fn parts(folder: &Path) -> usize {
    let parts = folder.join("results/parts/lab=my%20study/participant=sub-01");
    let entries = fs::read_dir(parts).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    names
        .filter(|name| name.to_string_lossy().ends_with(".parquet"))
        .count()
}

#[test]
fn a_recording_that_cannot_be_read_fails_alone_and_is_the_only_one_done_again() {
    let snakemake = python().with_file_name("snakemake");
    // `./dev test` reports that it could not install it.
    if !snakemake.is_file() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    study(&folder.path().join("my study"));
    let recording = folder
        .path()
        .join("my study/sub-01/ses-01/trial-017_attempt-1");
    let description = fs::read(recording.join("recording.toml")).unwrap();
    fs::write(recording.join("recording.toml"), "format = ").unwrap();

    let (output, jobs) = run(&snakemake, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert_eq!(jobs, RECORDINGS);
    assert_eq!(parts(folder.path()), RECORDINGS - 1);
    let failed: Vec<String> = text(&output)
        .lines()
        .filter_map(|line| line.strip_prefix("cannot be analysed: "))
        .map(str::to_owned)
        .collect();
    assert_eq!(failed, ["my study/sub-01/ses-01/trial-017_attempt-1"]);
    let results = folder.path().join("results/results.json");
    assert!(!results.exists());

    fs::write(recording.join("recording.toml"), &description).unwrap();
    let (output, jobs) = run(&snakemake, folder.path());
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!((jobs, parts(folder.path())), (1, RECORDINGS));
    let content: serde_json::Value = serde_json::from_slice(&fs::read(&results).unwrap()).unwrap();
    assert_eq!(content["recordings"].as_array().unwrap().len(), RECORDINGS);

    let (output, jobs) = run(&snakemake, folder.path());
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(jobs, 0, "{}", text(&output));

    // Regression test: results of before stayed, and the second run called them up to date.
    fs::write(recording.join("recording.toml"), "format = ").unwrap();
    for _ in 0..2 {
        let (output, jobs) = run(&snakemake, folder.path());
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        assert_eq!(jobs, 1);
        assert!(!results.exists());
    }
    fs::write(recording.join("recording.toml"), &description).unwrap();
    let (output, jobs) = run(&snakemake, folder.path());
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(jobs, 1);

    // An exclusion changes the results without a job.
    let study = folder.path().join("my study");
    let arguments = [
        "exclude",
        "sub-01",
        "--trial",
        "17",
        "--because",
        "wet",
        "--by",
        "ME",
        "--study",
    ];
    assert!(
        finish(Command::new(friction_bench()).args(arguments).arg(&study))
            .status
            .success()
    );
    fs::remove_file(&results).unwrap();
    let (output, jobs) = run(&snakemake, folder.path());
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(jobs, 0, "{}", text(&output));
    let results: serde_json::Value = serde_json::from_slice(&fs::read(results).unwrap()).unwrap();
    assert_eq!(
        results["recordings"].as_array().unwrap().len(),
        RECORDINGS - 1
    );
}
