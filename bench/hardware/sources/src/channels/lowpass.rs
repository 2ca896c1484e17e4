//! The filter before decimation: linear phase, so that its delay is the same at all frequencies and known exactly.

use std::f64::consts::PI;

use impedance::window::Kaiser;

/// Attenuation of the stopband, dB: the carrier that leaks into a gauge is of the order of its signal.
const STOPBAND_DB: f64 = 100.0;
/// Edges of passband and stopband, as shares of the decimated rate; frequencies between half that rate and the stopband's edge
/// alias to the passband's edge at the lowest.
const EDGES: [f64; 2] = [0.35, 0.65];

/// A lowpass for decimation by an integer factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lowpass {
    factor: usize,
    /// Number of samples on either side of the middle.
    pub(super) half: usize,
}

impl Lowpass {
    /// Creates the lowpass for decimation by `factor`.
    pub(super) fn new(factor: usize) -> Self {
        // Kaiser's length for this attenuation and width (Oppenheim & Schafer, Discrete-Time Signal Processing, 7.76).
        let width = 2.0 * PI * (EDGES[1] - EDGES[0]) / factor as f64;
        let length = (STOPBAND_DB - 7.95) / (2.285 * width);
        Self {
            factor,
            half: (0.5 * length).ceil() as usize + 1,
        }
    }

    /// Returns the taps, oldest sample first, for an input sampled `late` samples after the start of its frame. The sum of the
    /// taps is 1.
    pub(super) fn taps(self, late: f64) -> Vec<f64> {
        let window = Kaiser::new(0.1102 * (STOPBAND_DB - 8.7));
        let edge = 0.5 * (EDGES[0] + EDGES[1]) / self.factor as f64;
        let reach = self.half as f64 + 1.0;
        let half = self.half as f64;
        let taps: Vec<f64> = (0..=2 * self.half)
            .map(|i| {
                // Time from the filter's centre to the sampling instant.
                let time = i as f64 - half + late;
                sinc(2.0 * edge * time) * window.derivatives_at(time / reach)[0]
            })
            .collect();
        let sum: f64 = taps.iter().sum();
        taps.iter().map(|tap| tap / sum).collect()
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the gain at a frequency in cycles per sample, and the phase about the filter's centre, rad.
    fn response(taps: &[f64], frequency: f64, late: f64) -> (f64, f64) {
        let half = (taps.len() / 2) as f64;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, tap) in taps.iter().enumerate() {
            let angle = 2.0 * PI * frequency * (i as f64 - half + late);
            re += tap * angle.cos();
            im += tap * angle.sin();
        }
        (re.hypot(im), im.atan2(re))
    }

    #[test]
    fn the_filter_passes_hand_forces_and_stops_the_plates_vibration() {
        let lowpass = Lowpass::new(48);
        let taps = lowpass.taps(0.0);
        // 192 kHz to 4 kHz: flat to 1.3 kHz, stopband from 2.6 kHz, 2.7 ms of delay.
        for hz in [0.0, 10.0, 200.0, 1000.0, 1300.0] {
            let (gain, phase) = response(&taps, hz / 192e3, 0.0);
            assert!(
                (gain - 1.0).abs() < 1e-4 && phase.abs() < 1e-9,
                "{hz} Hz: {gain}"
            );
        }
        for hz in [2650.0, 4000.0, 8000.0, 35_000.0, 70_000.0] {
            let (gain, _) = response(&taps, hz / 192e3, 0.0);
            assert!(gain < 1.2e-5, "{hz} Hz: {gain:e}");
        }
        assert!((lowpass.half as f64 / 192e3) < 3e-3, "{}", lowpass.half);
    }

    #[test]
    fn a_late_input_is_put_back_to_where_it_belongs() {
        for late in [0.25, 1.0, 4.6, -0.5] {
            let taps = Lowpass::new(24).taps(late);
            for frequency in [1e-4, 1e-3, 1e-2] {
                let (gain, phase) = response(&taps, frequency, late);
                assert!((gain - 1.0).abs() < 1e-3, "{late} {frequency}: {gain}");
                // Delay error, samples.
                let error = phase / (2.0 * PI * frequency);
                assert!(error.abs() < 0.02, "{late} {frequency}: {error} samples");
            }
        }
    }
}
