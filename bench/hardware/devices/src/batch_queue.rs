//! Queue of batches from the acquisition to the session: the acquisition never waits for it, and it stays bounded while
//! it is not read.

use crossbeam_channel::{Receiver, Sender, TrySendError};
use recording::pipeline::Batch;

/// Most batches that wait: eight seconds, at one batch per millisecond. The safety watch stops a session that does not
/// look for one second.
const MOST_WAITING: usize = 1 << 13;
/// Most warnings kept from dropped batches.
const MOST_WARNINGS: usize = 100;

/// Number of batches that were not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0} ms of forces, positions and impedances did not reach the session, which read none for seconds: its displays \
     and verdicts have a gap, the recording does not"
)]
pub struct BatchesDropped(pub u64);

impl BatchesDropped {
    /// Returns the batches dropped before `batch`; `None` if there were none.
    #[must_use]
    pub fn dropped_before(batch: &Batch) -> Option<Self> {
        (batch.dropped > 0).then_some(Self(batch.dropped))
    }
}

/// Sending end of the queue, for the acquisition.
pub struct BatchSender {
    to: Sender<Batch>,
    /// Batches dropped since the last one that found room, and their warnings.
    dropped: u64,
    warnings: Vec<String>,
}

/// Returns both ends of a queue of batches.
#[must_use]
pub fn batch_queue() -> (BatchSender, Receiver<Batch>) {
    let (to, batches) = crossbeam_channel::bounded(MOST_WAITING);
    let sender = BatchSender {
        to,
        dropped: 0,
        warnings: Vec::new(),
    };
    (sender, batches)
}

impl BatchSender {
    /// Sends a batch, or counts it in the next one that finds room.
    pub(crate) fn send(&mut self, mut batch: Batch) {
        batch.dropped = self.dropped;
        let mut warnings = std::mem::take(&mut self.warnings);
        warnings.append(&mut batch.warnings);
        batch.warnings = warnings;
        match self.to.try_send(batch) {
            Err(TrySendError::Full(batch)) => {
                self.dropped += 1;
                self.warnings = batch.warnings;
                self.warnings.truncate(MOST_WARNINGS);
            }
            // The session ends only when the bench stops.
            Ok(()) | Err(TrySendError::Disconnected(_)) => self.dropped = 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 49.
    #[test]
    fn batches_that_nobody_takes_are_counted_in_the_next_one_and_keep_their_warnings() {
        let (mut sender, batches) = batch_queue();
        let most = MOST_WAITING as u64;
        for k in 0..most + 3 {
            sender.send(Batch {
                warnings: vec![k.to_string()],
                ..Batch::default()
            });
        }
        assert_eq!(batches.len(), MOST_WAITING);
        assert!(batches.try_iter().all(|batch| batch.dropped == 0));
        sender.send(Batch::default());
        let first = batches.try_recv().unwrap();
        assert_eq!(
            BatchesDropped::dropped_before(&first),
            Some(BatchesDropped(3))
        );
        let warnings = [most, most + 1, most + 2].map(|k| k.to_string());
        assert_eq!(first.warnings, warnings);
        sender.send(Batch::default());
        let next = batches.try_recv().unwrap();
        assert_eq!(
            (BatchesDropped::dropped_before(&next), next.warnings.len()),
            (None, 0)
        );
    }
}
