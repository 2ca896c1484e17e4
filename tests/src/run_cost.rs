//! Output, time and memory of a command.

use std::fs;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Output and cost of a command.
pub struct RunCost {
    /// Exit status; `None` if it was killed.
    pub code: Option<i32>,
    /// Standard output and standard error.
    pub transcript: String,
    /// Time until its end.
    pub time: Duration,
    /// Largest resident memory, kB.
    pub peak_kb: u64,
}

impl RunCost {
    /// Runs a command and watches its memory; kills it after `limit`.
    ///
    /// # Panics
    /// When it does not start.
    pub fn measure(command: &mut Command, limit: Duration) -> Self {
        let output = tempfile::NamedTempFile::new().expect("a file for its output");
        let start = Instant::now();
        let mut child = command
            .stdin(Stdio::null())
            .stdout(output.reopen().expect("its output"))
            .stderr(output.reopen().expect("its output"))
            .spawn()
            .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
        let status = format!("/proc/{}/status", child.id());
        let mut peak_kb = 0;
        let exit_status = loop {
            // Peak memory as recorded by the system.
            let status = fs::read_to_string(&status).unwrap_or_default();
            let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let peak = peak.and_then(|peak| peak.split_whitespace().next()?.parse().ok());
            peak_kb = peak_kb.max(peak.unwrap_or(0));
            if let Some(exit_status) = child.try_wait().expect("its end") {
                break exit_status;
            }
            if start.elapsed() > limit {
                child.kill().expect("its end");
                break child.wait().expect("its end");
            }
            thread::sleep(Duration::from_millis(2));
        };
        let transcript = fs::read(output.path()).expect("its output");
        Self {
            code: exit_status.code(),
            transcript: String::from_utf8_lossy(&transcript).into_owned(),
            time: start.elapsed(),
            peak_kb,
        }
    }
}
