//! Computations for the calibrations of a bench, from tones, silence and known loads; each value has a standard error.
//!
//! | quantity | module |
//! | --- | --- |
//! | amplitude and phase of a tone, with their errors | [`tone`] |
//! | power density, noise, and the tones in a silent recording | [`spectrum`] |
//! | offsets, hum and foreign tones in addition to a drive | [`disturbance`] |
//! | frequency and index of the modulation of a drive | [`drive_modulation`] |
//! | whether a generated carrier comes back at its own frequency | [`signal_path`] |
//! | whether a converter clips a tone | [`tone_clipping`] |
//! | a straight line with its errors | [`regression`] |
//! | gain, phase and delay between two channels | [`channel_fit`] |
//! | the plate's resonance, quality and static response | [`plate_fit`] |
//! | a cosine through the amplitude across the plate | [`mode_across`] |
//! | the matrix of a two-axis force sensor | [`crosstalk`] |
//!
//! Each fit is least squares, with equal weights or those of known deviations. Standard errors come from the inverse of the
//! normal matrix, scaled by the scatter of the residuals; with known deviations, only where the scatter exceeds them.
//!
//! Conventions, for the whole crate: exp(+iωt), peak amplitudes, SI units named in identifiers.
//! No input or output, no threads: `clippy.toml` next to this crate's `Cargo.toml` disallows them.

pub mod channel_fit;
pub mod complex_slope;
pub mod crosstalk;
pub mod disturbance;
pub mod drive_modulation;
mod fitted_value;
pub mod mode_across;
pub mod plate_fit;
pub mod regression;
pub mod signal_path;
pub mod spectrum;
pub mod tone;
pub mod tone_clipping;
pub mod volts;

pub use fitted_value::FittedValue;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
