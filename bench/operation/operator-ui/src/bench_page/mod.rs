//! Data for the dashboard's page of the bench, shared by sessions, `monitor`, drills and calibrations.

mod facts;
mod health;
mod processor;

pub use facts::facts;
pub use health::HealthMeter;
