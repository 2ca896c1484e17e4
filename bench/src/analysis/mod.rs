//! From recordings to impedance, gap and friction.

pub mod instance;
pub mod record;
pub mod statistics;
pub mod trial;
