//! A program that runs alongside the test and never outlives it.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use signal_hook::consts::SIGINT;

use crate::screen::Screen;
use crate::session::WrittenStudy;

/// Time between polls.
pub const POLL: Duration = Duration::from_millis(5);

static HEED_SIGINT: Once = Once::new();

/// Handles SIGINT, so that children react to it too: they inherit an ignored SIGINT, as a shell sets it for background
/// processes, but not a handler.
fn heed_sigint() {
    let ends = Arc::new(AtomicBool::new(true));
    signal_hook::flag::register_conditional_shutdown(SIGINT, 130, ends)
        .expect("SIGINT can be handled");
}

/// A child process with its output in a file, so that it never waits for a reader. The study that a `run` writes is verified
/// at the end: it may be incomplete, but must be free of contradictions.
pub struct Running {
    child: Child,
    output: PathBuf,
    study: Option<WrittenStudy>,
}

impl Running {
    /// Starts `command`; both of its outputs go to the file `output`.
    pub fn start(command: &mut Command, output: &Path) -> Self {
        let file = File::create(output).expect("a file for the program's output");
        let errors = file.try_clone().expect("a second handle");
        let study = WrittenStudy::from_command(command);
        let child = command
            .stdin(Stdio::null())
            .stdout(file)
            .stderr(errors)
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
        Self {
            child,
            output: output.to_owned(),
            study,
        }
    }

    /// Starts `command` on `screen`.
    pub fn start_on(screen: &Screen, command: &mut Command) -> Self {
        screen.attach(command);
        HEED_SIGINT.call_once(heed_sigint);
        let study = WrittenStudy::from_command(command);
        let child = command
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
        Self {
            child,
            output: PathBuf::new(),
            study,
        }
    }

    /// Declares that the test itself changes the recorded files, so that they need not verify.
    pub fn skip_verification(&mut self) {
        self.study = None;
    }

    /// Returns its process number.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Returns its resident memory, kB; `None` once it has ended, or where the system does not report it.
    pub fn resident_kb(&self) -> Option<i64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.pid())).ok()?;
        let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
        line.split_whitespace().nth(1)?.parse().ok()
    }

    /// Returns everything it has printed.
    pub fn output(&self) -> String {
        std::fs::read_to_string(&self.output).unwrap_or_default()
    }

    /// Returns its exit status, if it has ended.
    pub fn exit_status(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("a child can be waited for")
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        // A process that has just ended is no error: `wait` reports its end.
        let _ = kill_process(pid.expect("a process number"), signal);
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// When it runs for longer than `timeout`.
    pub fn wait(&mut self, timeout: Duration) -> ExitStatus {
        wait_until(timeout, || self.exit_status()).unwrap_or_else(|| {
            panic!(
                "still running after {timeout:?}; it printed:\n{}",
                self.output()
            )
        })
    }

    /// Asks it to end in good order, and kills it if it does not.
    pub fn end(&mut self, timeout: Duration) {
        self.signal(Signal::TERM);
        if wait_until(timeout, || self.exit_status()).is_none() {
            // It may just have ended.
            let _ = self.child.kill();
        }
    }

    /// Waits until `poll` returns a value; `None` if the program ends first.
    ///
    /// # Panics
    /// When neither happens within `timeout`.
    pub fn wait_for<T>(
        &mut self,
        timeout: Duration,
        mut poll: impl FnMut() -> Option<T>,
    ) -> Option<T> {
        wait_until(timeout, || match poll() {
            Some(value) => Some(Some(value)),
            None => self.exit_status().map(|_| None),
        })
        .unwrap_or_else(|| panic!("nothing within {timeout:?}; it printed:\n{}", self.output()))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        // Only one failure is reported at a time.
        if let Some(study) = self.study.take().filter(|_| !std::thread::panicking()) {
            study.require_consistent();
        }
    }
}

/// Repeats `ask` until it returns an answer or the time is over.
pub fn wait_until<T>(timeout: Duration, mut ask: impl FnMut() -> Option<T>) -> Option<T> {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return Some(answer);
        }
        if start.elapsed() > timeout {
            return None;
        }
        std::thread::sleep(POLL);
    }
}
