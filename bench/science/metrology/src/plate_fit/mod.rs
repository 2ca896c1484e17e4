//! The plate's resonance from its response to tones.
//!
//! The ratio of the pickup's to the drive's envelope, in sample units, is fitted by least squares with
//!
//! ```text
//! H(f) = A e^{−iφ f/f₀} / (1 − (f/f₀)² + i f/(f₀ Q)) + C₀ + C₁ (f − f₀)/f₀
//! ```
//!
//! one second-order mode with a delay, and smooth residual terms for further modes and crosstalk between the channels (Ewins
//! 2000, section 4.3). The delay is tied to its phase φ at resonance, because an independent delay cannot be separated from A
//! and C₀ in a narrow band: a pickup with a phase that is not a delay causes an error of φ/(2Q) in A. With x̃ = M
//! e^{+iφ}·sample and f̃ = γ V·sample the constants follow: k_p = (2πf₀)² m_p, b_p = 2πf₀ m_p/Q, γ = A k_p M/V.
//!
//! The first term is the unloaded plate (k_p − ω² m_p + iω b_p) x̃ = f̃ with r = f/f₀ = ω/√(k_p/m_p) and Q = √(k_p m_p)/b_p:
//! x̃/f̃ = (1/k_p)/(1 − r² + i r/Q), and the ratio of the samples is γV/(M k_p) e^{−iφ}/(1 − r² + i r/Q), so A = γV/(M k_p).
//! Unknown are f₀, ln Q, ln A, φ and the complex C₀ and C₁: eight real parameters. Σ|H − ratio|² over the tones is minimised by
//! Levenberg–Marquardt with analytic slopes, from a start read off the peak and its two neighbours.
//!
//! A real plate has more: neighbouring modes, drift, a clamp that slips. Two further fits measure their effect on the constants
//! (docs/decisions/0041-a-residual-by-its-effect.md).
//! One has a second mode with a complex static response; where it lowers the residuals to less than half, its constants are used,
//! and the second mode is named. Others refit the middle half and the middle three quarters of the band: a change of a
//! constant beyond the change that scatter explains is an error of the model, and part of the standard error.

mod coarse;
mod fit;
mod linear;
mod neighbour;
mod plate_fit_error;
mod problem;
mod refits;
mod response;
mod solution;
#[cfg(test)]
mod tests;

pub use coarse::{CoarseResonance, find_resonance};
pub use fit::{CHANNEL_MATCH, ConstantErrors, PlateFit};
pub use linear::LinearFit;
pub use neighbour::Neighbour;
pub use plate_fit_error::{LEAST_TONES, PlateFitError};
pub use response::Response;
