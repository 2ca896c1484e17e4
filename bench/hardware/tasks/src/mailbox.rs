//! Queue with a reader that never waits for a writer.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// Queue from tasks of any priority to one of high priority. Channels let their reader spin while a writer is half
/// done: a reader of high priority would spin for ever if it had interrupted that writer on the same core.
///
/// ```
/// let orders = tasks::Mailbox::default();
/// orders.clone().send("arm");
/// orders.send("disarm");
/// assert_eq!((orders.take(), orders.take(), orders.take()), (Some("arm"), Some("disarm"), None));
/// ```
#[derive(Debug)]
pub struct Mailbox<T>(Arc<Mutex<VecDeque<T>>>);

impl<T> Default for Mailbox<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T> Clone for Mailbox<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Mailbox<T> {
    /// Adds `letter`.
    pub fn send(&self, letter: T) {
        let mut letters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        letters.push_back(letter);
    }

    /// Takes the oldest letter; `None` if the mailbox is empty, or while another thread uses it.
    pub fn take(&self) -> Option<T> {
        match self.0.try_lock() {
            Ok(mut letters) => letters.pop_front(),
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner().pop_front(),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_writer_that_is_half_done_is_not_waited_for() {
        let mailbox = Mailbox::default();
        mailbox.send(1);
        let writing = mailbox.0.lock().unwrap();
        assert_eq!(mailbox.take(), None);
        drop(writing);
        assert_eq!(mailbox.take(), Some(1));
    }
}
