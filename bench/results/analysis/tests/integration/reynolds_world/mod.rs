//! A fingertip over a film of gas, from first principles (README.md): its checks, and the methods' estimates of its
//! recordings.

mod campaign;
pub mod film;
pub mod programs;
mod recorded_world;
mod scales;
