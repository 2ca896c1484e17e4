//! Queue of readings from the slow inputs to the acquisition: neither side waits for the other, and the queue stays
//! bounded while the acquisition is held up.

use crossbeam_channel::{Receiver, Sender, TrySendError};
use sources::{LineFaults, Moment};

use crate::field_reading::FieldReading;

/// Most readings that wait: seconds of the fastest sensor.
const MOST_WAITING: usize = 1 << 15;

/// Sending end of the queue, for the slow inputs.
pub struct ReadingSender {
    to: Sender<FieldReading>,
    /// Readings dropped and not yet reported, the start of their time, and encoder states missed with them.
    dropped: u64,
    since: Option<Moment>,
    missed: u64,
}

/// Returns both ends of a queue of readings.
#[must_use]
pub fn reading_queue() -> (ReadingSender, Receiver<FieldReading>) {
    let (to, readings) = crossbeam_channel::bounded(MOST_WAITING);
    let sender = ReadingSender {
        to,
        dropped: 0,
        since: None,
        missed: 0,
    };
    (sender, readings)
}

impl ReadingSender {
    /// Sends a reading, after a report of the readings that found no room; counts it if it finds no room.
    pub(crate) fn send(&mut self, mut reading: FieldReading) {
        if let Some(since) = self.since {
            let faults = LineFaults {
                lost: self.dropped,
                ..LineFaults::default()
            };
            let moment = reading.moment();
            let summary = FieldReading::ForceFaults {
                since,
                moment,
                faults,
            };
            if self.to.try_send(summary).is_ok() {
                (self.dropped, self.since) = (0, None);
            }
        }
        if let FieldReading::Position { missed, .. } = &mut reading {
            *missed += self.missed;
        }
        match self.to.try_send(reading) {
            Err(TrySendError::Full(reading)) => self.drop(&reading),
            // The acquisition ends only when the bench stops.
            Ok(()) | Err(TrySendError::Disconnected(_)) => {
                if matches!(reading, FieldReading::Position { .. }) {
                    self.missed = 0;
                }
            }
        }
    }

    fn drop(&mut self, reading: &FieldReading) {
        self.since.get_or_insert(reading.since());
        match reading {
            FieldReading::Position { missed, .. } => self.missed = missed + 1,
            FieldReading::ForceFaults { faults, .. } => self.dropped += faults.lost.max(1),
            _ => self.dropped += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn position(host_s: f64) -> FieldReading {
        FieldReading::Position {
            host_s,
            position_m: 0.0,
            missed: 0,
            jumped: false,
        }
    }

    /// Fault 49.
    #[test]
    fn readings_that_nobody_takes_are_told_of_by_those_that_follow() {
        let (mut sender, readings) = reading_queue();
        let loss = FieldReading::ForceFaults {
            since: Moment::Host(5.0),
            moment: Moment::Host(5.5),
            faults: LineFaults {
                lost: 2,
                ..LineFaults::default()
            },
        };
        (0..MOST_WAITING).for_each(|_| sender.send(position(1.0)));
        sender.send(loss);
        sender.send(position(6.0));
        sender.send(loss);
        assert_eq!(readings.try_iter().count(), MOST_WAITING);
        sender.send(position(9.0));
        let expected = FieldReading::ForceFaults {
            since: Moment::Host(5.0),
            moment: Moment::Host(9.0),
            faults: LineFaults {
                lost: 4,
                ..LineFaults::default()
            },
        };
        assert_eq!(readings.try_recv(), Ok(expected));
        let Ok(FieldReading::Position { missed: 1, .. }) = readings.try_recv() else {
            panic!("no position, or not the number of those before");
        };
        sender.send(position(10.0));
        assert_eq!(readings.try_iter().collect::<Vec<_>>(), [position(10.0)]);
    }
}
