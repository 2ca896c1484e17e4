//! Plans of real Fourier transforms.
//!
//! The transforms are generic: each crate that plans one compiles all of `rustfft` again. They are planned here for `f64`, and
//! compiled once.

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
