//! Readings of Im Z_p: one from each period of the modulation.

use nalgebra::SVector;
use num_complex::Complex64;

use super::sample::{FingerLoad, PlateSample};
use crate::assumed::AssumedConstants;
use crate::contact::Contact;
use crate::finger::FittedFinger;
use crate::harmonic::observed;
use crate::inversion::Dependent;
use crate::parameters::{IM_Z_T, LN_AREA, LN_LOSS_FACTOR, LN_Q0, LN_SIGMA_T, PARAMETERS, RE_Z_T};

/// Fewest samples of a reading.
const FEWEST: u32 = 8;
/// Samples near the crest have a finger impedance of at most this many times the minimum of the previous period.
const NEAR_CREST: f64 = 1.3;
/// Relative change of σ_t and of |Z_t| within a stroke that the fit does not include, due to moisture (an assumption of this
/// project).
const MOISTURE: f64 = 0.1;
/// Error of the normal force at a sample, N and relative: the sensor's noise after averaging over half a millisecond, and the
/// error of its gain (an assumption of this project).
const FORCE_STD_N: f64 = 0.01;
const FORCE_GAIN_STD: f64 = 0.02;
/// Error of every reading, N·s/m: 0.05 Hz at 8 g.
const FLOOR: f64 = 0.005;
/// Factor on the variance of a mean, because neighbouring frames share noise.
const SHARED_NOISE: f64 = 4.0;
/// Largest fraction of the finger's own modulation that the model may leave unexplained; without a finger all of it is
/// unexplained.
const UNEXPLAINED: f64 = 0.25;

/// A reading of the plate.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlateReading {
    pub(super) time_s: f64,
    /// Im Z_p, N·s/m.
    pub(super) reactance: f64,
    /// Variance of the reactance, (N·s/m)².
    pub(super) variance: f64,
    /// Re Z_p, N·s/m, and its variance; `None` under a finger, where it cannot be separated from the finger's own losses.
    pub(super) resistance: Option<(f64, f64)>,
}

/// Weighted sums of a complex quantity.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: u32,
    weight: f64,
    mean: Complex64,
    /// Σ weight |value − mean|², in real and imaginary part.
    squares: (f64, f64),
}

impl Sums {
    fn add(&mut self, value: Complex64, weight: f64) {
        self.count += 1;
        self.weight += weight;
        // m_n = m_(n−1) + (w/W)(z − m_(n−1)) and Q_n = Q_(n−1) + w (z − m_(n−1))(z − m_n) (West 1979).
        let prior = value - self.mean;
        self.mean += prior * (weight / self.weight);
        let posterior = value - self.mean;
        self.squares.0 += weight * prior.re * posterior.re;
        self.squares.1 += weight * prior.im * posterior.im;
    }

    /// Returns the variances of the mean's real and imaginary part: noise, plus all of the scatter, because noise alone
    /// does not explain it. With weights w of 1/variance, W = Σw and Q = Σw (z − m)² these are 4/W, as if four neighbours
    /// shared their noise, and the samples' own variance Q/W.
    fn variances(&self) -> (f64, f64) {
        let variance = |squares: f64| (SHARED_NOISE + squares) / self.weight + FLOOR * FLOOR;
        (variance(self.squares.0), variance(self.squares.1))
    }

    fn power(&self) -> f64 {
        (self.squares.0 + self.squares.1) / self.weight
    }
}

/// Returns the weight of a sample from its noise; `None` if the noise is unknown.
fn weight(sample: &PlateSample) -> Option<f64> {
    let std = sample.z_m_std_n_s_per_m;
    let known = std.is_finite() && sample.z_m_corrected_n_s_per_m.is_finite();
    // Without noise, as in synthetic records, all samples have the same weight.
    known.then(|| (std * std + FLOOR * FLOOR).recip())
}

/// Reading in progress of a plate without a finger.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FreeReading {
    since_s: Option<f64>,
    sums: Sums,
}

impl FreeReading {
    pub(super) fn take(&mut self, sample: &PlateSample, span_s: f64) -> Option<PlateReading> {
        let weight = weight(sample)?;
        let since_s = *self.since_s.get_or_insert(sample.time_s);
        let elapsed_s = sample.time_s - since_s;
        if !(0.0..2.0 * span_s).contains(&elapsed_s) {
            *self = Self::default();
            return None;
        }
        self.sums.add(sample.z_m_corrected_n_s_per_m, weight);
        if elapsed_s < span_s {
            return None;
        }
        let sums = std::mem::take(self).sums;
        let (resistance_variance, variance) = sums.variances();
        (sums.count >= FEWEST).then(|| PlateReading {
            time_s: since_s + elapsed_s / 2.0,
            reactance: sums.mean.im,
            variance,
            resistance: Some((sums.mean.re, resistance_variance)),
        })
    }
}

/// Reading in progress of a plate at the crest of the modulation under a finger.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CrestReading {
    /// Smallest impedance of the finger in the previous period, N·s/m.
    least_before: Option<f64>,
    period: Period,
}

#[derive(Debug, Clone, Copy)]
struct Period {
    since_s: Option<f64>,
    least: f64,
    /// Residuals and modelled finger over the whole period.
    residuals: Sums,
    finger: Sums,
    /// Residuals near the crest.
    crest: Sums,
    time_s: f64,
    by_parameter: SVector<f64, PARAMETERS>,
    by_force: f64,
}

impl Default for Period {
    fn default() -> Self {
        Self {
            since_s: None,
            least: f64::INFINITY,
            residuals: Sums::default(),
            finger: Sums::default(),
            crest: Sums::default(),
            time_s: 0.0,
            by_parameter: SVector::zeros(),
            by_force: 0.0,
        }
    }
}

impl CrestReading {
    /// Discards the period in progress.
    pub(super) fn restart(&mut self) {
        self.period = Period::default();
    }

    /// Adds a sample under a finger with the given modelled gap.
    pub(super) fn take(
        &mut self,
        sample: &PlateSample,
        (finger, load, gap_m): (&FittedFinger, &FingerLoad, f64),
        span_s: f64,
    ) -> Option<PlateReading> {
        let weight = weight(sample)?;
        let period = &mut self.period;
        let since_s = *period.since_s.get_or_insert(sample.time_s);
        let elapsed_s = sample.time_s - since_s;
        if !(0.0..2.0 * span_s).contains(&elapsed_s) {
            *self = Self::default();
            return None;
        }
        // Z_m = Z_p + φ² Z_F: the mode moves the finger with φ ṽ_p, and the finger's force acts on it with φ f̃_c.
        let modelled = FingerModel::new(finger).impedance_at(gap_m, load.amplitude_m);
        let share = load.amplitude_ratio.powi(2);
        let residual = sample.z_m_corrected_n_s_per_m - modelled * share;
        if !residual.is_finite() {
            return None;
        }
        period.least = period.least.min(modelled.norm());
        period.residuals.add(residual, 1.0);
        period.finger.add(modelled * share, 1.0);
        let near = self
            .least_before
            .is_some_and(|least| modelled.norm() <= NEAR_CREST * least);
        if near && let Some((by_parameter, by_force)) = slopes(finger, load) {
            period.crest.add(residual, weight);
            let part = weight / period.crest.weight;
            period.time_s += part * (sample.time_s - period.time_s);
            // Weighted means of the samples' derivatives: the parameters' errors are common to the samples of a crest.
            period.by_parameter += (by_parameter * share - period.by_parameter) * part;
            period.by_force += (by_force * share - period.by_force) * part;
        }
        if elapsed_s < span_s {
            return None;
        }
        let period = std::mem::take(period);
        self.least_before = Some(period.least);
        period.reading(finger)
    }
}

impl Period {
    fn reading(&self, finger: &FittedFinger) -> Option<PlateReading> {
        let is_explained = self.residuals.power() <= UNEXPLAINED * self.finger.power();
        if self.crest.count < FEWEST || !is_explained {
            return None;
        }
        let inversion = &finger.inversion;
        let known = inversion.covariance.map_or(0.0, |_| {
            let by_finger = Dependent {
                value: 0.0,
                slopes: self.by_parameter,
                noise: 0.0,
            };
            inversion.std(&by_finger).powi(2)
        });
        // σ² = g_σ² δ² + |Z_t|² (g_re² + g_im²) δ² with δ the relative change, g the derivatives by ln σ_t, Re Z_t and Im Z_t.
        let slopes = &self.by_parameter;
        let z_t = MOISTURE * finger.z_t_n_s_per_m().norm();
        let moisture = (MOISTURE * slopes[LN_SIGMA_T]).powi(2)
            + (z_t * slopes[RE_Z_T]).powi(2)
            + (z_t * slopes[IM_Z_T]).powi(2);
        Some(PlateReading {
            time_s: self.time_s,
            reactance: self.crest.mean.im,
            variance: self.crest.variances().1 + known + moisture + self.by_force.powi(2),
            resistance: None,
        })
    }
}

/// Parameters of a finger that determine its impedance.
#[derive(Clone, Copy)]
struct FingerModel {
    contact: Contact,
    z_t: Complex64,
    scale: Complex64,
    carrier_rad_per_s: f64,
}

impl FingerModel {
    fn new(finger: &FittedFinger) -> Self {
        Self {
            contact: *finger.contact(),
            z_t: finger.z_t_n_s_per_m(),
            scale: finger.inversion.finger_scale,
            carrier_rad_per_s: finger.inversion.carrier_rad_per_s,
        }
    }

    /// Returns the finger's contribution to Z_p, N·s/m.
    fn impedance_at(&self, gap_m: f64, amplitude_m: f64) -> Complex64 {
        let k_c = self.contact.stiffness_n_per_m(gap_m, amplitude_m);
        let z_c = self
            .contact
            .impedance_n_s_per_m(k_c, self.carrier_rad_per_s);
        self.scale * observed(Complex64::ZERO, self.z_t, z_c)
    }

    /// Returns the finger's contribution to Im Z_p in equilibrium, N·s/m.
    fn reactance(&self, amplitude_m: f64, normal_n: f64) -> Option<f64> {
        let gap_m = self.contact.equilibrium_gap_m(amplitude_m, normal_n).ok()?;
        Some(self.impedance_at(gap_m, amplitude_m).im)
    }

    /// Returns the finger with one parameter increased by `step`.
    fn displaced(mut self, parameter: usize, step: f64) -> Option<Self> {
        let mut skin: AssumedConstants = *self.contact.assumed();
        let mut sigma_t_m = self.contact.sigma_t_m();
        match parameter {
            LN_SIGMA_T => sigma_t_m *= step.exp(),
            LN_AREA => skin.contact_area_m2 *= step.exp(),
            LN_Q0 => skin.q0_rad_per_m *= step.exp(),
            LN_LOSS_FACTOR => skin.loss_factor *= step.exp(),
            RE_Z_T => self.z_t.re += step,
            IM_Z_T => self.z_t.im += step,
            _ => {}
        }
        self.contact = Contact::new(&skin, sigma_t_m).ok()?;
        Some(self)
    }
}

/// Step of the differences, relative to 1, 1 N·s/m and the force.
const STEP: f64 = 1e-4;

/// Returns the derivatives of a finger's contribution to Im Z_p by its parameters, and its standard error from the normal
/// force.
fn slopes(finger: &FittedFinger, load: &FingerLoad) -> Option<(SVector<f64, PARAMETERS>, f64)> {
    let model = FingerModel::new(finger);
    let (amplitude_m, normal_n) = (load.amplitude_m, load.normal_n);
    // Forward differences, at the equilibrium gap instead of the lagging one.
    let reactance = model.reactance(amplitude_m, normal_n)?;
    let mut by_parameter = SVector::zeros();
    for parameter in [LN_SIGMA_T, RE_Z_T, IM_Z_T, LN_AREA, LN_Q0, LN_LOSS_FACTOR] {
        let displaced_reactance = model
            .displaced(parameter, STEP)?
            .reactance(amplitude_m, normal_n)?;
        by_parameter[parameter] = (displaced_reactance - reactance) / STEP;
    }
    let loaded_reactance = model.reactance(amplitude_m, normal_n * (1.0 + STEP))?;
    let by_ln_force = (loaded_reactance - reactance) / STEP;
    let force = FORCE_GAIN_STD.hypot(FORCE_STD_N / normal_n);
    Some((by_parameter, by_ln_force * force))
}
