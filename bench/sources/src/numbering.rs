//! Account of numbered frames on a line that keeps their order: lost, repeated, corrupt, each counted once.

use crate::force_source::LineFaults;

/// The numbers that have come. They wrap at 2¹⁶.
#[derive(Debug, Default)]
pub(crate) struct Numbering {
    last: Option<u16>,
    /// Corrupt frames since the last good one: they are missing from the sequence too, and count once.
    corrupt_in_gap: u64,
}

impl Numbering {
    /// Takes a frame that cannot be read.
    pub(crate) fn corrupt(&mut self, faults: &mut LineFaults) {
        faults.corrupt += 1;
        self.corrupt_in_gap += 1;
    }

    /// Begins anew with the next number: the device has.
    pub(crate) fn restart(&mut self) {
        *self = Self::default();
    }

    /// Takes the number of a frame whose device time is `later` than that of those before, or is not; returns whether it
    /// follows them.
    pub(crate) fn follows(&mut self, number: u16, later: bool, faults: &mut LineFaults) -> bool {
        let ahead = self.last.map_or(1, |last| number.wrapping_sub(last));
        // By the number alone, a frame after a silence of half the circle would have come before.
        if ahead == 0 || !later {
            faults.repeated += 1;
            return false;
        }
        faults.lost += u64::from(ahead - 1).saturating_sub(self.corrupt_in_gap);
        self.corrupt_in_gap = 0;
        self.last = Some(number);
        true
    }
}
