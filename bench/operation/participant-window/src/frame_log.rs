//! Presentation times of an exploration's frames, and the slider's deviation from its ideal position.

use crate::message::FrameReport;
use crate::motion::Motion;

/// Maximum number of frames kept from an exploration: ten minutes at 240 Hz.
const MOST_FRAMES: usize = 144_000;

/// The frames of one exploration.
#[derive(Debug)]
pub struct FrameLog {
    motion: Motion,
    refresh_s: f64,
    /// Presentation time of each frame on the bench's clock, s, and its slider's position, m.
    frames: Vec<(f64, f64)>,
}

impl FrameLog {
    /// Returns an empty log of an exploration, on a monitor that refreshes every `refresh_s`.
    #[must_use]
    pub fn new(motion: Motion, refresh_s: f64) -> Self {
        Self {
            motion,
            refresh_s,
            frames: Vec::new(),
        }
    }

    /// Returns the slider's motion in these frames.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Adds a frame presented at `presented_s` on the bench's clock, with the slider drawn at `drawn_m`.
    pub fn take(&mut self, presented_s: f64, drawn_m: f64) {
        if self.frames.len() < MOST_FRAMES && presented_s.is_finite() {
            self.frames.push((presented_s, drawn_m));
        }
    }

    /// Returns the report on the frames; `None` for fewer than three.
    #[must_use]
    pub fn report(&self) -> Option<FrameReport> {
        let start_s = self.motion.starts_s?;
        if self.frames.len() < 3 {
            return None;
        }
        let mut intervals_s = Vec::new();
        let mut errors_m = Vec::new();
        for pair in self.frames.windows(2) {
            let [(from_s, drawn_m), (to_s, _)] = [pair[0], pair[1]];
            intervals_s.push(to_s - from_s);
            // The ideal position is monotone in time, so the deviation is largest at an end.
            let error_m = |at_s: f64| (drawn_m - self.motion.at_m(at_s)).abs();
            errors_m.push(error_m(from_s).max(error_m(to_s)));
        }
        let dropped: f64 = intervals_s
            .iter()
            .map(|interval_s| (interval_s / self.refresh_s).round() - 1.0)
            .filter(|missed| *missed > 0.0)
            .sum();
        intervals_s.sort_by(f64::total_cmp);
        errors_m.sort_by(f64::total_cmp);
        Some(FrameReport {
            start_s,
            frames: u32::try_from(self.frames.len()).unwrap_or(u32::MAX),
            interval_p50_s: statistics::quantile(&intervals_s, 0.5).unwrap_or_default(),
            interval_p99_s: statistics::quantile(&intervals_s, 0.99).unwrap_or_default(),
            interval_max_s: statistics::quantile(&intervals_s, 1.0).unwrap_or_default(),
            // The cast saturates.
            dropped: dropped as u32,
            slider_error_p50_m: statistics::quantile(&errors_m, 0.5).unwrap_or_default(),
            slider_error_max_m: statistics::quantile(&errors_m, 1.0).unwrap_or_default(),
            frame_m: self.motion.speed_m_per_s * self.refresh_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTION: Motion = Motion {
        from_m: 0.0,
        to_m: 0.1,
        speed_m_per_s: 0.05,
        starts_s: Some(10.0),
    };
    const REFRESH_S: f64 = 1.0 / 60.0;

    /// Returns the report on frames drawn for the middle of their time on the screen, with some frames dropped.
    fn log(dropped: impl Fn(u32) -> bool) -> FrameReport {
        let mut log = FrameLog::new(MOTION, REFRESH_S);
        for i in (0..100).filter(|i| !dropped(*i)) {
            let presented_s = 10.0 + REFRESH_S * f64::from(i);
            log.take(presented_s, MOTION.at_m(presented_s + 0.5 * REFRESH_S));
        }
        log.report().unwrap()
    }

    #[test]
    fn a_slider_drawn_for_the_middle_of_each_frame_is_half_a_frame_off_at_most() {
        let report = log(|_| false);
        assert_eq!((report.frames, report.dropped), (100, 0));
        assert!((report.interval_p50_s - REFRESH_S).abs() < 1e-9);
        assert!((report.interval_p99_s - REFRESH_S).abs() < 1e-9);
        assert!((report.slider_error_max_m / report.frame_m - 0.5).abs() < 1e-6);
    }

    #[test]
    fn frames_that_did_not_come_are_counted_and_the_slider_was_late_on_the_one_before() {
        let report = log(|i| (50..53).contains(&i));
        assert_eq!((report.frames, report.dropped), (97, 3));
        assert!((report.interval_max_s - 4.0 * REFRESH_S).abs() < 1e-9);
        assert!((report.slider_error_max_m / report.frame_m - 3.5).abs() < 1e-6);
        assert!((report.slider_error_p50_m / report.frame_m - 0.5).abs() < 1e-6);
    }

    #[test]
    fn an_exploration_without_frames_has_no_report() {
        assert_eq!(FrameLog::new(MOTION, REFRESH_S).report(), None);
    }
}
