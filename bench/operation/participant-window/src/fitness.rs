//! Checks whether a finger can follow the window: frames in time, on the chosen monitor.

use std::collections::VecDeque;

use crate::message::FromWindow;

/// Duration above which a frame is slow enough to be seen, s.
const SLOW_S: f64 = 0.05;
/// Number of slow frames allowed …
const MOST_SLOW: usize = 5;
/// … within this time, s; the window is fit again after as long without a slow frame.
const WITHIN_S: f64 = 10.0;

/// A monitor, by the properties that the slider depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnMonitor {
    /// Its name.
    pub name: String,
    /// Its width and height, pixels.
    pub size_px: (u32, u32),
}

/// Reasons why a finger cannot follow the window.
#[derive(Debug, Default)]
pub struct Fitness {
    /// Time of the last frame with a moving slider, s.
    last_s: Option<f64>,
    /// End times of the last slow frames, s, one more than is allowed.
    slow_s: VecDeque<f64>,
    is_slow: bool,
    fault: Option<String>,
    /// Reason reported to the session last.
    last_reason: Option<String>,
}

impl Fitness {
    /// Takes a frame with a moving slider; `presented_s` never decreases.
    pub fn note_frame(&mut self, presented_s: f64) {
        let before_s = self.last_s.replace(presented_s);
        if before_s.is_none_or(|before_s| presented_s - before_s <= SLOW_S) {
            return;
        }
        self.slow_s.push_back(presented_s);
        if self.slow_s.len() > MOST_SLOW + 1 {
            self.slow_s.pop_front();
        }
        let first_s = self.slow_s.front().copied().unwrap_or(presented_s);
        self.is_slow |= self.slow_s.len() > MOST_SLOW && presented_s - first_s <= WITHIN_S;
    }

    /// Notes that the slider stands still, so that the time to the next frame does not count.
    pub fn note_rest(&mut self) {
        self.last_s = None;
    }

    /// Compares the chosen monitor with the present one, `None` if it is unknown.
    pub fn set_monitor(&mut self, expected: &OnMonitor, current: Option<&OnMonitor>) {
        self.fault = current.filter(|current| *current != expected).map(|current| {
            if current.name == expected.name {
                let ((was_x, was_y), (x, y)) = (expected.size_px, current.size_px);
                format!(
                    "its monitor {} has {x} × {y} pixels now, not {was_x} × {was_y}, and the slider is not true to the millimetre: \
                     close it (Ctrl-Q) and start it again",
                    current.name
                )
            } else {
                format!(
                    "it is on the monitor {}, not on {}: move it back, or close it (Ctrl-Q) and start it again with --monitor",
                    current.name, expected.name
                )
            }
        });
    }

    /// Forgets all reports, for a new session.
    pub fn forget(&mut self) {
        *self = Self {
            fault: self.fault.take(),
            ..Self::default()
        };
    }

    /// Returns a report if it differs from the last one. Slow frames of a virtual display are reported but do not stop
    /// the session.
    pub fn news(&mut self, now_s: f64, virtual_display: bool) -> Option<FromWindow> {
        let last_slow_s = self.slow_s.back().copied();
        if last_slow_s.is_none_or(|last_s| now_s - last_s > WITHIN_S) {
            self.is_slow = false;
        }
        let slow = self.is_slow.then(|| {
            format!(
                "more than {MOST_SLOW} of its frames took over {:.0} ms within {WITHIN_S:.0} s, so that the slider jerks: close other \
                 programs on this computer",
                1e3 * SLOW_S
            )
        });
        let reason = self.fault.clone().or(slow);
        if reason == self.last_reason {
            return None;
        }
        self.last_reason = reason.clone();
        if virtual_display {
            return reason.map(|text| FromWindow::Trouble { text });
        }
        Some(FromWindow::Unfit { why: reason })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows frames at 60 Hz for a time; every `slow_every_s`, one takes `slow_s`.
    fn run(fitness: &mut Fitness, from_s: f64, to_s: f64, slow_every_s: f64, slow_s: f64) {
        let (mut at_s, mut slow_at_s) = (from_s, from_s + slow_every_s);
        while at_s < to_s {
            let slow = at_s >= slow_at_s;
            if slow {
                slow_at_s += slow_every_s;
            }
            at_s += if slow { slow_s } else { 1.0 / 60.0 };
            fitness.note_frame(at_s);
        }
    }

    fn reason(news: Option<FromWindow>) -> Option<String> {
        match news {
            Some(FromWindow::Unfit { why: reason }) => reason,
            message => panic!("{message:?}"),
        }
    }

    /// Fault 43.
    #[test]
    fn frames_that_are_slow_again_and_again_make_it_unfit_until_they_have_come_in_time_for_as_long()
    {
        let mut fitness = Fitness::default();
        run(&mut fitness, 0.0, 10.0, 1.5, 0.06);
        let text = reason(fitness.news(10.0, false)).unwrap();
        assert!(text.contains("over 50 ms"), "{text}");
        assert_eq!(fitness.news(10.0, false), None, "said twice");
        fitness.note_rest();
        assert_eq!(fitness.news(18.0, false), None);
        assert_eq!(reason(fitness.news(20.0, false)), None);
    }

    #[test]
    fn five_slow_frames_in_ten_seconds_are_allowed_and_so_are_many_short_ones() {
        for (every_s, slow_s) in [(2.1, 0.06), (0.1, 0.049)] {
            let mut fitness = Fitness::default();
            run(&mut fitness, 0.0, 60.0, every_s, slow_s);
            assert_eq!(fitness.news(60.0, false), None, "{every_s} {slow_s}");
        }
    }

    #[test]
    fn a_slider_that_stands_is_not_slow() {
        let mut fitness = Fitness::default();
        for exploration in 0..20 {
            let from_s = 0.4 * f64::from(exploration);
            run(&mut fitness, from_s, from_s + 0.2, 9.0, 0.0);
            fitness.note_rest();
        }
        assert_eq!(fitness.news(8.0, false), None);
    }

    /// Fault 43.
    #[test]
    fn a_window_on_another_monitor_or_one_of_other_pixels_is_unfit_until_it_is_back() {
        let monitor = |name: &str, width| OnMonitor {
            name: name.to_owned(),
            size_px: (width, 1080),
        };
        let expected = monitor("HDMI-1", 1920);
        for (actual, word) in [
            (monitor("eDP-1", 1920), "eDP-1, not on HDMI-1"),
            (monitor("HDMI-1", 1280), "1280 × 1080 pixels now"),
        ] {
            let mut fitness = Fitness::default();
            fitness.set_monitor(&expected, Some(&expected));
            assert_eq!(fitness.news(0.0, false), None);
            fitness.set_monitor(&expected, Some(&actual));
            let text = reason(fitness.news(1.0, false)).unwrap();
            assert!(text.contains(word), "{text}");
            fitness.forget();
            assert!(
                reason(fitness.news(2.0, false)).is_some(),
                "another session"
            );
            fitness.set_monitor(&expected, None);
            assert_eq!(reason(fitness.news(3.0, false)), None);
        }
    }

    #[test]
    fn slow_frames_of_a_virtual_display_are_reported_without_a_stop() {
        let mut fitness = Fitness::default();
        run(&mut fitness, 0.0, 10.0, 0.5, 0.1);
        assert!(matches!(
            fitness.news(10.0, true),
            Some(FromWindow::Trouble { .. })
        ));
        assert_eq!(fitness.news(30.0, true), None);
    }
}
