//! NI's library: its functions, its numbers, its errors.

mod daq_error;
mod functions;
mod task;
mod values;

pub use daq_error::{DaqError, DaqFault};
pub use functions::{Card, Daqmx};
pub use task::{AnalogInput, AnalogOutput, CounterInput, LineInput, LineOutput, Timing};
