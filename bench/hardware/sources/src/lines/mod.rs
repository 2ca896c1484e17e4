//! Digital lines of a bench: stops, button, enable and heartbeat, and the signals of an encoder without a counter.

mod digital_lines;
mod line_source;

pub use digital_lines::Lines;
pub use line_source::{LineError, LineSource, take_lines};
