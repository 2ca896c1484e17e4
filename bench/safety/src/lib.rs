//! The safety watch. It is nobody's passenger: a task of its own that needs neither the screen nor the disk nor the protocol.
//!
//! Whatever it finds wrong ends the same way: the drive ramps to zero, the amplifier's heartbeat stops, and the state latches
//! until the operator re-arms. It reads [`Signals`] that other tasks publish, drives its own [`SafetyLines`], and reaches the
//! drive through a [`DriveGuard`]; it knows nothing else of the bench.

mod guard;
mod limits;
mod lines;
mod readback;
mod signals;
mod state;
mod trip;
mod watch;

pub use guard::{Commanded, DriveGuard};
pub use limits::{SENSITIVITY, SafetyLimits};
pub use lines::{GpioError, Input, Output, SafetyLines, input, output};
pub use readback::{Misfit, Readback};
pub use signals::{DriveReading, Press, Signals};
pub use state::{SafetyCommand, SafetyState};
pub use trip::Trip;
pub use watch::Watch;
