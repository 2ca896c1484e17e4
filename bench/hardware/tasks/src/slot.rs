//! Latest value that one task publishes and others read.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

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

    /// Updates `reading` to the latest value, unless another thread uses the slot at this moment: for a thread of high
    /// priority, which must not wait for one of lower priority.
    ///
    /// ```
    /// let (force_n, mut seen) = (tasks::Slot::default(), None);
    /// force_n.set(0.4);
    /// force_n.look(&mut seen);
    /// assert_eq!(seen, Some(0.4));
    /// ```
    pub fn look(&self, reading: &mut Option<T>) {
        if let Some(latest) = self.without_waiting() {
            reading.clone_from(&latest);
        }
    }

    /// Publishes `value` and takes it, unless another thread uses the slot at this moment; it is then left for a later
    /// try.
    pub fn offer(&self, value: &mut Option<T>) {
        if value.is_some()
            && let Some(mut latest) = self.without_waiting()
        {
            *latest = value.take();
        }
    }

    fn without_waiting(&self) -> Option<MutexGuard<'_, Option<T>>> {
        match self.0.try_lock() {
            Ok(latest) => Some(latest),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_that_another_thread_holds_is_not_waited_for() {
        let slot = Slot::default();
        slot.set(1);
        let (mut latest, mut offered) = (None, Some(3));
        slot.look(&mut latest);
        let guard = slot.0.lock().unwrap();
        slot.look(&mut latest);
        slot.offer(&mut offered);
        assert_eq!((latest, offered), (Some(1), Some(3)));
        drop(guard);
        slot.offer(&mut offered);
        slot.look(&mut latest);
        assert_eq!((latest, offered), (Some(3), None));
    }
}
