//! Newest values for the live panels.

use analysis::measurements::SMOOTHING_HZ;
use devices::field_task::POSITION_HZ;
use impedance::ZmFrame;
use impedance::smoothing::{Causal, LowPass};
use operator_ui::bench_page::HealthMeter;
use recording::pipeline::Batch;
use recording::{ForceRow, PositionRow};
use tui::event::{Live, PeriodTrace};

use crate::period::LastPeriod;
use crate::screen_words;

/// Smallest normal force for a friction coefficient, N.
const CONTACT_N: f64 = 0.1;
/// Age from which the last force and the last position are no longer shown, s.
const OUTDATED_S: f64 = 0.5;
/// Smallest speed of a sliding finger, m/s.
const SLIDING_M_PER_S: f64 = 0.005;

/// Collects the values shown by a session or a monitor.
#[derive(Debug, Default)]
pub struct LiveMeter {
    frame: Option<ZmFrame>,
    /// Ends of the last batches with a force and with a position, s.
    force_s: f64,
    position_s: f64,
    normal_n: Option<f64>,
    lateral_n: Option<f64>,
    position_m: Option<f64>,
    velocity: Velocity,
    /// Measured friction coefficient while the finger slides.
    measured_mu: Option<f64>,
    period: LastPeriod,
    /// Health of the bench's tasks and devices.
    pub health: HealthMeter,
}

/// Velocity of the finger: derivative of the position after a causal second-order 100 Hz Butterworth filter; delayed by 2.3 ms.
#[derive(Debug)]
struct Velocity {
    filter: Option<Causal<f64>>,
    last_row: Option<PositionRow>,
    m_per_s: Option<f64>,
}

impl Default for Velocity {
    fn default() -> Self {
        let filter = LowPass::new(SMOOTHING_HZ, POSITION_HZ)
            .map(Causal::new)
            .ok();
        Self {
            filter,
            last_row: None,
            m_per_s: None,
        }
    }
}

impl Velocity {
    fn take(&mut self, row: &PositionRow) {
        if row.position_m.is_nan() {
            // NaN would stay in the filter.
            *self = Self::default();
            return;
        }
        let Some(filter) = &mut self.filter else {
            return;
        };
        let row = PositionRow {
            time_s: row.time_s,
            position_m: filter.run(row.position_m),
        };
        if let Some(last_row) = self.last_row.replace(row) {
            self.m_per_s =
                Some((row.position_m - last_row.position_m) / (row.time_s - last_row.time_s));
        }
    }
}

impl LiveMeter {
    /// Takes a batch of acquired data.
    pub fn take(&mut self, batch: &Batch) {
        self.frame = batch.frames.last().copied().or(self.frame);
        if let Some(row) = batch.force.last() {
            self.force_s = batch.audio_s;
            self.normal_n = Some(row.normal_n);
            self.lateral_n = Some(row.lateral_n);
        }
        if !batch.force.is_empty() {
            let sum =
                |component: fn(&ForceRow) -> f64| batch.force.iter().map(component).sum::<f64>();
            let (normal_n, lateral_n) = (sum(|row| row.normal_n), sum(|row| row.lateral_n));
            let least_n = CONTACT_N * batch.force.len() as f64;
            self.measured_mu = (normal_n >= least_n).then(|| (lateral_n / normal_n).abs());
        }
        self.period.take(&batch.frames);
        if let Some(row) = batch.position.last() {
            self.position_s = batch.audio_s;
            self.position_m = Some(row.position_m).filter(|position_m| position_m.is_finite());
        }
        for row in &batch.position {
            self.velocity.take(row);
        }
        self.drop_outdated(batch.audio_s);
    }

    /// Drops force and position of a source that has sent nothing for a while.
    fn drop_outdated(&mut self, audio_s: f64) {
        if audio_s - self.force_s > OUTDATED_S {
            (self.normal_n, self.lateral_n, self.measured_mu) = (None, None, None);
        }
        if audio_s - self.position_s > OUTDATED_S {
            self.position_m = None;
            self.velocity = Velocity::default();
        }
    }

    /// Sets the frequency of the drive's modulation, Hz.
    pub fn modulate(&mut self, modulation_hz: f64) {
        self.period.modulate(modulation_hz);
    }

    /// Returns the impedance over the last period; `None` before the first frame.
    pub fn period(&self) -> Option<PeriodTrace> {
        self.period.trace()
    }

    /// Returns the position of the finger, m.
    pub fn position_m(&self) -> Option<f64> {
        self.position_m
    }

    /// Returns the newest values; `None` before the first frame.
    pub fn live(&self, slider_m: Option<f64>) -> Option<Live> {
        Some(Live {
            normal_n: self.normal_n,
            lateral_n: self.lateral_n,
            position_m: self.position_m,
            velocity_m_per_s: self.velocity.m_per_s,
            slider_m,
            measured_mu: self.measured_mu.filter(|_| self.is_sliding()),
            ..screen_words::live(self.frame.as_ref()?)
        })
    }

    /// Returns whether the finger slides; true on a bench without an encoder, where the velocity is unknown.
    fn is_sliding(&self) -> bool {
        self.velocity
            .m_per_s
            .is_none_or(|m_per_s| m_per_s.abs() >= SLIDING_M_PER_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a batch up to `audio_s`, with a force if the sensor sends.
    fn batch(audio_s: f64, normal_n: Option<f64>) -> Batch {
        let row = |normal_n| ForceRow {
            time_s: audio_s,
            normal_n,
            lateral_n: 0.1,
        };
        Batch {
            audio_s,
            force: normal_n.map(row).into_iter().collect(),
            ..Batch::default()
        }
    }

    #[test]
    fn the_last_force_of_a_silent_sensor_is_not_shown_as_live() {
        let mut meter = LiveMeter::default();
        let mut shown = |audio_s, normal_n| {
            meter.take(&batch(audio_s, normal_n));
            meter.normal_n
        };
        assert_eq!(shown(1.0, Some(0.62)), Some(0.62));
        assert_eq!(shown(1.4, None), Some(0.62));
        assert_eq!(shown(1.6, None), None);
        assert_eq!(shown(1.7, Some(0.5)), Some(0.5));
    }
}
