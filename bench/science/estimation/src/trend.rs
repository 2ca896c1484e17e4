//! Slow change within an instance, for example of the skin's moisture or the plate's temperature.

use std::ops::{AddAssign, Mul};

use num_complex::Complex64;

use contact::Contact;
use contact::inversion::Inversion;

/// Fewest instances of an exploration that determine a trend.
const MIN_INSTANCES: usize = 3;
/// Largest interval between instances of the same exploration, s.
pub(super) const NEIGHBOURS_S: f64 = 0.7;

/// Returns the rate of change about an instance, 1/s: the regression of `values` on the middle times of all instances of the
/// same exploration. Returns zero where those are too few.
pub(super) fn rate_about<T>(index: usize, times_s: &[f64], values: impl Fn(usize) -> T) -> T
where
    T: Default + AddAssign + Mul<f64, Output = T>,
{
    let is_pause = |pair: &[f64]| pair[1] - pair[0] > NEIGHBOURS_S;
    let pause_before = times_s[..=index].windows(2).rposition(is_pause);
    let pause_after = times_s[index..].windows(2).position(is_pause);
    let begin = pause_before.map_or(0, |last| last + 1);
    let end = pause_after.map_or(times_s.len(), |last| index + last + 1);
    let neighbours_s = &times_s[begin..end];
    // Least-squares slope Σ (t − t̄) v/Σ (t − t̄)².
    let mean_s = neighbours_s.iter().sum::<f64>() / neighbours_s.len() as f64;
    let spread: f64 = neighbours_s
        .iter()
        .map(|time_s| (time_s - mean_s).powi(2))
        .sum();
    let mut per_s = T::default();
    if neighbours_s.len() >= MIN_INSTANCES && spread > 0.0 {
        for (k, time_s) in (begin..end).zip(neighbours_s) {
            per_s += values(k) * ((time_s - mean_s) / spread);
        }
    }
    per_s
}

/// Rates of change of the instance's parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Rates {
    /// Rate of ln σ_t, 1/s.
    pub(super) ln_sigma_t_per_s: f64,
    /// Rate of Z_t, N·s/m per second.
    pub(super) z_t_per_s: Complex64,
    /// Rate of Z_p, N·s/m per second.
    pub(super) z_p_per_s: Complex64,
    /// Rate of the phase rotation of the finger's part, rad/s.
    pub(super) finger_angle_rad_per_s: f64,
}

/// Parameters of an instance at each sample, extrapolated from its middle.
pub(super) struct Trend {
    /// Time since the middle of the instance, s.
    elapsed_s: Vec<f64>,
    rates: Rates,
    /// σ_t at each sample relative to its value at the middle.
    sigma_ratio: Vec<f64>,
    /// Factor that rotates the finger's part of Z_m at each sample.
    rotation: Vec<Complex64>,
}

impl Trend {
    /// Makes a constant trend for an instance that begins after `lead` samples.
    pub(super) fn new(time_s: &[f64], lead: usize) -> Self {
        let middle_s = 0.5 * (time_s[lead] + time_s[time_s.len() - 1]);
        Self {
            elapsed_s: time_s.iter().map(|time_s| time_s - middle_s).collect(),
            rates: Rates::default(),
            sigma_ratio: vec![1.0; time_s.len()],
            rotation: vec![Complex64::ONE; time_s.len()],
        }
    }

    /// Returns the rates.
    pub(super) fn rates(&self) -> Rates {
        self.rates
    }

    /// Changes the rates.
    pub(super) fn follow(&mut self, rates: Rates) {
        self.rates = rates;
        let samples = self.sigma_ratio.iter_mut().zip(&mut self.rotation);
        for ((sigma_ratio, rotation), elapsed_s) in samples.zip(&self.elapsed_s) {
            *sigma_ratio = (rates.ln_sigma_t_per_s * elapsed_s).exp();
            *rotation = Complex64::cis(rates.finger_angle_rad_per_s * elapsed_s);
        }
    }

    /// Returns σ_t at a sample relative to its value at the middle.
    pub(super) fn sigma_ratio(&self, sample: usize) -> f64 {
        self.sigma_ratio[sample]
    }

    /// Returns the contact at a sample.
    pub(super) fn contact(&self, contact: &Contact, sample: usize) -> Contact {
        contact.with_sigma_ratio(self.sigma_ratio[sample])
    }

    /// Returns Z_t at a sample.
    pub(super) fn z_t(&self, z_t: Complex64, sample: usize) -> Complex64 {
        z_t + self.rates.z_t_per_s * self.elapsed_s[sample]
    }

    /// Returns Z_p at a sample.
    pub(super) fn z_p(&self, z_p: Complex64, sample: usize) -> Complex64 {
        z_p + self.rates.z_p_per_s * self.elapsed_s[sample]
    }

    /// Returns the ratio of the measured to the true finger part of Z_m at a sample.
    pub(super) fn finger_scale(&self, scale: Complex64, sample: usize) -> Complex64 {
        scale * self.rotation[sample]
    }

    /// Returns the inversion at a sample.
    pub(super) fn inversion<const N: usize>(
        &self,
        inversion: &Inversion<N>,
        sample: usize,
    ) -> Inversion<N> {
        Inversion {
            contact: self.contact(&inversion.contact, sample),
            z_t: self.z_t(inversion.z_t, sample),
            z_p: self.z_p(inversion.z_p, sample),
            finger_scale: self.finger_scale(inversion.finger_scale, sample),
            ..*inversion
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_rate_is_that_of_one_exploration() {
        let times_s = [0.0, 0.2, 0.4, 5.0, 5.2, 9.0, 9.1, 9.3];
        let values = [1.0, 1.4, 1.8, 7.0, 3.0, 2.0, 1.9, 1.7];
        let rate = |index| rate_about(index, &times_s, |k| values[k]);
        for (index, expected) in [2.0, 2.0, 2.0, 0.0, 0.0, -1.0, -1.0, -1.0]
            .into_iter()
            .enumerate()
        {
            assert_relative_eq!(rate(index), expected, epsilon = 1e-12);
        }
    }
}
