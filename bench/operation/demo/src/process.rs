//! A step of the demonstration, as a process.

use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus};
use std::thread::sleep;
use std::time::Duration;

use crate::signals::Signals;
use crate::steps::Step;

/// Time between two checks of a running step.
const PERIOD: Duration = Duration::from_millis(20);

/// Runs a step to completion, on this process's terminal or pipes.
pub fn run(step: &Step, program: &Path, signals: &mut Signals) -> io::Result<ExitStatus> {
    let mut child = Command::new(program).args(&step.words).spawn()?;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        signals.pass_on(&mut child);
        sleep(PERIOD);
    }
}
