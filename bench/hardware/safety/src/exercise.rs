//! Exercise of the hardware stops under a faint tone: first the heartbeat is withheld, then the enable line is set low.
//! Each time the read-back must fall, and return with the line.

use crate::signals::DriveReading;
use crate::stop_times::{StopLine, StopTimes};

/// Longest wait for the read-back to fall or to return, s. A slower stop does not count as a stop.
const PATIENCE_S: f64 = 0.3;
/// Shares of the tone as read back before, below which the drive counts as off, and above which as back.
const OFF: f64 = 0.5;
const BACK: f64 = 0.75;

/// A running exercise.
#[derive(Debug)]
pub(crate) struct Exercise {
    /// Lines still to be exercised, the next one last.
    waiting: Vec<StopLine>,
    stage: Option<Stage>,
    done: Vec<StopTimes>,
}

#[derive(Debug, Clone, Copy)]
struct Stage {
    line: StopLine,
    since_ns: u64,
    /// Sample of the last reading before the stage began.
    after_sample: u64,
    /// Time to the silent read-back found in the first half of the stage, s; known in the second half.
    off_s: Option<Option<f64>>,
    /// Read-back of the tone before the line was touched, V peak; `None` if it was missing.
    tone_v: Option<f64>,
}

/// Required state of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Demand {
    /// Heartbeat and enable as in any armed bench.
    All,
    /// All but this line.
    AllBut(StopLine),
}

impl Exercise {
    /// Begins under a steady tone; `lines` are exercised in their order.
    pub(crate) fn new(mut lines: Vec<StopLine>) -> Self {
        lines.reverse();
        Self {
            waiting: lines,
            stage: None,
            done: Vec::new(),
        }
    }

    /// Takes the latest reading; returns the required state of the lines, or `None` once all are done.
    pub(crate) fn poll(&mut self, now_ns: u64, reading: Option<DriveReading>) -> Option<Demand> {
        let sample = reading.map_or(0, |reading| reading.sample);
        let Some(stage) = self.stage else {
            let line = self.waiting.pop()?;
            self.stage = Some(Stage {
                line,
                since_ns: now_ns,
                after_sample: sample,
                off_s: None,
                tone_v: reading.map(|reading| reading.volts),
            });
            return Some(Demand::AllBut(line));
        };
        let passed_s = now_ns.saturating_sub(stage.since_ns) as f64 * 1e-9;
        let share = reading
            .filter(|reading| reading.sample > stage.after_sample)
            .zip(stage.tone_v)
            .map(|(reading, tone_v)| reading.volts / tone_v);
        let reached = match stage.off_s {
            None => share.is_some_and(|share| share < OFF),
            Some(_) => share.is_some_and(|share| share > BACK),
        };
        let hold = match stage.off_s {
            None => Demand::AllBut(stage.line),
            Some(_) => Demand::All,
        };
        if !reached && passed_s < PATIENCE_S {
            return Some(hold);
        }
        let duration_s = reached.then_some(passed_s);
        match stage.off_s {
            None => {
                self.stage = Some(Stage {
                    since_ns: now_ns,
                    after_sample: sample,
                    off_s: Some(duration_s),
                    ..stage
                });
            }
            Some(off_s) => {
                self.done.push(StopTimes {
                    line: stage.line,
                    off_s,
                    back_s: duration_s,
                });
                self.stage = None;
            }
        }
        Some(Demand::All)
    }

    /// Returns the times of the exercised lines.
    pub(crate) fn times(self) -> Vec<StopTimes> {
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs an exercise on a bench with an amplifier that follows each line after its delay, ms; `None` for never.
    fn times(heartbeat_ms: Option<u64>, enable_ms: Option<u64>) -> Vec<StopTimes> {
        let mut exercise = Exercise::new(vec![StopLine::Heartbeat, StopLine::Enable]);
        let (mut fault_since, mut now_ms) = (None::<(StopLine, u64)>, 0);
        loop {
            let delay = |line| match line {
                StopLine::Heartbeat => heartbeat_ms,
                StopLine::Enable => enable_ms,
            };
            let is_off = fault_since.is_some_and(|(line, since)| {
                delay(line).is_some_and(|delay| now_ms - since >= delay)
            });
            let reading = DriveReading {
                volts: if is_off { 0.01 } else { 2.0 },
                sample: now_ms,
                ahead: 0,
                at_ns: now_ms * 1_000_000,
            };
            match exercise.poll(now_ms * 1_000_000, Some(reading)) {
                None => return exercise.times(),
                Some(Demand::All) => fault_since = None,
                Some(Demand::AllBut(line)) => {
                    fault_since = fault_since.or(Some((line, now_ms)));
                }
            }
            now_ms += 1;
            assert!(now_ms < 2_000, "never ends");
        }
    }

    #[test]
    fn each_line_is_timed_off_and_back() {
        let times = times(Some(90), Some(5));
        assert_eq!(times.len(), 2);
        assert_eq!(times[0].line, StopLine::Heartbeat);
        assert!((times[0].off_s.unwrap() - 0.09).abs() < 2e-3, "{times:?}");
        assert!((times[1].off_s.unwrap() - 0.005).abs() < 2e-3, "{times:?}");
        assert!(times.iter().all(|t| t.back_s.is_some_and(|s| s < 0.005)));
    }

    #[test]
    fn a_line_that_stops_nothing_is_reported() {
        let times = times(None, Some(5));
        assert_eq!((times[0].off_s, times[1].off_s.is_some()), (None, true));
    }

    #[test]
    fn a_read_back_that_does_not_come_is_no_stop() {
        let mut exercise = Exercise::new(vec![StopLine::Enable]);
        let mut now_ns = 0;
        while exercise.poll(now_ns, None).is_some() {
            now_ns += 1_000_000;
        }
        assert_eq!(
            exercise.times(),
            [StopTimes {
                line: StopLine::Enable,
                off_s: None,
                back_s: None
            }]
        );
    }
}
