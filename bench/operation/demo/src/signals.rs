//! Signals during a step: they end the step properly, and then the demonstration.

use std::io;
use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::register_usize;

/// Signals that end a demonstration.
#[cfg(unix)]
const ENDING: &[i32] = &[SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
const ENDING: &[i32] = &[SIGINT, SIGTERM];

/// The most recent signal, if any.
pub struct Signals {
    came: Arc<AtomicUsize>,
    /// Last signal passed on to the step.
    told: Option<i32>,
}

impl Signals {
    /// Starts to handle the signals that end a demonstration.
    pub fn handle() -> io::Result<Self> {
        let came = Arc::new(AtomicUsize::new(0));
        for &signal in ENDING {
            register_usize(
                signal,
                Arc::clone(&came),
                usize::try_from(signal).unwrap_or(0),
            )?;
        }
        Ok(Self { came, told: None })
    }

    /// Returns the most recent signal.
    pub fn came(&self) -> Option<i32> {
        let signal = self.came.load(Ordering::Relaxed);
        i32::try_from(signal).ok().filter(|signal| *signal != 0)
    }

    /// Passes a signal on to the step, once. Ctrl-C is skipped: the terminal has already sent it to the step.
    pub fn pass_on(&mut self, step: &mut Child) {
        let came = self.came();
        if came == self.told {
            return;
        }
        self.told = came;
        if let Some(signal) = came.filter(|signal| *signal != SIGINT) {
            send(signal, step);
        }
    }
}

/// Sends a signal to a step that is not yet reaped.
#[cfg(unix)]
fn send(signal: i32, step: &Child) {
    use rustix::process::{Pid, Signal, kill_process};
    let pid = i32::try_from(step.id()).ok().and_then(Pid::from_raw);
    if let Some((pid, signal)) = pid.zip(Signal::from_named_raw(signal)) {
        // The step may have just ended.
        let _ = kill_process(pid, signal);
    }
}

/// Kills a step that is not yet reaped; this platform has no other signals.
#[cfg(not(unix))]
fn send(_: i32, step: &mut Child) {
    // The step may have just ended.
    let _ = step.kill();
}
