//! The safety watch: a task that judges the bench and stops the drive on any fault.
//!
//! It depends on neither the screen nor the disk nor the protocol. Every fault ends the same way: the drive ramps to
//! zero, the amplifier's heartbeat stops, and the state latches until the operator re-arms. The watch reads [`Signals`]
//! that other tasks publish, drives its own [`SafetyLines`], and reaches the drive through a [`DriveGuard`]; it knows
//! no other part of the bench.

mod commanded_envelope;
mod dead_man;
mod delay;
mod dose;
mod drive_stop;
mod exercise;
mod guard;
mod loop_delay;
mod losses;
mod minutes;
mod plate_heat;
#[cfg(test)]
mod properties;
mod readback;
mod safety_limits;
mod safety_lines;
mod safety_state;
mod signals;
mod sliding_hour;
mod stop_times;
mod trip;
mod watch;

pub use dead_man::Hold;
pub use dose::{Allowance, DoseLeft, FAINT_V, span_reports};
pub use drive_stop::DriveStop;
pub use guard::{Commanded, DriveGuard};
pub use loop_delay::{DELAY_WITHIN_S, LoopDelay};
pub use losses::{Losses, LostDevice, RearmObstacle};
pub use minutes::{at_least, at_most};
pub use plate_heat::PlateHeat;
pub use readback::{Readback, ReadbackMisfit};
pub use safety_limits::{
    BlindLimit, DEAD_MAN_RELEASE_S, FaintDrive, HiddenByDelay, Pace, SENSITIVITY, SafetyLimits,
};
pub use safety_lines::{GpioError, InputLine, LineLevels, OutputLine, SafetyLines, input, output};
pub use safety_state::{SafetyCommand, SafetyState};
pub use signals::{DriveReading, Nonsense, Press, Signals};
pub use sliding_hour::{DrivenSpan, SlidingHour};
pub use stop_times::{StopLine, StopTimes};
pub use trip::Trip;
pub use watch::Watch;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
