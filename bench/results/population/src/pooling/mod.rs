//! Pooling of estimates with known errors over trials, participants and a study.
//!
//! The estimates may be of any quantity; positive quantities are given as natural logarithms. Quantities are pooled one
//! by one, without the correlation of their errors.
//!
//! # The model
//! Trial j of participant i gives y_ij with the known standard error σ_ij; its true value is θ_ij:
//! ```text
//!  y_ij = θ_ij + σ_ij (√ρ c_i + √(1 − ρ) u_ij),    c, u ~ N(0, 1)         errors, a fraction ρ of their variance shared
//!  θ_ij ~ N(m_i, τ²)                                                   trials about their participant
//!  m_i ~ N(M, T²)                                                      participants about the study
//! ```
//! The data are y and σ; unknown are τ² or ρ (at most one of them is not 0), m_i, T² and M. They are found upwards, one after
//! the other: τ² or ρ from the scatter of all trials about their participants' means (`scatter`), m_i as means weighted with
//! 1/(σ² + τ²) (`mean`), T² from the m_i and their errors by the moment of DerSimonian and Laird, M as their weighted mean with
//! the error of Hartung and Knapp, and the interval of T by the Q profile (`hierarchy`). Downwards each m_i is shrunken
//! towards M and each y_ij towards m_i by empirical Bayes.

mod estimate;
mod hierarchy;
mod mean;
mod scatter;

pub use estimate::Estimate;
pub use hierarchy::{Group, Hierarchy, Mean, Overall, Shrunken, hierarchy};
pub use mean::mean;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
