//! Signals that ask the program to end: an orderly stop while a listener exists, the system's default otherwise.
//!
//! On Unix, separate threads silence the drives when a signal arrives, and end a program that waits for a hanging disk
//! or terminal.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use anyhow::{Context, bail};
use safety::DriveStop;
use signal_hook::consts::{SIGINT, SIGTERM};
use tasks::StopFlag;

/// Interrupt and termination; also SIGHUP, after the terminal was closed, and SIGQUIT, its quit key.
#[cfg(unix)]
const SIGNALS: [i32; 4] = [
    SIGINT,
    SIGTERM,
    signal_hook::consts::SIGHUP,
    signal_hook::consts::SIGQUIT,
];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// State of the signals of this process.
#[derive(Default)]
struct Heard {
    /// Whether a signal came while a listener existed.
    signalled: Arc<AtomicBool>,
    /// Whether a signal ends the program at once, because no listener exists.
    at_once: Arc<AtomicBool>,
    listeners: Mutex<Listeners>,
}

/// Benches and programs that end in good order.
#[derive(Default)]
struct Listeners {
    listening: Vec<(u64, StopFlag, DriveStop)>,
    next: u64,
}

impl Heard {
    fn listeners(&self) -> MutexGuard<'_, Listeners> {
        self.listeners
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

static HEARD: OnceLock<Heard> = OnceLock::new();

/// Listener to signals; after it is dropped, a signal ends the program as if nothing had been opened.
#[derive(Debug)]
pub struct Listening(u64);

impl Drop for Listening {
    fn drop(&mut self) {
        let Some(state) = HEARD.get() else { return };
        let mut listeners = state.listeners();
        listeners.listening.retain(|(number, ..)| *number != self.0);
        if listeners.listening.is_empty() {
            // After a signal the program is about to end in good order, and says how.
            let signalled = state.signalled.load(Ordering::Acquire);
            state.at_once.store(!signalled, Ordering::Release);
        }
    }
}

/// Raises `stop` when a signal asks a program without a drive to end, as for a bench.
///
/// # Errors
/// If a signal came before, or a handler cannot be registered.
pub fn stop_on_signals(stop: &StopFlag) -> anyhow::Result<Listening> {
    stop_drive_on_signals(stop, DriveStop::default())
}

/// Raises `stop` and silences `drive` when a signal asks the program to end: SIGINT, SIGTERM, and SIGHUP and SIGQUIT
/// where they exist. On Unix the process ends within a second of the signal, even if a part of it hangs.
///
/// # Errors
/// If a signal came before, or a handler cannot be registered.
pub fn stop_drive_on_signals(stop: &StopFlag, drive: DriveStop) -> anyhow::Result<Listening> {
    let state = state()?;
    let listening = {
        let mut listeners = state.listeners();
        let number = listeners.next;
        listeners.next += 1;
        listeners.listening.push((number, stop.clone(), drive));
        Listening(number)
    };
    state.at_once.store(false, Ordering::Release);
    for signal in SIGNALS {
        signal_hook::flag::register(signal, stop.shared()).context("cannot hear of signals")?;
    }
    if state.signalled.load(Ordering::Acquire) {
        bail!("ended by a signal");
    }
    Ok(listening)
}

/// Returns the state of the signals, with permanent handlers.
fn state() -> anyhow::Result<&'static Heard> {
    if let Some(state) = HEARD.get() {
        return Ok(state);
    }
    let state = Heard::default();
    for signal in SIGNALS {
        // Registered first, so that it runs first: without a listener, nothing else runs.
        #[cfg(unix)]
        signal_hook::flag::register_conditional_default(signal, Arc::clone(&state.at_once))
            .context("cannot hear of signals")?;
        signal_hook::flag::register(signal, Arc::clone(&state.signalled))
            .context("cannot hear of signals")?;
    }
    let mut first = false;
    let state = HEARD.get_or_init(|| {
        first = true;
        state
    });
    #[cfg(unix)]
    if first {
        ending::watch_signals(state)?;
        ending::leave_signals_to_their_threads()?;
    }
    Ok(state)
}

/// Sets a function to run before a hanging program is ended, such as to restore its terminal; only the first call
/// counts.
pub fn before_a_hard_end(restore: fn()) {
    #[cfg(unix)]
    let _kept = ending::RESTORE.set(restore);
    #[cfg(not(unix))]
    let _ = restore;
}

#[cfg(unix)]
mod ending {
    use std::io::Write;
    use std::sync::OnceLock;
    use std::sync::mpsc;
    use std::thread;
    use std::time::Duration;

    use anyhow::Context;
    use nix::sys::signal::{SigSet, Signal};
    use signal_hook::iterator::Signals;

    use super::{Heard, SIGNALS};

    /// Time from a signal to the end of a program that hangs: a second, less the time of the last steps.
    const PATIENCE: Duration = Duration::from_millis(800);
    /// Longest wait for the terminal to be restored and to take the last message.
    const LAST_WORDS: Duration = Duration::from_millis(60);
    /// Exit status of a program that was ended because it hung.
    const STATUS: i32 = 2;

    /// Function that restores the terminal.
    pub(super) static RESTORE: OnceLock<fn()> = OnceLock::new();

    /// Starts two threads that wait for signals: while one hangs, the other does its work.
    ///
    /// # Errors
    /// The system's error.
    pub(super) fn watch_signals(state: &'static Heard) -> anyhow::Result<()> {
        for (patience, speaks) in [(PATIENCE, true), (PATIENCE + LAST_WORDS, false)] {
            let mut signals = Signals::new(SIGNALS).context("cannot hear of signals")?;
            thread::Builder::new()
                .name("signals".to_owned())
                .spawn(move || {
                    // Signals are unblocked on a thread that must receive them, for any state that it inherited.
                    let _heard = of_signals().map(|set| set.thread_unblock());
                    for _signal in signals.forever() {
                        let listening = state.listeners().listening.clone();
                        for (_, stop, drive) in &listening {
                            stop.raise();
                            drive.kill();
                        }
                        if !listening.is_empty() {
                            thread::sleep(patience);
                            let busy = listening.iter().flat_map(|(_, stop, _)| stop.busy());
                            if speaks {
                                say_what_hangs(busy.collect());
                            }
                            signal_hook::low_level::exit(STATUS);
                        }
                    }
                })
                .context("cannot start the threads that wait for signals")?;
        }
        Ok(())
    }

    fn of_signals() -> nix::Result<SigSet> {
        SIGNALS.into_iter().map(Signal::try_from).collect()
    }

    /// Blocks the signals on this thread and on all threads that it starts from now on. The system gives a signal to
    /// any thread that does not block it, preferably the first, and a thread that hangs in a disk's driver would keep
    /// it.
    ///
    /// # Errors
    /// The system's error.
    pub(super) fn leave_signals_to_their_threads() -> anyhow::Result<()> {
        of_signals()
            .and_then(|set| set.thread_block())
            .context("cannot leave the signals to threads of theirs")
    }

    /// Restores the terminal and reports on it that the program waited for `busy`, if the terminal responds in time.
    fn say_what_hangs(busy: Vec<&'static str>) {
        let (sender, receiver) = mpsc::channel();
        let last_words = thread::Builder::new().spawn(move || {
            if let Some(restore) = RESTORE.get() {
                restore();
            }
            let _ = writeln!(
                standard_streams::stderr(),
                "friction-bench: {}",
                words(&busy)
            );
            let _ = sender.send(());
        });
        if last_words.is_ok() {
            let _ = receiver.recv_timeout(LAST_WORDS);
        }
    }

    fn words(busy: &[&str]) -> String {
        let parts = match busy {
            [] => "its end".to_owned(),
            parts => parts.join(", "),
        };
        format!(
            "ended without waiting any longer for {parts}: a disk, a network share or a terminal hangs; saved data are \
             kept: look at the disk, then `friction-bench verify`, and `run` with --resume"
        )
    }

    #[cfg(test)]
    mod tests {
        #[test]
        fn the_last_words_name_the_parts_that_hang() {
            assert!(
                super::words(&["recorder", "journal"]).contains("for recorder, journal: a disk")
            );
            assert!(super::words(&[]).contains("for its end"));
        }
    }
}
