//! Real Fourier transforms, and spectra under a Hann window.
//!
//! The transforms are generic: each crate that plans one compiles all of `rustfft` again. They are planned here for `f64`, and
//! compiled once.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::{ComplexToReal, RealToComplex};

/// Plans the transform of `length` real values to `length`/2 + 1 complex ones, Σ x_n e^(−2πi kn/`length`).
///
/// ```
/// let transform = fourier::forward(4);
/// let (mut values, mut spectrum) = ([1.0, 0.0, -1.0, 0.0], transform.make_output_vec());
/// transform.process(&mut values, &mut spectrum).unwrap();
/// assert_eq!(spectrum[1].re, 2.0);
/// ```
#[must_use]
pub fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// Plans the transform of `length`/2 + 1 complex values to `length` real ones, `length` times the inverse of [`forward`].
#[must_use]
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}

/// Returns the weights of a Hann window of `length` values, symmetric about its middle.
pub fn hann(length: usize) -> impl ExactSizeIterator<Item = f64> + Clone {
    (0..length).map(move |n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / length as f64).cos())
}

/// Returns the power in each line of a spectrum of values under a Hann window: at its frequency, the squared amplitude of a steady tone.
///
/// ```
/// let tone: Vec<f64> = (0..64).map(|n| 3.0 * (std::f64::consts::TAU * f64::from(n) / 8.0).sin()).collect();
/// assert!((fourier::tone_powers(&tone)[8] - 9.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn tone_powers(values: &[f64]) -> Vec<f64> {
    let transform = forward(values.len());
    let mut weighted: Vec<f64> = values
        .iter()
        .zip(hann(values.len()))
        .map(|(value, weight)| value * weight)
        .collect();
    let mut lines = transform.make_output_vec();
    // The transform made the buffer, so it fits.
    if transform.process(&mut weighted, &mut lines).is_err() {
        return Vec::new();
    }
    // The window's mean is a half, and a real tone has half its amplitude in either of two lines.
    let scale = (4.0 / values.len() as f64).powi(2);
    lines.iter().map(|line| scale * line.norm_sqr()).collect()
}
