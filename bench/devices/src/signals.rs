//! Signals that ask the program to end: an orderly stop while somebody listens, the system's own ending otherwise.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use anyhow::{Context, bail};
use signal_hook::consts::{SIGINT, SIGTERM};
use tasks::StopFlag;

/// The terminal was closed, or its key for the hardest stop was pressed.
#[cfg(unix)]
const SIGNALS: [i32; 4] = [
    SIGINT,
    SIGTERM,
    signal_hook::consts::SIGHUP,
    signal_hook::consts::SIGQUIT,
];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// What is known of the signals of this process.
#[derive(Default)]
struct Heard {
    /// A signal came while somebody listened.
    signalled: Arc<AtomicBool>,
    /// A signal ends the program at once, because nobody listens.
    at_once: Arc<AtomicBool>,
    listeners: AtomicUsize,
}

static HEARD: OnceLock<Heard> = OnceLock::new();

/// Somebody who listens to signals; dropped, a signal ends the program as if nothing had been opened.
#[derive(Debug)]
pub struct Listening(());

impl Drop for Listening {
    fn drop(&mut self) {
        if let Some(heard) = HEARD.get()
            && heard.listeners.fetch_sub(1, Ordering::AcqRel) == 1
        {
            // After a signal the program is about to end in good order, and says how.
            let signalled = heard.signalled.load(Ordering::Acquire);
            heard.at_once.store(!signalled, Ordering::Release);
        }
    }
}

/// Raises `stop` when a signal asks the program to end: SIGINT, SIGTERM, and SIGHUP and SIGQUIT where there are any.
///
/// # Errors
/// When a signal came before, or a handler cannot be registered.
pub fn stop_on_signals(stop: &StopFlag) -> anyhow::Result<Listening> {
    let heard = heard()?;
    heard.listeners.fetch_add(1, Ordering::AcqRel);
    let listening = Listening(());
    heard.at_once.store(false, Ordering::Release);
    for signal in SIGNALS {
        signal_hook::flag::register(signal, stop.shared()).context("cannot hear of signals")?;
    }
    if heard.signalled.load(Ordering::Acquire) {
        bail!("ended by a signal");
    }
    Ok(listening)
}

/// Returns what is known of signals, with the handlers that stay.
fn heard() -> anyhow::Result<&'static Heard> {
    if let Some(heard) = HEARD.get() {
        return Ok(heard);
    }
    let heard = Heard::default();
    for signal in SIGNALS {
        // The first that runs: where nobody listens, nothing else is asked.
        #[cfg(unix)]
        signal_hook::flag::register_conditional_default(signal, Arc::clone(&heard.at_once))
            .context("cannot hear of signals")?;
        signal_hook::flag::register(signal, Arc::clone(&heard.signalled))
            .context("cannot hear of signals")?;
    }
    Ok(HEARD.get_or_init(|| heard))
}
