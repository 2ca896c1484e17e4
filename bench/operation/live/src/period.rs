//! Impedance over the last period of the modulation.

use std::collections::VecDeque;

use impedance::ZmFrame;
use tui::event::PeriodTrace;

use crate::screen_words::impedance;

/// Largest number of points of a trace.
const POINTS: usize = 120;
/// Period for an unknown modulation, s: the published 6 Hz (Huloux 2021, section IV).
const PUBLISHED_S: f64 = 1.0 / 6.0;
/// Longest period kept, s.
const LONGEST_S: f64 = 2.0;

/// Keeps the frames of the last period.
#[derive(Debug)]
pub(crate) struct LastPeriod {
    period_s: f64,
    frames: VecDeque<ZmFrame>,
}

impl Default for LastPeriod {
    fn default() -> Self {
        Self {
            period_s: PUBLISHED_S,
            frames: VecDeque::new(),
        }
    }
}

impl LastPeriod {
    /// Sets the frequency of the drive's modulation, Hz; without modulation, the published frequency is used.
    pub(crate) fn modulate(&mut self, modulation_hz: f64) {
        self.period_s = if modulation_hz > 0.0 {
            (1.0 / modulation_hz).min(LONGEST_S)
        } else {
            PUBLISHED_S
        };
    }

    pub(crate) fn take(&mut self, frames: &[ZmFrame]) {
        self.frames.extend(frames);
        let Some(last_s) = self.frames.back().map(|frame| frame.time_s) else {
            return;
        };
        let from_s = last_s - self.period_s;
        let is_outside = |frame: &ZmFrame| frame.time_s < from_s || frame.time_s > last_s;
        while self.frames.front().is_some_and(is_outside) {
            self.frames.pop_front();
        }
    }

    /// Returns the period's trace; `None` before the first frame.
    pub(crate) fn trace(&self) -> Option<PeriodTrace> {
        let (first, last) = self.frames.front().zip(self.frames.back())?;
        let step = self.frames.len().div_ceil(POINTS);
        let thinned = || self.frames.iter().step_by(step);
        Some(PeriodTrace {
            z_m_n_s_per_m: thinned()
                .map(|frame| impedance(frame.corrected_n_s_per_m))
                .collect(),
            z_plain_n_s_per_m: thinned()
                .map(|frame| impedance(frame.plain_n_s_per_m))
                .collect(),
            duration_s: last.time_s - first.time_s,
        })
    }
}
