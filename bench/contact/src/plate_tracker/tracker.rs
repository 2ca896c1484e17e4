use std::f64::consts::PI;

use super::followed_gap::FollowedGap;
use super::reading::{CrestReading, FreeReading, PlateReading};
use super::sample::{FingerLoad, PlateSample};
use crate::error::{ModelError, not_negative, positive};
use crate::finger::FittedFinger;
use crate::uncertain::Uncertain;

/// Shortest and longest stretch that a reading is made of, s.
const SHORTEST_S: f64 = 0.1;
const LONGEST_S: f64 = 10.0;
/// Time after the last sample under a finger before the plate counts as free, s: a force sensor's burst may come late.
const LIFTED_S: f64 = 0.06;
/// Innovations beyond this many standard deviations are no drift of the plate.
const GATE: f64 = 4.0;

/// How the plate is expected to move, and what a reading spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateTracking {
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Random walk of the resonance, Hz/√s. Default 1: a crest every sixth of a second then follows the steepest drift
    /// that is to be expected, 4 Hz/s under a warm finger, within a hertz (an assumption of this project).
    pub drift_hz_per_sqrt_s: f64,
    /// Random walk of the damping Re Z_p, N·s/m/√s. Default 0.005, read only while no finger is on the plate: a glue
    /// that warms by some kelvin changes it by as many per mille of 7 N·s/m (an assumption of this project).
    pub damping_n_s_per_m_per_sqrt_s: f64,
    /// Frequency of the drive's modulation, Hz; 0 without one.
    pub modulation_hz: f64,
}

impl PlateTracking {
    /// Returns the tracking of a plate with the default drift.
    pub fn of(modal_mass_kg: f64, modulation_hz: f64) -> Self {
        Self {
            modal_mass_kg,
            drift_hz_per_sqrt_s: 1.0,
            damping_n_s_per_m_per_sqrt_s: 0.005,
            modulation_hz,
        }
    }

    /// Returns the length of a reading, s: whole periods of the modulation.
    fn span_s(&self) -> f64 {
        if self.modulation_hz <= 0.0 {
            return SHORTEST_S;
        }
        let periods = (SHORTEST_S * self.modulation_hz).ceil();
        (periods / self.modulation_hz).min(LONGEST_S)
    }
}

/// Tracker of the plate's resonance; allocates nothing.
#[derive(Debug, Clone)]
pub struct PlateTracker {
    tracking: PlateTracking,
    plate: Option<Tracked>,
    free: FreeReading,
    crest: CrestReading,
    gap: FollowedGap,
    touched_s: f64,
}

/// The plate as it is known.
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
    /// Makes a tracker that has not seen the plate.
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
            touched_s: f64::NEG_INFINITY,
        })
    }

    /// Goes on under a drive of another modulation.
    pub fn modulate(&mut self, modulation_hz: f64) {
        if modulation_hz >= 0.0 && modulation_hz != self.tracking.modulation_hz {
            self.tracking.modulation_hz = modulation_hz;
            self.interrupt();
        }
    }

    /// Goes on at a carrier that is higher by `by_hz`: Im Z_p grows by 4π m_p times that, and what is called drift is
    /// counted from the resonance that fits the new carrier as the first one fitted the old.
    pub fn retune(&mut self, by_hz: f64) {
        if let Some(plate) = &mut self.plate {
            plate.reactance.value += self.tracking.n_s_per_m_and_hz() * by_hz;
        }
        self.interrupt();
    }

    /// Forgets the reading that is being made: to be called when it is not known whether a finger is on the plate.
    pub fn interrupt(&mut self) {
        self.free = FreeReading::default();
        self.crest.restart();
        self.gap = FollowedGap::default();
    }

    /// Takes a sample of the plate without a finger.
    pub fn take_free(&mut self, sample: &PlateSample) {
        self.gap = FollowedGap::default();
        self.crest = CrestReading::default();
        if (0.0..LIFTED_S).contains(&(sample.time_s - self.touched_s)) {
            return;
        }
        let span_s = self.tracking.span_s();
        if let Some(reading) = self.free.take(sample, span_s) {
            self.learn(&reading);
        }
    }

    /// Takes a sample of the plate under a finger whose parameters are `finger`. Nothing is learnt of a plate that was
    /// never seen without a finger.
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

    /// Takes notice of a finger of which nothing is known.
    pub fn touch(&mut self, time_s: f64) {
        self.touched_s = time_s;
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
        // A reading that is none of the plate's resonance is none of its damping either.
        if plate
            .reactance
            .learn(&reactance, self.tracking.reactance_rate())
            && let Some(resistance) = resistance
        {
            let rate = self.tracking.damping_n_s_per_m_per_sqrt_s;
            plate.resistance.learn(&resistance, rate);
        }
    }

    /// Returns Im Z_p at a time, N·s/m; `None` before the plate was seen.
    pub fn reactance_n_s_per_m(&self, time_s: f64) -> Option<Uncertain> {
        let rate = self.tracking.reactance_rate();
        Some(self.plate?.reactance.at(time_s, rate))
    }

    /// Returns Re Z_p at a time, N·s/m, from when no finger was on the plate; `None` before the plate was seen.
    pub fn resistance_n_s_per_m(&self, time_s: f64) -> Option<Uncertain> {
        let rate = self.tracking.damping_n_s_per_m_per_sqrt_s;
        Some(self.plate?.resistance.at(time_s, rate))
    }

    /// Returns how far the resonance is from where it was when the plate was first seen, Hz, up positive.
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
    /// Returns 4π m_p: what a hertz of the resonance takes from Im Z_p, N·s/m.
    fn n_s_per_m_and_hz(&self) -> f64 {
        4.0 * PI * self.modal_mass_kg
    }

    /// Returns the random walk of Im Z_p, N·s/m/√s.
    fn reactance_rate(&self) -> f64 {
        self.drift_hz_per_sqrt_s * self.n_s_per_m_and_hz()
    }
}

impl Walk {
    /// Takes a reading of what walks at this rate per √s; false if it is too far away to be one.
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

    fn at(&self, time_s: f64, rate: f64) -> Uncertain {
        Uncertain {
            value: self.value,
            std: self.variance_at(time_s, rate).sqrt(),
        }
    }
}
