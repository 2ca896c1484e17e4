//! Resuming an interrupted session with the same protocol and order.

use std::fs;

use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, demo_with, finish, text, unattended};
use rustix::process::Signal;

use super::refusals::{MINUTE, ONE_TRIAL, assert_refusal, room};

/// Fault 35.
#[test]
fn a_session_goes_on_in_its_own_order_or_not_at_all() {
    let (folder, study) = room();
    let protocol = demo_with(folder.path(), ONE_TRIAL);
    let mut run = Running::start(
        &mut unattended(&study, "sub-01", &protocol),
        &folder.path().join("output"),
    );
    let begun = study.join("sub-01/ses-01/trial-001_attempt-1");
    let recorded = run.wait_for(MINUTE, || begun.exists().then_some(()));
    assert_eq!(recorded, Some(()), "{}", run.output());
    run.signal(Signal::INT);
    run.wait(MINUTE);
    let before = SessionFolder::read(&study, "sub-01").unwrap();
    // `--protocol` defaults to huloux2021.
    let other = finish(unattended(&study, "sub-01", "huloux2021").arg("--resume"));
    assert_refusal(
        &other,
        &[
            "begun with the protocol demo",
            "--protocol",
            "--new-session",
        ],
    );
    let reordered =
        finish(unattended(&study, "sub-01", &protocol).args(["--resume", "--seed", "99"]));
    assert_refusal(
        &reordered,
        &["begun with the seed", "another order", "--seed"],
    );
    let edit = [("max_n = 0.8", "max_n = 0.9")];
    let edited = demo_with(folder.path(), &[ONE_TRIAL, &edit[..]].concat());
    let refusal = finish(unattended(&study, "sub-01", &edited).arg("--resume"));
    let words = [
        "force.max_n was 0.8, is 0.9",
        "--accept-edited-protocol",
        "demo.toml",
    ];
    assert_refusal(&refusal, &words);
    let after = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(after.starts().len(), before.starts().len());
    let mut resume = unattended(&study, "sub-01", &edited);
    let resumed = finish(resume.args(["--resume", "--accept-edited-protocol"]));
    assert!(resumed.status.success(), "{}", text(&resumed));
    let after = SessionFolder::read(&study, "sub-01").unwrap();
    let starts = after.starts();
    let (first, last) = (starts[0], starts[starts.len() - 1]);
    assert_eq!(first.protocol_file.as_deref(), Some("demo.toml"));
    assert!(first.protocol_edits.is_empty());
    assert_eq!(last.protocol_file.as_deref(), Some("demo.2.toml"));
    assert_eq!(last.protocol_edits, ["force.max_n was 0.8, is 0.9"]);
    let recorded = fs::read_dir(&after.path).unwrap().filter_map(|entry| {
        let manifest = entry.unwrap().path().join("recording.toml");
        let text = fs::read_to_string(manifest).ok()?;
        let named = text
            .lines()
            .find(|line| line.starts_with("protocol_file"))?;
        Some(named.to_owned())
    });
    let mut files: Vec<_> = recorded.collect();
    files.sort();
    files.dedup();
    let names = ["demo.2.toml", "demo.toml"];
    assert_eq!(
        files,
        names.map(|name| format!("protocol_file = \"{name}\""))
    );
}
