//! Direct stop of the drive for a key or a signal.

use std::fmt;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

use tasks::Mailbox;

use crate::safety_state::SafetyCommand;
use crate::signals::Signals;
use crate::trip::Trip;

/// Stops a drive from any thread, bypassing the task that decides about it. The thread that reads a key or a signal
/// calls it before it passes either on: no disk, network or full queue can delay the stop.
///
/// ```
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// use safety::{DriveStop, SafetyCommand, Signals, Trip};
///
/// let (kills, commands) = (Arc::new(AtomicU64::new(0)), tasks::Mailbox::default());
/// let counted = Arc::clone(&kills);
/// let stop = DriveStop::new(commands.clone(), Arc::new(Signals::default()), move || {
///     counted.fetch_add(1, Ordering::Relaxed);
/// });
/// stop.trip(Trip::Operator);
/// assert_eq!(kills.load(Ordering::Relaxed), 1);
/// assert!(matches!(commands.take(), Some(SafetyCommand::Trip(Trip::Operator))));
/// ```
#[derive(Clone, Default)]
pub struct DriveStop(Arc<Mutex<Option<Wired>>>);

/// The drive that is stopped.
#[derive(Clone)]
struct Wired {
    commands: Mailbox<SafetyCommand>,
    signals: Arc<Signals>,
    kill: Arc<dyn Fn() + Send + Sync>,
}

impl DriveStop {
    /// Makes the stop of the drive that `kill` silences; the safety watch at `commands` and `signals` latches it.
    pub fn new(
        commands: Mailbox<SafetyCommand>,
        signals: Arc<Signals>,
        kill: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let wired = Wired {
            commands,
            signals,
            kill: Arc::new(kill),
        };
        Self(Arc::new(Mutex::new(Some(wired))))
    }

    /// Shows the watch that the stop key is read: after the first call, an armed bench trips a second after the last
    /// one.
    pub fn hear(&self) {
        if let Some(Wired { signals, .. }) = self.wired() {
            signals.hearings.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Stops the drive of `other` from now on: one dashboard may show several benches, one after the other.
    pub fn follow(&self, other: &Self) {
        let wired = other.wired();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = wired;
    }

    /// Silences the drive and latches the trip.
    pub fn trip(&self, trip: Trip) {
        if let Some(Wired { commands, kill, .. }) = self.wired() {
            // First, so that the watch finds the reason of the kill.
            commands.send(SafetyCommand::Trip(trip));
            kill();
        }
    }

    /// Silences the drive of a bench that ends.
    pub fn kill(&self) {
        if let Some(Wired { signals, kill, .. }) = self.wired() {
            // First, so that the watch knows the kill as the end's.
            signals.ends.store(true, Ordering::SeqCst);
            kill();
        }
    }

    fn wired(&self) -> Option<Wired> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl fmt::Debug for DriveStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DriveStop").finish_non_exhaustive()
    }
}
