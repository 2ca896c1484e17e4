//! Estimates σ_t, Z_t and τ from the measured impedance of one instance, and with them contact stiffness, gap and friction
//! over time.
//!
//! Two methods fit one instance and always both run: [`paper`] as published, and [`dynamic`], which corrects for the envelope,
//! the levitation lag and a shifted plate. A third, [`trial`], fits all instances of a trial together and estimates the skin's
//! constants that the others assume.
//!
//! Measured on two independent time-domain simulations of plate and finger (80 dB SNR, 6 Hz, 95 %; seven instances
//! each, means; `bench/results/analysis/tests/integration/reference_recordings.rs`):
//!
//! | | σ_t µm | Z_t N·s/m | τ ms | RMS error of μ |
//! | --- | --- | --- | --- | --- |
//! | truth | 1.70 | 0.47 + 3.16i | 1.0 | |
//! | `paper` | 2.88 | −0.13 + 1.27i | | 0.160 |
//! | `dynamic` | 1.703 | 0.466 + 3.149i | 1.02 | 0.0013 |
//! | `trial` | 1.700 | 0.475 + 3.155i | 0.92 | 0.0012 |
//! | truth | 1.30 | 0.30 + 2.60i | 0.7 | |
//! | `paper` | 2.00 | −0.12 + 1.79i | | 0.091 |
//! | `dynamic` | 1.306 | 0.295 + 2.589i | 0.70 | 0.0017 |
//! | `trial` | 1.292 | 0.310 + 2.611i | 0.64 | 0.0014 |
//!
//! On records of the model's own equations `dynamic` recovers every parameter to 2e-6, and its standard errors match the
//! scatter of repeated fits (`tests/fits/`). σ_t, Z_t and τ are conditional on the assumed constants: on the first
//! simulation with S wrong by 20 % σ_t moves by up to 4.4 % and τ by up to 0.7 ms, while μ stays within 0.005 RMS.
//!
//! # Order of reading
//! | topic | module |
//! | --- | --- |
//! | published method: one unknown, σ_t | [`paper`] |
//! | model with a lagging gap, and its slopes | `lagged_model`, on `loads`, `trend`, `transient`, `contact::first_order_lag` |
//! | fit of one instance, standard errors | [`dynamic`], `candidate_fit`, `least_squares` |
//! | fit of a trial: cost, priors, order of the search | [`trial`], `trial/layout`, `trial/members`, `trial/search` |
//! | signs that an instance does not follow the laws | `instance_misfit` |
//! | results of a trial, standard errors | `trial/solution`, `trial/identifiability` |
//! | covariance of the residuals | `trial/scatter` |
//! | plate between readings | [`contact::plate_course`], `trial/plate` |
//! | friction | `trial/friction`, `trial/friction_spread`, [`random_walk`] |
//! | least squares in blocks, its minimum and covariance | the package `arrowhead` |

mod candidate_fit;
mod conditions;
pub mod dynamic;
mod estimated_series;
mod fit_agreement;
mod fit_error;
mod fit_verdict;
mod friction_law;
mod instance_fit;
mod instance_misfit;
mod lagged_model;
mod least_squares;
mod loads;
mod modelled_series;
pub mod paper;
pub mod random_walk;
mod sensitivity;
mod series;
mod sigma_search;
mod transient;
mod trend;
pub mod trial;

pub use conditions::{FitConditions, ModeAcross, SHORTEST_WAVELENGTH_M};
pub use estimated_series::EstimatedSeries;
pub use fit_agreement::Agreement;
pub use fit_error::FitError;
pub use fit_verdict::{FitParameter, FitVerdict};
pub use instance_fit::InstanceFit;
pub use instance_misfit::InstanceMisfit;
pub use modelled_series::ModelledSeries;
pub use paper::PaperFit;
pub use sensitivity::{Sensitivities, Sensitivity};
pub use series::{InstanceSamples, InstanceSeries};
