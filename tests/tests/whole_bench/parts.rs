//! Parts of an analysis: the results of `analyze --from` are those of the recordings, whatever became of the runs that wrote the
//! parts.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::program::bench;
use bench_tests::running::Running;
use bench_tests::session::{finish, text};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;

use crate::verify::StudyCopy;

/// Number of kills in every test run; `FRICTION_BENCH_PART_KILLS` asks for more.
const KILLS: usize = 3;
const MINUTE: Duration = Duration::from_secs(60);

/// Two studies with equal pseudonyms: one with an excluded trial, another with a rejected attempt and a recording that cannot be
/// read.
struct TwoStudies {
    first: StudyCopy,
    second: StudyCopy,
    results: tempfile::TempDir,
}

impl TwoStudies {
    fn new() -> Self {
        let (first, second) = (StudyCopy::new(), StudyCopy::new());
        fs::write(
            first.study().join("exclusions.tsv"),
            "participant_id\tsession\ttrial\treason\tby\nsub-01\t1\t2\tslipped\tA. Tester\n",
        )
        .unwrap();
        let session = second.session();
        // Another recording than that of the first study, of which it would be a copy otherwise.
        let description = session.join("trial-001_attempt-1/recording.toml");
        second.edit(
            &description,
            "format = 1",
            "# second laboratory\nformat = 1",
        );
        fs::write(session.join("trial-002_attempt-1/signals.wav"), "no sound").unwrap();
        let rejected = session.join("trial-002_attempt-2");
        fs::create_dir(&rejected).unwrap();
        fs::copy(
            session.join("trial-002_attempt-1/recording.toml"),
            rejected.join("recording.toml"),
        )
        .unwrap();
        second.edit(
            &rejected.join("recording.toml"),
            "attempt = 1",
            "attempt = 2",
        );
        Self {
            first,
            second,
            results: tempfile::tempdir().unwrap(),
        }
    }

    fn studies(&self) -> [PathBuf; 2] {
        let mut studies = [self.first.study(), self.second.study()];
        studies.sort();
        studies
    }

    fn parts(&self) -> PathBuf {
        self.results.path().join("parts")
    }

    /// Writes the parts; returns the exit status and the lines of the recordings, sorted.
    fn write_parts(&self, options: &[&str]) -> (Option<i32>, Vec<String>) {
        let mut command = bench();
        command.args(["analyze", "--each"]).args(options);
        let output = finish(command.arg("--out").arg(self.parts()).args(self.studies()));
        let mut lines: Vec<String> = String::from_utf8_lossy(&output.stdout)
            .lines()
            .map(str::to_owned)
            .collect();
        lines.sort();
        (output.status.code(), lines)
    }

    fn reduce(&self, options: &[&str]) -> Output {
        let mut command = bench();
        command.args(["analyze", "--from"]).arg(self.parts());
        finish(command.args(options))
    }

    /// Writes results, tables, figures and page of `source`; returns exit status, output and the files.
    fn results(&self, source: &[&Path], name: &str) -> (Option<i32>, String, Files) {
        let folder = self.results.path().join(name);
        fs::create_dir(&folder).unwrap();
        let mut command = bench();
        command.arg("analyze").args(source);
        for (option, file) in [
            ("--json", "results.json"),
            ("--report", "page.html"),
            ("--tables", "tables"),
            ("--figures", "figures"),
        ] {
            command.arg(option).arg(folder.join(file));
        }
        let output = finish(command.arg("--table"));
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), printed, files(&folder))
    }
}

type Files = BTreeMap<PathBuf, Vec<u8>>;

/// Returns the files in a folder, at any depth, by their names in it.
fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                found.insert(name, fs::read(path).unwrap());
            }
        }
    }
    found
}

/// Removes the date from a page.
fn undated(mut files: Files) -> Files {
    let page = files.remove(Path::new("page.html")).unwrap();
    let page = String::from_utf8(page).unwrap();
    let lines = page
        .lines()
        .filter(|line| !line.contains("friction-bench 0."));
    let page: String = lines.collect();
    files.insert("page.html".into(), page.into_bytes());
    files
}

fn require_equal(files: &Files, expected: &Files) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(files), names(expected));
    for (name, bytes) in files {
        assert!(bytes == &expected[name], "{} differs", name.display());
    }
}

#[test]
fn parts_give_the_results_of_the_recordings_without_them() {
    let studies = TwoStudies::new();
    let [first, second] = studies.studies();
    let (status, printed, expected) =
        studies.results(&[first.as_path(), second.as_path()], "expected");
    assert_eq!(status, Some(1), "{printed}");

    let (status, lines) = studies.write_parts(&[]);
    assert_eq!(status, Some(1));
    let states: Vec<&str> = lines
        .iter()
        .filter_map(|line| line.split('\t').next())
        .collect();
    assert_eq!(states, ["done", "done", "failed"], "{lines:?}");

    // What is there is left, and the same bytes are there whichever run wrote them.
    let before = files(&studies.parts());
    let (status, lines) = studies.write_parts(&[]);
    assert_eq!(status, Some(1));
    let kept = lines
        .iter()
        .filter(|line| line.starts_with("kept\t"))
        .count();
    assert_eq!(kept, 2, "{lines:?}");
    require_equal(&files(&studies.parts()), &before);

    for study in studies.studies() {
        fs::rename(&study, study.with_extension("away")).unwrap();
    }
    let parts = studies.parts();
    let source = [Path::new("--from"), parts.as_path()];
    let (status, from_parts, found) = studies.results(&source, "found");
    assert_eq!((status, &from_parts), (Some(1), &printed));
    require_equal(&undated(found), &undated(expected));

    let output = studies.reduce(&["--assume", "young_modulus_pa=2e6"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output).contains("leave out --assume here"),
        "{}",
        text(&output)
    );

    // A part that was cut off, and one that another program wrote.
    let part = before.keys().find(|name| {
        name.extension()
            .is_some_and(|extension| extension == "parquet")
    });
    let part = parts.join(part.unwrap());
    let bytes = fs::read(&part).unwrap();
    for damaged in [
        &bytes[..bytes.len() / 2],
        &b"PAR1 and something else PAR1"[..],
    ] {
        fs::write(&part, damaged).unwrap();
        let output = studies.reduce(&["--json", "-"]);
        let transcript = text(&output);
        assert_eq!(output.status.code(), Some(2), "{transcript}");
        assert!(
            transcript.contains(&*part.to_string_lossy()),
            "{transcript}"
        );
        assert!(transcript.contains("delete it"), "{transcript}");
    }
}

#[test]
fn a_file_that_was_changed_is_named_and_gives_another_part() {
    let studies = TwoStudies::new();
    let (_, lines) = studies.write_parts(&["--lab", "Lab of ä"]);
    let changed = studies
        .first
        .session()
        .join("trial-001_attempt-1/force.csv");
    let text = fs::read_to_string(&changed).unwrap();
    fs::write(&changed, text.replacen("0.0", "0.1", 1)).unwrap();
    let mut command = bench();
    command.args([
        "analyze",
        "--each",
        "--verify-inputs",
        "--lab",
        "Lab of ä",
        "--out",
    ]);
    let output = finish(command.arg(studies.parts()).args(studies.studies()));
    let transcript = bench_tests::session::text(&output);
    assert_eq!(output.status.code(), Some(1), "{transcript}");
    assert!(
        transcript.contains("force.csv: warning: differs from its sum"),
        "{transcript}"
    );
    let done = transcript
        .lines()
        .filter(|line| line.starts_with("done\t"))
        .count();
    assert_eq!(done, 1, "{transcript}");
    assert!(
        !lines
            .iter()
            .any(|line| transcript.contains(line) && line.starts_with("done"))
    );
    // The part of the earlier content is gone: a recording has one part.
    let parts = files(&studies.parts());
    let parts = parts
        .keys()
        .filter(|name| name.starts_with("lab=Lab%20of%20%C3%A4"));
    assert_eq!(parts.count(), 2);
}

#[test]
fn people_who_were_excluded_or_removed_leave_the_parts() {
    let study = StudyCopy::new();
    let results = tempfile::tempdir().unwrap();
    let parts = results.path().join("parts");
    let each = || {
        let mut command = bench();
        command.args(["analyze", "--each"]).arg(study.study());
        let output = finish(command.arg("--out").arg(&parts));
        let transcript = text(&output);
        assert_eq!(output.status.code(), Some(0), "{transcript}");
        transcript
    };
    let count = |suffix: &str| {
        let files = files(&parts);
        let names = files.keys().map(|name| name.to_string_lossy().into_owned());
        names.filter(|name| name.ends_with(suffix)).count()
    };
    each();
    let all = count(".parquet");
    assert!(all > 1);
    let exclusions = "participant_id\tsession\ttrial\treason\tby\nsub-01\t1\t2\twithdrew\tME\n";
    fs::write(study.study().join("exclusions.tsv"), exclusions).unwrap();
    let transcript = each();
    assert!(transcript.contains("removed\t"), "{transcript}");
    assert_eq!((count(".parquet"), count(".cbor.gz")), (all - 1, all - 1));
    fs::remove_file(study.study().join("exclusions.tsv")).unwrap();
    assert!(each().contains("done\t"));
    assert_eq!(count(".parquet"), all);
}

#[test]
fn parts_of_killed_runs_are_those_of_one_run() {
    let kills = campaign::repeats("FRICTION_BENCH_PART_KILLS", KILLS);
    let whole = TwoStudies::new();
    let started = Instant::now();
    whole.write_parts(&[]);
    let duration = started.elapsed();
    let expected = files(&whole.parts());
    fs::rename(whole.parts(), whole.results.path().join("one-run")).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(33);
    for kill in 0..kills {
        let log = whole.results.path().join("output");
        let mut command = bench();
        command
            .args(["analyze", "--each", "--out"])
            .arg(whole.parts());
        let mut running = Running::start(command.args(whole.studies()), &log);
        std::thread::sleep(duration.mul_f64(rng.random()));
        if running.exit_status().is_none() {
            running.signal(Signal::KILL);
        }
        running.wait(MINUTE);
        if kill % 3 == 2 {
            fs::remove_dir_all(whole.parts()).unwrap();
        }
    }
    whole.write_parts(&[]);
    require_equal(&files(&whole.parts()), &expected);
}
