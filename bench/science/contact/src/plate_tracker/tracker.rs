use std::f64::consts::PI;

use super::followed_gap::FollowedGap;
use super::reading::{CrestReading, FreeReading, PlateReading};
use super::sample::{FingerLoad, PlateSample};
use crate::error::{ModelError, not_negative, positive};
use crate::finger::FittedFinger;
use crate::uncertain::Uncertain;

/// Shortest and longest stretch for a reading, s.
const SHORTEST_S: f64 = 0.1;
const LONGEST_S: f64 = 10.0;
/// Time after the last sample under a finger before the plate counts as free, s: a burst of the force sensor may be late.
const LIFTED_S: f64 = 0.06;
/// Innovations beyond this many standard deviations are not attributed to drift of the plate.
const GATE: f64 = 4.0;

/// Expected drift of the plate, and its modulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateTracking {
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Random walk of the resonance, Hz/√s. Default 1: with a crest every sixth of a second, the tracker then follows the
    /// steepest drift expected, 4 Hz/s under a warm finger, within one hertz (an assumption of this project).
    pub drift_hz_per_sqrt_s: f64,
    /// Random walk of the damping Re Z_p, N·s/m/√s. Default 0.005, for readings only while no finger is on the plate: warming
    /// the glue by some kelvin changes it by as many per mille of 7 N·s/m (an assumption of this project).
    pub damping_n_s_per_m_per_sqrt_s: f64,
    /// Frequency of the drive's modulation, Hz; 0 without one.
    pub modulation_hz: f64,
}

impl PlateTracking {
    /// Returns the tracking of a plate with the default drift.
    pub fn new(modal_mass_kg: f64, modulation_hz: f64) -> Self {
        Self {
            modal_mass_kg,
            drift_hz_per_sqrt_s: 1.0,
            damping_n_s_per_m_per_sqrt_s: 0.005,
            modulation_hz,
        }
    }

    /// Returns the length of a reading, s, in whole periods of the modulation.
    fn span_s(&self) -> f64 {
        if self.modulation_hz <= 0.0 {
            return SHORTEST_S;
        }
        let periods = (SHORTEST_S * self.modulation_hz).ceil();
        (periods / self.modulation_hz).min(LONGEST_S)
    }
}

/// Tracker of the plate's resonance; does not allocate.
#[derive(Debug, Clone)]
pub struct PlateTracker {
    tracking: PlateTracking,
    plate: Option<Tracked>,
    free: FreeReading,
    crest: CrestReading,
    gap: FollowedGap,
    contact_s: f64,
}

/// Current estimate of the plate.
#[derive(Debug, Clone, Copy)]
struct Tracked {
    /// Im Z_p as first read, N·s/m.
    first: f64,
    reactance: Walk,
    resistance: Walk,
}

/// State of a scalar Kalman filter of a random walk.
#[derive(Debug, Clone, Copy)]
struct Walk {
    value: f64,
    variance: f64,
    at_s: f64,
}

impl PlateTracker {
    /// Makes a tracker without readings.
    ///
    /// # Errors
    /// If the modal mass is not positive, or a drift or frequency negative.
    pub fn new(tracking: PlateTracking) -> Result<Self, ModelError> {
        positive("modal mass", "kg", tracking.modal_mass_kg)?;
        not_negative("drift", "Hz/√s", tracking.drift_hz_per_sqrt_s)?;
        let damping = tracking.damping_n_s_per_m_per_sqrt_s;
        not_negative("drift of the damping", "N·s/m/√s", damping)?;
        not_negative("modulation frequency", "Hz", tracking.modulation_hz)?;
        Ok(Self {
            tracking,
            plate: None,
            free: FreeReading::default(),
            crest: CrestReading::default(),
            gap: FollowedGap::default(),
            contact_s: f64::NEG_INFINITY,
        })
    }

    /// Changes the modulation frequency.
    pub fn modulate(&mut self, modulation_hz: f64) {
        if modulation_hz >= 0.0 && modulation_hz != self.tracking.modulation_hz {
            self.tracking.modulation_hz = modulation_hz;
            self.interrupt();
        }
    }

    /// Changes to a carrier that is higher by `shift_hz`: Im Z_p grows by 4π m_p times that, and drift is counted from the first
    /// resonance plus `shift_hz`.
    pub fn retune(&mut self, shift_hz: f64) {
        if let Some(plate) = &mut self.plate {
            plate.reactance.value += self.tracking.n_s_per_m_and_hz() * shift_hz;
        }
        self.interrupt();
    }

    /// Discards the reading in progress; call it when it is unknown whether a finger is on the plate.
    pub fn interrupt(&mut self) {
        self.free = FreeReading::default();
        self.crest.restart();
        self.gap = FollowedGap::default();
    }

    /// Takes a sample of the plate without a finger.
    pub fn take_free(&mut self, sample: &PlateSample) {
        self.gap = FollowedGap::default();
        self.crest = CrestReading::default();
        if (0.0..LIFTED_S).contains(&(sample.time_s - self.contact_s)) {
            return;
        }
        let span_s = self.tracking.span_s();
        if let Some(reading) = self.free.take(sample, span_s) {
            self.learn(&reading);
        }
    }

    /// Takes a sample of the plate under a finger with the parameters `finger`. It does not update a plate that has never been
    /// read without a finger.
    pub fn take_loaded(&mut self, sample: &PlateSample, finger: &FittedFinger, load: &FingerLoad) {
        self.touch(sample.time_s);
        if self.plate.is_none() {
            return;
        }
        let Some(gap_m) = self.gap.follow(sample.time_s, finger, load) else {
            return;
        };
        let span_s = self.tracking.span_s();
        if let Some(reading) = self.crest.take(sample, (finger, load, gap_m), span_s) {
            self.learn(&reading);
        }
    }

    /// Registers a finger with unknown parameters.
    pub fn touch(&mut self, time_s: f64) {
        self.contact_s = time_s;
        self.free = FreeReading::default();
    }

    fn learn(&mut self, reading: &PlateReading) {
        let at_s = reading.time_s;
        let reactance = Walk {
            value: reading.reactance,
            variance: reading.variance,
            at_s,
        };
        let resistance = reading.resistance.map(|(value, variance)| Walk {
            value,
            variance,
            at_s,
        });
        let Some(plate) = &mut self.plate else {
            self.plate = resistance.map(|resistance| Tracked {
                first: reading.reactance,
                reactance,
                resistance,
            });
            return;
        };
        // A reading rejected for the resonance is rejected for the damping too.
        if plate
            .reactance
            .learn(&reactance, self.tracking.reactance_rate())
            && let Some(resistance) = resistance
        {
            let rate = self.tracking.damping_n_s_per_m_per_sqrt_s;
            plate.resistance.learn(&resistance, rate);
        }
    }

    /// Returns Im Z_p at a time, N·s/m; `None` before the first reading.
    pub fn reactance_n_s_per_m(&self, time_s: f64) -> Option<Uncertain> {
        let rate = self.tracking.reactance_rate();
        Some(self.plate?.reactance.value_at(time_s, rate))
    }

    /// Returns Re Z_p at a time, N·s/m, from readings without a finger; `None` before the first one.
    pub fn resistance_n_s_per_m(&self, time_s: f64) -> Option<Uncertain> {
        let rate = self.tracking.damping_n_s_per_m_per_sqrt_s;
        Some(self.plate?.resistance.value_at(time_s, rate))
    }

    /// Returns the shift of the resonance since the first reading, Hz, positive upwards.
    pub fn drift_hz(&self, time_s: f64) -> Option<Uncertain> {
        let (first, reactance) = (self.plate?.first, self.reactance_n_s_per_m(time_s)?);
        let per_hz = self.tracking.n_s_per_m_and_hz();
        Some(Uncertain {
            value: (first - reactance.value) / per_hz,
            std: reactance.std / per_hz,
        })
    }
}

impl PlateTracking {
    /// Returns 4π m_p, the decrease of Im Z_p per hertz of resonance shift, N·s/m.
    fn n_s_per_m_and_hz(&self) -> f64 {
        4.0 * PI * self.modal_mass_kg
    }

    /// Returns the random walk of Im Z_p, N·s/m/√s.
    fn reactance_rate(&self) -> f64 {
        self.drift_hz_per_sqrt_s * self.n_s_per_m_and_hz()
    }
}

impl Walk {
    /// Updates a random walk of this rate per √s with a reading; returns false if the reading is too far away.
    fn learn(&mut self, reading: &Self, rate: f64) -> bool {
        let predicted = self.variance_at(reading.at_s, rate);
        let expected = reading.variance + predicted;
        let innovation = reading.value - self.value;
        if innovation.powi(2) > GATE.powi(2) * expected {
            return false;
        }
        let gain = predicted / expected;
        *self = Self {
            value: self.value + gain * innovation,
            variance: (1.0 - gain) * predicted,
            at_s: reading.at_s,
        };
        true
    }

    fn variance_at(&self, time_s: f64, rate: f64) -> f64 {
        self.variance + rate.powi(2) * (time_s - self.at_s).max(0.0)
    }

    fn value_at(&self, time_s: f64, rate: f64) -> Uncertain {
        Uncertain {
            value: self.value,
            std: self.variance_at(time_s, rate).sqrt(),
        }
    }
}
