//! Stretches of a vector, read in place of the whole where it is long.

use std::ops::Range;

/// Longest vector that is read whole, values.
const LONGEST_WHOLE: u64 = 1 << 21;
/// Length of the stretch in the middle of a longer one, values.
const MIDDLE: u64 = 1 << 20;
/// Length of each other stretch, values.
const SHORT: u64 = 1 << 14;
/// Number of the other stretches.
const SHORT_COUNT: u64 = 48;
/// Number of equal parts in the course of a vector.
pub(crate) const COURSE_PARTS: usize = 1024;

/// Least rate of the means by which rules are tried, Hz, as of an import.
const FINE_HZ: f64 = 1_000.0;

/// Consecutive values of a vector.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    /// Index of the first value in the vector.
    pub start: u64,
    /// The values; NaN where one is lost.
    pub values: Vec<f64>,
}

/// Stretches of a vector.
#[derive(Debug, Clone)]
pub(crate) struct Excerpt {
    /// Length of the vector.
    pub length: u64,
    /// The stretches, in order.
    pub pieces: Vec<Piece>,
}

/// Returns the stretches to be read of a vector, in order and without overlap.
pub(crate) fn plan(length: u64) -> Vec<Range<u64>> {
    if length <= LONGEST_WHOLE {
        return std::iter::once(0..length).collect();
    }
    let middle = (length - MIDDLE) / 2..(length - MIDDLE) / 2 + MIDDLE;
    let mut ranges: Vec<Range<u64>> = (0..SHORT_COUNT)
        .map(|n| (length - SHORT) / (SHORT_COUNT - 1) * n)
        .map(|start| start..start + SHORT)
        .filter(|range| range.end <= middle.start || range.start >= middle.end)
        .collect();
    ranges.push(middle);
    ranges.sort_by_key(|range| range.start);
    ranges
}

/// Extremes and mean of the values read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extremes {
    pub least: f64,
    pub mean: f64,
    pub greatest: f64,
    /// Number of values that are not finite.
    pub lost: u64,
}

/// Means of a stretch, at the rate at which rules are tried.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FineCourse {
    pub interval_s: f64,
    pub values: Vec<f64>,
}

impl Excerpt {
    /// Returns all values, in order.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.pieces
            .iter()
            .flat_map(|piece| piece.values.iter().copied())
    }

    /// Returns the number of values read.
    pub fn count(&self) -> u64 {
        self.pieces
            .iter()
            .map(|piece| piece.values.len() as u64)
            .sum()
    }

    /// Returns the longest stretch.
    pub fn longest(&self) -> &[f64] {
        let longest = self.pieces.iter().max_by_key(|piece| piece.values.len());
        longest.map_or(&[], |piece| &piece.values)
    }

    /// Returns extremes and mean; `None` without a finite value.
    pub fn extremes(&self) -> Option<Extremes> {
        let mut extremes = Extremes {
            least: f64::INFINITY,
            mean: 0.0,
            greatest: f64::NEG_INFINITY,
            lost: 0,
        };
        let mut count = 0.0;
        for value in self.values() {
            if value.is_finite() {
                extremes.least = extremes.least.min(value);
                extremes.greatest = extremes.greatest.max(value);
                count += 1.0;
                // A running mean does not overflow.
                extremes.mean += (value - extremes.mean) / count;
            } else {
                extremes.lost += 1;
            }
        }
        (count > 0.0).then_some(extremes)
    }

    /// Returns the largest change from a value to the next one.
    pub fn leap(&self) -> f64 {
        let changes = self.pieces.iter().flat_map(|piece| {
            piece
                .values
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs())
        });
        changes
            .filter(|change| change.is_finite())
            .fold(0.0, f64::max)
    }

    /// Returns the longest stretch at 1 to 2 kHz, or at its rate if that is lower.
    pub fn fine(&self, rate_hz: f64) -> Option<FineCourse> {
        let group = ((rate_hz / FINE_HZ) as usize).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / group as f64;
        let values: Vec<f64> = self.longest().chunks_exact(group).map(mean).collect();
        (values.len() > 1).then_some(FineCourse {
            interval_s: group as f64 / rate_hz,
            values,
        })
    }

    /// Returns the means of equal parts of the vector's length; NaN where nothing was read.
    pub fn course(&self) -> Vec<f64> {
        let parts = COURSE_PARTS.min(self.length as usize);
        let (mut sums, mut counts) = (vec![0.0; parts], vec![0.0; parts]);
        for piece in &self.pieces {
            for (i, value) in piece
                .values
                .iter()
                .enumerate()
                .filter(|(_, value)| value.is_finite())
            {
                let part = (u128::from(piece.start + i as u64) * parts as u128
                    / u128::from(self.length)) as usize;
                sums[part] += value;
                counts[part] += 1.0;
            }
        }
        sums.iter()
            .zip(counts)
            .map(|(sum, count)| sum / count)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_vector_is_read_in_part_and_in_order() {
        for length in [0, 1, LONGEST_WHOLE, LONGEST_WHOLE + 1, 500_000_000] {
            let ranges = plan(length);
            assert!(
                ranges.windows(2).all(|pair| pair[0].end <= pair[1].start),
                "{length}"
            );
            assert!(ranges.iter().all(|range| range.end <= length), "{length}");
            assert_eq!(ranges.first().map(|range| range.start), Some(0));
            let count: u64 = ranges.iter().map(|range| range.end - range.start).sum();
            assert!(count <= LONGEST_WHOLE, "{length}");
        }
        assert!(plan(500_000_000).last().unwrap().end > 499_000_000);
    }

    #[test]
    fn the_course_is_that_of_the_whole_vector() {
        let values: Vec<f64> = (0..10_240).map(f64::from).collect();
        let pieces = vec![
            Piece {
                start: 0,
                values: values[..1_000].to_vec(),
            },
            Piece {
                start: 9_240,
                values: values[9_240..].to_vec(),
            },
        ];
        let excerpt = Excerpt {
            length: 10_240,
            pieces,
        };
        let course = excerpt.course();
        assert_eq!((course[0], course[1_023]), (4.5, 10_234.5));
        assert!(course[500].is_nan());
        let extremes = excerpt.extremes().unwrap();
        assert_eq!(
            (extremes.least, extremes.greatest, extremes.lost),
            (0.0, 10_239.0, 0)
        );
        assert!((extremes.mean - 5_119.5).abs() < 1e-9);
    }
}
