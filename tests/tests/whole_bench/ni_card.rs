//! The bench on a card of National Instruments: the program loads the simulated library in place of NI's.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use analysis::estimate::Method;
use analysis::{Settings, analyse};
use attempts::find;
use bench_tests::program::{bench, protocol};
use bench_tests::recorded::Recording;
use bench_tests::room::{Room, WEIGH, require_refusal};
use bench_tests::session::{SessionFolder, finish, replace_parts, text};
use bench_tests::truth::Skin;
use config::CalibrationFile;
use recording::manifest::End;
use statistics::quantile;

/// The published rig, on a USB-6211.
const RIG: &str = config::rigs::MOCK_BENCH_NIDAQMX;
const GAUGES: &str = config::rigs::MOCK_BENCH_CHANNELS;
/// An unknown bench with the card's sequential sampling of its inputs as the only skew.
const UNKNOWN_BENCH: &str = "[jitter]\nenabled = true\nskew_samples = 0.0\n";

/// Writes the configuration of a bench into `folder`.
fn write_config(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("bench.toml");
    fs::write(&path, text).unwrap();
    path
}

/// Returns the rig with forces on inputs of the card, which must have a converter for each.
fn gauge_rig() -> String {
    let text = replace_parts(
        RIG,
        &[
            ("rate_hz = 100000", "rate_hz = 250000"),
            ("input_channels = 2", "input_channels = 8"),
            (
                "inputs = [\"ai0\", \"ai1\"]",
                "inputs = [\"ai0\", \"ai1\", \"ai3\", \"ai4\", \"ai5\", \"ai6\", \"ai7\", \"ai8\"]",
            ),
            (
                "input_ranges_v = [10.0, 10.0]",
                "input_ranges_v = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0]",
            ),
            ("clock = \"start-trigger\"", "clock = \"ao-sample-clock\""),
            ("convert_hz = 250000", "#"),
        ],
    );
    let gauges = replace_parts(
        GAUGES,
        &[(
            "inputs = [3, 4, 5, 6, 7, 8]",
            "inputs = [2, 3, 4, 5, 6, 7]\nrate_hz = 5000.0",
        )],
    );
    let [start, end] =
        ["port = \"/dev/ttyUSB0\"", "[encoder]"].map(|part| text.find(part).unwrap());
    format!("{}{gauges}\n{}", &text[..start], &text[end..])
}

/// Returns `run` of one exploration without a calibration.
fn one_exploration(scenario: &str, config: &Path, study: &Path) -> Command {
    let mut run = bench();
    run.args(["run", "--speed", "max", "--headless", "--uncalibrated"])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .args(["--mock", scenario, "--config"])
        .arg(config)
        .arg("--protocol")
        .arg(protocol("one-exploration.toml"))
        .arg("--study")
        .arg(study);
    run
}

fn session(study: &Path) -> SessionFolder {
    let session = SessionFolder::read(study, "sub-01").unwrap();
    session.require_whole();
    session
}

/// Requires each recording to have every sample between the start of its trial and its verdict.
fn assert_every_sample(session: &SessionFolder, rate_hz: f64) {
    let recordings = session.recordings();
    assert!(!recordings.is_empty());
    for (index, path) in recordings.iter().enumerate() {
        let recording = Recording::read(path);
        let began_s = session.named("trial_began").nth(index).unwrap().audio_s;
        let ended_s = session.phases("verdict").nth(index).unwrap().audio_s;
        let frames = ((ended_s - began_s) * rate_hz).round() as usize;
        assert_eq!(recording.frames(), frames, "{}", path.display());
        assert_eq!(recording.nonfinite_samples(), 0, "{}", path.display());
    }
}

/// A user's complete procedure: channels, pickup, plate, force, check, session, analysis; at both rates that a USB-6211
/// supports.
#[test]
fn the_published_rig_is_calibrated_runs_and_finds_the_participant_unattended() {
    for rate_hz in [100_000, 125_000] {
        let room = Room::new(UNKNOWN_BENCH, 7);
        let folder = room.folder.path();
        let rig = replace_parts(
            RIG,
            &[("rate_hz = 100000", &format!("rate_hz = {rate_hz}"))],
        );
        let config = write_config(folder, &rig);
        let run_on_card = |mut command: Command| {
            let output = finish(command.arg("--config").arg(&config));
            assert!(output.status.success(), "{rate_hz}: {}", text(&output));
            text(&output)
        };
        for words in [&["channels"][..], &["pickup"], &["plate"], &WEIGH] {
            run_on_card(room.calibrate(words));
        }
        // With one converter the pickup is sampled 4 µs after the drive, 50° at the carrier; the calibration removes this
        // completely.
        let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
        let channels = calibration.channels.unwrap();
        let delay = channels.input(1).unwrap().delay.value;
        assert!(delay.abs() < 2e-3, "{rate_hz}: {delay} samples");
        let table = run_on_card(room.check());
        assert!(table.contains("USB-6211"), "{table}");
        let (study, truth) = (folder.join("study"), folder.join("truth"));
        fs::create_dir_all(&truth).unwrap();
        let mut run = room.command(&["run", "--headless", "--participant", "sub-01"]);
        run.args(["--consent-by", "A. Tester", "--study"])
            .arg(&study)
            .arg("--protocol")
            .arg(protocol("one-exploration.toml"))
            .arg("--mock-truth")
            .arg(&truth);
        run_on_card(run);
        assert_every_sample(&session(&study), f64::from(rate_hz));
        let recordings = find::recordings(&[study], false).unwrap();
        let analysis = analyse(&recordings, &Settings::default(), |_| {});
        let mut sigma_t: Vec<f64> = analysis
            .instances()
            .filter_map(|(_, instance)| instance.estimate(Method::Dynamic))
            .map(|estimate| estimate.sigma_t_m())
            .collect();
        assert!(sigma_t.len() >= 5, "{} instances", sigma_t.len());
        sigma_t.sort_by(f64::total_cmp);
        let error = quantile(&sigma_t, 0.5).unwrap() / Skin::read(&truth).sigma_t_m - 1.0;
        assert!(error.abs() < 0.08, "{rate_hz}: sigma_t {error:+.3}");
    }
}

/// Forces on the same card, with simultaneous sampling at 250 kHz.
#[test]
fn a_card_with_a_converter_for_each_input_reads_forces_too() {
    let folder = tempfile::tempdir().unwrap();
    let config = write_config(folder.path(), &gauge_rig());
    let study = folder.path().join("study");
    let mut run = one_exploration("gauges", &config, &study);
    let output = finish(run.env("MOCK_NIDAQMX_PRODUCT", "USB-6366"));
    assert!(output.status.success(), "{}", text(&output));
    let session = session(&study);
    assert_every_sample(&session, 250e3);
    let recording = Recording::read(&session.recordings()[0]);
    assert_eq!(recording.channels, 8);
    let trial = recording.manifest.trial.unwrap();
    assert_eq!(trial.end, Some(End::Completed));
}

/// The program's thread and the apparatus take turns, however busy the computer is.
#[test]
fn free_running_time_stops_while_the_program_reads() {
    let sessions = std::thread::scope(|scope| {
        let run = || {
            let folder = tempfile::tempdir().unwrap();
            let config = write_config(folder.path(), RIG);
            let study = folder.path().join("study");
            let output = finish(&mut one_exploration("nominal", &config, &study));
            assert!(output.status.success(), "{}", text(&output));
            Recording::read(&session(&study).recordings()[0]).samples
        };
        let threads = [scope.spawn(run), scope.spawn(run)];
        threads.map(|thread| thread.join().unwrap())
    });
    assert!(sessions[0].len() > 100_000);
    assert!(sessions[0] == sessions[1], "not the same samples");
}

/// Fault 47.
#[test]
fn a_card_that_fails_stops_the_drive_names_itself_and_keeps_what_was_recorded() {
    let overrun = "the card's input buffer ran over";
    let underrun = "the card's output ran dry";
    let loss = "Device cannot be accessed";
    for (faults, message, counts) in [
        (&["xrun@5s"][..], overrun, "1 input and 0 output xruns"),
        (&["xrun-output@5s"], underrun, "0 input and 1 output xruns"),
        (&["card-lost-input@5s"], loss, ""),
        (&["card-lost-output@5s"], loss, ""),
        (&["gpio-removed@5s"], loss, ""),
        // Two faults at once.
        (&["xrun@5s", "xrun-output@5s"], "the card", ""),
        (&["card-lost-input@5s", "estop@5s"], "STOPPED", ""),
        (&["xrun@5s", "force-silent@5s"], overrun, "1 input"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let config = write_config(folder.path(), RIG);
        let study = folder.path().join("study");
        let mut run = bench();
        run.args(["run", "--mock", "nominal", "--speed", "max", "--headless"])
            .args(["--uncalibrated", "--participant", "sub-01"])
            .args(["--consent-by", "A. Tester", "--protocol", "demo"])
            .arg("--config")
            .arg(&config)
            .arg("--study")
            .arg(&study);
        for fault in faults {
            run.args(["--fault", fault]);
        }
        let output = finish(&mut run);
        let transcript = text(&output);
        assert!(!output.status.success(), "{faults:?}: {transcript}");
        assert!(
            transcript.contains("STOPPED") && transcript.contains(message),
            "{faults:?}: {transcript}"
        );
        assert!(transcript.contains(counts), "{faults:?}: {transcript}");
        assert!(!transcript.contains("panicked"), "{faults:?}: {transcript}");
        let session = session(&study);
        let recording = Recording::read(&session.recordings()[0]);
        assert!(recording.duration_s() > 1.0, "{faults:?}");
        assert_eq!(recording.nonfinite_samples(), 0, "{faults:?}");
    }
}

/// A drill leaves out faults that make a card unusable; the others work as on any bench.
#[test]
fn a_drill_on_a_card_skips_faults_that_disable_it() {
    let folder = tempfile::tempdir().unwrap();
    let config = write_config(folder.path(), RIG);
    let drill = |faults: &str| {
        let mut drill = bench();
        drill
            .current_dir(folder.path())
            .args(["drill", "--mock", "nominal", "--speed", "max", "--headless"])
            .args([
                "--uncalibrated",
                "--operator",
                "A. Tester",
                "--only",
                faults,
            ])
            .arg("--config")
            .arg(&config);
        drill
    };
    let output = finish(&mut drill("estop,gpio-removed,card-lost-input"));
    assert!(output.status.success(), "{}", text(&output));
    require_refusal(drill("xrun"), &["audio.host = \"nidaqmx\" in bench.toml"]);
}

/// Returns the program with its locks in `folder`, so that tests at the same time may each claim a card `Dev1`.
fn bench_with_own_locks(folder: &Path) -> Command {
    let mut bench = bench();
    bench.env("XDG_RUNTIME_DIR", folder);
    bench
}

/// Fault 47.
#[test]
fn what_a_card_cannot_do_is_refused_with_the_line_to_change() {
    for (product, changes, words) in [
        (
            "USB-6211",
            &[
                ("rate_hz = 100000", "rate_hz = 250000"),
                ("convert_hz = 250000", "convert_hz = 500000"),
            ][..],
            &[
                "2 inputs × 250000 Hz = 500000 Hz",
                "lower audio.rate_hz to 125000",
                "bench.toml",
            ][..],
        ),
        (
            "USB-6211",
            &[("clock = \"start-trigger\"", "clock = \"ao-sample-clock\"")],
            &[
                "error -89136",
                "set clock = \"start-trigger\" in [nidaqmx] of bench.toml",
            ],
        ),
        (
            "USB-6211",
            &[("convert_hz = 250000", "#")],
            &["add convert_hz = 250000 to [nidaqmx] in bench.toml"],
        ),
        (
            "USB-6211",
            &[("convert_hz = 250000", "convert_hz = 240000")],
            &[
                "240000 Hz (nidaqmx.convert_hz)",
                "240963.855 Hz",
                "in bench.toml",
            ],
        ),
        (
            "USB-6211",
            &[("rate_hz = 100000", "rate_hz = 96000")],
            &["96000 Hz (audio.rate_hz)", "in bench.toml"],
        ),
        (
            "USB-6366",
            &[],
            &["samples all inputs at the same instant: remove nidaqmx.convert_hz from bench.toml"],
        ),
        (
            "USB-6211",
            &[
                ("output_device = \"Dev1\"", "output_device = \"Dev2\""),
                ("input_device = \"Dev1\"", "input_device = \"Dev2\""),
            ],
            &[
                "there is no NI card Dev2, there is Dev1 (USB-6211)",
                "in bench.toml",
            ],
        ),
        (
            "USB-6211",
            &[("counter = \"ctr0\"", "counter = \"ctr7\"")],
            &["Dev1/ctr7", "nidaqmx.counter in bench.toml"],
        ),
        (
            "USB-6211",
            &[(
                "inputs = [\"ai0\", \"ai1\"]",
                "inputs = [\"ai0\", \"ai77\"]",
            )],
            &["error -200170", "look at nidaqmx.inputs"],
        ),
        (
            "USB-6211",
            &[("heartbeat = 1", "heartbeat = 9")],
            &["has no GPIO line 9 for the heartbeat", "check [gpio]"],
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let config = write_config(folder.path(), &replace_parts(RIG, changes));
        let mut check = bench();
        check
            .env("MOCK_NIDAQMX_PRODUCT", product)
            .args(["check", "--quick", "--mock", "--config"])
            .arg(&config);
        require_refusal(check, words);
    }
    // Without the driver.
    let folder = tempfile::tempdir().unwrap();
    let config_text = replace_parts(
        RIG,
        &[
            (
                "outputs = [\"ao0\"]",
                "library = \"/absent/libnidaqmx.so\"\noutputs = [\"ao0\"]",
            ),
            ("silence_s = 0.25", "silence_s = 0.05"),
        ],
    );
    let config = write_config(folder.path(), &config_text);
    let mut check = bench_with_own_locks(folder.path());
    check.args(["check", "--quick", "--config"]).arg(&config);
    require_refusal(
        check,
        &["install NI's driver", "nidaqmx.library in bench.toml"],
    );
}

/// The unmodified program, in real time, as on a real card.
#[test]
fn the_program_runs_on_the_simulated_library_alone() {
    let folder = tempfile::tempdir().unwrap();
    let library = mock_hw::rack::library().unwrap();
    let force = folder.path().join("force");
    let config_text = replace_parts(
        RIG,
        &[
            (
                "outputs = [\"ao0\"]",
                &format!("library = \"{}\"\noutputs = [\"ao0\"]", library.display()),
            ),
            ("/dev/ttyUSB0", force.to_str().unwrap()),
            ("device = \"sim-speakers\"", "device = \"\""),
            // On a busy machine the program may be late.
            ("lead_s = 0.01", "lead_s = 0.05"),
            ("silence_s = 0.25", "silence_s = 0.1"),
        ],
    );
    let config = write_config(folder.path(), &config_text);
    let mut check = bench_with_own_locks(folder.path());
    check
        .env("MOCK_NIDAQMX_FORCE_LINK", &force)
        .args(["check", "--quick", "--config"])
        .arg(&config);
    let table = text(&finish(&mut check));
    for row in [
        "custom:Dev1 (USB-6211",
        "passed  encoder",
        "passed  e-stop",
        "passed  heartbeat",
    ] {
        assert!(table.contains(row), "no {row}: {table}");
    }
    let mut devices = bench();
    let list = text(&finish(devices.arg("devices")));
    assert!(list.contains("host = \"nidaqmx\""), "{list}");
}
