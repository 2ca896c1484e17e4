//! Sessions in real time with hanging threads, and an oscilloscope on the plate that shows whether a stop still works.
#![cfg(target_os = "linux")]

use std::fmt;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mock_hw::oscilloscope::{Readings, monotonic_ns, press_estop};
use protocols::TrialOutcome;
use rustix::process::Signal;
use tempfile::TempDir;

use crate::finding;
use crate::program::bench;
use crate::running::{POLL, Running, wait_until};
use crate::screen::Screen;
use crate::session::{SessionFolder, finish, replace_parts, text, write_demo_protocol};
use crate::thread_hold::{Thread, ThreadHold, has_ended, numbers, threads};

/// Longest time until a session drives the plate.
const PATIENCE: Duration = Duration::from_secs(30);
/// Number of sessions to start until one drives.
const STARTS: usize = 3;
/// Time without drive that counts as silence, ns: longer than the zeros of the modulation.
const QUIET_NS: u64 = 400_000_000;
/// Time between the two keys of a stop that asks for confirmation.
const ANSWER: Duration = Duration::from_millis(200);

/// A stop of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The operator's key `e`.
    Key,
    /// The operator's key `q`, confirmed by `y`.
    Quit,
    /// Ctrl-C on the operator's keyboard, confirmed by `y`.
    Interrupt,
    /// SIGTERM.
    Terminate,
    /// The e-stop.
    EStop,
}

impl Stop {
    /// All stops.
    pub const ALL: [Self; 5] = [
        Self::Key,
        Self::Quit,
        Self::Interrupt,
        Self::Terminate,
        Self::EStop,
    ];

    /// Whether it is entered at the operator's keyboard.
    #[must_use]
    pub fn is_typed(self) -> bool {
        matches!(self, Self::Key | Self::Quit | Self::Interrupt)
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Key => "e",
            Self::Quit => "q y",
            Self::Interrupt => "Ctrl-C y",
            Self::Terminate => "SIGTERM",
            Self::EStop => "e-stop",
        })
    }
}

/// Configuration of a session.
#[derive(Debug, Clone)]
pub struct Rig {
    /// Simulated scenario.
    pub scenario: &'static str,
    /// Duration of an exploration, s; the plate is driven for longer.
    pub stroke_s: f64,
    /// Number of trials.
    pub trials: u32,
    /// Further options of `run`.
    pub options: Vec<&'static str>,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            scenario: "nominal",
            stroke_s: 8.5,
            trials: 1,
            options: Vec::new(),
        }
    }
}

/// A session on its own terminal.
pub struct HungSession {
    /// The terminal.
    pub screen: Screen,
    running: Running,
    /// Folder of all files except the oscilloscope's.
    pub folder: TempDir,
    scope: ScopeFile,
}

/// The oscilloscope's file, in memory where possible.
struct ScopeFile(PathBuf);

impl ScopeFile {
    fn for_folder(folder: &Path) -> Self {
        let name = folder
            .file_name()
            .map_or_else(Default::default, |name| name.to_string_lossy().into_owned());
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory } else { folder };
        Self(parent.join(format!("oscilloscope-{name}")))
    }
}

impl Drop for ScopeFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Effect of a stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopEffect {
    /// Time from the stop to the last driven sample at the plate, s; `None` if it was driven until the end of the observation.
    pub silent_s: Option<f64>,
    /// Time from the stop to the end of the process, s; `None` if it ran until the end of the observation.
    pub ended_s: Option<f64>,
    /// Greatest lateness of this machine during the observation, s, measured on the test's thread.
    pub late_s: f64,
}

impl HungSession {
    /// Starts a session and waits until its trial is being recorded and the plate driven.
    ///
    /// # Panics
    /// When no session drives.
    #[must_use]
    pub fn start(rig: &Rig) -> Self {
        Self::start_prepared(rig, |_: &Path| ())
    }

    /// Does the same after `prepare` has prepared the session's folder, for instance with a window to connect to.
    ///
    /// # Panics
    /// When no session drives.
    #[must_use]
    pub fn start_prepared(rig: &Rig, prepare: impl Fn(&Path)) -> Self {
        // On a busy machine the check before a session may refuse it.
        let session = (0..STARTS).find_map(|_| Self::try_start(rig, &prepare));
        session.unwrap_or_else(|| panic!("no drive in {STARTS} sessions"))
    }

    fn try_start(rig: &Rig, prepare: impl Fn(&Path)) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder");
        // The session and the window meet only in a private folder.
        let private = Permissions::from_mode(0o700);
        std::fs::set_permissions(folder.path(), private).expect("a folder of its own");
        prepare(folder.path());
        let trials = format!("per_condition = {}", rig.trials);
        let speed = format!("speed_m_per_s = {:.4}", 0.085 / rig.stroke_s);
        write_demo_protocol(
            folder.path(),
            &[
                ("practice = 1", "practice = 0"),
                ("per_condition = 4", &trials),
                ("speed_m_per_s = 0.050", &speed),
                (
                    "[\"left_to_right\", \"right_to_left\"]",
                    "[\"left_to_right\"]",
                ),
            ],
        );
        let output = finish(bench().args(["run", "--mock", rig.scenario, "--print-config"]));
        // Limits that allow for a busy machine.
        let config = replace_parts(
            &text(&output),
            &[
                ("loop_latency_s =", "loop_latency_s = 1.0 # not"),
                ("silence_s =", "silence_s = 1.0 # not"),
            ],
        );
        std::fs::write(folder.path().join("bench.toml"), config).expect("a configuration");
        let scope = ScopeFile::for_folder(folder.path());
        let screen = Screen::open(120, 40);
        let mut run = bench();
        run.args(["run", "--mock", rig.scenario, "--participant", "sub-01"])
            .args(["--consent-by", "A. Tester", "--protocol", "protocol.toml"])
            .args(["--study", "study", "--config", "bench.toml"])
            .args(&rig.options)
            .current_dir(folder.path())
            .env("FRICTION_BENCH_OSCILLOSCOPE", &scope.0);
        let running = Running::start_on(&screen, &mut run);
        let session = Self {
            screen,
            running,
            folder,
            scope,
        };
        let drives = wait_until(PATIENCE, || {
            let is_driving = session.log_contains("\"trial_began\"") && session.is_driven();
            (is_driving || has_ended(session.pid())).then_some(is_driving)
        });
        (drives == Some(true)).then_some(session)
    }

    /// Returns the study's folder.
    #[must_use]
    pub fn study(&self) -> PathBuf {
        self.folder.path().join("study")
    }

    /// Returns whether the session's log contains `words`.
    #[must_use]
    pub fn log_contains(&self, words: &str) -> bool {
        let log = self.study().join("sub-01/ses-01/events.jsonl");
        std::fs::read_to_string(log).is_ok_and(|log| log.contains(words))
    }

    /// Returns the program's process number.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.running.pid()
    }

    /// Returns the oscilloscope's readings.
    ///
    /// # Panics
    /// When its file cannot be read.
    #[must_use]
    pub fn readings(&self) -> Readings {
        let readings = Readings::read(&self.scope.0).expect("the oscilloscope's file");
        readings.unwrap_or_default()
    }

    /// Returns whether the plate is driven, ignoring the zeros of the modulation.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        monotonic_ns().saturating_sub(self.readings().driven_ns) < QUIET_NS
    }

    /// Returns the threads with this name.
    #[must_use]
    pub fn threads_named(&self, name: &str) -> Vec<Thread> {
        let mut matches = threads(self.pid());
        matches.retain(|thread| thread.name == name);
        matches
    }

    /// Holds the thread `name` at its next call of `call`; `None` if there is no such thread, or it does not call within
    /// `timeout`.
    #[must_use]
    pub fn hold(&self, name: &str, call: &str, timeout: Duration) -> Option<ThreadHold> {
        let thread = self.threads_named(name).into_iter().next()?;
        ThreadHold::begin(self.pid(), thread.id, &numbers(call), timeout)
    }

    /// Requests a stop; returns the time of the request, ns.
    ///
    /// # Panics
    /// When the e-stop cannot be pressed.
    pub fn ask(&mut self, stop: Stop) -> u64 {
        if let Some(key) = match stop {
            Stop::Quit => Some("q"),
            Stop::Interrupt => Some("\u{3}"),
            _ => None,
        } {
            self.screen.press(key);
            std::thread::sleep(ANSWER);
        }
        let now_ns = monotonic_ns();
        match stop {
            Stop::Key => self.screen.press("e"),
            Stop::Quit | Stop::Interrupt => self.screen.press("y"),
            Stop::Terminate => self.running.signal(Signal::TERM),
            Stop::EStop => press_estop(&self.scope.0, true).expect("the e-stop's button"),
        }
        now_ns
    }

    /// Observes the effect of a stop requested at `asked_ns`, for up to `longest`.
    #[must_use]
    pub fn watch(&self, asked_ns: u64, longest: Duration, awaits_end: bool) -> StopEffect {
        let mut effect = StopEffect {
            silent_s: None,
            ended_s: None,
            late_s: 0.0,
        };
        let mut poll_time = Instant::now();
        let delay_s = |ns: u64| ns.saturating_sub(asked_ns) as f64 * 1e-9;
        let _longest = wait_until(longest, || {
            let now_ns = monotonic_ns();
            let lateness = poll_time.elapsed().saturating_sub(POLL);
            effect.late_s = effect.late_s.max(lateness.as_secs_f64());
            poll_time = Instant::now();
            let has_ended_now = has_ended(self.pid());
            let last_driven_ns = self.readings().driven_ns;
            if has_ended_now && effect.ended_s.is_none() {
                effect.ended_s = Some(delay_s(now_ns));
            }
            if effect.silent_s.is_none()
                && (has_ended_now || now_ns.saturating_sub(last_driven_ns.max(asked_ns)) > QUIET_NS)
            {
                effect.silent_s = Some(delay_s(last_driven_ns));
            }
            (effect.silent_s.is_some() && (has_ended_now || !awaits_end)).then_some(())
        });
        effect
    }

    /// Ends the program, by force if necessary.
    pub fn end(&mut self) {
        if !has_ended(self.pid()) {
            self.running.signal(Signal::TERM);
        }
        let end = wait_until(Duration::from_secs(20), || {
            has_ended(self.pid()).then_some(())
        });
        if end.is_none() {
            self.running.signal(Signal::KILL);
        }
        let _ = wait_until(Duration::from_secs(5), || self.running.exit_status());
    }

    /// Returns the contradictions in the study between log, recordings and `verify`.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        contradictions(&self.study())
    }
}

/// Returns the contradictions in a study of one session of `sub-01`: between its log, its recordings, `verify`, and the
/// recordings that `analyze` finds.
#[must_use]
pub fn contradictions(study: &Path) -> Vec<String> {
    let mut findings = Vec::new();
    let Some(session) = SessionFolder::read(study, "sub-01") else {
        return vec!["no log".to_owned()];
    };
    let trials = accepted_trials(&session);
    for name in &trials {
        let folder = session.path.join(name);
        match recording::RecordingReader::open(&folder) {
            Ok(reader) => {
                let ending = reader.manifest().trial.as_ref().and_then(|trial| trial.end);
                if ending != Some(recording::manifest::End::Completed) {
                    findings.push(format!("{name} is accepted, its recording {ending:?}"));
                }
                if reader.frames() == 0 {
                    findings.push(format!("{name} is accepted without a sample"));
                }
            }
            Err(error) => findings.push(format!("{name} is accepted, and unreadable: {error}")),
        }
    }
    match study::verification::session(&session.path, || {}) {
        // An interrupted session may be incomplete without being damaged.
        Ok(checks) if !checks.is_whole() => {
            findings.push(format!("verify: {}", short_debug(&checks)));
        }
        Ok(_) => {}
        Err(error) => findings.push(format!("verify: {error}")),
    }
    if !trials.is_empty() {
        match attempts::find::recordings(&[study.to_owned()], false) {
            Ok(paths) => {
                let names = paths.iter().filter_map(|path| path.file_name());
                let mut names: Vec<String> = names
                    .map(|name| name.to_string_lossy().into_owned())
                    .collect();
                names.sort();
                if names != trials {
                    findings.push(format!("accepted {trials:?}, analysed {names:?}"));
                }
            }
            Err(error) => findings.push(format!("analyze: {error}")),
        }
    }
    if !findings.is_empty() {
        finding::keep(&findings.join("\n"));
    }
    findings
}

fn short_debug(checks: &impl fmt::Debug) -> String {
    let words = format!("{checks:?}");
    words.chars().take(400).collect()
}

/// Returns the folders of the attempts that the log records as accepted, in order. The protocol has no practice trials.
fn accepted_trials(session: &SessionFolder) -> Vec<String> {
    let is_accepted = |outcome: &TrialOutcome| {
        matches!(
            outcome,
            TrialOutcome::Accepted | TrialOutcome::AcceptedAnyway { .. }
        )
    };
    let records = session.history().records.into_iter();
    let records = records.filter(|record| is_accepted(&record.outcome));
    let mut names: Vec<String> = records
        .map(|record| {
            let (number, attempt) = (record.key.number, record.key.attempt);
            format!("trial-{number:03}_attempt-{attempt}")
        })
        .collect();
    names.sort();
    names
}
