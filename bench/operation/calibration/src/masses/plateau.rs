//! Force readings at rest: test for rest, and means.

use anyhow::bail;

use calibration_rig::capture::Capture;

/// Length of one window, s.
pub const WINDOW_S: f64 = 1.0;
/// Number of pieces of a window: 0.1 s each, whole periods of the mains at 50 and at 60 Hz.
const PIECES: usize = 10;
/// Fewest readings in a piece.
const LEAST_IN_PIECE: usize = 10;
/// Ratio of the scatter of the pieces' means to their standard error that white noise exceeds in one of 1,000 windows (χ² of 9
/// degrees of freedom, 99.9 %: 27.9).
const WHITE: f64 = 1.76;

/// One window of both axes, normal and lateral.
#[derive(Debug, Clone, PartialEq)]
pub struct Plateau {
    /// Middle of the window on the audio clock, s.
    pub at_s: f64,
    /// Mean readings, N.
    pub mean: [f64; 2],
    /// Standard errors of the means, N: from white noise or from the scatter of the pieces' means, whichever is larger.
    pub error: [f64; 2],
    /// Standard deviation of the pieces' means, N.
    pub scatter: [f64; 2],
    /// One-sided density of the white noise, N/√Hz.
    pub density: [f64; 2],
    /// Standard error of a piece's mean from white noise, N.
    white: [f64; 2],
}

struct Look {
    mean: f64,
    error: f64,
    scatter: f64,
    density: f64,
    white: f64,
}

impl Look {
    fn new(values: &[f64], duration_s: f64) -> Self {
        let length = values.len() / PIECES;
        let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let pieces: Vec<f64> = values
            .chunks_exact(length)
            .take(PIECES)
            .map(mean_of)
            .collect();
        let mean = mean_of(&pieces);
        let squares: f64 = pieces.iter().map(|piece| (piece - mean).powi(2)).sum();
        let scatter = (squares / (PIECES - 1) as f64).sqrt();
        // Differences of neighbours are insensitive to slow changes.
        let steps: f64 = values.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
        let sd = (0.5 * steps / (values.len() - 1) as f64).sqrt();
        let white = sd / (length as f64).sqrt();
        let nyquist_hz = 0.5 * values.len() as f64 / duration_s;
        Self {
            mean,
            error: scatter.max(white) / (PIECES as f64).sqrt(),
            scatter,
            density: sd / nyquist_hz.sqrt(),
            white,
        }
    }
}

impl Plateau {
    /// Reads the forces of a capture.
    ///
    /// # Errors
    /// If the sensor sent too few readings.
    pub fn read(capture: &Capture) -> anyhow::Result<Self> {
        let count = capture.normal_n.len();
        if count < PIECES * LEAST_IN_PIECE {
            bail!(
                "the force sensor sent {count} readings in {WINDOW_S} s, at least {} are needed: check port, baud and protocol in [force]",
                PIECES * LEAST_IN_PIECE
            );
        }
        let duration_s = capture.duration_s();
        let looks =
            [&capture.normal_n, &capture.lateral_n].map(|values| Look::new(values, duration_s));
        let by_axis = |value: fn(&Look) -> f64| [value(&looks[0]), value(&looks[1])];
        Ok(Self {
            at_s: capture.from_s + 0.5 * duration_s,
            mean: by_axis(|look| look.mean),
            error: by_axis(|look| look.error),
            scatter: by_axis(|look| look.scatter),
            density: by_axis(|look| look.density),
            white: by_axis(|look| look.white),
        })
    }

    /// Returns whether both axes are at rest: the pieces' means scatter by less than `rest_n`, N, or by no more than their
    /// noise explains.
    #[must_use]
    pub fn at_rest(&self, rest_n: f64) -> bool {
        let mut axes = self.scatter.iter().zip(&self.white);
        axes.all(|(scatter, white)| *scatter <= rest_n.max(WHITE * white))
    }

    /// Averages several windows of the same load.
    #[must_use]
    pub fn mean_of(looks: &[Self]) -> Self {
        let n = looks.len() as f64;
        let mean = |value: &dyn Fn(&Self) -> f64| looks.iter().map(value).sum::<f64>() / n;
        let by_axis =
            |value: &dyn Fn(&Self, usize) -> f64| [0, 1].map(|k| mean(&|look| value(look, k)));
        let means = by_axis(&|look, k| look.mean[k]);
        let within_window =
            by_axis(&|look, k| look.error[k].powi(2)).map(|square| (square / n).sqrt());
        let between_windows = by_axis(&|look, k| (look.mean[k] - means[k]).powi(2))
            .map(|square| (square / (n - 1.0).max(1.0)).sqrt());
        Self {
            at_s: mean(&|look| look.at_s),
            mean: means,
            error: [0, 1].map(|k| within_window[k].max(between_windows[k])),
            scatter: by_axis(&|look, k| look.scatter[k]),
            density: by_axis(&|look, k| look.density[k].powi(2)).map(f64::sqrt),
            white: by_axis(&|look, k| look.white[k]),
        }
    }

    /// Returns means and standard errors as columns of a table.
    pub(super) fn row(&self) -> String {
        let ([n, l], [sn, sl]) = (self.mean, self.error);
        format!("{n:.7},{l:.7},{sn:.1e},{sl:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE_HZ: f64 = 10e3;

    fn capture(mut reading: impl FnMut(f64) -> f64) -> Capture {
        let values: Vec<f64> = (0..10_000)
            .map(|i| reading(f64::from(i) / RATE_HZ))
            .collect();
        Capture {
            samples: vec![0.0; 1000],
            channels: 1,
            rate_hz: 1000.0,
            lateral_n: vec![0.0; values.len()],
            normal_n: values,
            ..Capture::default()
        }
    }

    #[test]
    fn white_noise_rests_and_its_density_and_error_are_known() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (mut rests, mut inside) = (0, 0);
        for _ in 0..200 {
            let noise = capture(|_| {
                let white: f64 = StandardNormal.sample(&mut rng);
                0.5 + 0.02 * white
            });
            let plateau = Plateau::read(&noise).unwrap();
            rests += u32::from(plateau.at_rest(0.0));
            inside += u32::from((plateau.mean[0] - 0.5).abs() < 2.0 * plateau.error[0]);
            assert!((plateau.density[0] / (0.02 / 5000f64.sqrt()) - 1.0).abs() < 0.05);
        }
        assert!(rests >= 197, "{rests} of 200");
        assert!(inside >= 185, "{inside} of 200");
    }

    #[test]
    fn a_swing_a_ramp_and_a_step_do_not_rest() {
        type Motion = fn(f64) -> f64;
        let motions: [Motion; 3] = [
            |t| 0.01 * (std::f64::consts::TAU * 2.5 * t).sin(),
            |t| 0.005 * t,
            |t| if t > 0.7 { 0.002 } else { 0.0 },
        ];
        for motion in motions {
            assert!(!Plateau::read(&capture(motion)).unwrap().at_rest(3e-4));
        }
        let hum = |t: f64| 0.01 * (std::f64::consts::TAU * 50.0 * t).sin();
        assert!(
            Plateau::read(&capture(hum)).unwrap().at_rest(3e-4),
            "the mains"
        );
    }

    #[test]
    fn a_sensor_that_sends_too_little_is_named() {
        let mut silent = capture(|_| 0.0);
        silent.normal_n.truncate(50);
        let message = Plateau::read(&silent).unwrap_err().to_string();
        assert!(message.contains("50 readings"), "{message}");
    }
}
