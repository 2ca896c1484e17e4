//! Rates and starts of channels, from the headers of their segments.

use crate::scan::Run;

/// Greatest error of starts that are written as texts, s.
const CLOCK_ERROR_S: f64 = 2e-6;

/// Times of a channel's samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Timing {
    /// Samples follow one another at one rate.
    Even {
        interval_s: f64,
        /// Sentences for a user.
        notes: Vec<String>,
    },
    /// Segments have times of their own.
    Uneven {
        /// Reason.
        reason: String,
    },
    /// No header states an interval.
    Unstated,
}

/// Returns the time of a run's first sample after that of the first run, s.
pub(crate) fn start_s(runs: &[Run], run: &Run) -> Option<f64> {
    let first = &runs[0].column;
    let clock_s = run.column.clock_s? - first.clock_s?;
    Some(clock_s + run.column.x0_s - first.x0_s)
}

impl Timing {
    /// Returns the timing of a channel's runs.
    pub(crate) fn find(runs: &[Run]) -> Self {
        let filled: Vec<Run> = runs.iter().filter(|run| run.count > 0).cloned().collect();
        let Some(first) = filled.first() else {
            return Self::Unstated;
        };
        let Some(interval_s) = first.column.interval_s else {
            return Self::Unstated;
        };
        if first.column.samples == Some(1) && first.count > 1 {
            let reason = "its header states an interval for single samples".to_owned();
            return Self::Uneven { reason };
        }
        let other = filled.iter().find_map(|run| match run.column.interval_s {
            Some(other_s) if (other_s / interval_s - 1.0).abs() < 1e-6 => None,
            other_s => Some(other_s.unwrap_or(0.0)),
        });
        if let Some(other_s) = other {
            let reason = format!("its segments have intervals of {interval_s} s and {other_s} s");
            return Self::Uneven { reason };
        }
        let headed: Vec<&Run> = filled.iter().filter(|run| !run.is_continued).collect();
        let starts: Vec<Option<f64>> = headed.iter().map(|run| start_s(&filled, run)).collect();
        let is_one = starts
            .iter()
            .all(|start| start.is_none_or(|start| start == 0.0));
        if is_one {
            return Self::Even {
                interval_s,
                notes: one_start(first, headed.len(), &filled)
                    .into_iter()
                    .chain(few_digits(first))
                    .collect(),
            };
        }
        for (i, (run, start)) in headed.iter().zip(&starts).enumerate() {
            let expected_s = run.first as f64 * interval_s;
            let gap_s = start.unwrap_or(expected_s) - expected_s;
            if gap_s.abs() > 0.5 * interval_s + CLOCK_ERROR_S {
                let side = if gap_s > 0.0 { "after" } else { "before" };
                let reason = format!(
                    "segment {} begins {:.6} s {side} the end of the one before it",
                    i + 1,
                    gap_s.abs()
                );
                return Self::Uneven { reason };
            }
        }
        Self::Even {
            interval_s,
            notes: few_digits(first).into_iter().collect(),
        }
    }
}

/// Returns the rate of an interval: a whole one where the interval is that of one but for the last bit.
pub(crate) fn rate_hz(interval_s: f64) -> f64 {
    let (rate_hz, whole_hz) = (1.0 / interval_s, (1.0 / interval_s).round());
    let is_whole = (rate_hz / whole_hz - 1.0).abs() < 1e-12;
    if is_whole { whole_hz } else { rate_hz }
}

/// Returns the note for an interval whose digits do not tell its rate.
fn few_digits(first: &Run) -> Option<String> {
    let (interval_s, error_s) = (first.column.interval_s?, first.column.interval_error_s);
    if rate_hz(interval_s).fract() == 0.0 || error_s <= 1e-6 * interval_s || error_s >= interval_s {
        return None;
    }
    Some(format!(
        "`Delta_X` = {interval_s} s has few digits: the rate is between {:.1} and {:.1} Hz; write rate_hz if it is known",
        1.0 / (interval_s + error_s),
        1.0 / (interval_s - error_s)
    ))
}

/// Returns the note for segments whose headers do not tell their starts.
fn one_start(first: &Run, headers: usize, runs: &[Run]) -> Option<String> {
    let count: u64 = runs.iter().map(|run| run.count).sum();
    if headers > 1 {
        return Some(format!(
            "its {headers} segments state one start, and are read one after the other"
        ));
    }
    let stated = first.column.samples.filter(|stated| *stated < count)?;
    Some(format!(
        "its header states {stated} samples, and {count} are there: those of later segments, which state no start, are read one \
         after the other"
    ))
}
