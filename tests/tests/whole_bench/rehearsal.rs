//! Faults that are rehearsed from the command line: what is recorded says so, and what cannot be is refused.

use bench_tests::program::bench;
use bench_tests::session::{SessionFolder, config_with, demo_with, finish, text, unattended};
use recording::RecordingReader;

use super::refusals::{refused, refused_before_anything_is_made, room, uncalibrated};

#[test]
fn what_was_recorded_with_faults_says_so_everywhere() {
    let (folder, study) = room();
    let protocol = demo_with(
        folder.path(),
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
        ],
    );
    let mut run = unattended(&study, "sub-01", protocol);
    run.args(["--fault", "xrun@3s:96", "--fault", "force-dropped@3500ms"]);
    let ended = finish(&mut run);
    let printed = text(&ended);
    assert!(ended.status.success(), "{printed}");
    assert!(printed.contains("REHEARSAL, not data"), "{printed}");
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let faults = ["xrun@3s:96", "force-dropped@3.5s"];
    assert_eq!(session.starts()[0].rehearsed, faults);
    for folder in session.recordings() {
        let reader = RecordingReader::open(&folder).unwrap();
        assert_eq!(
            reader.manifest().hardware.as_ref().unwrap().rehearsed,
            faults
        );
    }
    let analysed = finish(bench().arg("analyze").arg(&study).args(["--json", "-"]));
    assert!(
        text(&analysed).contains("a rehearsal, not data"),
        "{}",
        text(&analysed)
    );
}

#[test]
fn faults_are_refused_where_they_cannot_be_injected() {
    let (folder, study) = room();
    let config = config_with(folder.path(), &[]);
    let mut run = uncalibrated(&study, &config);
    run.args(["--fault", "estop@3s"]);
    refused_before_anything_is_made(&mut run, &study, &["this is real", "friction-bench drill"]);

    for (fault, words) in [
        ("estp@3s", "did you mean `estop`?"),
        ("estop", "estop@12s"),
        ("estop@3", "s or ms"),
        ("xrun@3s:0", "1 to 4800 frames"),
        ("nan@3s", "sample_format"),
    ] {
        let mut monitor = bench();
        monitor.args([
            "monitor",
            "--mock",
            "--headless",
            "--duration-s",
            "1",
            "--fault",
            fault,
        ]);
        refused(&finish(&mut monitor), &[words]);
    }
    let mut drill = bench();
    drill.current_dir(folder.path()).args([
        "drill",
        "--mock",
        "--headless",
        "--speed",
        "max",
        "--operator",
        "ME",
    ]);
    refused(
        &finish(drill.args(["--only", "relay-welded"])),
        &["check --mock --fault relay-welded@0s"],
    );
    assert!(!folder.path().join("drills").exists());
}

/// Faults 16, 19.
/// Hazards 17, 18.
#[test]
fn a_fault_that_is_there_from_the_start_is_found_by_the_check_that_precedes() {
    let (_folder, study) = room();
    for (fault, row) in [
        ("relay-welded@0s", "FAILED  relay"),
        ("amplifier-off@0s", "FAILED  "),
    ] {
        let mut run = unattended(&study, "sub-01", "demo");
        run.args(["--fault", fault]);
        refused_before_anything_is_made(
            &mut run,
            &study,
            &[row, "nothing was driven but the test's faint tone"],
        );
    }
}

/// Fault 17.
#[test]
fn a_fault_comes_at_its_time_in_a_monitor_and_a_drill_ends_with_its_times() {
    let (folder, _) = room();
    let mut monitor = bench();
    monitor
        .args([
            "monitor",
            "--mock",
            "--headless",
            "--speed",
            "max",
            "--drive-v",
            "20",
        ])
        .args(["--duration-s", "6", "--fault", "estop@2s"]);
    let ended = finish(&mut monitor);
    let printed = text(&ended);
    assert_eq!(ended.status.code(), Some(1), "{printed}");
    assert!(printed.contains("STOPPED: e-stop pressed"), "{printed}");
    // A line for the first second, one for the second as it stops, and none after.
    assert_eq!(printed.matches("Z_m").count(), 2, "{printed}");

    let mut drill = bench();
    drill.current_dir(folder.path()).args([
        "drill",
        "--mock",
        "--headless",
        "--speed",
        "max",
        "--operator",
        "ME",
        "--only",
        "estop",
    ]);
    let ended = finish(&mut drill);
    let printed = text(&ended);
    assert!(ended.status.success(), "{printed}");
    for words in ["1 of 1 met", "drill.toml", "row 17"] {
        assert!(printed.contains(words), "{printed}");
    }
}
