//! Simulated apparatus behind the real hardware interfaces.

pub mod fingertip;
pub mod person;
pub mod plant;
pub mod scenario;
mod seed;
pub mod truth;
