//! Gap and friction while the finger slides, from every impedance frame and the participant's last fit.
//!
//! Meanwhile the plate's resonance is tracked ([`PlateTracker`]), and its damping while no finger is on it, so that
//! gap and friction remain valid while the plate warms.
//!
//! Forces are not smoothed by the zero-phase filter of the analysis: a frame uses the mean of the force readings since
//! the previous frame, or the last reading if the sensor's bursts are late, against the zero read while no finger is on
//! the plate. If the amplitude along the plate was
//! measured, amplitude and impedance are those under the finger, at its last known position.

use std::collections::VecDeque;

use contact::FittedFinger;
use contact::live_estimator::{LiveEstimator, LiveFrame, Uncertain};
use contact::plate_tracker::{FingerLoad, PlateSample, PlateTracker, PlateTracking};
use impedance::ZmFrame;
use num_complex::Complex64;

use crate::live_zero::LiveZero;
use crate::trial_fit::TrialContact;
use analysis::amplitude_profile::AmplitudeProfile;
use analysis::under_finger;
use recording::pipeline::Batch;
use recording::{ForceRow, PositionRow};

/// Contact at one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactReading {
    /// Time of the frame, s.
    pub time_s: f64,
    /// Contact stiffness k_c, N/m.
    pub k_c_n_per_m: Uncertain,
    /// Gap ⟨x_t⟩, m.
    pub gap_m: Uncertain,
    /// Friction coefficient; its error combines those of μ/μ0 and of μ0 as independent.
    pub mu: Uncertain,
    /// Normal force from impedance and amplitude alone, N; `None` in the first five frames of a contact.
    pub self_sensed_normal_n: Option<Uncertain>,
    /// Measured normal force against the sensor's zero, N.
    pub normal_n: f64,
    /// Measured |f_t|/f_n.
    pub measured_mu: f64,
}

/// Reasons why the newest frame has no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoReading {
    /// There is no fit yet.
    NoFit,
    /// The force is not measured.
    NoForce,
    /// No finger is on the plate.
    NoFinger,
    /// The impedance is masked.
    Masked,
    /// The model has no gap for the measured values.
    OffModel,
}

/// Live reader of the contact, frame by frame. It gives no readings before the first fit, nor while no finger is on the
/// plate.
#[derive(Debug)]
pub struct LiveContact {
    contact_n: f64,
    fit: Option<Fit>,
    /// Tracker of the plate; `None` if the plate's constants are not valid.
    tracker: Option<PlateTracker>,
    /// Time of the newest frame, s.
    time_s: f64,
    /// Last mean of the force readings, as the sensor read them.
    force: Option<ForceRow>,
    zero: LiveZero,
    /// Force readings later than the newest frame.
    pending_force: VecDeque<ForceRow>,
    /// Last known position of the finger, m; NaN before the first.
    position_m: f64,
    /// Known positions later than the newest frame.
    pending_positions: VecDeque<PositionRow>,
    latest: Result<ContactReading, NoReading>,
}

#[derive(Debug)]
struct Fit {
    estimator: LiveEstimator,
    finger: FittedFinger,
    mu0: Uncertain,
    profile: AmplitudeProfile,
}

/// Age beyond which a force reading is no longer used, s: bursts are late by less.
const MAX_FORCE_AGE_S: f64 = 0.1;

impl LiveContact {
    /// Makes a reader without a fit, for a plate tracked by `tracking`. A normal force of `contact_n` or more, N,
    /// counts as a finger on the plate, one of less than half of it as none.
    pub fn new(contact_n: f64, tracking: PlateTracking) -> Self {
        Self {
            contact_n,
            fit: None,
            tracker: PlateTracker::new(tracking).ok(),
            time_s: f64::NEG_INFINITY,
            force: None,
            zero: LiveZero::default(),
            pending_force: VecDeque::new(),
            position_m: f64::NAN,
            pending_positions: VecDeque::new(),
            latest: Err(NoReading::NoFit),
        }
    }

    /// Uses a newer fit from now on.
    pub fn refit(&mut self, fit: &TrialContact) {
        self.latest = Err(NoReading::NoFinger);
        // A fit was made from frames, so their interval is positive.
        self.fit = LiveEstimator::new(fit.finger, fit.interval_s)
            .ok()
            .map(|estimator| Fit {
                estimator,
                finger: fit.finger,
                mu0: fit.mu0,
                profile: fit.profile.clone(),
            });
    }

    /// Reads the acquired frames; calls `callback` for every frame in contact that has a gap.
    pub fn take(&mut self, batch: &Batch, mut callback: impl FnMut(&ContactReading)) {
        self.pending_force.extend(&batch.force);
        let known_positions = batch
            .position
            .iter()
            .filter(|row| row.position_m.is_finite());
        self.pending_positions.extend(known_positions);
        for frame in &batch.frames {
            let is_due = |row: &PositionRow| row.time_s <= frame.time_s;
            let due_count = self.pending_positions.partition_point(is_due);
            if let Some(row) = self.pending_positions.drain(..due_count).next_back() {
                self.position_m = row.position_m;
            }
            let (mut sum, mut rows) = ((0.0, 0.0), 0u32);
            let due_count = self
                .pending_force
                .partition_point(|row| row.time_s <= frame.time_s);
            for row in self.pending_force.drain(..due_count) {
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
            self.time_s = frame.time_s;
            self.latest = self.read(frame);
            if let Ok(reading) = &self.latest {
                callback(reading);
            }
        }
    }

    fn read(&mut self, frame: &ZmFrame) -> Result<ContactReading, NoReading> {
        let force = self
            .force
            .filter(|force| frame.time_s - force.time_s < MAX_FORCE_AGE_S);
        match &force {
            Some(force) if force.normal_n.abs() < self.contact_n / 2.0 => {
                let plate = self.plate_n_s_per_m();
                self.zero.take_free(force, frame, plate);
            }
            _ => self.zero.interrupt(),
        }
        let zero = self.zero.zero();
        let force = force.map(|force| ForceRow {
            normal_n: force.normal_n - zero.normal_n,
            lateral_n: force.lateral_n - zero.lateral_n,
            ..force
        });
        self.track(frame, force.as_ref());
        let (reactance, resistance) = (self.reactance(), self.resistance());
        let reason = match force {
            _ if self.fit.is_none() => NoReading::NoFit,
            None => NoReading::NoForce,
            Some(force) if force.normal_n < self.contact_n => NoReading::NoFinger,
            Some(_) => NoReading::Masked,
        };
        let fit = self.fit.as_mut().ok_or(reason)?;
        let force = force.filter(|force| force.normal_n >= self.contact_n);
        let (true, Some(force)) = (frame.mask.is_clear(), force) else {
            fit.estimator.reset();
            return Err(reason);
        };
        let ratio = fit.profile.ratio_at(self.position_m);
        // The finger's part is (Z_m − Z_p)/φ², so that an error δ of Z_p moves it by −δ/φ².
        let at_finger = |part: Uncertain| Uncertain {
            std: part.std / (ratio * ratio),
            ..part
        };
        let mut z_p = fit.finger.z_p_n_s_per_m();
        if let Some(reactance) = reactance {
            fit.estimator.move_plate(at_finger(reactance));
            z_p.im = reactance.value;
        }
        if let Some(resistance) = resistance {
            fit.estimator.damp_plate(at_finger(resistance));
            z_p.re = resistance.value;
        }
        let z_m = under_finger::impedance(frame.corrected_n_s_per_m, z_p, ratio);
        // The model has no gap for this frame, so there is no reading.
        let estimate = fit
            .estimator
            .update(&LiveFrame {
                z_m_corrected_n_s_per_m: z_m,
                amplitude_m: ratio * frame.amplitude_m,
                normal_n: Some(force.normal_n),
            })
            .map_err(|_| NoReading::OffModel)?;
        let ratio = estimate.mu_ratio.ok_or(NoReading::OffModel)?;
        Ok(ContactReading {
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

    /// Passes a frame to the tracker, as one of a free plate or one under a finger.
    fn track(&mut self, frame: &ZmFrame, force: Option<&ForceRow>) {
        let Some(tracker) = &mut self.tracker else {
            return;
        };
        let Some(force) = force else {
            tracker.interrupt();
            return;
        };
        // Noise may hide the amplitude in every trough: skip such a frame and continue its period.
        if !frame.mask.is_clear() {
            return;
        }
        let sample = PlateSample {
            time_s: frame.time_s,
            z_m_corrected_n_s_per_m: frame.corrected_n_s_per_m,
            z_m_std_n_s_per_m: frame.corrected_std_n_s_per_m,
        };
        match &self.fit {
            _ if force.normal_n.abs() < self.contact_n / 2.0 => tracker.take_free(&sample),
            Some(fit) if force.normal_n >= self.contact_n => {
                let amplitude_ratio = fit.profile.ratio_at(self.position_m);
                let load = FingerLoad {
                    amplitude_m: amplitude_ratio * frame.amplitude_m,
                    amplitude_ratio,
                    normal_n: force.normal_n,
                };
                tracker.take_loaded(&sample, &fit.finger, &load);
            }
            _ => tracker.touch(frame.time_s),
        }
    }

    /// Changes the modulation frequency of the drive, Hz.
    pub fn modulate(&mut self, modulation_hz: f64) {
        if let Some(tracker) = &mut self.tracker {
            tracker.modulate(modulation_hz);
        }
    }

    /// Changes to a carrier higher by `shift_hz`; the drift is then counted from it.
    pub fn retune(&mut self, shift_hz: f64) {
        self.latest = Err(NoReading::Masked);
        if let Some(tracker) = &mut self.tracker {
            tracker.retune(shift_hz);
        }
    }

    fn reactance(&self) -> Option<Uncertain> {
        self.tracker.as_ref()?.reactance_n_s_per_m(self.time_s)
    }

    fn resistance(&self) -> Option<Uncertain> {
        self.tracker.as_ref()?.resistance_n_s_per_m(self.time_s)
    }

    /// Returns the shift of the plate's resonance, Hz, since the plate was first read without a finger;
    /// positive upwards. `None` before that.
    pub fn drift_hz(&self) -> Option<Uncertain> {
        self.tracker.as_ref()?.drift_hz(self.time_s)
    }

    /// Returns the tracked Z_p of the plate, N·s/m; `None` before the plate was read without a finger.
    pub fn plate_n_s_per_m(&self) -> Option<Complex64> {
        let (re, im) = self.resistance().zip(self.reactance())?;
        Some(Complex64::new(re.value, im.value))
    }

    /// Returns the reading of the newest frame.
    pub fn latest(&self) -> Option<&ContactReading> {
        self.latest.as_ref().ok()
    }

    /// Returns the reason why the newest frame has no reading, if it has none.
    pub fn missing_reason(&self) -> Option<NoReading> {
        self.latest.as_ref().err().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use contact::{AssumedConstants, Contact, FittedFinger, harmonic};
    use recording::manifest::RecordedProfile;

    use crate::tests::frame;

    const CARRIER_HZ: f64 = 35_000.0;
    const AMPLITUDE_M: f64 = 1e-6;
    const NORMAL_N: f64 = 0.6;
    const MU0: f64 = 0.8;

    /// A contact at rest in force balance, with impedance, gap and friction ratio from the forward model.
    fn contact() -> (TrialContact, Complex64, f64, f64) {
        let contact = Contact::new(&AssumedConstants::ESTIMATION, 1.7e-6).unwrap();
        let (z_p, z_t) = (Complex64::new(7.0, 0.0), Complex64::new(0.5, 3.2));
        let omega = std::f64::consts::TAU * CARRIER_HZ;
        let gap_m = contact.equilibrium_gap_m(AMPLITUDE_M, NORMAL_N).unwrap();
        let k_c = contact.stiffness_n_per_m(gap_m, AMPLITUDE_M);
        let z_c = contact.impedance_n_s_per_m(k_c, omega);
        let uncertain = |value| Uncertain { value, std: 0.01 };
        let fit = TrialContact {
            sigma_t_m: uncertain(1.7e-6),
            z_t_n_s_per_m: z_t,
            z_t_std_n_s_per_m: Complex64::ZERO,
            tau_s: uncertain(1e-3),
            mu0: uncertain(MU0),
            sigma_t_spread_m: 0.0,
            usable: 1,
            instances: 1,
            force_difference: None,
            finger: FittedFinger::with_parameters(contact, z_t, 1e-3, z_p, CARRIER_HZ).unwrap(),
            interval_s: 5e-4,
            profile: AmplitudeProfile::default(),
        };
        let ratio = contact.friction_ratio(gap_m, NORMAL_N);
        (fit, harmonic::observed(z_p, z_t, z_c), gap_m, ratio)
    }

    fn batch(first_frame: u64, z_m: Complex64, normal_n: f64) -> Batch {
        let frames = (first_frame..first_frame + 10).map(|i| frame(i * 96, i as f64 * 5e-4, z_m));
        // Five readings per frame, the last at the frame's own time.
        let first = (first_frame * 5).saturating_sub(4);
        let force = (first..(first_frame + 9) * 5 + 1).map(|i| ForceRow {
            time_s: i as f64 * 1e-4,
            normal_n,
            lateral_n: -0.5 * normal_n,
        });
        Batch {
            frames: frames.collect(),
            force: force.collect(),
            ..Batch::default()
        }
    }

    #[test]
    fn a_frame_in_contact_gives_the_models_gap_and_friction() {
        let (fit, z_m, gap_m, ratio) = contact();
        let mut live = LiveContact::new(0.1, PlateTracking::new(0.008, 6.0));
        live.refit(&fit);
        let mut frames = 0;
        live.take(&batch(0, z_m, NORMAL_N), |_| frames += 1);
        assert_eq!(frames, 10);
        let reading = live.latest().unwrap();
        assert_relative_eq!(reading.gap_m.value, gap_m, max_relative = 1e-9);
        assert_relative_eq!(reading.mu.value, MU0 * ratio, max_relative = 1e-9);
        assert_relative_eq!(reading.measured_mu, 0.5, max_relative = 1e-12);
        let self_sensed = reading.self_sensed_normal_n.unwrap();
        assert_relative_eq!(self_sensed.value, NORMAL_N, max_relative = 1e-9);
    }

    /// A finger where the plate's motion is 10 % smaller than at the pickup acts on it with 0.81 of its impedance.
    #[test]
    fn where_the_plate_moves_less_the_gap_is_still_the_models() {
        let (mut fit, z_m, gap_m, ratio) = contact();
        fit.profile = AmplitudeProfile::new(&RecordedProfile {
            positions_m: vec![0.0, 0.05, 0.1],
            ratios: vec![1.0, 0.9, 0.9],
        });
        let z_p = fit.finger.z_p_n_s_per_m();
        let mut batch = batch(0, z_p + 0.81 * (z_m - z_p), NORMAL_N);
        for frame in &mut batch.frames {
            frame.amplitude_m = AMPLITUDE_M / 0.9;
        }
        let position_row = |time_s, position_m| PositionRow { time_s, position_m };
        // The unknown position is skipped, and the last one is not reached yet.
        batch.position = vec![
            position_row(0.0, 0.05),
            position_row(1e-3, f64::NAN),
            position_row(1.0, 0.0),
        ];
        let mut live = LiveContact::new(0.1, PlateTracking::new(0.008, 6.0));
        live.refit(&fit);
        live.take(&batch, |_| {});
        let reading = live.latest().unwrap();
        assert_relative_eq!(reading.gap_m.value, gap_m, max_relative = 1e-9);
        assert_relative_eq!(reading.mu.value, MU0 * ratio, max_relative = 1e-9);
        let self_sensed = reading.self_sensed_normal_n.unwrap();
        assert_relative_eq!(self_sensed.value, NORMAL_N, max_relative = 1e-9);
    }

    /// Regression test: where the plate moves less, the error of the plate's reactance counted too little, here by a factor of
    /// 0.36 in the gap's error.
    #[test]
    fn an_error_of_the_plate_counts_for_the_finger_where_the_plate_moves_less() {
        let gap_std_m = |ratio: f64| {
            let (mut fit, z_m, ..) = contact();
            fit.finger.inversion.covariance = Some(Default::default());
            fit.profile = AmplitudeProfile::new(&RecordedProfile {
                positions_m: vec![0.0, 0.1],
                ratios: vec![ratio; 2],
            });
            let z_p = fit.finger.z_p_n_s_per_m();
            let mut live = LiveContact::new(0.1, PlateTracking::new(0.008, 6.0));
            live.refit(&fit);
            for first_frame in (0..1000).step_by(10) {
                live.take(&batch(first_frame, z_p, 0.0), |_| {});
            }
            let touched = z_p + ratio * ratio * (z_m - z_p);
            let mut batch = batch(1000, touched, NORMAL_N);
            for frame in &mut batch.frames {
                frame.amplitude_m = AMPLITUDE_M / ratio;
            }
            batch.position = vec![PositionRow {
                time_s: 0.5,
                position_m: 0.05,
            }];
            live.take(&batch, |_| {});
            live.latest().unwrap().gap_m.std
        };
        assert_relative_eq!(gap_std_m(0.6), gap_std_m(1.0) / 0.36, max_relative = 1e-6);
    }

    /// A phase of 50 mrad that the pickup's stated one lacks turns all of Z_m.
    #[test]
    fn a_turned_finger_is_read_from_a_turned_pickup() {
        let (mut fit, z_m, gap_m, ratio) = contact();
        fit.finger = fit.finger.turned(0.05);
        let mut live = LiveContact::new(0.1, PlateTracking::new(0.008, 6.0));
        live.refit(&fit);
        let batch = batch(0, z_m * Complex64::cis(0.05), NORMAL_N);
        live.take(&batch, |_| {});
        let reading = live.latest().unwrap();
        assert_relative_eq!(reading.gap_m.value, gap_m, max_relative = 1e-9);
        assert_relative_eq!(reading.mu.value, MU0 * ratio, max_relative = 1e-9);
    }

    #[test]
    fn nothing_is_read_before_the_first_fit_nor_without_a_finger() {
        let (fit, z_m, ..) = contact();
        let mut live = LiveContact::new(0.1, PlateTracking::new(0.008, 6.0));
        live.take(&batch(0, z_m, NORMAL_N), |_| panic!("read without a fit"));
        live.refit(&fit);
        live.take(&batch(10, z_m, 0.05), |_| panic!("read without a finger"));
        assert_eq!(live.latest(), None);
        live.take(&batch(20, z_m, NORMAL_N), |_| {});
        assert!(live.latest().is_some());
        live.take(&batch(30, z_m, f64::NAN), |_| {});
        assert_eq!(live.latest(), None);
    }
}
