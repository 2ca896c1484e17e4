//! A program that is frozen while the plate is driven, and continues: the hardware's one-shot has switched the amplifier off by
//! then, and the drive must not return without the operator.

use std::time::{Duration, Instant};

use bench_tests::program::bench;
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, patient_config};
use recording::RecordingReader;
use rustix::process::Signal;

const MINUTE: Duration = Duration::from_secs(60);
/// Longer than any timeout of this bench.
const FREEZE: Duration = Duration::from_millis(2500);

/// Fault 7.
/// Hazard 15.
#[test]
fn a_session_that_was_frozen_is_stopped_when_it_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let config = patient_config(folder.path());
    let mut run = bench();
    run.args(["run", "--mock", "--headless", "--protocol", "demo"])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(&config);
    let mut run = Running::start(&mut run, &folder.path().join("output"));
    let log = study.join("sub-01/ses-01/events.jsonl");
    let drive_start = run.wait_for(MINUTE, || {
        let log = std::fs::read_to_string(&log).ok()?;
        log.contains("\"trial_began\"").then(Instant::now)
    });
    let drive_start = drive_start.unwrap_or_else(|| panic!("{}", run.output()));
    run.wait_for(MINUTE, || {
        (drive_start.elapsed() > Duration::from_secs(1)).then_some(())
    });

    run.signal(Signal::STOP);
    std::thread::sleep(FREEZE);
    run.signal(Signal::CONT);
    let status = run.wait(MINUTE);

    let transcript = run.output();
    assert!(!status.success(), "{transcript}");
    assert!(
        transcript.contains("the safety watch itself did not run for 2."),
        "{transcript}"
    );
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let recordings = session.recordings();
    assert!(!recordings.is_empty(), "{transcript}");
    for recording in recordings {
        assert!(RecordingReader::open(&recording).unwrap().frames() > 0);
    }
}
