#![doc = include_str!("../README.md")]

mod block_rows;
mod covariance;
mod minimise;
mod normal;
mod normal_matrix;
mod scatter;
mod whitening;

pub use block_rows::BlockRows;
pub use covariance::{ArrowCovariance, ArrowResponse, BlockCovariance};
pub use minimise::{ArrowMinimum, ArrowProblem, Prior, Termination, minimise};
pub use normal::{BlockNormal, ParameterPoint};
pub use normal_matrix::inverse_of_normal;
pub use scatter::{exponential_correlation, variance_components};
pub use whitening::Whitening;
