//! The bench's clock, estimated from the session's beats.

use std::collections::VecDeque;

use crate::message::Beat;

/// Window over which beats count, s: long enough to include one without delay, short enough for clock drift not to matter.
const WINDOW_S: f64 = 10.0;
/// Change of the clocks' offset above which the bench's clock is taken to have restarted, s.
const LEAP_S: f64 = 0.5;
/// Longest silence during which the clock keeps running, s.
pub const LONGEST_SILENCE_S: f64 = 1.0;

/// The bench's clock, estimated from beats that may arrive late by any time, but never early.
///
/// ```
/// use participant_window::bench_clock::BenchClock;
/// use participant_window::message::Beat;
///
/// let mut clock = BenchClock::default();
/// for (audio_s, shared_s) in [(1.0, 101.020), (1.1, 101.101), (1.2, 101.230)] {
///     clock.take(&Beat { audio_s, shared_s, finger_m: None });
/// }
/// assert!((clock.audio_s(101.301).unwrap() - 1.3).abs() < 1e-9);
/// assert_eq!(clock.audio_s(103.0), None, "silent for too long");
/// ```
#[derive(Debug, Default)]
pub struct BenchClock {
    /// Shared time minus audio time of beats, each smaller than all after it, s, and the shared time of the beat.
    offsets: VecDeque<(f64, f64)>,
    latest_s: Option<f64>,
}

impl BenchClock {
    /// Takes a beat; ignores one that is not finite or is older than the last.
    pub fn take(&mut self, beat: &Beat) {
        let offset_s = beat.shared_s - beat.audio_s;
        let newer = self
            .latest_s
            .is_none_or(|latest_s| beat.shared_s >= latest_s);
        if !offset_s.is_finite() || !newer {
            return;
        }
        if self
            .offsets
            .front()
            .is_some_and(|(least_s, _)| (offset_s - least_s).abs() > LEAP_S)
        {
            self.offsets.clear();
        }
        while self
            .offsets
            .back()
            .is_some_and(|(last_s, _)| *last_s >= offset_s)
        {
            self.offsets.pop_back();
        }
        self.offsets.push_back((offset_s, beat.shared_s));
        while self
            .offsets
            .front()
            .is_some_and(|(_, at_s)| *at_s < beat.shared_s - WINDOW_S)
        {
            self.offsets.pop_front();
        }
        self.latest_s = Some(beat.shared_s);
    }

    /// Returns the time on the bench's clock, s; `None` before the first beat and after a silence of [`LONGEST_SILENCE_S`].
    #[must_use]
    pub fn audio_s(&self, shared_s: f64) -> Option<f64> {
        let (offset_s, _) = self.offsets.front()?;
        let silent_s = shared_s - self.latest_s?;
        (silent_s <= LONGEST_SILENCE_S).then_some(shared_s - offset_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn beat(audio_s: f64, shared_s: f64) -> Beat {
        Beat {
            audio_s,
            shared_s,
            finger_m: None,
        }
    }

    #[test]
    fn a_clock_that_drifts_is_followed() {
        let mut clock = BenchClock::default();
        // 200 ppm, the worst of cheap cards, for an hour.
        for i in 0..36_000 {
            let shared_s = 5.0 + 0.1 * f64::from(i);
            clock.take(&beat(1.0002 * (shared_s - 5.0), shared_s));
        }
        let shared_s = 5.0 + 3600.0;
        let error_s = clock.audio_s(shared_s - 0.1).unwrap() - 1.0002 * (shared_s - 5.1);
        assert!(error_s.abs() < 3e-3, "{error_s}");
    }

    #[test]
    fn a_restarted_bench_clock_is_followed_at_once() {
        let mut clock = BenchClock::default();
        clock.take(&beat(500.0, 1000.0));
        clock.take(&beat(0.0, 1000.1));
        assert!((clock.audio_s(1000.2).unwrap() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn a_beat_without_a_number_is_left_out() {
        let mut clock = BenchClock::default();
        for (audio_s, shared_s) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0)] {
            clock.take(&beat(audio_s, shared_s));
        }
        assert_eq!(clock.audio_s(1.0), None);
    }

    proptest! {
        /// Beats that are late by up to 80 ms give the time as accurately as the promptest of them.
        #[test]
        fn lateness_does_not_move_the_clock(late in prop::collection::vec(0.0..0.08f64, 20..400)) {
            let mut clock = BenchClock::default();
            let mut shared_s = 0.0f64;
            for (i, late_s) in late.iter().enumerate() {
                shared_s = shared_s.max(7.0 + 0.02 * i as f64 + late_s);
                clock.take(&beat(0.02 * i as f64, shared_s));
            }
            let least_s = late.iter().copied().fold(f64::INFINITY, f64::min);
            let offset_s = shared_s - clock.audio_s(shared_s).unwrap();
            prop_assert!(offset_s >= 7.0 + least_s - 1e-9);
            prop_assert!(offset_s <= 7.0 + 0.08 + 1e-9);
        }
    }
}
