//! Tests of the package on recordings of other simulations.

mod independent_world;
#[cfg(feature = "parquet")]
mod reference_recordings;
mod reynolds_world;
