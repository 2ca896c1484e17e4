//! Delay from a command to its read-back, and the agreement of the latest readings with it.

/// Outcome of comparing a reading with a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// Whether the reading agrees with the command.
    pub(crate) fits: bool,
    /// Whether half the gain would not have agreed.
    pub(crate) tells: bool,
}

/// A delay that is still possible.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Delay {
    /// Rendered frames less samples: sample s shows the command at frame s + lead.
    pub(crate) lead: i64,
    total: Votes,
    telling: Votes,
}

/// The latest votes, up to 64.
#[derive(Debug, Clone, Copy, Default)]
struct Votes {
    /// One bit per vote, the latest in the lowest.
    bits: u64,
    count: u32,
}

/// Smallest number of telling readings that is judged.
const FEWEST_TELLING: u32 = 4;

impl Delay {
    pub(crate) fn new(lead: i64) -> Self {
        Self {
            lead,
            total: Votes::default(),
            telling: Votes::default(),
        }
    }

    pub(crate) fn vote(&mut self, comparison: Comparison) {
        self.total.push(comparison.fits);
        if comparison.tells {
            self.telling.push(comparison.fits);
        }
    }

    /// Returns whether at least half of the latest `readings` fit, and at least half of as many telling ones: otherwise
    /// half the gain would pass under a drive that is low most of the time.
    pub(crate) fn explains(&self, readings: u32) -> bool {
        self.total.is_majority(readings)
            && (self.telling.count < FEWEST_TELLING || self.telling.is_majority(readings))
    }
}

impl Votes {
    fn push(&mut self, vote: bool) {
        self.bits = self.bits << 1 | u64::from(vote);
        self.count = (self.count + 1).min(u64::BITS);
    }

    /// Returns whether at least half of the latest `limit` votes are in favour.
    fn is_majority(&self, limit: u32) -> bool {
        let count = self.count.min(limit);
        let latest = self.bits & u64::MAX.checked_shr(u64::BITS - count).unwrap_or(0);
        2 * latest.count_ones() >= count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn votes_of(votes: &[bool]) -> Votes {
        let mut count = Votes::default();
        votes.iter().for_each(|&vote| count.push(vote));
        count
    }

    #[test]
    fn half_of_the_latest_votes_are_enough() {
        assert!(votes_of(&[]).is_majority(64));
        assert!(votes_of(&[false, true]).is_majority(2));
        assert!(!votes_of(&[true, true, false, false, true]).is_majority(3));
        assert!(votes_of(&[true, true, false, false, true]).is_majority(5));
        assert!(votes_of(&[true; 100]).is_majority(64));
        assert!(!votes_of(&[false; 100]).is_majority(64));
        assert!(votes_of(&[false; 100]).is_majority(0));
    }

    #[test]
    fn a_delay_fails_by_its_telling_readings_alone() {
        let mut delay = Delay::new(0);
        for index in 0..64 {
            let tells = index % 10 == 0;
            delay.vote(Comparison {
                fits: !tells,
                tells,
            });
        }
        assert!(!delay.explains(20));
    }
}
