//! Forces that end in equal rows: a file that was filled up, or a sensor that stopped.

use recording::ForceRow;

/// Fewest rows of zeros at the end, and least duration, s, that no sensor's noise makes.
const FEWEST: usize = 50;
const SHORTEST_S: f64 = 0.1;
/// Least duration of equal rows of other values, s: friction under a finger changes within a period of the modulation.
const SHORTEST_HELD_S: f64 = 0.3;

/// Equal rows at the end of a file, so far.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EqualTail {
    /// Number of rows.
    pub rows: usize,
    /// Time of the first one, s.
    pub from_s: f64,
    /// Normal and lateral force, N.
    pub forces_n: [f64; 2],
    to_s: f64,
    /// Forces of the first rows, if enough are equal.
    begin_n: Option<[f64; 2]>,
    has_others: bool,
}

impl EqualTail {
    /// Takes the next row.
    pub fn take(&mut self, row: &ForceRow) {
        let forces_n = [row.normal_n, row.lateral_n];
        if self.rows == 0 || forces_n != self.forces_n {
            if !self.has_others && self.is_long() {
                self.begin_n = Some(self.forces_n);
            }
            self.has_others |= self.rows > 0;
            (self.rows, self.from_s, self.forces_n) = (0, row.time_s, forces_n);
        }
        self.rows += 1;
        self.to_s = row.time_s;
    }

    /// Returns whether the rows are zeros.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.forces_n == [0.0; 2]
    }

    fn is_long(&self) -> bool {
        let shortest_s = if self.is_zero() {
            SHORTEST_S
        } else {
            SHORTEST_HELD_S
        };
        self.rows >= FEWEST && self.to_s - self.from_s >= shortest_s
    }

    /// Returns the rows if they are too many for a sensor's noise or a finger; those of a file of equal rows alone are constant columns. A
    /// sensor without noise, as of a simulation, begins as it ends: with no finger.
    #[must_use]
    pub fn implausible(self) -> Option<Self> {
        let is_as_begun = self.begin_n == Some(self.forces_n);
        (self.has_others && !is_as_begun && self.is_long()).then_some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tail(force_n: impl Fn(u32) -> f64) -> Option<(usize, f64, [f64; 2])> {
        let mut tail = EqualTail::default();
        for row in 0..3000 {
            tail.take(&ForceRow {
                time_s: f64::from(row) * 1e-3,
                normal_n: force_n(row),
                lateral_n: 0.5 * force_n(row),
            });
        }
        let tail = tail.implausible()?;
        Some((tail.rows, tail.from_s, tail.forces_n))
    }

    #[test]
    fn zeros_and_repeated_readings_at_the_end_are_found() {
        let zeros = tail(|row| if row < 2500 { 0.6 } else { 0.0 });
        assert_eq!(zeros, Some((500, 2.5, [0.0; 2])));
        let repeated = tail(|row| f64::from(row.min(2500)));
        assert_eq!(repeated, Some((500, 2.5, [2500.0, 1250.0])));
    }

    #[test]
    fn equal_rows_before_the_end_or_alone_or_few_are_none() {
        assert_eq!(
            tail(|row| if row < 2500 { 0.0 } else { f64::from(row) }),
            None
        );
        let noiseless = |row: u32| if (500..2500).contains(&row) { 0.6 } else { 0.0 };
        assert_eq!(tail(noiseless), None);
        assert_eq!(tail(|_| 0.0), None);
        assert_eq!(tail(|_| 0.6), None);
        assert_eq!(tail(|row| if row < 2960 { 0.6 } else { 0.0 }), None);
        assert_eq!(tail(|row| f64::from(row.min(2800))), None);
    }
}
