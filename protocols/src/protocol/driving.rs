//! Driving time of a protocol.

use super::definition::Protocol;

/// Time for a participant to place the finger and say "ready", s (an assumption).
pub const PLACE_S: f64 = 5.0;
/// Time for a participant to lift the finger, s (an assumption).
pub const LIFT_S: f64 = 2.0;
/// Length of an hour, s.
const HOUR_S: f64 = 3600.0;

/// Driving time of a session without repetitions, with the times assumed for the participant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivingTime {
    /// Number of trials, practice included.
    pub trials: u32,
    /// Driving time of a trial, s.
    pub trial_s: f64,
    /// Largest driving time within any hour of the session, s.
    pub hour_s: f64,
}

impl Protocol {
    /// Returns the protocol's driving time: in each trial from before the baseline to the last feedback.
    ///
    /// ```
    /// use protocols::{Protocol, built_in};
    ///
    /// let text = built_in("huloux2021").expect("a built-in protocol");
    /// let driving = Protocol::parse(text, "huloux2021.toml")?.driving_time();
    /// // 0.2 + 0.8 s of baseline, and twice 5 + 3 + 1.7 + 2 + 3 s.
    /// assert!((driving.trial_s - 30.4).abs() < 1e-9);
    /// assert!((driving.hour_s - 12.0 * 30.4).abs() < 1e-9);
    /// # Ok::<(), protocols::ProtocolError>(())
    /// ```
    pub fn driving_time(&self) -> DrivingTime {
        let timing = &self.timing;
        let explorations = self.exploration.directions.iter().map(|&direction| {
            let slide_s = self.exploration.slider(direction).duration_s();
            PLACE_S + timing.countdown_s + slide_s + LIFT_S + timing.feedback_s
        });
        let trial_s = timing.settle_s + timing.baseline_s + explorations.sum::<f64>();
        let trials = self.planned_trials();
        Self::busiest_hour(trial_s, &self.starts_s(trials, trial_s), trials)
    }

    /// Returns the start time of each trial, s.
    pub(super) fn starts_s(&self, trials: u32, trial_s: f64) -> Vec<f64> {
        let practice = self.trials.practice;
        let mut start_s = 0.0;
        let starts = (0..trials).map(|trial| {
            if self.rest.is_due_after(trial, practice) {
                start_s += self.rest.min_s;
            }
            let begins_s = start_s;
            start_s += trial_s + self.timing.verdict_s;
            begins_s
        });
        starts.collect()
    }

    fn busiest_hour(trial_s: f64, starts_s: &[f64], trials: u32) -> DrivingTime {
        let mut hour_s = 0.0f64;
        let mut past = 0;
        // The hour with the most driving time starts with a trial.
        for (first, from_s) in starts_s.iter().enumerate() {
            while past < starts_s.len() && starts_s[past] < from_s + HOUR_S {
                past += 1;
            }
            let last_s = (from_s + HOUR_S - starts_s[past - 1]).min(trial_s);
            hour_s = hour_s.max((past - 1 - first) as f64 * trial_s + last_s);
        }
        DrivingTime {
            trials,
            trial_s,
            hour_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn demo(changes: &[(&str, &str)]) -> DrivingTime {
        let mut text = super::super::built_in("demo").unwrap().to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "no `{from}`");
            text = text.replacen(from, to, 1);
        }
        Protocol::parse(&text, "demo.toml").unwrap().driving_time()
    }

    #[test]
    fn a_session_within_an_hour_drives_for_all_of_its_trials() {
        let driving = demo(&[]);
        assert_eq!(driving.trials, 5);
        assert!((driving.trial_s - 22.4).abs() < 1e-9);
        assert!((driving.hour_s - 5.0 * 22.4).abs() < 1e-9);
    }

    #[test]
    fn the_busiest_hour_of_a_longer_session_counts() {
        // Trials of 22.4 s, each with a verdict of 0.5 s after it, and no rests: 157 of them and a part begin in an
        // hour.
        let driving = demo(&[
            ("per_condition = 4", "per_condition = 400"),
            ("every_trials = 2", "every_trials = 0"),
        ]);
        let trial_count = (HOUR_S / 22.9).floor();
        let expected_s = trial_count * 22.4 + (HOUR_S - trial_count * 22.9).min(22.4);
        assert!((driving.hour_s - expected_s).abs() < 1e-6, "{driving:?}");
        // A rest of ten minutes after every trial leaves six of them.
        let hourly = demo(&[
            ("per_condition = 4", "per_condition = 400"),
            ("every_trials = 2", "every_trials = 1"),
            ("min_s = 2.0 ", "min_s = 600.0"),
        ]);
        assert!((hourly.hour_s - 7.0 * 22.4).abs() < 1e-6, "{hourly:?}");
    }
}
