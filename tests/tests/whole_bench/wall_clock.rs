//! A wall clock that is set during a session: dates are labels, and nothing depends on them (FAULTS.md, row 39).
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bench_tests::in_process::{Setup, apparatus, config, options};
use bench_tests::session::{SessionFolder, require_whole};
use config::Effective;
use friction_bench::run::{SessionPlan, run, terminal_front};
use jiff::{SignedDuration, Timestamp};
use serde_json::Value;

/// Runs a session and returns its folder.
fn session(study: &Path, date_errors: &'static [(f64, i64)]) -> PathBuf {
    let plan = SessionPlan::new(Effective::uncalibrated(config(&[])), &options(study)).unwrap();
    let setup = Setup {
        date_errors,
        ..Setup::default()
    };
    let (report, _) = run(plan, apparatus(setup), terminal_front(std::io::sink())).unwrap();
    assert!(report.completed, "{:?}", report.reason);
    require_whole(study);
    SessionFolder::read(study, "sub-01").unwrap().path
}

/// Every file of a session by its path, except the log; the log's documents without their dates; and the dates.
type SessionContent = (BTreeMap<PathBuf, Vec<u8>>, Vec<Value>, Vec<Timestamp>);

fn session_content(session: &Path) -> SessionContent {
    let (mut files, mut folders) = (BTreeMap::new(), vec![session.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(session).unwrap().to_owned();
                files.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    let log = files.remove(Path::new("events.jsonl")).unwrap();
    let lines = String::from_utf8(log).unwrap();
    let mut dates = Vec::new();
    let documents = lines.lines().map(|line| {
        let mut document: Value = serde_json::from_str(line).unwrap();
        if let Some(date) = document.as_object_mut().unwrap().remove("time") {
            dates.push(date.as_str().unwrap().parse().unwrap());
        }
        document
    });
    (files, documents.collect(), dates)
}

/// Fault 39.
#[test]
fn a_wall_clock_that_is_set_during_a_session_changes_nothing_but_the_dates() {
    let folder = tempfile::tempdir().unwrap();
    let content =
        |name: &str, date_errors| session_content(&session(&folder.path().join(name), date_errors));
    let (files, documents, dates) = content("steady", &[]);
    let (shifted_files, shifted_documents, shifted_dates) = content("set", &[(1.5, 1), (3.0, -1)]);

    // The dates in the log show that the clock was an hour ahead, then an hour behind.
    let matches = |hours: i64| {
        let pairs = dates.iter().zip(&shifted_dates);
        pairs
            .filter(|(date, shifted)| {
                date.duration_until(**shifted) == SignedDuration::from_hours(hours)
            })
            .count()
    };
    let counts = [0, 1, -1].map(matches);
    assert!(
        counts.iter().all(|&count| count > 0),
        "{counts:?}: {dates:?}"
    );
    assert_eq!(counts.iter().sum::<usize>(), dates.len());

    assert_eq!(documents, shifted_documents);
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&files), names(&shifted_files));
    assert!(files.len() > 5, "{:?}", names(&files));
    for (name, bytes) in &files {
        assert!(*bytes == shifted_files[name], "{} differs", name.display());
    }
}
