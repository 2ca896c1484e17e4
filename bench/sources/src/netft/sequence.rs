//! Account of numbered records: lost, late, repeated, each counted exactly.

/// Numbers behind the newest for which it is known whether they came; one that has not come by then is lost.
const WINDOW: u32 = 64;

/// What a record is by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// Newer than all before.
    Next,
    /// Overtaken by a newer one.
    Late,
    /// It has been here before, or is so late that it was counted as lost.
    Repeated,
}

/// The numbers that have come. They wrap at 2³².
#[derive(Debug, Default)]
pub(super) struct Sequence {
    newest: Option<u32>,
    /// Bit k: whether number newest − k has come.
    came: u64,
    /// Datagrams without a number since, each of which may stand for a number that is missing.
    unnumbered: u64,
    lost: u64,
}

impl Sequence {
    /// Returns how far ahead of the newest `number` is, backwards if negative; 1 for the very first.
    pub(super) fn ahead(&self, number: u32) -> i64 {
        self.newest.map_or(1, |newest| {
            i64::from(number.wrapping_sub(newest).cast_signed())
        })
    }

    /// Takes the number of a record.
    pub(super) fn take(&mut self, number: u32) -> Place {
        if self.newest.is_none() {
            (self.newest, self.came) = (Some(number), u64::MAX);
            return Place::Next;
        }
        match self.ahead(number) {
            ahead @ 1.. => {
                let ahead = ahead.unsigned_abs();
                let missing = if ahead < u64::from(WINDOW) {
                    let leaving = self.came >> (u64::from(WINDOW) - ahead);
                    self.came = self.came << ahead | 1;
                    ahead - u64::from(leaving.count_ones())
                } else {
                    let never = ahead - u64::from(WINDOW);
                    let in_window = u64::from(self.came.count_zeros());
                    self.came = 1;
                    in_window + never
                };
                self.lose(missing);
                self.newest = Some(number);
                Place::Next
            }
            behind => {
                let bit = 1u64.checked_shl((-behind).try_into().unwrap_or(WINDOW));
                match bit {
                    Some(bit) if self.came & bit == 0 => {
                        self.came |= bit;
                        Place::Late
                    }
                    _ => Place::Repeated,
                }
            }
        }
    }

    /// Takes a datagram whose number cannot be read: if one is missing, it was this.
    pub(super) fn take_unnumbered(&mut self) {
        self.unnumbered += 1;
    }

    fn lose(&mut self, missing: u64) {
        let forgiven = missing.min(self.unnumbered);
        self.unnumbered -= forgiven;
        self.lost += missing - forgiven;
        if self.came == u64::MAX {
            // Nothing is missing: what had no number was none of these records.
            self.unnumbered = 0;
        }
    }

    /// Begins anew with the next number; what is missing until now is lost.
    pub(super) fn restart(&mut self) {
        self.lose(u64::from(self.came.count_zeros()) * u64::from(self.newest.is_some()));
        (self.newest, self.unnumbered) = (None, 0);
    }

    /// Returns how many records never came.
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
    fn what_had_no_number_is_not_lost_besides() {
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
        // And a stranger among them hides nothing that is lost later.
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
            // Each number is sent once, or not at all, or twice, or behind the one after it.
            let (mut sent, mut counts, mut held) = (Vec::new(), (0, 0, 0), None);
            for (i, fate) in fates.iter().enumerate() {
                let number = start.wrapping_add(i as u32);
                match fate {
                    0 if i > 0 => counts.0 += 1,
                    1 => { sent.extend([number; 2]); counts.2 += 1; }
                    2 if held.is_none() && i > 0 => { held = Some(number); continue; }
                    _ => sent.push(number),
                }
                if let Some(late) = held.take_if(|_| *fate != 0) {
                    sent.push(late);
                    counts.1 += 1;
                }
            }
            // Still held: behind those that follow.
            let end = start.wrapping_add(fates.len() as u32);
            sent.push(end);
            if let Some(late) = held { sent.push(late); counts.1 += 1; }
            sent.extend((1..=WINDOW).map(|k| end.wrapping_add(k)));
            let (mut sequence, mut late, mut repeated) = (Sequence::default(), 0, 0);
            for number in sent {
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
