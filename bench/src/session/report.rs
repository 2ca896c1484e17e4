//! Report on the end of a session, and its lines.

use std::sync::atomic::Ordering;

use devices::{DeviceReadings, SensorClocks};
use protocols::SessionSummary;
use recorder::RecorderGauge;
use recording::pipeline::Account;
use safety::Signals;

/// Report on the end of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionReport {
    /// The session in numbers.
    pub summary: SessionSummary,
    /// Account of the audio frames.
    pub account: Account,
    /// Whether every trial is settled, so that nothing remains to resume.
    pub completed: bool,
    /// Reason for an early end.
    pub reason: Option<String>,
}

/// How close the program came to missing its time limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeptUp {
    /// Longest time between two looks of the safety watch, s.
    pub watch_away_s: f64,
    /// Greatest fill of the ring between sound card and acquisition, 0 to 1.
    pub ring_fill: f64,
    /// Maximum amount of audio that waited for the disk, s; `None` in simulated time.
    pub recorder_lag_s: Option<f64>,
    /// Clocks of the sensors.
    pub clocks: SensorClocks,
}

impl KeptUp {
    /// Reads the gauges of a bench up to now.
    pub fn read(signals: &Signals, gauges: &DeviceReadings, recorder: &RecorderGauge) -> Self {
        Self {
            watch_away_s: signals.longest_away_ns.load(Ordering::Relaxed) as f64 * 1e-9,
            ring_fill: gauges.fullest_ring.get().unwrap_or_default(),
            recorder_lag_s: Some(recorder.greatest_lag_s()),
            clocks: gauges.sensor_clocks(),
        }
    }

    /// Returns a line for each clock that differs from the sound card's by more than a crystal's.
    pub fn clock_lines(&self) -> impl Iterator<Item = String> {
        let clocks = self.clocks.notable();
        clocks.map(|clock| format!("{:<17} {}", clock.sensor, clock.in_words()))
    }

    /// Returns the line for the end of a session.
    pub fn line(&self) -> String {
        let lag = self
            .recorder_lag_s
            .map(|lag_s| format!(", disk {lag_s:.2} s behind"));
        format!(
            "at worst          {:.1} ms between looks of the safety watch, audio ring {:.1} % full{}",
            1e3 * self.watch_away_s,
            100.0 * self.ring_fill,
            lag.unwrap_or_default()
        )
    }
}

/// Returns the summary of a session in a few lines.
pub fn summary_lines(summary: &SessionSummary, account: &Account) -> Vec<String> {
    let force = summary
        .mean_normal_n
        .map_or_else(|| "not measured".to_owned(), |n| format!("{n:.3} N"));
    let kept = match summary.accepted_anyway {
        0 => String::new(),
        kept => format!(", {kept} of them kept by the operator"),
    };
    vec![
        format!(
            "trials accepted   {} of {}{kept}",
            summary.accepted + summary.accepted_anyway,
            summary.planned
        ),
        format!("trials repeated   {}", summary.redone),
        format!("mean normal force {force}"),
        format!("instances         {}", summary.instances),
        format!("drop-outs         {}", account.drop_outs()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_the_operator_kept_is_accepted_and_called_kept() {
        let summary = SessionSummary {
            planned: 4,
            accepted: 1,
            accepted_anyway: 1,
            ..SessionSummary::default()
        };
        let lines = summary_lines(&summary, &Account::default());
        assert_eq!(
            lines[0],
            "trials accepted   2 of 4, 1 of them kept by the operator"
        );
        let all_by_verdict = SessionSummary {
            accepted: 2,
            accepted_anyway: 0,
            ..summary
        };
        let lines = summary_lines(&all_by_verdict, &Account::default());
        assert_eq!(lines[0], "trials accepted   2 of 4");
    }
}
