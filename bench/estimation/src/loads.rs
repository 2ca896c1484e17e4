//! The contact area and the amplitude that the film answers to, sample by sample.
//!
//! The area of contact grows with the normal force as S (f_n/f̄)^ν; for finger pads ν is 0.3 to 0.6, less than Hertz's 2/3
//! (Adams et al. 2013). The film answers to the squared amplitude as it was a moment ago: its pressure needs some cycles of the
//! carrier to build up. Both are 0 for the published model.

use first_order_lag::Lag;

use contact::Contact;
use contact::inversion::Inversion;
use contact::parameters::LoadSlopes;

/// The amplitude that the film answers to and the area of contact, at each sample.
pub(super) struct Loads {
    measured_m: Vec<f64>,
    squared_m2: Vec<f64>,
    answered_m2: Vec<f64>,
    by_mean_m2: Vec<f64>,
    /// Amplitude that the film answers to, m.
    pub(super) amplitude_m: Vec<f64>,
    /// Area of contact over that at the reference force.
    pub(super) area_ratio: Vec<f64>,
    pub(super) slopes: Vec<LoadSlopes>,
}

impl Loads {
    /// Takes the samples of an instance; the area is that of `reference_n` where the normal force is.
    pub(super) fn new(amplitude_m: &[f64], normal_n: &[f64], reference_n: f64) -> Self {
        let n = amplitude_m.len();
        let ln_area_by_exponent = |&normal_n: &f64| (normal_n / reference_n).ln();
        Self {
            measured_m: amplitude_m.to_vec(),
            squared_m2: amplitude_m.iter().map(|a| a * a).collect(),
            answered_m2: vec![0.0; n],
            by_mean_m2: vec![0.0; n],
            amplitude_m: amplitude_m.to_vec(),
            area_ratio: vec![1.0; n],
            slopes: normal_n
                .iter()
                .map(|of| LoadSlopes {
                    ln_area_by_exponent: ln_area_by_exponent(of),
                    ln_film_by_mean_ms: 0.0,
                    ln_film_by_mobility: 0.0,
                })
                .collect(),
        }
    }

    /// Follows the parameters; `None` where the film would answer to no amplitude.
    pub(super) fn follow(
        &mut self,
        area_exponent: f64,
        (ln_ratio, mobility): (f64, f64),
        film_mean_intervals: f64,
        intervals_per_ms: f64,
    ) -> Option<()> {
        let mean = Lag::new(film_mean_intervals, 1.0);
        if film_mean_intervals == 0.0 {
            self.answered_m2.copy_from_slice(&self.squared_m2);
            self.amplitude_m.copy_from_slice(&self.measured_m);
        } else {
            mean.apply(&self.squared_m2, &mut self.answered_m2);
        }
        mean.slope(&self.squared_m2, &self.answered_m2, &mut self.by_mean_m2);
        for (at, &answered_m2) in self.answered_m2.iter().enumerate() {
            if answered_m2 <= 0.0 && self.squared_m2[at] > 0.0 {
                return None;
            }
            let slopes = &mut self.slopes[at];
            if answered_m2 > 0.0 {
                slopes.ln_film_by_mean_ms = self.by_mean_m2[at] * intervals_per_ms / answered_m2;
            }
            if film_mean_intervals != 0.0 {
                self.amplitude_m[at] = answered_m2.sqrt();
            }
            let ln_moved = ln_ratio + 0.5 * mobility * slopes.ln_film_by_mobility;
            if ln_moved != 0.0 {
                self.amplitude_m[at] *= ln_moved.exp();
            }
            self.area_ratio[at] = if area_exponent == 0.0 {
                1.0
            } else {
                (area_exponent * slopes.ln_area_by_exponent).exp()
            };
        }
        Some(())
    }

    /// Returns the inversion under the load of a sample.
    pub(super) fn inversion<const N: usize>(
        &self,
        inversion: &Inversion<N>,
        at: usize,
    ) -> Inversion<N> {
        Inversion {
            contact: self.contact(&inversion.contact, at),
            load: self.slopes[at],
            ..*inversion
        }
    }

    /// Returns the contact under the load of a sample.
    pub(super) fn contact(&self, contact: &Contact, at: usize) -> Contact {
        contact.with_area_ratio(self.area_ratio[at])
    }
}
