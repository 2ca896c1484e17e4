//! Failure of the last step of a recording: the rename of its finished description.

use std::time::Duration;

use bench_tests::hung::contradictions;
use bench_tests::program::protocol;
use bench_tests::running::{Running, wait_until};
use bench_tests::session::{SessionFolder, finish, headless_run, text};
use bench_tests::thread_hold::{ThreadHold, numbers};
use protocols::TrialOutcome;

const MINUTE: Duration = Duration::from_secs(60);

/// Returns the attempts of the session and their outcomes in the log.
fn outcomes(session: &SessionFolder) -> Vec<(u32, TrialOutcome)> {
    let records = session.history().records.into_iter();
    records
        .map(|record| (record.key.attempt, record.outcome))
        .collect()
}

/// The disk refuses the complete description of a session's only trial once.
///
/// Fault 27.
#[test]
fn a_trial_whose_description_cannot_be_renamed_is_not_accepted_and_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let session = || headless_run(&study, "sub-01", protocol("one-exploration.toml"));
    let mut running = Running::start(&mut session(), &folder.path().join("output"));
    let description = study.join("sub-01/ses-01/trial-001_attempt-1/recording.toml.tmp");
    let pid = running.pid();
    // In lock step one thread does everything. It first renames other files, and a description without an end.
    let thread = i32::try_from(pid).unwrap();
    loop {
        // On a busy machine a session may finish unobserved.
        let hold =
            ThreadHold::begin(pid, thread, &numbers("rename"), MINUTE).expect("a held rename");
        let text = std::fs::read_to_string(&description).unwrap_or_default();
        if text.contains("end = \"completed\"") {
            // The call fails because its file is gone; the next attempt finds a working disk.
            std::fs::remove_file(&description).unwrap();
            drop(hold);
            break;
        }
    }
    let status = wait_until(MINUTE, || running.exit_status()).expect("an end");
    let transcript = running.output();
    assert!(!status.success(), "{transcript}");
    // The verdict had accepted the trial; the session did not.
    for words in [
        "trial-001_attempt-1 failed",
        "recording.toml",
        "trials accepted   0 of 1",
    ] {
        assert!(transcript.contains(words), "no `{words}` in:\n{transcript}");
    }
    let log = SessionFolder::read(&study, "sub-01").unwrap();
    let attempts = outcomes(&log);
    assert!(
        matches!(attempts[..], [(1, TrialOutcome::Interrupted { .. })]),
        "{attempts:?}"
    );
    assert_eq!(contradictions(&study), Vec::<String>::new());

    let output = finish(session().arg("--resume"));
    assert!(output.status.success(), "{}", text(&output));
    let log = SessionFolder::read(&study, "sub-01").unwrap();
    let attempts = outcomes(&log);
    assert!(
        matches!(
            attempts[..],
            [
                (1, TrialOutcome::Interrupted { .. }),
                (2, TrialOutcome::Accepted)
            ]
        ),
        "{attempts:?}"
    );
    // `verify` and the analysis agree too: only the second attempt counts.
    assert_eq!(contradictions(&study), Vec::<String>::new());
}
