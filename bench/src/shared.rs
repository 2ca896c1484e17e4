//! Latest values that one task publishes and others read. Nothing here waits for long: a slot holds one small value.

use std::sync::{Mutex, PoisonError};

use crate::field::FieldHealth;
use crate::safety::SafetyState;

/// A value that is replaced, never queued.
#[derive(Debug)]
pub struct Slot<T>(Mutex<Option<T>>);

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T: Clone> Slot<T> {
    /// Publishes `value`.
    pub fn set(&self, value: T) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
    }

    /// The latest value; `None` before the first.
    pub fn get(&self) -> Option<T> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// The drive's voltage as it is read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReading {
    /// Envelope, V peak.
    pub volts: f64,
    /// The input's sample that it belongs to.
    pub sample: u64,
    /// When it was read, host time, ns.
    pub at_ns: u64,
}

/// How hard the finger presses, as the force sensor tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    /// Normal force, N.
    pub normal_n: f64,
    /// The same without calibration, as the sensor itself says it, N.
    pub raw_n: f64,
    /// The normal axis was at the end of its range.
    pub saturated: bool,
    /// Host time, ns.
    pub at_ns: u64,
}

/// What the tasks of one bench tell each other.
#[derive(Debug, Default)]
pub struct Shared {
    /// The drive read back: written by the acquisition.
    pub readback: Slot<DriveReading>,
    /// When the force link last looked for samples, host time, ns.
    pub force_polled_ns: Slot<u64>,
    /// The latest press: written by the force link.
    pub press: Slot<Press>,
    /// State of the safety watch.
    pub safety: Slot<SafetyState>,
    /// Fill of the audio ring, 0 to 1.
    pub ring_fill: Slot<f64>,
    /// What the slow inputs have suffered.
    pub field: Slot<FieldHealth>,
}
