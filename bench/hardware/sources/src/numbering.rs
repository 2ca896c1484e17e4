//! Count of lost, repeated and corrupt frames by their numbers, on a line that preserves order; each is counted once.

use crate::force_source::LineFaults;

/// Frame numbers received so far. They wrap at 2¹⁶.
#[derive(Debug, Default)]
pub(crate) struct Numbering {
    last: Option<u16>,
    /// Corrupt frames since the last valid one; they also leave gaps in the sequence, but count once.
    corrupt_in_gap: u64,
}

impl Numbering {
    /// Records a corrupt frame.
    pub(crate) fn corrupt(&mut self, faults: &mut LineFaults) {
        faults.corrupt += 1;
        self.corrupt_in_gap += 1;
    }

    /// Restarts with the next number after a restart of the device.
    pub(crate) fn restart(&mut self) {
        *self = Self::default();
    }

    /// Records the number of a frame; `later` tells whether its device time is later than all earlier ones. Returns whether the
    /// frame follows them.
    pub(crate) fn follows(&mut self, number: u16, later: bool, faults: &mut LineFaults) -> bool {
        let ahead = self.last.map_or(1, |last| number.wrapping_sub(last));
        // By the number alone, a frame after a silence of half the range would seem to be an earlier one.
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
