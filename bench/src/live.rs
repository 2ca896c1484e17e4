//! Gap and friction while the finger slides: every impedance frame read with the participant's last fit.
//!
//! Forces are as they come, without the zero-phase filter of the analysis; a frame takes the mean of the force readings since the
//! frame before it, or the last reading when the sensor's bursts are late.

use std::collections::VecDeque;

use contact::live::{Frame, LiveEstimator, Uncertain};
use impedance::ZmFrame;
use tui::event::{Estimate, Live};

use crate::pipeline::Batch;
use crate::recording::ForceRow;
use crate::refit::TrialFit;

/// What one frame says about the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time of the frame, s.
    pub time_s: f64,
    /// Contact stiffness k_c, N/m.
    pub k_c_n_per_m: Uncertain,
    /// Gap ⟨x_t⟩, m.
    pub gap_m: Uncertain,
    /// Friction coefficient; its error holds those of μ/μ0 and of μ0, taken as independent.
    pub mu: Uncertain,
    /// Normal force from impedance and amplitude alone, N; `None` in the first five frames of a contact.
    pub self_sensed_normal_n: Option<Uncertain>,
    /// Measured normal force, N.
    pub normal_n: f64,
    /// Measured |f_t|/f_n.
    pub measured_mu: f64,
}

/// Reads the contact frame by frame. Nothing is read before the first fit, nor while no finger is on the plate.
#[derive(Debug)]
pub struct LiveContact {
    contact_n: f64,
    fit: Option<Fit>,
    force: Option<ForceRow>,
    /// Readings later than the newest frame.
    ahead: VecDeque<ForceRow>,
    latest: Option<Reading>,
}

#[derive(Debug)]
struct Fit {
    estimator: LiveEstimator,
    mu0: Uncertain,
}

impl LiveContact {
    /// From `contact_n` on the finger is on the plate, N.
    pub fn new(contact_n: f64) -> Self {
        Self {
            contact_n,
            fit: None,
            force: None,
            ahead: VecDeque::new(),
            latest: None,
        }
    }

    /// From now on with a newer fit.
    pub fn refit(&mut self, fit: &TrialFit) {
        self.latest = None;
        // A fit was made of frames, so their interval is one.
        self.fit = LiveEstimator::new(fit.finger, fit.interval_s)
            .ok()
            .map(|estimator| Fit {
                estimator,
                mu0: fit.mu0,
            });
    }

    /// Reads what was acquired; `each` sees every frame in contact that has a gap.
    pub fn take(&mut self, batch: &Batch, mut each: impl FnMut(&Reading)) {
        self.ahead.extend(&batch.force);
        for frame in &batch.frames {
            let (mut sum, mut rows) = ((0.0, 0.0), 0u32);
            let due = self.ahead.partition_point(|row| row.time_s <= frame.time_s);
            for row in self.ahead.drain(..due) {
                sum = (sum.0 + row.normal_n, sum.1 + row.lateral_n);
                rows += 1;
            }
            if rows > 0 {
                let rows = f64::from(rows);
                self.force = Some(ForceRow {
                    time_s: frame.time_s,
                    normal_n: sum.0 / rows,
                    lateral_n: sum.1 / rows,
                });
            }
            self.latest = self.read(frame);
            if let Some(reading) = &self.latest {
                each(reading);
            }
        }
    }

    fn read(&mut self, frame: &ZmFrame) -> Option<Reading> {
        let fit = self.fit.as_mut()?;
        let force = self.force.filter(|force| force.normal_n >= self.contact_n);
        let (true, Some(force)) = (frame.mask.is_clear(), force) else {
            fit.estimator.reset();
            return None;
        };
        // A frame without a gap is one that the model has no answer for: nothing is shown.
        let estimate = fit
            .estimator
            .update(&Frame {
                z_m_corrected_n_s_per_m: frame.corrected_n_s_per_m,
                amplitude_m: frame.amplitude_m,
                normal_n: Some(force.normal_n),
            })
            .ok()?;
        let ratio = estimate.mu_ratio?;
        Some(Reading {
            time_s: frame.time_s,
            k_c_n_per_m: estimate.k_c_n_per_m,
            gap_m: estimate.gap_m,
            mu: Uncertain {
                value: fit.mu0.value * ratio.value,
                std: (fit.mu0.value * ratio.std).hypot(ratio.value * fit.mu0.std),
            },
            self_sensed_normal_n: estimate.self_sensed_normal_n,
            normal_n: force.normal_n,
            measured_mu: (force.lateral_n / force.normal_n).abs(),
        })
    }

    /// The newest frame's reading.
    pub fn latest(&self) -> Option<&Reading> {
        self.latest.as_ref()
    }

    /// `live` with gap and friction.
    pub fn shown(&self, live: Live) -> Live {
        let estimate = |uncertain: Uncertain| Estimate {
            value: uncertain.value,
            std: uncertain.std,
        };
        Live {
            gap_m: self.latest.map(|reading| estimate(reading.gap_m)),
            mu: self.latest.map(|reading| estimate(reading.mu)),
            ..live
        }
    }
}
