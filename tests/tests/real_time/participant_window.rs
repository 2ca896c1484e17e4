//! The participant's window on a virtual display: a participant who follows its pixels follows the slider.
#![cfg(target_os = "linux")]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::{File, Permissions};
use std::os::unix::fs::{FileExt, PermissionsExt};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use bench_tests::program::{find_program, friction_bench, participants_window, protocol};
use bench_tests::running::Running;
use participant_window::geometry::Geometry;
use participant_window::message::{Beat, Content, FrameReport, Track};
use participant_window::motion::Motion;
use participant_window::page::{GROUND, SLIDER};
use participant_window::place::shared_s;
use participant_window::seat::{Seat, SeatEvent};
use rustix::process::Signal;
use statistics::median;
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(30);
const SIZE: (u32, u32) = (1280, 720);
const PIXEL_M: f64 = 2.5e-4;
const SPEED_M_PER_S: f64 = 0.05;

/// A virtual display that keeps its picture in a file.
struct VirtualDisplay {
    folder: TempDir,
    name: String,
    _server: Running,
}

impl VirtualDisplay {
    fn start() -> Self {
        let folder = private_folder();
        let output = folder.path().join("xvfb.log");
        let screen = format!("{}x{}x24", SIZE.0, SIZE.1);
        let mut server = Running::start(
            Command::new(find_program("Xvfb"))
                .args([
                    "-displayfd",
                    "1",
                    "-nolisten",
                    "tcp",
                    "-screen",
                    "0",
                    &screen,
                    "-fbdir",
                ])
                .arg(folder.path()),
            &output,
        );
        let number = server.wait_for(PATIENCE, || {
            let transcript = std::fs::read_to_string(&output).ok()?;
            let line = transcript
                .lines()
                .find_map(|line| line.trim().parse::<u32>().ok());
            line.filter(|_| transcript.ends_with('\n'))
        });
        let number = number.unwrap_or_else(|| panic!("no virtual display: {}", server.output()));
        let scales = folder.path().join("friction-bench");
        std::fs::create_dir(&scales).unwrap();
        let text = format!(
            "[[monitors]]\nname = \"screen\"\nwidth_px = {}\nheight_px = {}\npixel_m = {PIXEL_M}\n",
            SIZE.0, SIZE.1
        );
        std::fs::write(scales.join("monitors.toml"), text).unwrap();
        Self {
            name: format!(":{number}"),
            folder,
            _server: server,
        }
    }

    fn socket(&self) -> PathBuf {
        self.folder.path().join("s")
    }

    fn window(&self, log: &str) -> Running {
        let mut command = participant(friction_bench());
        command
            .arg("--socket")
            .arg(self.socket())
            .env("DISPLAY", &self.name)
            .env("XDG_CONFIG_HOME", self.folder.path());
        Running::start(&mut command, &self.folder.path().join(log))
    }

    /// Returns the centre of the slider's colour in a row, pixels from the left, and the time of the look, s.
    fn slider(&self, row: u32) -> Option<(f64, f64)> {
        let picture = File::open(self.folder.path().join("Xvfb_screen0")).ok()?;
        let mut header = [0; 100];
        picture.read_exact_at(&mut header, 0).ok()?;
        let word = |offset: usize| {
            let bytes = header
                .get(offset..offset + 4)
                .and_then(|bytes| bytes.try_into().ok());
            bytes.map_or(0, |bytes| u64::from(u32::from_be_bytes(bytes)))
        };
        // Header of an XWD file: length of the header, bytes per line, number of colours of 12 bytes each.
        let (length, line, colours) = (word(0), word(48), word(76));
        let mut pixels = vec![0; usize::try_from(line).ok()?];
        let start_s = shared_s();
        let offset = length + 12 * colours + u64::from(row) * line;
        picture.read_exact_at(&mut pixels, offset).ok()?;
        let look_s = 0.5 * (start_s + shared_s());
        let red = |colour: u32| f64::from(colour >> 16 & 0xff);
        let shares = pixels.chunks_exact(4).enumerate().map(|(x, pixel)| {
            let share = (f64::from(pixel[2]) - red(GROUND)) / (red(SLIDER) - red(GROUND));
            (x as f64 + 0.5, share.clamp(0.0, 1.0))
        });
        let (weight, sum) = shares.fold((0.0, 0.0), |(weight, sum), (x, share)| {
            (weight + share, sum + share * x)
        });
        (weight > 4.0).then(|| (sum / weight, look_s))
    }
}

fn slider_content(starts_s: Option<f64>) -> Content {
    let (from_m, to_m) = (0.010, 0.095);
    Content {
        title: "Follow the slider".to_owned(),
        silent: "Paused".to_owned(),
        track: Some(Track {
            plate_m: 0.105,
            motion: Motion {
                from_m,
                to_m,
                speed_m_per_s: SPEED_M_PER_S,
                starts_s,
            },
            marks: ("start".to_owned(), "end".to_owned()),
            place: false,
        }),
        ..Content::default()
    }
}

fn wait_for(seat: &mut Seat, name: &str, is_match: impl Fn(&SeatEvent) -> bool) {
    let start = Instant::now();
    while !seat.look(shared_s()).iter().any(&is_match) {
        assert!(start.elapsed() < PATIENCE, "{name} did not happen");
        sleep(Duration::from_millis(5));
    }
}

fn is_taken(event: &SeatEvent) -> bool {
    matches!(event, SeatEvent::Arrival(_))
}

fn is_left(event: &SeatEvent) -> bool {
    matches!(event, SeatEvent::Departure { .. })
}

/// Observation of one exploration.
#[derive(Default)]
struct Exploration {
    errors_m: Vec<f64>,
    /// Mean speed of a finger that follows the pixels, over the middle 60 mm, m/s.
    finger_m_per_s: f64,
    report: Option<FrameReport>,
}

/// Shows an exploration and follows its pixels with a finger.
fn explore(display: &VirtualDisplay, seat: &mut Seat) -> Exploration {
    let geometry = Geometry {
        width: f64::from(SIZE.0),
        height: f64::from(SIZE.1),
        pixel_m: PIXEL_M,
    };
    let row = geometry.plate_y() - geometry.fingertip() - geometry.slider_height() / 2.0;
    // The bench's clock starts at an arbitrary time; it is sent in blocks, so some milliseconds late.
    let offset_s = shared_s() - 5.0;
    let starts_s = 5.6;
    let mut exploration = Exploration::default();
    let content = slider_content(Some(starts_s));
    let track = content.track.clone().unwrap();
    seat.show(content);
    let (mut beat_s, mut look_s, mut finger_m) = (0.0, f64::NAN, track.motion.from_m);
    let mut middle: Vec<(f64, f64)> = Vec::new();
    loop {
        let now_s = shared_s() - offset_s;
        if now_s - beat_s > 0.04 {
            beat_s = now_s;
            seat.beat(Beat {
                audio_s: now_s,
                shared_s: shared_s(),
                finger_m: None,
            });
        }
        for event in seat.look(shared_s()) {
            match event {
                SeatEvent::Explored(report) => exploration.report = Some(report),
                // On a busy computer frames are missed; the reports count them.
                SeatEvent::Trouble { .. } => {}
                event => panic!("{event:?}"),
            }
        }
        if let Some((x, pixel_s)) = display.slider(row as u32) {
            let audio_s = pixel_s - offset_s;
            let shown_m = track.plate_m / 2.0 + (x - geometry.width / 2.0) * PIXEL_M;
            if track.motion.moves(audio_s) {
                exploration
                    .errors_m
                    .push((shown_m - track.motion.at_m(audio_s)).abs());
            }
            let elapsed_s = audio_s - look_s;
            if elapsed_s > 0.0 {
                // A hand lags its target by some tenths of a second.
                finger_m += (shown_m - finger_m) * (1.0 - (-elapsed_s / 0.15).exp());
            }
            look_s = audio_s;
            if (finger_m - track.plate_m / 2.0).abs() < 0.03 {
                middle.push((audio_s, finger_m));
            }
        }
        let end_s = starts_s + track.motion.duration_s();
        if exploration.report.is_some() || now_s > end_s + PATIENCE.as_secs_f64() {
            break;
        }
        sleep(Duration::from_millis(3));
    }
    if let (Some((from_s, from_m)), Some((to_s, to_m))) = (middle.first(), middle.last()) {
        exploration.finger_m_per_s = (to_m - from_m) / (to_s - from_s);
    }
    exploration
}

/// Takes five minutes with `FRICTION_BENCH_WINDOW_S=300`, and prints with --nocapture.
#[test]
fn a_finger_that_follows_the_pixels_follows_the_slider_within_a_frame() {
    let display = VirtualDisplay::start();
    let mut seat = Seat::open(&display.socket()).unwrap();
    let mut window = display.window("window.log");
    wait_for(&mut seat, "a window", is_taken);
    let duration_s = std::env::var("FRICTION_BENCH_WINDOW_S").map_or(0.0, |s| s.parse().unwrap());
    let start = Instant::now();
    let mut explorations: Vec<Exploration> = Vec::new();
    while explorations.is_empty() || start.elapsed().as_secs_f64() < duration_s {
        explorations.push(explore(&display, &mut seat));
        assert_eq!(window.exit_status(), None, "{}", window.output());
    }
    let reports: Vec<FrameReport> = explorations
        .iter()
        .filter_map(|exploration| exploration.report)
        .collect();
    assert_eq!(
        reports.len(),
        explorations.len(),
        "an exploration was not reported"
    );
    let mut errors_m: Vec<f64> = explorations
        .iter()
        .flat_map(|exploration| exploration.errors_m.iter().copied())
        .collect();
    errors_m.sort_by(f64::total_cmp);
    let error_m = median(errors_m.iter().copied()).unwrap();
    let p99_m = errors_m[errors_m.len() * 99 / 100];
    let median_of = |value: fn(&FrameReport) -> f64| median(reports.iter().map(value)).unwrap();
    let frames: u32 = reports.iter().map(|report| report.frames).sum();
    let dropped: u32 = reports.iter().map(|report| report.dropped).sum();
    let longest_s = reports
        .iter()
        .map(|report| report.interval_max_s)
        .fold(0.0, f64::max);
    println!(
        "virtual display, {} explorations, {:.0} s, {frames} frames, {dropped} dropped\n\
         interval: median {:.2} ms, 99th percentile {:.2} ms (median over explorations), longest {:.1} ms\n\
         slider: by the window's own account median {:.2} mm, by the pixels median {:.2} mm, 99th percentile {:.2} mm; \
         a frame is {:.2} mm",
        explorations.len(),
        start.elapsed().as_secs_f64(),
        1e3 * median_of(|report| report.interval_p50_s),
        1e3 * median_of(|report| report.interval_p99_s),
        1e3 * longest_s,
        1e3 * median_of(|report| report.slider_error_p50_m),
        1e3 * error_m,
        1e3 * p99_m,
        1e3 * median_of(|report| report.frame_m),
    );
    let frame_m = median_of(|report| report.frame_m);
    assert!((frame_m - SPEED_M_PER_S / 60.0).abs() < 1e-5, "{frame_m}");
    // Medians, because a busy computer drops frames; the reports count them.
    assert!(error_m <= frame_m, "{error_m} m");
    assert!(median_of(|report| report.slider_error_p50_m) <= frame_m);
    // The protocol's rule: within a quarter of the slider's speed.
    for exploration in &explorations {
        assert!(
            (exploration.finger_m_per_s / SPEED_M_PER_S - 1.0).abs() < 0.25,
            "{} m/s",
            exploration.finger_m_per_s
        );
    }
}

/// Fault 43.
#[test]
fn a_window_that_dies_or_hangs_is_missed_and_another_takes_its_place() {
    let display = VirtualDisplay::start();
    let mut seat = Seat::open(&display.socket()).unwrap();
    seat.show(slider_content(None));
    let mut first_window = display.window("killed.log");
    wait_for(&mut seat, "a window", is_taken);

    let mut second_window = display.window("second.log");
    assert_eq!(second_window.wait(PATIENCE).code(), Some(2));
    assert!(
        second_window.output().contains("is open already"),
        "{}",
        second_window.output()
    );

    first_window.signal(Signal::KILL);
    wait_for(&mut seat, "its death", is_left);
    first_window.wait(PATIENCE);
    let third_window = display.window("hanging.log");
    wait_for(&mut seat, "a window after it", is_taken);
    third_window.signal(Signal::STOP);
    wait_for(&mut seat, "its hanging", is_left);
    third_window.signal(Signal::CONT);
    wait_for(&mut seat, "its return", is_taken);
    let start_s = shared_s();
    drop(seat);
    assert!(shared_s() - start_s < 1.0);
}

/// On a virtual display a warning is enough; in front of a participant the session pauses.
///
/// Fault 43.
#[test]
fn a_slider_that_jerks_again_and_again_is_told() {
    let display = VirtualDisplay::start();
    let mut seat = Seat::open(&display.socket()).unwrap();
    let window = display.window("window.log");
    wait_for(&mut seat, "a window", is_taken);
    let offset_s = shared_s() - 5.0;
    seat.show(slider_content(Some(5.2)));
    let start = Instant::now();
    let mut warning = None;
    while warning.is_none() && start.elapsed() < PATIENCE {
        for signal in [Signal::STOP, Signal::CONT] {
            seat.beat(Beat {
                audio_s: shared_s() - offset_s,
                shared_s: shared_s(),
                finger_m: None,
            });
            window.signal(signal);
            sleep(Duration::from_millis(80));
        }
        warning = seat
            .look(shared_s())
            .into_iter()
            .find_map(|event| match event {
                SeatEvent::Trouble { text } => Some(text),
                _ => None,
            });
    }
    let warning = warning.expect("a word about frames");
    assert!(warning.contains("over 50 ms"), "{warning}");
}

/// Returns a command that opens the participant's window.
fn participant(program: &Path) -> Command {
    participants_window();
    let mut command = Command::new(program);
    command.arg("participant");
    command
}

/// Returns a folder that is private to this user.
fn private_folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::set_permissions(folder.path(), Permissions::from_mode(0o700)).unwrap();
    folder
}

/// Returns the exit status of the command without a screen, and its output.
fn run_without_screen(command: &mut Command, folder: &Path) -> (Option<i32>, String) {
    let output = command
        .arg("--socket")
        .arg(folder.join("s"))
        .env("XDG_CONFIG_HOME", folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    let transcript = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), transcript)
}

#[test]
fn a_missing_screen_is_reported() {
    let folder = private_folder();
    let (code, transcript) = run_without_screen(&mut participant(friction_bench()), folder.path());
    assert_eq!(code, Some(2));
    assert!(
        transcript.contains("DISPLAY") && !transcript.contains("panic"),
        "{transcript}"
    );
}

#[test]
fn the_command_passes_arguments_signals_and_status_of_the_window() {
    let display = VirtualDisplay::start();
    let mut seat = Seat::open(&display.socket()).unwrap();
    let mut window = display.window("window.log");
    wait_for(&mut seat, "a window", is_taken);
    // The command replaced itself by the window, so the shell waits for the window.
    let program = std::fs::read_link(format!("/proc/{}/exe", window.pid())).unwrap();
    assert!(program.ends_with("friction-bench-participant"));
    window.signal(Signal::TERM);
    assert_eq!(
        window.wait(PATIENCE).signal(),
        Some(Signal::TERM.as_raw()),
        "{}",
        window.output()
    );
    let output = participant(friction_bench())
        .args(["--monitor", "nowhere", "--socket"])
        .arg(display.folder.path().join("other"))
        .env("DISPLAY", &display.name)
        .env("XDG_CONFIG_HOME", display.folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let transcript = String::from_utf8_lossy(&output.stderr);
    assert!(
        transcript.contains("there is no monitor nowhere"),
        "{transcript}"
    );
}

/// Makes a copy of friction-bench in a folder without the window's program.
fn lone_copy(folder: &Path) -> PathBuf {
    let copy = folder.join("friction-bench");
    if std::fs::hard_link(friction_bench(), &copy).is_err() {
        std::fs::copy(friction_bench(), &copy).unwrap();
    }
    copy
}

#[test]
fn a_missing_window_is_named_and_one_on_the_path_is_found() {
    let (folder, programs) = (private_folder(), private_folder());
    let program = lone_copy(programs.path());
    let empty = tempfile::tempdir().unwrap();
    let (code, transcript) = run_without_screen(
        participant(&program).env("PATH", empty.path()),
        folder.path(),
    );
    assert_eq!(code, Some(2));
    for words in [
        "friction-bench: the participant's window is a separate program, friction-bench-participant",
        &format!("neither in {} nor on the PATH", programs.path().display()),
        "cargo build --release -p friction-bench-participant",
    ] {
        assert!(transcript.contains(words), "{transcript}");
    }
    let window_folder = participants_window().parent().unwrap();
    let (code, transcript) = run_without_screen(
        participant(&program).env("PATH", window_folder),
        folder.path(),
    );
    assert_eq!(code, Some(2));
    assert!(
        transcript.starts_with("friction-bench-participant: no screen to open a window on"),
        "{transcript}"
    );
    std::fs::write(programs.path().join("friction-bench-participant"), "").unwrap();
    let (code, transcript) = run_without_screen(
        participant(&program).env("PATH", window_folder),
        folder.path(),
    );
    assert_eq!(code, Some(2));
    assert!(transcript.contains("does not start"), "{transcript}");
}

/// Returns the display libraries that a command opened, judging by file names in its strace.
fn display_libraries(command: &Command, folder: &Path) -> Vec<String> {
    let trace = folder.join("trace");
    let mut strace = Command::new(find_program("strace"));
    strace
        .args(["-f", "-qq", "-e", "trace=open,openat", "-o"])
        .arg(&trace)
        .arg(command.get_program())
        .args(command.get_args())
        .env("XDG_CONFIG_HOME", folder)
        .env_remove("DISPLAY")
        .current_dir(folder);
    let output = strace.output().unwrap();
    let trace = std::fs::read_to_string(&trace).unwrap();
    assert!(trace.contains("libc.so"), "{output:?}\n{trace}");
    let libraries = trace.split('"').filter(|name| {
        let file = name.rsplit('/').next().unwrap_or_default();
        let display = ["libX", "libxcb", "libxkb", "libwayland"];
        display.iter().any(|library| file.starts_with(library))
    });
    libraries.map(str::to_owned).collect()
}

#[test]
fn a_session_loads_no_library_of_a_display() {
    let folder = private_folder();
    let mut session = Command::new(friction_bench());
    session
        .args(["run", "--mock", "--headless", "--speed", "max"])
        .args(["--participant", "sub-01", "--consent-by", "T", "--protocol"])
        .arg(protocol("one-exploration.toml"));
    let libraries = display_libraries(&session, folder.path());
    assert_eq!(libraries, [""; 0]);
    let log = folder.path().join("study/sub-01/ses-01/events.jsonl");
    assert!(log.is_file(), "no session took place");
    // The window opens them, so the check above is meaningful.
    let mut window = participant(friction_bench());
    window.arg("--socket").arg(folder.path().join("s"));
    let libraries = display_libraries(&window, folder.path());
    assert!(
        libraries.iter().any(|name| name.contains("libX11")),
        "{libraries:?}"
    );
}
