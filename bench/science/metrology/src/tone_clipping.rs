//! Clipping of a tone's peaks by a converter.

use std::f64::consts::PI;

/// Level and flatness of a tone's peaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// Largest |sample| on the side with the smaller excursion.
    pub level: f64,
    /// Standard deviation of that side's largest sample among tenths of the stretch.
    pub scatter: f64,
    /// Fraction of all samples within [`TOP`] of the largest on a side, the larger of both sides, relative to that of a
    /// sine.
    pub flatness: f64,
}

/// Depth of the top, relative to the largest sample.
pub const TOP: f64 = 2e-3;
/// Flatness from which on peaks are clipped: that of a sine that would reach 1 % beyond the limit.
pub const CUT_OFF: f64 = 2.5;
/// Number of parts of the stretch, for comparing their largest samples.
const PARTS: usize = 10;

impl Peaks {
    /// Reads one channel of an interleaved stretch with a tone of constant amplitude, at a frequency with sample
    /// values that do not repeat after a few samples. Returns `None` if a sample is lost, or with fewer than 1000 samples.
    ///
    /// A sine has a flatness of 1; clipped 1 %, 5 % and 20 % below its peak it has 2.5, 5.3 and 10
    /// (`flatness_tells_a_cut_off_sine`).
    #[must_use]
    pub fn read(interleaved: &[f32], stream_channels: usize, channel: usize) -> Option<Self> {
        let samples: Vec<f64> = interleaved
            .iter()
            .skip(channel)
            .step_by(stream_channels)
            .map(|&sample| f64::from(sample))
            .collect();
        if samples.len() < 100 * PARTS || samples.iter().any(|sample| !sample.is_finite()) {
            return None;
        }
        let side = |sign: f64| {
            let largest = |part: &[f64]| part.iter().map(|x| sign * x).fold(0.0, f64::max);
            let level = largest(&samples);
            let top = samples.iter().filter(|&x| sign * x >= (1.0 - TOP) * level);
            let share = top.count() as f64 / samples.len() as f64;
            let parts: Vec<f64> = samples
                .chunks_exact(samples.len() / PARTS)
                .map(largest)
                .collect();
            let mean = parts.iter().sum::<f64>() / parts.len() as f64;
            let squares: f64 = parts.iter().map(|x| (x - mean).powi(2)).sum();
            let scatter = (squares / (parts.len() - 1) as f64).sqrt();
            (level, scatter, share)
        };
        let (upper, lower) = (side(1.0), side(-1.0));
        let (level, scatter, _) = if upper.0 < lower.0 { upper } else { lower };
        // A sine is above 1 − ε of its peak for 2 arccos(1 − ε) of its 2π: for the fraction arccos(1 − ε)/π of all samples.
        Some(Self {
            level,
            scatter,
            flatness: upper.2.max(lower.2) * PI / (1.0 - TOP).acos(),
        })
    }

    /// Whether the peaks are clipped.
    #[must_use]
    pub fn cut_off(&self) -> bool {
        self.flatness >= CUT_OFF
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn tone(amplitude: f64, limits: [f64; 2]) -> Vec<f32> {
        (0..19_200)
            .flat_map(|n| {
                let sine = amplitude * (TAU * 35_037.0 * f64::from(n) / 192e3).sin();
                [0.0, sine.clamp(limits[0], limits[1]) as f32]
            })
            .collect()
    }

    #[test]
    fn flatness_tells_a_cut_off_sine() {
        for (amplitude, flatness) in [(0.7, 1.0), (0.808, 2.5), (0.842, 5.3), (1.0, 10.3)] {
            let peaks = Peaks::read(&tone(amplitude, [-0.8, 0.8]), 2, 1).unwrap();
            assert!((peaks.flatness / flatness - 1.0).abs() < 0.1, "{peaks:?}");
            assert!((peaks.level - amplitude.min(0.8)).abs() < 1e-4);
            assert!(peaks.scatter < 1e-4);
        }
    }

    #[test]
    fn the_side_that_is_cut_off_first_counts() {
        let peaks = Peaks::read(&tone(0.9, [-0.6, 1.0]), 2, 1).unwrap();
        assert!(peaks.cut_off());
        assert!((peaks.level - 0.6).abs() < 1e-6);
    }

    #[test]
    fn what_is_lost_or_short_has_no_peaks() {
        assert_eq!(Peaks::read(&[0.0; 50], 1, 0), None);
        let mut lost = tone(0.5, [-1.0, 1.0]);
        lost[101] = f32::NAN;
        assert_eq!(Peaks::read(&lost, 2, 1), None);
    }
}
