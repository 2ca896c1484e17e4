//! Power of a channel over frequency by Welch's method: noise about the carrier, and tones.

/// One-sided power density of a stretch of samples: averaged periodograms of Hann-windowed segments that overlap by
/// half (Welch 1967). The mean of the stretch is subtracted first.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Density at multiples of `resolution_hz`, sample units²/Hz.
    density: Vec<f64>,
    resolution_hz: f64,
    duration_s: f64,
    /// Mean of the samples, sample units.
    pub mean: f64,
}

/// A tone in a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Frequency of the tone, Hz, to a fraction of the resolution.
    pub frequency_hz: f64,
    /// Amplitude of the tone, peak, sample units.
    pub amplitude: f64,
}

/// White noise about a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseDensity {
    /// Root of the one-sided power density, sample units per √Hz.
    pub value: f64,
    /// Standard error of `value`, sample units per √Hz.
    pub standard_error: f64,
    /// Degrees of freedom behind `value`.
    pub degrees_of_freedom: usize,
}

/// Reasons why a stretch has no spectrum.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// Shorter than one segment.
    #[error("{frames} frames contain no segment of {segment} frames")]
    TooShort {
        /// Frames in the stretch.
        frames: usize,
        /// Frames in a segment.
        segment: usize,
    },
    /// A sample is lost.
    #[error("sample {frame} of channel {channel} is lost")]
    Lost {
        /// Frame within the stretch.
        frame: usize,
        /// Channel.
        channel: usize,
    },
}

/// Ratio to the median about it from which on a bin contains a tone. Averaged over 19 segments, noise alone exceeds it
/// once in 10⁴⁰ bins; in a single segment once in 10³.
const STANDS_OUT: f64 = 10.0;
/// Bins over which the median is taken.
const FLOOR_BINS: usize = 101;
/// Bins to either side of a tone beyond which the Hann window's sidelobes are 80 dB down.
const SIDELOBES: usize = 20;
/// Bins to either side of a tone over which the Hann window spreads it.
const SKIRT: usize = 2;

impl Spectrum {
    /// Reads the spectrum of `channel` in an interleaved stretch of `stream_channels` channels, at about
    /// `resolution_hz`.
    ///
    /// # Errors
    /// When the stretch is shorter than 1/`resolution_hz`, or a sample is lost.
    pub fn read(
        interleaved: &[f32],
        stream_channels: usize,
        channel: usize,
        sample_rate_hz: f64,
        resolution_hz: f64,
    ) -> Result<Self, SpectrumError> {
        let half = (0.5 * sample_rate_hz / resolution_hz).round().max(8.0) as usize;
        let segment = 2 * half;
        let frames = interleaved.len() / stream_channels;
        if frames < segment {
            return Err(SpectrumError::TooShort { frames, segment });
        }
        let samples: Vec<f64> = interleaved
            .iter()
            .skip(channel)
            .step_by(stream_channels)
            .map(|&sample| f64::from(sample))
            .collect();
        if let Some(frame) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(SpectrumError::Lost { frame, channel });
        }
        let mean = samples.iter().sum::<f64>() / frames as f64;
        let window: Vec<f64> = fourier::hann(segment).collect();
        let power: f64 = window.iter().map(|w| w * w).sum();
        let transform = fourier::forward(segment);
        let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
        let mut density = vec![0.0; half + 1];
        let mut segments = 0u32;
        for begin in (0..=frames - segment).step_by(half) {
            for ((x, sample), w) in input.iter_mut().zip(&samples[begin..]).zip(&window) {
                *x = w * (sample - mean);
            }
            // The transform made the buffers, so they fit.
            if transform.process(&mut input, &mut output).is_ok() {
                segments += 1;
                for (sum, bin) in density.iter_mut().zip(&output) {
                    *sum += bin.norm_sqr();
                }
            }
        }
        // One-sided density 2 |Σ w_n x_n e^{−iω_k n}|²/(rate Σ w_n²), averaged over segments: its sum over the bins
        // times the resolution is the mean square.
        let scale = 2.0 / (power * sample_rate_hz * f64::from(segments));
        density.iter_mut().for_each(|bin| *bin *= scale);
        Ok(Self {
            density,
            resolution_hz: sample_rate_hz / segment as f64,
            duration_s: frames as f64 / sample_rate_hz,
            mean,
        })
    }

    /// Returns the noise between two frequencies without tones, assumed white. The standard error is that of a
    /// power averaged over a bandwidth B and a duration T, 1/√(BT).
    #[must_use]
    pub fn noise(&self, from_hz: f64, to_hz: f64) -> NoiseDensity {
        let bin =
            |hz: f64| ((hz / self.resolution_hz).round() as usize).min(self.density.len() - 1);
        let bins = &self.density[bin(from_hz)..=bin(to_hz)];
        let limit = STANDS_OUT * statistics::median(bins.iter().copied()).unwrap_or(f64::INFINITY);
        let tones: Vec<usize> = (0..bins.len()).filter(|&i| bins[i] > limit).collect();
        let is_quiet = |i: &usize| tones.iter().all(|tone| tone.abs_diff(*i) > SIDELOBES);
        let mut quiet: Vec<f64> = (0..bins.len()).filter(is_quiet).map(|i| bins[i]).collect();
        if quiet.is_empty() {
            quiet = bins.to_vec();
        }
        let power = quiet.iter().sum::<f64>() / quiet.len() as f64;
        // The mean P of B T independent looks, each exponentially distributed, has the relative error 1/√(B T); √P has half of
        // it.
        let looks = quiet.len() as f64 * self.resolution_hz * self.duration_s;
        NoiseDensity {
            value: power.sqrt(),
            standard_error: 0.5 * power.sqrt() / looks.sqrt(),
            degrees_of_freedom: (2.0 * looks) as usize,
        }
    }

    /// Returns the tones that stand out from the spectrum about them, strongest first.
    #[must_use]
    pub fn peaks(&self) -> Vec<Peak> {
        let floor = self.floor();
        let density = &self.density;
        let mut peaks: Vec<Peak> = (SKIRT..density.len() - SKIRT)
            .filter(|&i| {
                density[i] > STANDS_OUT * floor[i]
                    && (i - SKIRT..=i + SKIRT).all(|j| density[j] <= density[i])
            })
            .map(|i| {
                // The power A²/2 of the tone is the density above the floor times the resolution, summed over its skirt.
                let skirt = i - SKIRT..=i + SKIRT;
                let excess = |j: usize| (density[j] - floor[j]).max(0.0);
                let power: f64 = skirt.clone().map(excess).sum();
                let centre = skirt.map(|j| j as f64 * excess(j)).sum::<f64>() / power;
                Peak {
                    frequency_hz: centre * self.resolution_hz,
                    amplitude: (2.0 * power * self.resolution_hz).sqrt(),
                }
            })
            .collect();
        peaks.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        peaks
    }

    /// Returns the distance of neighbouring bins, Hz.
    #[must_use]
    pub fn resolution_hz(&self) -> f64 {
        self.resolution_hz
    }

    /// Returns the median of the bins about each bin, sample units²/Hz.
    fn floor(&self) -> Vec<f64> {
        let medians: Vec<f64> = self
            .density
            .chunks(FLOOR_BINS)
            .filter_map(|bins| statistics::median(bins.iter().copied()))
            .collect();
        (0..self.density.len())
            .map(|i| medians[i / FLOOR_BINS])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE_HZ: f64 = 192e3;

    /// Two channels: silence, and noise of a known density with an offset and two tones.
    fn noisy(seed: u64, density: f64) -> Vec<f32> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let deviation = density * (RATE_HZ / 2.0).sqrt();
        (0..192_000)
            .flat_map(|n| {
                let t = f64::from(n) / RATE_HZ;
                let white: f64 = StandardNormal.sample(&mut rng);
                let tones = 1e-3 * (TAU * 50.0 * t).sin() + 2e-4 * (TAU * 35_123.0 * t).cos();
                [0.0, (0.01 + deviation * white + tones) as f32]
            })
            .collect()
    }

    #[test]
    fn the_noise_density_lies_within_its_interval_with_any_tones() {
        let truth = 1e-7;
        let mut covered = 0;
        for seed in 0..60 {
            let spectrum = Spectrum::read(&noisy(seed, truth), 2, 1, RATE_HZ, 10.0).unwrap();
            let noise = spectrum.noise(33e3, 37e3);
            assert!((noise.value / truth - 1.0).abs() < 0.04, "{noise:?}");
            covered += u32::from((noise.value - truth).abs() < 1.96 * noise.standard_error);
        }
        assert!((53..=60).contains(&covered), "{covered} of 60");
    }

    #[test]
    fn tones_are_found_with_frequency_and_amplitude() {
        let spectrum = Spectrum::read(&noisy(1, 1e-8), 2, 1, RATE_HZ, 10.0).unwrap();
        assert!((spectrum.mean - 0.01).abs() < 1e-6);
        let peaks = spectrum.peaks();
        assert_eq!(peaks.len(), 2, "{peaks:?}");
        for (peak, (hz, amplitude)) in peaks.iter().zip([(50.0, 1e-3), (35_123.0, 2e-4)]) {
            assert!((peak.frequency_hz - hz).abs() < 2.0, "{peak:?}");
            assert!((peak.amplitude / amplitude - 1.0).abs() < 0.01, "{peak:?}");
        }
    }

    #[test]
    fn data_without_a_spectrum_are_refused() {
        assert_eq!(
            Spectrum::read(&[0.0; 100], 1, 0, RATE_HZ, 10.0),
            Err(SpectrumError::TooShort {
                frames: 100,
                segment: 19_200
            })
        );
        let mut lost = vec![0.0; 19_200];
        lost[7] = f32::NAN;
        assert_eq!(
            Spectrum::read(&lost, 1, 0, RATE_HZ, 10.0),
            Err(SpectrumError::Lost {
                frame: 7,
                channel: 0
            })
        );
    }
}
