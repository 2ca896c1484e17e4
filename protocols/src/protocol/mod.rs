//! Protocol files: conditions, explorations, verdict rules and limits of repetition.

mod built_in;
mod checks;
mod course;
mod definition;
mod drive;
mod driving;
mod error;
mod exploration;
mod parse;
mod plate;
mod raw;
mod sections;
#[cfg(test)]
mod tests;

pub use built_in::{BUILT_IN, TEMPLATE, built_in, nearest_built_in};
pub use course::{Course, CourseStep, StepKind};
pub use definition::Protocol;
pub use drive::{Carrier, Condition, Drive};
pub use driving::{DrivingTime, LIFT_S, PLACE_S};
pub use error::{BrokenRule, ProtocolError};
pub use exploration::{Exploration, Slider};
pub use plate::OffPlateError;
pub use sections::{
    NewCarrier, Order, RedoLimits, ResonanceDrift, Rest, Selection, Timeouts, Timing, Trials,
};
