//! Tests of the package on recordings of other simulations.

mod independent_world;
mod law_check;
#[cfg(feature = "parquet")]
mod reference_recordings;
mod reynolds_world;
