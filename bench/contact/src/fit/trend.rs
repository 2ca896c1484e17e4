//! Slow change within an instance: a skin that grows moist, a plate that grows warm.

use num_complex::Complex64;

use crate::contact::Contact;
use crate::inversion::Inversion;

/// Rates of an instance's own parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Rates {
    /// Rate of ln σ_t, 1/s.
    pub(super) ln_sigma_t_per_s: f64,
    /// Rate of Z_t, N·s/m a second.
    pub(super) z_t_per_s: Complex64,
    /// Rate of Z_p, N·s/m a second.
    pub(super) z_p_per_s: Complex64,
    /// Rate of the angle by which the finger's part is turned, rad/s.
    pub(super) finger_angle_rad_per_s: f64,
}

/// Where the parameters of an instance, which hold at its middle, are at each sample.
pub(super) struct Trend {
    /// Time since the middle of the instance, s.
    elapsed_s: Vec<f64>,
    pub(super) rates: Rates,
}

impl Trend {
    /// Makes the trend of an instance that begins after `lead` samples and does not change.
    pub(super) fn new(time_s: &[f64], lead: usize) -> Self {
        let middle_s = 0.5 * (time_s[lead] + time_s[time_s.len() - 1]);
        Self {
            elapsed_s: time_s.iter().map(|time_s| time_s - middle_s).collect(),
            rates: Rates::default(),
        }
    }

    /// Returns the contact at a sample.
    pub(super) fn contact(&self, contact: &Contact, at: usize) -> Contact {
        if self.rates.ln_sigma_t_per_s == 0.0 {
            return *contact;
        }
        contact.with_sigma_ratio((self.rates.ln_sigma_t_per_s * self.elapsed_s[at]).exp())
    }

    /// Returns Z_t at a sample.
    pub(super) fn z_t(&self, z_t: Complex64, at: usize) -> Complex64 {
        z_t + self.rates.z_t_per_s * self.elapsed_s[at]
    }

    /// Returns Z_p at a sample.
    pub(super) fn z_p(&self, z_p: Complex64, at: usize) -> Complex64 {
        z_p + self.rates.z_p_per_s * self.elapsed_s[at]
    }

    /// Returns the finger's part of Z_m as it is measured, over what it is, at a sample.
    pub(super) fn finger_scale(&self, scale: Complex64, at: usize) -> Complex64 {
        scale * Complex64::cis(self.rates.finger_angle_rad_per_s * self.elapsed_s[at])
    }

    /// Returns the inversion at a sample.
    pub(super) fn inversion<const N: usize>(
        &self,
        inversion: &Inversion<N>,
        at: usize,
    ) -> Inversion<N> {
        Inversion {
            contact: self.contact(&inversion.contact, at),
            z_t: self.z_t(inversion.z_t, at),
            z_p: self.z_p(inversion.z_p, at),
            finger_scale: self.finger_scale(inversion.finger_scale, at),
            ..*inversion
        }
    }
}
