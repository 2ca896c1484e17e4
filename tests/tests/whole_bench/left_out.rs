//! Recordings that an analysis leaves out: by an older log, by the log of another session, by `--exclude`.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;

use bench_tests::program::bench;
use bench_tests::session::{finish, text};

use super::verify::StudyCopy;

/// Runs a command on the study, and returns its exit status and output.
fn command(study: &StudyCopy, name: &str, options: &[&str]) -> (i32, String) {
    let output = finish(bench().arg(name).arg(study.study()).args(options));
    (output.status.code().unwrap(), text(&output))
}

#[test]
fn an_analysis_names_the_recordings_that_an_older_log_does_not_have() {
    let study = StudyCopy::new();
    let log = study.session().join("events.jsonl");
    let content = fs::read_to_string(&log).unwrap();
    let mut begun = content.match_indices("\"event\":\"trial_began\"");
    let (third, _) = begun.nth(2).unwrap();
    let end = content[..third].rfind('\n').unwrap();
    fs::write(&log, &content[..=end]).unwrap();
    let to = study.study().with_file_name("exported");
    let export = ["--as", "npz", "--to", to.to_str().unwrap()];
    for (name, options) in [("analyze", &[][..]), ("export", &export)] {
        let (status, transcript) = command(&study, name, options);
        assert_eq!(status, 1, "{transcript}");
        let words = "trial-002_attempt-1: the session's log does not have it";
        assert!(transcript.contains(words), "{transcript}");
    }
}

#[test]
fn a_log_of_another_session_is_named_and_decides_nothing() {
    let study = StudyCopy::new();
    let log = study.session().join("events.jsonl");
    let content = fs::read_to_string(&log).unwrap();
    let other = content
        .replace("\"participant\":\"sub-01\"", "\"participant\":\"sub-03\"")
        .replace("\"sha256\":{", "\"of\":{");
    fs::write(&log, other).unwrap();
    for (name, words) in [("analyze", "accepted 0, analysed 2"), ("list", "complete")] {
        let (status, transcript) = command(&study, name, &[]);
        assert_eq!(status, 0, "{transcript}");
        for words in ["it is the log of sub-03, session 1", words] {
            assert!(transcript.contains(words), "no `{words}` in:\n{transcript}");
        }
    }
}

#[test]
fn a_folder_to_leave_out_that_is_not_of_the_study_is_refused() {
    let study = StudyCopy::new();
    let (status, transcript) = command(&study, "analyze", &["--exclude", "sub-01"]);
    assert_eq!(status, 2, "{transcript}");
    let meant = format!("did you mean {}?", study.study().join("sub-01").display());
    for words in ["cannot leave out sub-01", &meant] {
        assert!(transcript.contains(words), "no `{words}` in:\n{transcript}");
    }
}
