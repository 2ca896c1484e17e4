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

    /// Takes the number of a frame; returns whether it follows those before.
    pub(crate) fn follows(&mut self, number: u16, faults: &mut LineFaults) -> bool {
        let ahead = self.last.map_or(1, |last| number.wrapping_sub(last));
        // Half the circle ahead is lost frames, the other half is a frame that came before.
        if ahead == 0 || ahead > u16::MAX / 2 {
            faults.repeated += 1;
            return false;
        }
        faults.lost += u64::from(ahead - 1).saturating_sub(self.corrupt_in_gap);
        self.corrupt_in_gap = 0;
        self.last = Some(number);
        true
    }
}
