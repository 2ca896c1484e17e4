//! Resuming an interrupted session with the same protocol and order.

use std::fs;

use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, finish, headless_run, text, write_demo_protocol};
use rustix::process::Signal;

use super::refusals::{MINUTE, ONE_EXPLORATION, assert_refusal, room};

/// Fault 35.
#[test]
fn a_session_goes_on_in_its_own_order_or_not_at_all() {
    let (folder, study) = room();
    let protocol = write_demo_protocol(folder.path(), ONE_EXPLORATION);
    let mut run = Running::start(
        &mut headless_run(&study, "sub-01", &protocol),
        &folder.path().join("output"),
    );
    let recording_path = study.join("sub-01/ses-01/trial-001_attempt-1");
    let has_begun = run.wait_for(MINUTE, || recording_path.exists().then_some(()));
    assert_eq!(has_begun, Some(()), "{}", run.output());
    run.signal(Signal::INT);
    run.wait(MINUTE);
    let session_before = SessionFolder::read(&study, "sub-01").unwrap();
    // `--protocol` defaults to huloux2021.
    let output = finish(headless_run(&study, "sub-01", "huloux2021").arg("--resume"));
    assert_refusal(
        &output,
        &[
            "begun with the protocol demo",
            "--protocol",
            "--new-session",
        ],
    );
    let output =
        finish(headless_run(&study, "sub-01", &protocol).args(["--resume", "--seed", "99"]));
    assert_refusal(&output, &["begun with the seed", "another order", "--seed"]);
    let edit = [("max_n = 0.8", "max_n = 0.9")];
    let edited_protocol =
        write_demo_protocol(folder.path(), &[ONE_EXPLORATION, &edit[..]].concat());
    let output = finish(headless_run(&study, "sub-01", &edited_protocol).arg("--resume"));
    let words = [
        "force.max_n was 0.8, is 0.9",
        "--accept-edited-protocol",
        "demo.toml",
    ];
    assert_refusal(&output, &words);
    let session_after = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(session_after.starts().len(), session_before.starts().len());
    let mut resume = headless_run(&study, "sub-01", &edited_protocol);
    let output = finish(resume.args(["--resume", "--accept-edited-protocol"]));
    assert!(output.status.success(), "{}", text(&output));
    let session_after = SessionFolder::read(&study, "sub-01").unwrap();
    let starts = session_after.starts();
    let (first_start, last_start) = (starts[0], starts[starts.len() - 1]);
    assert_eq!(first_start.protocol_file.as_deref(), Some("demo.toml"));
    assert!(first_start.protocol_edits.is_empty());
    assert_eq!(last_start.protocol_file.as_deref(), Some("demo.2.toml"));
    assert_eq!(last_start.protocol_edits, ["force.max_n was 0.8, is 0.9"]);
    let manifest_lines = fs::read_dir(&session_after.path)
        .unwrap()
        .filter_map(|entry| {
            let manifest = entry.unwrap().path().join("recording.toml");
            let text = fs::read_to_string(manifest).ok()?;
            let protocol_line = text
                .lines()
                .find(|line| line.starts_with("protocol_file"))?;
            Some(protocol_line.to_owned())
        });
    let mut files: Vec<_> = manifest_lines.collect();
    files.sort();
    files.dedup();
    let names = ["demo.2.toml", "demo.toml"];
    assert_eq!(
        files,
        names.map(|name| format!("protocol_file = \"{name}\""))
    );
}
