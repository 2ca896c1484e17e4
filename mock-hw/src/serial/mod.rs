//! Device of the force sensor, and the serial lines of the simulated instruments.

mod force_device;
#[cfg(not(unix))]
mod no_terminal;
#[cfg(unix)]
mod pseudo_terminal;

pub(crate) use force_device::ForceDevice;
pub use force_device::{DeviceStart, ForceFault};
#[cfg(not(unix))]
pub(crate) use no_terminal::SerialLine;
#[cfg(unix)]
pub(crate) use pseudo_terminal::SerialLine;
