//! Forces that end in equal rows: a file that was filled up, or a sensor that stopped.

use recording::ForceRow;

use crate::flaw::Flaw;

/// Fewest rows of zeros at the end, and least duration, s, that no sensor's noise makes.
const FEWEST: usize = 50;
const SHORTEST_S: f64 = 0.1;
/// Least duration of equal rows of other values, s: friction under a finger changes within a period of the modulation.
const SHORTEST_HELD_S: f64 = 0.3;

/// Equal rows at the end, so far.
#[derive(Debug, Default)]
pub(super) struct ZeroTail {
    rows: usize,
    from_s: f64,
    to_s: f64,
    forces_n: [f64; 2],
    has_others: bool,
}

impl ZeroTail {
    /// Takes the next row.
    pub(super) fn take(&mut self, row: &ForceRow) {
        let forces_n = [row.normal_n, row.lateral_n];
        if self.rows == 0 || forces_n != self.forces_n {
            self.has_others |= self.rows > 0;
            (self.rows, self.from_s, self.forces_n) = (0, row.time_s, forces_n);
        }
        self.rows += 1;
        self.to_s = row.time_s;
    }

    /// Returns the flaw of a file that ends in equal rows; one of equal rows alone has constant columns.
    pub(super) fn flaw(&self) -> Option<Flaw> {
        let Self {
            rows,
            from_s,
            forces_n: [normal_n, lateral_n],
            ..
        } = *self;
        let length_s = self.to_s - from_s;
        if !self.has_others || rows < FEWEST || length_s < SHORTEST_S {
            return None;
        }
        if [normal_n, lateral_n] == [0.0; 2] {
            return Some(Flaw::ZeroTail { rows, from_s });
        }
        (length_s >= SHORTEST_HELD_S).then_some(Flaw::HeldTail {
            rows,
            from_s,
            normal_n,
            lateral_n,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tail(force_n: impl Fn(u32) -> f64) -> Option<String> {
        let mut tail = ZeroTail::default();
        for row in 0..3000 {
            tail.take(&ForceRow {
                time_s: f64::from(row) * 1e-3,
                normal_n: force_n(row),
                lateral_n: 0.5 * force_n(row),
            });
        }
        tail.flaw().map(|flaw| flaw.to_string())
    }

    #[test]
    fn zeros_at_the_end_are_named_with_their_time() {
        let found = tail(|row| if row < 2500 { 0.6 } else { 0.0 }).unwrap();
        assert!(
            found.contains("last 500 rows") && found.contains("from 2.500 s"),
            "{found}"
        );
    }

    #[test]
    fn a_last_reading_that_is_repeated_is_named_with_its_value() {
        let found = tail(|row| f64::from(row.min(2500))).unwrap();
        assert!(
            found.contains("stay at 2500 and 1250 N in the last 500 rows, from 2.500 s"),
            "{found}"
        );
        assert_eq!(tail(|row| f64::from(row.min(2800))), None);
        assert_eq!(tail(|_| 0.6), None);
    }

    #[test]
    fn zeros_before_the_end_or_alone_or_few_are_none() {
        assert_eq!(
            tail(|row| if row < 2500 { 0.0 } else { f64::from(row) }),
            None
        );
        assert_eq!(tail(|_| 0.0), None);
        assert_eq!(tail(|row| if row < 2960 { 0.6 } else { 0.0 }), None);
    }
}
