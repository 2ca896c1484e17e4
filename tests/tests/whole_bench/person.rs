//! Protection of the person at the plate: the hourly driving time, the dead-man switch, the plate's temperature (FAULTS.md, row
//! 42).
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bench_tests::in_process::{Setup, apparatus, config, options};
use bench_tests::program::bench;
use bench_tests::session::{
    SessionFolder, finish, headless_run, require_consistent, text, write_bench_config,
};
use config::{Config, Effective};
use friction_bench::run::{SessionPlan, run, terminal_front};
use friction_bench::session::SessionReport;
use protocols::Instruction;
use recording::RecordingReader;
use safety::{GpioError, InputLine};

use super::refusals::{assert_early_refusal, room};

/// Returns a bench that passes for hardware and allows 12 s an hour; a session of one exploration needs 10.4 s.
fn short_hour() -> Config {
    config(&[
        ("silence_s = 0.25", "silence_s = 0.05"),
        ("ramp_s = 0.05", "ramp_s = 0.05\ndriving_s_per_hour = 12.0"),
    ])
}

fn hold_session(
    study: &Path,
    participant: &str,
    config: Config,
    setup: Setup,
) -> anyhow::Result<SessionReport> {
    let mut options = options(study);
    options.participant = Some(participant.to_owned());
    options.new_session = true;
    options.hardware.calibration = Some(study.with_file_name("calibration.toml"));
    let plan = SessionPlan::new(Effective::uncalibrated(config), &options)?;
    let result = run(plan, apparatus(setup), terminal_front(std::io::sink()));
    require_consistent(study);
    result.map(|(report, _)| report)
}

/// Returns the dead-man switch according to the session's first recording.
fn recorded_dead_man(session: &SessionFolder) -> Option<bool> {
    let reader = RecordingReader::open(&session.recordings()[0]).unwrap();
    reader.manifest().hardware.as_ref().unwrap().dead_man
}

/// Faults 39, 42.
/// Hazards 4, 5, 6.
#[test]
fn a_person_is_not_driven_again_by_starting_the_program_again() {
    let (_folder, study) = room();
    let setup = |date_errors| Setup {
        date_errors,
        is_real: true,
        ..Setup::default()
    };
    let report = hold_session(&study, "sub-01", short_hour(), setup(&[])).unwrap();
    assert!(report.completed, "{:?}", report.reason);
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(recorded_dead_man(&session), Some(false));
    let account = study.join("sub-01").join("driving.tsv");
    assert!(std::fs::read_to_string(&account).unwrap().lines().count() == 2);
    // A wall clock that is wrong, or changed in between, does not free driving time.
    for date_errors in [&[][..], &[(0.0, 2)], &[(0.0, -2)], &[(0.0, 1), (0.5, 20)]] {
        let error = hold_session(&study, "sub-01", short_hour(), setup(date_errors)).unwrap_err();
        let error = error.to_string();
        for word in [
            "driving time left this hour: ",
            " s of 12 s",
            "11 s are needed",
            "begin in",
        ] {
            assert!(error.contains(word), "{error}");
        }
    }
    // Another person has a separate hour.
    let report = hold_session(&study, "sub-02", short_hour(), setup(&[])).unwrap();
    assert!(report.completed, "{:?}", report.reason);

    std::fs::write(&account, "boot\tup_s\tdriven_s\tdate\nnonsense\n").unwrap();
    let error = hold_session(&study, "sub-01", short_hour(), setup(&[])).unwrap_err();
    assert!(
        error.to_string().contains("driving.tsv cannot be used"),
        "{error}"
    );
}

#[test]
fn simulated_driving_time_is_not_accounted() {
    let (_folder, study) = room();
    for _ in 0..2 {
        let report = hold_session(&study, "sub-01", short_hour(), Setup::default()).unwrap();
        assert!(report.completed, "{:?}", report.reason);
    }
    assert!(!study.join("sub-01").join("driving.tsv").exists());
}

/// A dead-man switch in a simulated hand.
#[derive(Clone, Default)]
struct Switch(Arc<AtomicBool>);

impl InputLine for Switch {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        Ok(self.0.load(Ordering::Relaxed))
    }
}

/// Runs a session with a dead-man switch that is released once the slider is past `release_m`.
fn run_with_switch(study: &Path, release_m: f64) -> SessionReport {
    let switch = Switch::default();
    let hand = switch.clone();
    let holder = Box::new(
        move |view: &tui::ScreenView, _: bool, _: Option<devices::loudspeaker::Tone>| {
            let is_past = view.slider_m.is_some_and(|slider_m| slider_m > release_m);
            let is_following = view.instruction == Instruction::FollowSlider;
            match view.instruction {
                Instruction::HoldSwitch => hand.0.store(true, Ordering::Relaxed),
                Instruction::ReleaseSwitch => hand.0.store(false, Ordering::Relaxed),
                _ if is_following && is_past => hand.0.store(false, Ordering::Relaxed),
                _ => {}
            }
        },
    );
    let setup = Setup {
        dead_man: Some((Box::new(switch), holder)),
        ..Setup::default()
    };
    let config = config(&[("[safety]\n", "[safety]\ndead_man = \"button\"\n")]);
    hold_session(study, "sub-01", config, setup).unwrap()
}

/// Fault 42.
/// Hazard 15.
#[test]
fn a_participant_who_lets_go_stops_the_session_and_what_was_recorded_reads() {
    let (_folder, study) = room();
    let report = run_with_switch(&study, 0.04);
    assert!(!report.completed);
    let reason = report.reason.unwrap();
    assert!(
        reason.contains("the dead-man switch was released"),
        "{reason}"
    );
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let recordings = session.recordings();
    assert_eq!(recordings.len(), 1);
    let reader = RecordingReader::open(&recordings[0]).unwrap();
    let events = &reader.manifest().events;
    let is_logged = |text: &str| {
        events
            .iter()
            .any(|event| event.text.as_deref().is_some_and(|t| t.contains(text)))
    };
    assert!(is_logged("the dead-man switch was released"), "{events:?}");
    assert!(reader.frames() > 192_000, "{}", reader.frames());

    let report = run_with_switch(&study, 1.0);
    assert!(report.completed, "{:?}", report.reason);
}

/// Hazard 15.
#[test]
fn a_session_with_a_dead_man_switch_says_so_and_runs() {
    let (folder, study) = room();
    let keys = "[safety]\ndead_man = \"button\"\n";
    let config = write_bench_config(folder.path(), &[("[safety]\n", keys)]);
    let mut run = headless_run(
        &study,
        "sub-01",
        bench_tests::program::protocol("one-exploration.toml"),
    );
    let output = finish(run.arg("--config").arg(&config));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(
        transcript.contains("dead-man switch in use: released for 0.2 s it stops the drive"),
        "{transcript}"
    );
    assert!(
        transcript.contains("driving time left this hour: 2 min of 2 min"),
        "{transcript}"
    );
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let rows = session.starts()[0].preflight.as_array().unwrap().clone();
    assert!(
        rows.iter()
            .any(|row| row["name"] == "dead-man" && row["passed"] == true)
    );
    let log = std::fs::read_to_string(session.path.join("events.jsonl")).unwrap();
    assert!(log.contains("\"phase\":\"hold\""), "{log}");
    assert_eq!(recorded_dead_man(&session), Some(true));
}

/// Fault 42.
/// Hazard 4.
#[test]
fn a_drive_over_its_dose_or_too_warm_says_when_to_go_on() {
    let (folder, study) = room();
    let dose = [("ramp_s = 0.05", "ramp_s = 0.05\ndriving_s_per_hour = 3.0")];
    let heat = [
        ("ramp_s = 0.05", "ramp_s = 0.05\nsurface_c = 30.0"),
        (
            "length_m = 0.105",
            "length_m = 0.105\nheat_capacity_j_per_k = 0.5\nroom_c = 27.0",
        ),
    ];
    for (changes, words) in [
        (
            &dose[..],
            "STOPPED: the plate was driven for 3 s within an hour, of at most 3 s (limits.driving_s_per_hour): go on in 60 min",
        ),
        (
            &heat[..],
            "STOPPED: the plate is estimated at 30.0 °C, at its limit of 30.0 °C (limits.surface_c): go on in 6 s",
        ),
    ] {
        let config = write_bench_config(folder.path(), changes);
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
            .args(["--duration-s", "20", "--config"])
            .arg(&config);
        let output = finish(&mut monitor);
        let transcript = text(&output);
        assert!(
            !output.status.success() && transcript.contains(words),
            "{transcript}"
        );
    }
    // A calibration warms the plate like any other drive.
    let config = write_bench_config(folder.path(), &heat);
    let mut calibrate = bench();
    calibrate
        .current_dir(folder.path())
        .args(["calibrate", "pickup", "--mock", "--headless"])
        .args(["--speed", "max", "--operator", "ME", "--config"])
        .arg(&config);
    let transcript = text(&finish(&mut calibrate));
    let words = "stopped the calibration: the plate is estimated at 30.0 °C";
    assert!(transcript.contains(words), "{transcript}");
    // A protocol that exceeds the dose is refused with the arithmetic.
    let config = write_bench_config(folder.path(), &dose);
    let mut run = headless_run(&study, "sub-01", "demo");
    run.arg("--config").arg(&config);
    let words = [
        "5 trials of 22.4 s",
        "drives the plate for 112 s within an hour",
        "allows 3 s",
    ];
    assert_early_refusal(&mut run, &study, &words);
}
