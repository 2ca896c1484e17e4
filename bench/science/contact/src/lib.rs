//! Contact and levitation of a fingertip on an ultrasonic plate: the model and its inversion, with all derivatives. The
//! package `estimation` estimates the model's parameters.
//!
//! N. Huloux, C. Bernard, M. Wiertlewski, "Estimating Friction Modulation From the Ultrasonic Mechanical Impedance",
//! IEEE Trans. Haptics 14(2), 2021, doi 10.1109/TOH.2020.3038937; cited as `Huloux 2021, Eq. n`.
//!
//! # The gap equation
//! ```text
//!  ⟨f_c⟩ [1 − exp((x_t⁰ − x)/σ_t)] = (5/4) p0 S |x̃_p|² / x²        Huloux 2021, Eq. 17
//! ```
//! The squeeze film carries the force that the asperities no longer carry. [`Contact::equilibrium_gap_m`] solves the equation.
//!
//! # From a sample of Z_m to friction, and back
//! ```text
//!  |x̃_p|, ⟨f_c⟩ ──17──▸ x_eq ──τ dx/dt = x_eq − x──▸ x ──18──▸ k_c ──b_c = η k_c/ω──▸ Z_c ──9──▸ Z_m
//!  Z_m ──12──▸ Z_c ──k_c = −ω Im Z_c──▸ k_c ──18──▸ x ──19──▸ μ/μ0;   x + τ dx/dt ──13, 14, 15──▸ ⟨f_c⟩
//! ```
//! The unknowns are σ_t, Z_t, τ and the constants of [`AssumedConstants`]; `estimation` fits the first line to Z_m. This
//! package evaluates both lines for known parameters. An error of each result follows from the parameters' covariance
//! and the sample's noise to first order ([`inversion`]).
//!
//! | topic | equation | item |
//! | --- | --- | --- |
//! | plate, contact, tissue at the carrier; Z_m ↔ Z_c; Z_t at rest | 4–12, 21 | [`harmonic`] |
//! | film and asperity force, gap at rest, equilibrium gap | 13–17 | [`Contact`] |
//! | stiffness k_c and the gap from it; share of trapped air | 18 | [`Contact::stiffness_n_per_m`], [`Contact::gap_from_balance_stiffness`], [`Contact::gap_from_stiffness_m`] |
//! | friction μ/μ0 | 19 | [`Contact::friction_ratio`] |
//! | inversion of a sample's Z_m to stiffness, gap and friction, with errors | | [`inversion`] |
//! | order of the parameters, and dependence on them | | [`parameters`] |
//! | asperities averaged over a cycle; a mode averaged over the contact's width | | [`cycle_average`], [`mode_moments`] |
//! | normal force without a sensor | | [`self_sensed`] |
//! | frame by frame | | [`live_estimator`] |
//! | the plate's resonance, tracked while the finger slides; the plate between readings | | [`plate_tracker`], [`plate_course`] |
//!
//! # Conventions
//! SI units, named in identifiers. Envelopes are peak values with exp(+iωt); impedance is force over velocity, N·s/m. A
//! gap is ⟨x_t⟩, averaged over a carrier period, m. No input or output, no threads: `clippy.toml` next to this crate's
//! `Cargo.toml` disallows them. All results are deterministic.

mod assumed;
pub mod calibration_errors;
mod contact;
pub mod cycle_average;
pub mod damping_reading;
pub mod error;
mod finger;
pub mod first_order_lag;
pub mod harmonic;
pub mod inversion;
pub mod live_estimator;
pub mod mode_moments;
pub mod parameters;
pub mod plate_course;
pub mod plate_tracker;
#[cfg(test)]
mod properties;
pub mod residual_noise;
mod root;
pub mod self_sensed;
pub mod skin_motion;
mod stiffness;
pub mod stimulus_effect;
mod stored_arrays;
pub mod touches;
pub mod uncertain;

pub use assumed::AssumedConstants;
pub use calibration_errors::CalibrationErrors;
pub use contact::{Contact, InversionCounts, InvertedGap, StiffnessBranch, equilibrium_gaps};
pub use error::ModelError;
pub use finger::FittedFinger;
pub use stiffness::{PartSlopes, StiffnessParts};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
