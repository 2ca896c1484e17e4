//! Exact count of lost, late and repeated records by their numbers.

/// Size of the window of tracked numbers behind the newest one; a number that has not arrived within it is lost.
const WINDOW: u32 = 64;

/// Position of a record by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// Newer than all earlier records.
    Next,
    /// Overtaken by a newer one.
    Late,
    /// Already received, or so late that it was counted as lost.
    Repeated,
}

/// Record numbers received so far. They wrap at 2³².
#[derive(Debug, Default)]
pub(super) struct Sequence {
    newest: Option<u32>,
    /// Bit k: whether number newest − k was received.
    arrivals: u64,
    /// Datagrams without a number since then, each of which may be a missing record.
    unnumbered: u64,
    lost: u64,
}

impl Sequence {
    /// Returns the distance of `number` ahead of the newest, negative if behind; 1 for the very first.
    pub(super) fn ahead(&self, number: u32) -> i64 {
        self.newest.map_or(1, |newest| {
            i64::from(number.wrapping_sub(newest).cast_signed())
        })
    }

    /// Records the number of a record.
    pub(super) fn take(&mut self, number: u32) -> Place {
        if self.newest.is_none() {
            (self.newest, self.arrivals) = (Some(number), u64::MAX);
            return Place::Next;
        }
        match self.ahead(number) {
            ahead @ 1.. => {
                let ahead = ahead.unsigned_abs();
                let missing = if ahead < u64::from(WINDOW) {
                    let leaving = self.arrivals >> (u64::from(WINDOW) - ahead);
                    self.arrivals = self.arrivals << ahead | 1;
                    ahead - u64::from(leaving.count_ones())
                } else {
                    let beyond_window = ahead - u64::from(WINDOW);
                    let gap_count = u64::from(self.arrivals.count_zeros());
                    self.arrivals = 1;
                    gap_count + beyond_window
                };
                self.lose(missing);
                self.newest = Some(number);
                Place::Next
            }
            behind => {
                let bit = 1u64.checked_shl((-behind).try_into().unwrap_or(WINDOW));
                match bit {
                    Some(bit) if self.arrivals & bit == 0 => {
                        self.arrivals |= bit;
                        Place::Late
                    }
                    _ => Place::Repeated,
                }
            }
        }
    }

    /// Records a datagram without a readable number; it accounts for one missing number, if any.
    pub(super) fn take_unnumbered(&mut self) {
        self.unnumbered += 1;
    }

    fn lose(&mut self, missing: u64) {
        let forgiven = missing.min(self.unnumbered);
        self.unnumbered -= forgiven;
        self.lost += missing - forgiven;
        if self.arrivals == u64::MAX {
            // No number is missing, so the datagrams without a number were not records of the stream.
            self.unnumbered = 0;
        }
    }

    /// Restarts with the next number; missing numbers count as lost.
    pub(super) fn restart(&mut self) {
        self.lose(u64::from(self.arrivals.count_zeros()) * u64::from(self.newest.is_some()));
        (self.newest, self.unnumbered) = (None, 0);
    }

    /// Returns the number of lost records.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_numbers_go_on_past_their_wrap() {
        let mut sequence = Sequence::default();
        let numbers = [u32::MAX - 1, u32::MAX, 0, 1, 3, 2, 1];
        let places = numbers.map(|number| sequence.take(number));
        use Place::{Late, Next, Repeated};
        assert_eq!(places, [Next, Next, Next, Next, Next, Late, Repeated]);
        assert_eq!(sequence.lost(), 0);
    }

    #[test]
    fn a_gap_longer_than_the_window_is_counted_whole() {
        for gap in [1, 2, 63, 64, 65, 1000, 100_000] {
            let mut sequence = Sequence::default();
            for number in (0..100).chain(100 + gap..300 + gap) {
                sequence.take(number);
            }
            assert_eq!(sequence.lost(), u64::from(gap), "{gap}");
        }
    }

    #[test]
    fn unnumbered_readings_are_not_counted_as_lost() {
        let mut sequence = Sequence::default();
        for number in 0..1000u32 {
            if number % 10 == 5 {
                sequence.take_unnumbered();
            } else if number % 100 != 7 {
                sequence.take(number);
            }
        }
        for number in 1000..1100 {
            sequence.take(number);
        }
        assert_eq!(sequence.lost(), 10);
        // A foreign datagram does not hide a later loss.
        sequence.take_unnumbered();
        for number in (1100..1300).chain(1301..1400) {
            sequence.take(number);
        }
        assert_eq!(sequence.lost(), 11);
    }

    proptest! {
        /// Fault 40.
        #[test]
        fn lost_late_and_repeated_are_counted_exactly(
            start: u32,
            fates in prop::collection::vec(0u8..12, 1..2000),
        ) {
            // Each number is sent once, not at all, twice, or after its successor.
            let (mut numbers, mut counts, mut delayed) = (Vec::new(), (0, 0, 0), None);
            for (i, fate) in fates.iter().enumerate() {
                let number = start.wrapping_add(i as u32);
                match fate {
                    0 if i > 0 => counts.0 += 1,
                    1 => { numbers.extend([number; 2]); counts.2 += 1; }
                    2 if delayed.is_none() && i > 0 => { delayed = Some(number); continue; }
                    _ => numbers.push(number),
                }
                if let Some(late) = delayed.take_if(|_| *fate != 0) {
                    numbers.push(late);
                    counts.1 += 1;
                }
            }
            // A number still held is sent after its successors.
            let end = start.wrapping_add(fates.len() as u32);
            numbers.push(end);
            if let Some(late) = delayed { numbers.push(late); counts.1 += 1; }
            numbers.extend((1..=WINDOW).map(|k| end.wrapping_add(k)));
            let (mut sequence, mut late, mut repeated) = (Sequence::default(), 0, 0);
            for number in numbers {
                match sequence.take(number) {
                    Place::Next => {}
                    Place::Late => late += 1,
                    Place::Repeated => repeated += 1,
                }
            }
            prop_assert_eq!((sequence.lost(), late, repeated), counts);
        }
    }
}
