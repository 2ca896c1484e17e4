//! The force sensor on its serial line: the device that samples and sends, and the port it is
//! plugged into.

mod device;
mod port;

pub(crate) use device::ForceDevice;
pub use device::{DeviceStart, ForceFault};
pub(crate) use port::SerialLine;
