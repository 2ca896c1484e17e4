//! The unmodified binary on a real audio server at 192 kHz, with the simulated apparatus as another client of the server.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]
#![expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use bench_tests::finding;
use bench_tests::program::{bench, find_program, jack_apparatus};
use bench_tests::recorded::Recording;
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, finish, text, write_bench_config, write_demo_protocol};
use config::CalibrationFile;
use mock_world::scenario::Scenario;
use recording::manifest::{End, EventKind, RecordedIntervalKind, RecordingEvent};
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(30);
/// Phase limit, rad: well above the noise of the carrier's phase, well below the turn by one sample.
const SLIP_RAD: f64 = 0.01;

/// Time from the start of the drive to the landing of the finger, s: in a session, and without a finger.
const TOUCH_S: &str = "1.5";
const NO_TOUCH_S: &str = "1e6";

/// Synchronous mode: a late client delays the others, and no period is lost.
const JACKD: [&str; 11] = [
    "-S", "-d", "dummy", "-r", "192000", "-p", "1024", "-C", "0", "-P", "0",
];

/// Lock that runs one server at a time: servers in real time would disturb each other.
static SERVER_LOCK: Mutex<()> = Mutex::new(());

/// A server with the apparatus as its client, under a unique name.
struct Server {
    folder: TempDir,
    name: String,
    force_port: PathBuf,
    apparatus: Running,
    jackd: Running,
}

impl Server {
    /// Starts a server on which a finger lands on the plate `touch_after_s` after the start of the drive.
    ///
    /// # Panics
    /// When the server does not start, or does not call its clients in time, as may happen on a busy machine.
    fn start(touch_after_s: &str) -> Self {
        let jackd = find_program("jackd");
        let folder = tempfile::tempdir().unwrap();
        static SERVERS: AtomicU32 = AtomicU32::new(0);
        let number = SERVERS.fetch_add(1, Ordering::Relaxed);
        let name = format!("friction-bench-test-{}-{number}", std::process::id());
        let force_port = folder.path().join("force");
        // A server that lost its clients may write endlessly, so its output is discarded.
        let jackd = Running::start(
            set_server(&name, Command::new(jackd)).args(JACKD),
            Path::new("/dev/null"),
        );
        let mut apparatus = Running::start(
            set_server(&name, Command::new(jack_apparatus()))
                .arg("--force-link")
                .arg(&force_port)
                .args(["--touch-after-s", touch_after_s]),
            &folder.path().join("apparatus.log"),
        );
        let log = folder.path().join("apparatus.log");
        let ready = apparatus.wait_for(PATIENCE, || {
            std::fs::read_to_string(&log)
                .ok()?
                .contains("ready at 192000 Hz")
                .then_some(())
        });
        let mut server = Self {
            folder,
            name,
            force_port,
            apparatus,
            jackd,
        };
        let is_serving = ready.is_some() && server.jackd.exit_status().is_none();
        assert!(is_serving, "no server: {}", server.apparatus.output());
        server
    }

    /// Writes the configuration of the bench on this server, with its force sensor at `force_port`.
    fn config(&self, force_port: &Path) -> PathBuf {
        let port = format!("port = \"{}\" #", force_port.display());
        write_bench_config(
            self.folder.path(),
            &[
                ("host = \"native\"", "host = \"jack\""),
                ("output_device = \"sim\"", "output_device = \"output\""),
                ("input_device = \"sim\"", "input_device = \"input\""),
                ("sample_format = \"i32\"", "sample_format = \"f32\""),
                ("output_channels = 2", "output_channels = 1"),
                ("loop_latency_s =", "loop_latency_s = 1.0 #"),
                ("silence_s =", "silence_s = 1.0 #"),
                ("port =", &port),
                (
                    "[encoder]\nmetres_per_count = 25.0e-6\norigin_m",
                    "# no encoder",
                ),
                (
                    "[safety]\n",
                    "[safety]\nwaived = [\"estop\", \"heartbeat\"]\nwaived_by = \"A. Tester\"\n",
                ),
                ("device = \"sim-speakers\"", "device = \"\""),
            ],
        )
    }

    /// Returns `run` on this server, with its force sensor at `force_port`.
    fn run(&self, force_port: &Path) -> Command {
        let config = self.config(force_port);
        let protocol = write_demo_protocol(
            self.folder.path(),
            &[
                ("practice = 1", "practice = 0"),
                ("per_condition = 4", "per_condition = 1"),
                (
                    "[\"left_to_right\", \"right_to_left\"]",
                    "[\"left_to_right\"]",
                ),
                ("max_per_trial = 3", "max_per_trial = 0"),
                ("lift_finger_s = 30.0", "lift_finger_s = 1.0"),
            ],
        );
        let mut command = set_server(&self.name, bench());
        command
            .args([
                "run",
                "--headless",
                "--uncalibrated",
                "--participant",
                "sub-01",
                "--consent-by",
                "A. Tester",
            ])
            .arg("--config")
            .arg(config)
            .arg("--protocol")
            .arg(protocol)
            .arg("--study")
            .arg(self.study());
        command
    }

    fn study(&self) -> PathBuf {
        self.folder.path().join("study")
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // The system lists at most eight servers, and keeps those that could not unregister.
        self.jackd.end(Duration::from_secs(5));
    }
}

fn set_server(server: &str, mut command: Command) -> Command {
    command
        .env("JACK_DEFAULT_SERVER", server)
        .env("JACK_NO_AUDIO_RESERVATION", "1")
        .env("JACK_NO_START_SERVER", "1");
    command
}

/// Runs a session to its end.
///
/// # Panics
/// When it fails, as it may on a machine too busy for the server or for the bench's safety watch.
fn session() -> (Server, SessionFolder) {
    let mut server = Server::start(TOUCH_S);
    let mut run = Running::start(
        &mut server.run(&server.force_port),
        &server.folder.path().join("output"),
    );
    let status = run.wait(Duration::from_secs(120));
    let transcript = run.output();
    println!("{transcript}");
    assert!(!transcript.contains("panicked"), "{transcript}");
    assert!(
        server.jackd.exit_status().is_none() && server.apparatus.exit_status().is_none(),
        "the server or the apparatus is gone: {}",
        server.apparatus.output()
    );
    assert!(status.success(), "{transcript}");
    let session = SessionFolder::read(&server.study(), "sub-01").unwrap();
    (server, session)
}

#[test]
fn an_exploration_over_a_real_audio_server_is_recorded_to_the_sample() {
    let _lock = SERVER_LOCK.lock();
    let (_server, session) = session();
    let recordings = session.recordings();
    assert_eq!(recordings.len(), 1, "{recordings:?}");
    let recording = Recording::read(&recordings[0]);
    assert_eq!(recording.warnings, Vec::<String>::new());
    assert_eq!((recording.rate_hz, recording.channels), (192_000, 4));
    let manifest = &recording.manifest;
    assert_eq!(manifest.trial.as_ref().unwrap().end, Some(End::Completed));
    let hardware = manifest.hardware.as_ref().unwrap();
    assert!(!hardware.input_device.contains("sim"), "{hardware:?}");
    let start = &session.starts()[0];
    assert_eq!(start.devices["simulated"], "false");
    let kinds: Vec<_> = manifest
        .intervals
        .iter()
        .map(|interval| interval.kind)
        .collect();
    assert_eq!(kinds[0], RecordedIntervalKind::Unloaded);
    assert!(
        matches!(kinds[1..], [RecordedIntervalKind::Exploration(_)]),
        "{kinds:?}"
    );
    assert!(manifest.intervals[1].end_s < recording.duration_s());

    // Every sample is accounted for: the count matches the audio clock between the start and the verdict, up to the blocks in
    // transit; no sample is invented; and the carrier, read back through the server, never slips, though a single sample would
    // turn it by 65.6°.
    let began_s = session.named("trial_began").next().unwrap().audio_s;
    let ended_s = session.phases("verdict").next().unwrap().audio_s;
    let missing_s = ended_s - began_s - recording.duration_s();
    assert!(missing_s.abs() < 0.1, "{missing_s} s");
    assert_eq!(recording.nonfinite_samples(), 0);
    let step_rad = recording.greatest_phase_step_rad();
    println!(
        "{} frames, carrier phase within {step_rad:.2e} rad",
        recording.frames()
    );
    let is_loss = |event: &RecordingEvent| {
        let losses = [EventKind::Gap, EventKind::InputXrun, EventKind::OutputXrun];
        losses.contains(&event.kind)
    };
    let is_reported = manifest.events.iter().any(is_loss);
    let is_slipping = step_rad >= SLIP_RAD;
    finding::require(is_reported || !is_slipping, || {
        format!("the carrier jumps by {step_rad} rad, and the bench does not report it")
    });
    assert!(!is_slipping, "the carrier jumps by {step_rad} rad");
}

/// Fault 21.
#[test]
fn a_force_sensor_that_is_not_there_is_named() {
    let _lock = SERVER_LOCK.lock();
    // A server under load may refuse a client before the bench opens the sensor.
    let server = Server::start(TOUCH_S);
    let output = finish(&mut server.run(&server.folder.path().join("absent")));
    let transcript = text(&output);
    assert!(
        !transcript.contains("client activation error"),
        "{transcript}"
    );
    assert!(
        output.status.code().is_some_and(|code| code != 0),
        "{transcript}"
    );
    for word in ["the force sensor", "absent"] {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
    assert!(!transcript.contains("panicked"), "{transcript}");
    assert!(!server.study().exists());
}

/// Calibrates pickup and plate in turn.
fn calibration() -> CalibrationFile {
    let server = Server::start(NO_TOUCH_S);
    let path = server.folder.path().join("calibration.toml");
    let config = server.config(&server.force_port);
    let plate = Scenario::default().plate;
    let carrier_rad_per_s = TAU * plate.resonance_hz;
    let um =
        |v: f64| 1e6 * v * plate.force_factor_n_per_v / plate.damping_n_s_per_m / carrier_rad_per_s;
    let known_um = [2.0, 4.0, 8.0].map(|v| um(v).to_string()).join(",");
    let known_at_hz = plate.resonance_hz.to_string();
    let pickup = ["pickup", "--levels-v", "2,4,8", "--known-um", &known_um];
    let pickup = [&pickup[..], &["--known-at-hz", &known_at_hz]].concat();
    for words in [&pickup[..], &["plate"]] {
        let mut calibrate = set_server(&server.name, bench());
        calibrate
            .arg("calibrate")
            .args(words)
            .args(["--headless", "--operator", "A. Tester", "--config"])
            .arg(&config)
            .arg("--calibration")
            .arg(&path);
        let output = finish(&mut calibrate);
        let transcript = text(&output);
        println!("{transcript}");
        assert!(!transcript.contains("panicked"), "{transcript}");
        // The server reports an xrun whenever a client connects, also for the bench; a calibration must not stop on these.
        assert!(output.status.success(), "{transcript}");
    }
    CalibrationFile::read(&path).unwrap().0
}

#[test]
fn a_bench_is_calibrated_over_a_real_audio_server() {
    let _lock = SERVER_LOCK.lock();
    let file = calibration();
    let (plate, truth) = (file.plate.unwrap(), Scenario::default().plate);
    let error_hz = plate.resonance_hz.value - truth.resonance_hz;
    let error = plate.force_factor_n_per_v.value / truth.force_factor_n_per_v - 1.0;
    println!("resonance off by {error_hz:.3} Hz, force factor by {error:.4}");
    // The amplitudes were computed from the commanded volts, of which the amplifier loses 1.5 % at the carrier.
    assert!(
        error_hz.abs() < 0.5 && (error - 0.015).abs() < 0.002,
        "{error_hz} Hz, {error}"
    );
}
