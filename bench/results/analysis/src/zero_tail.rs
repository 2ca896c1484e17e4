//! Forces that end in zeros: a file that was filled up, or a sensor that stopped.

use recording::ForceRow;

use crate::flaw::Flaw;

/// Fewest rows of zeros at the end, and least duration, s, that no sensor's noise makes.
const FEWEST: usize = 50;
const SHORTEST_S: f64 = 0.1;

/// Rows at the end with both forces exactly 0, so far.
#[derive(Debug, Default)]
pub(super) struct ZeroTail {
    rows: usize,
    from_s: f64,
    to_s: f64,
    has_forces: bool,
}

impl ZeroTail {
    /// Takes the next row.
    pub(super) fn take(&mut self, row: &ForceRow) {
        if row.normal_n != 0.0 || row.lateral_n != 0.0 {
            (self.rows, self.has_forces) = (0, true);
            return;
        }
        if self.rows == 0 {
            self.from_s = row.time_s;
        }
        self.rows += 1;
        self.to_s = row.time_s;
    }

    /// Returns the flaw of a file that ends in zeros; one of zeros alone has constant columns.
    pub(super) fn flaw(&self) -> Option<Flaw> {
        let is_tail =
            self.has_forces && self.rows >= FEWEST && self.to_s - self.from_s >= SHORTEST_S;
        is_tail.then_some(Flaw::ZeroTail {
            rows: self.rows,
            from_s: self.from_s,
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
    fn zeros_before_the_end_or_alone_or_few_are_none() {
        assert_eq!(tail(|row| if row < 2500 { 0.0 } else { 0.6 }), None);
        assert_eq!(tail(|_| 0.0), None);
        assert_eq!(tail(|row| if row < 2960 { 0.6 } else { 0.0 }), None);
    }
}
