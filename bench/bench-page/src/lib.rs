//! What the dashboard's page of the bench is told, the same in a session, in `monitor`, in a drill and while calibrating.

mod facts;
mod health;
mod processor;

pub use facts::facts;
pub use health::HealthMeter;
