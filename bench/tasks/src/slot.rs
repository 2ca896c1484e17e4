//! Latest value that one task publishes and others read.

use std::sync::{Mutex, PoisonError};

/// Latest value of a quantity: replaced, never queued.
///
/// ```
/// let force_n = tasks::Slot::default();
/// assert_eq!(force_n.get(), None);
/// force_n.set(0.4);
/// force_n.set(0.6);
/// assert_eq!(force_n.get(), Some(0.6));
/// ```
#[derive(Debug)]
pub struct Slot<T>(Mutex<Option<T>>);

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T: PartialOrd> Slot<T> {
    /// Publishes `value` if it is greater than the latest one.
    ///
    /// ```
    /// let longest_s = tasks::Slot::default();
    /// longest_s.raise(0.4);
    /// longest_s.raise(0.3);
    /// assert_eq!(longest_s.get(), Some(0.4));
    /// ```
    pub fn raise(&self, value: T) {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if latest.as_ref().is_none_or(|latest| value > *latest) {
            *latest = Some(value);
        }
    }
}

impl<T: Clone> Slot<T> {
    /// Publishes `value`.
    pub fn set(&self, value: T) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
    }

    /// Returns the latest value; `None` before the first.
    pub fn get(&self) -> Option<T> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}
