//! Samples of one instance, as the fits read them.

use num_complex::Complex64;

use super::fit_error::FitError;
use contact::error::{ModelError, not_negative, positive, same_length};

/// Largest deviation from an even grid, as a fraction of the sampling interval.
const MAX_UNEVENNESS: f64 = 0.01;
/// Fewest samples that can determine the parameters of either fit.
const MIN_SAMPLES: usize = 8;

/// Simultaneous samples of one stretch of an exploration, evenly spaced (2 kHz on this bench).
#[derive(Debug, Clone, Copy)]
pub struct InstanceSamples<'a> {
    /// Time, s.
    pub time_s: &'a [f64],
    /// Plain impedance f̃_a/ṽ_p for the `paper` method, low-passed as in Huloux 2021, N·s/m.
    pub z_m_plain_n_s_per_m: &'a [Complex64],
    /// Corrected impedance (f̃_a − 2 m_p dṽ_p/dt)/ṽ_p for the `dynamic` method, N·s/m. It has no filter except the
    /// demodulator's window: a further low-pass smears the low-amplitude end and changes σ_t by up to 5 %.
    pub z_m_corrected_n_s_per_m: &'a [Complex64],
    /// Vibration amplitude |x̃_p|, peak, m; no filter except the demodulator's window.
    pub amplitude_m: &'a [f64],
    /// Normal force, N. The fits use it as given, so the noise of its sensor must be removed first.
    pub normal_n: &'a [f64],
    /// Measured friction |f_t|/f_n.
    pub mu: &'a [f64],
}

/// One instance with its lead-in, the input of a fit.
#[derive(Debug, Clone, Copy)]
pub struct InstanceSeries<'a> {
    samples: InstanceSamples<'a>,
    start: usize,
    interval_s: f64,
}

impl<'a> InstanceSeries<'a> {
    /// Checks the samples. `start` is the index of the instance's first sample; earlier ones are its lead-in, of which
    /// `dynamic` needs 20 ms.
    ///
    /// # Errors
    /// If slices differ in length, time is not even, a sample is not finite or not physical, or the instance is too
    /// short. The lead-in needs only amplitude and force; its friction is used where it is finite.
    pub fn new(samples: InstanceSamples<'a>, start: usize) -> Result<Self, FitError> {
        let n = samples.time_s.len();
        same_length("z_m_plain", samples.z_m_plain_n_s_per_m.len(), n)?;
        same_length("z_m_corrected", samples.z_m_corrected_n_s_per_m.len(), n)?;
        same_length("amplitude_m", samples.amplitude_m.len(), n)?;
        same_length("normal_n", samples.normal_n.len(), n)?;
        same_length("mu", samples.mu.len(), n)?;
        let instance_samples = n.saturating_sub(start);
        if instance_samples < MIN_SAMPLES {
            return Err(FitError::TooFewSamples {
                got: instance_samples,
                needed: MIN_SAMPLES,
            });
        }
        let interval_s = (samples.time_s[n - 1] - samples.time_s[0]) / (n - 1) as f64;
        positive("sampling interval", "s", interval_s)?;
        for (index, step) in samples.time_s.windows(2).enumerate() {
            let step_s = step[1] - step[0];
            if step_s.is_nan() || (step_s - interval_s).abs() > MAX_UNEVENNESS * interval_s {
                return Err(FitError::UnevenTime {
                    index: index + 1,
                    step_s,
                    interval_s,
                });
            }
        }
        for index in 0..n {
            let sample_error = |source| ModelError::AtSample {
                index,
                source: Box::new(source),
            };
            positive("amplitude", "m", samples.amplitude_m[index]).map_err(sample_error)?;
            positive("normal force", "N", samples.normal_n[index]).map_err(sample_error)?;
            // A null of the envelope may invalidate the rest of the lead-in.
            if index < start {
                continue;
            }
            not_negative("measured friction", "", samples.mu[index]).map_err(sample_error)?;
            for z in [
                samples.z_m_plain_n_s_per_m[index],
                samples.z_m_corrected_n_s_per_m[index],
            ] {
                if !z.is_finite() {
                    return Err(sample_error(ModelError::OutOfRange {
                        name: "|Z_m|",
                        value: z.norm(),
                        unit: "N s/m",
                        limit: "finite",
                    })
                    .into());
                }
            }
        }
        Ok(Self {
            samples,
            start,
            interval_s,
        })
    }

    /// Returns the sampling interval, s.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Returns the instance without its lead-in.
    pub fn instance(&self) -> InstanceSamples<'a> {
        self.tail(self.start)
    }

    /// Returns the instance and the part of its lead-in within the same rise of the amplitude, from the minimum amplitude on.
    pub(crate) fn rise(&self) -> InstanceSamples<'a> {
        let lead_in = &self.samples.amplitude_m[..=self.start];
        let lowest = (0..=self.start).min_by(|&a, &b| lead_in[a].total_cmp(&lead_in[b]));
        self.tail(lowest.unwrap_or(self.start))
    }

    /// Returns the instance and the `lead_in_s` before it, with the number of samples in the lead-in.
    ///
    /// # Errors
    /// If the lead-in is shorter.
    pub(crate) fn with_lead_in(
        &self,
        lead_in_s: f64,
    ) -> Result<(InstanceSamples<'a>, usize), FitError> {
        let lead = (lead_in_s / self.interval_s).round() as usize;
        if lead > self.start {
            return Err(FitError::LeadInTooShort {
                got_s: self.start as f64 * self.interval_s,
                needed_s: lead_in_s,
            });
        }
        Ok((self.tail(self.start - lead), lead))
    }

    fn tail(&self, first: usize) -> InstanceSamples<'a> {
        let s = &self.samples;
        InstanceSamples {
            time_s: &s.time_s[first..],
            z_m_plain_n_s_per_m: &s.z_m_plain_n_s_per_m[first..],
            z_m_corrected_n_s_per_m: &s.z_m_corrected_n_s_per_m[first..],
            amplitude_m: &s.amplitude_m[first..],
            normal_n: &s.normal_n[first..],
            mu: &s.mu[first..],
        }
    }
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
pub(crate) mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// An arbitrary, physical record: 20 ms of lead-in and 60 ms at 2 kHz.
    pub(crate) fn with_instance(test: impl FnOnce(&InstanceSeries<'_>)) {
        let time_s: Vec<f64> = (0..160).map(|i| f64::from(i) * 5e-4 - 0.05).collect();
        let amplitude_m: Vec<f64> = time_s
            .iter()
            .map(|t| 2e-6 * (1.0 + 0.9 * (TAU * 6.0 * t).sin()))
            .collect();
        let normal_n: Vec<f64> = time_s.iter().map(|t| 0.65 + 0.3 * t).collect();
        let z_m = vec![Complex64::new(9.3, -2.4); time_s.len()];
        let samples = InstanceSamples {
            time_s: &time_s,
            z_m_plain_n_s_per_m: &z_m,
            z_m_corrected_n_s_per_m: &z_m,
            amplitude_m: &amplitude_m,
            normal_n: &normal_n,
            mu: &vec![0.5; time_s.len()],
        };
        test(&InstanceSeries::new(samples, 40).unwrap());
    }
}
