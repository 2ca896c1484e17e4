//! Position along the plate from the counts of an encoder, for any source of the counts.

use sources::position::{Counted, PositionSource};
use sources::{SourceGone, SourceHealth};

/// Speed that no finger reaches, m/s: a plate of a tenth of a metre crossed in a tenth of a second. An assumption, some
/// ten times the speed of the published explorations.
pub const IMPOSSIBLE_M_PER_S: f64 = 1.0;

/// Largest sum of removed jumps at which positions are trusted, m: a thirtieth of the published crop of 60 mm.
pub const BELIEVED_M: f64 = 2e-3;

/// Removes jumps from positions. A finger cannot jump: either the count slipped or the carriage was thrown, which look
/// alike. The sum of removed jumps is the possible error of the position; beyond [`BELIEVED_M`] the position is unknown
/// (`docs/decisions/0013-after-a-jump-of-the-encoder.md`).
#[derive(Debug, Default)]
pub struct JumpWatch {
    last: Option<(f64, f64)>,
    taken_out_m: f64,
}

/// A counted position after the check for jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watched {
    /// Position without jumps, m; NaN while it is unknown.
    pub position_m: f64,
    /// Whether the position cannot have been reached since the last one.
    pub jumped: bool,
}

impl JumpWatch {
    /// Takes the position as unknown from now on: the counter has restarted.
    pub fn lose(&mut self) {
        self.taken_out_m = f64::INFINITY;
    }

    /// Checks a position counted at `source_s`, s by a clock that advances.
    pub fn take(&mut self, source_s: f64, counted_m: f64) -> Watched {
        let step = self
            .last
            .replace((source_s, counted_m))
            .map(|(last_s, last_m)| (source_s - last_s, counted_m - last_m));
        let jump_m = step
            .filter(|(interval_s, step_m)| step_m.abs() > IMPOSSIBLE_M_PER_S * interval_s)
            .map(|(_, step_m)| step_m);
        self.taken_out_m += jump_m.unwrap_or(0.0);
        let is_plausible = self.taken_out_m.abs() <= BELIEVED_M;
        Watched {
            position_m: if is_plausible {
                counted_m - self.taken_out_m
            } else {
                f64::NAN
            },
            jumped: jump_m.is_some(),
        }
    }
}

/// Position, and the encoder states missed before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    /// Host time, s.
    pub(crate) host_s: f64,
    /// Position without jumps.
    pub(crate) watched: Watched,
    /// Number of encoder states missed since the last position.
    pub(crate) missed: u64,
}

/// An encoder along the plate.
pub struct PositionEncoder {
    source: Box<dyn PositionSource>,
    metres_per_count: f64,
    origin_m: f64,
    watch: JumpWatch,
    missed_before: u64,
}

impl PositionEncoder {
    /// Makes an encoder that counts from `origin_m`, the carriage's present position.
    pub fn new(source: Box<dyn PositionSource>, metres_per_count: f64, origin_m: f64) -> Self {
        Self {
            source,
            metres_per_count,
            origin_m,
            watch: JumpWatch::default(),
            missed_before: 0,
        }
    }

    /// Polls the source, as [`PositionSource::poll`].
    pub(crate) fn poll(
        &mut self,
        now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Placed),
    ) -> Result<(), SourceGone> {
        self.source.poll(now_ns, now_s, &mut |counted: Counted| {
            let counted_m = self.origin_m + self.metres_per_count * counted.count as f64;
            if counted.lost {
                self.watch.lose();
            }
            take(Placed {
                host_s: counted.host_s,
                watched: self.watch.take(counted.source_s, counted_m),
                missed: counted.missed - std::mem::replace(&mut self.missed_before, counted.missed),
            });
        })
    }

    /// Returns the health of the source, if it has its own clock.
    pub(crate) fn health(&self) -> SourceHealth {
        self.source.health()
    }

    /// Returns the number of encoder states missed so far.
    pub(crate) fn missed(&self) -> u64 {
        self.missed_before
    }
}

#[cfg(test)]
mod tests {
    use super::JumpWatch;

    /// Returns the watched positions of counted ones, a millisecond apart, and the indices of the jumps.
    fn positions_and_jumps(counted_m: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let mut watch = JumpWatch::default();
        let times_s = (0..).map(|ms| f64::from(ms) * 1e-3);
        let samples: Vec<_> = times_s
            .zip(counted_m)
            .map(|(host_s, &counted_m)| watch.take(host_s, counted_m))
            .collect();
        let jumps = (0..samples.len()).filter(|&i| samples[i].jumped).collect();
        (
            samples.iter().map(|sample| sample.position_m).collect(),
            jumps,
        )
    }

    fn agree(positions_m: &[f64], expected_m: &[f64]) {
        assert_eq!(positions_m.len(), expected_m.len());
        for (position, expected) in positions_m.iter().zip(expected_m) {
            let both_unknown = position.is_nan() && expected.is_nan();
            assert!(
                both_unknown || (position - expected).abs() < 1e-12,
                "{positions_m:?}"
            );
        }
    }

    /// Fault 48.
    #[test]
    fn a_counter_that_has_begun_anew_leaves_the_position_unknown() {
        let mut watch = JumpWatch::default();
        assert_eq!(watch.take(0.0, 0.05).position_m, 0.05);
        watch.lose();
        for (ms, counted_m) in [(1, 0.05), (2, 0.051), (3, 0.001), (4, 0.05)] {
            assert!(
                watch
                    .take(1e-3 * f64::from(ms), counted_m)
                    .position_m
                    .is_nan()
            );
        }
    }

    /// Fault 20.
    #[test]
    fn a_jump_is_what_no_finger_does_and_is_taken_out() {
        let (positions_m, jumps) = positions_and_jumps(&[0.0500, 0.0509, 0.0520, 0.0521, 0.0522]);
        assert_eq!(jumps, [2]);
        agree(&positions_m, &[0.0500, 0.0509, 0.0509, 0.0510, 0.0511]);
        // A jump and its reversal cancel.
        let (positions_m, jumps) = positions_and_jumps(&[0.05, 0.0, 0.05, 0.0501]);
        assert_eq!(jumps, [1, 2]);
        agree(&positions_m, &[0.05, f64::NAN, 0.05, 0.0501]);
    }

    #[test]
    fn after_a_jump_that_matters_the_position_is_not_known() {
        let jumps = [0.05, 0.0515, 0.0516, 0.0531, 0.0532, 0.0517, 0.0518];
        let (positions_m, jumps) = positions_and_jumps(&jumps);
        assert_eq!(jumps, [1, 3, 5]);
        let unknown = f64::NAN;
        // 1.5 mm, then 3 mm, then 1.5 mm again.
        agree(
            &positions_m,
            &[0.05, 0.05, 0.0501, unknown, unknown, 0.0502, 0.0503],
        );
    }

    #[test]
    fn a_reader_that_comes_late_sees_no_jump() {
        let mut watch = JumpWatch::default();
        watch.take(1.0, 0.02);
        let late = watch.take(1.1, 0.09);
        assert_eq!((late.jumped, late.position_m), (false, 0.09));
    }
}
