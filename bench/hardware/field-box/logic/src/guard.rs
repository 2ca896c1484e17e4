//! Guard of the box over the amplifier.

/// Time after the last command from the bench at which the box disables the amplifier, µs. With a check every few milliseconds
/// it is disabled within the 100 ms of FAULTS.md, row 41.
pub const SILENCE_US: u64 = 80_000;

/// Line levels requested by a command of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineRequest {
    /// Whether to enable the amplifier.
    pub enable: bool,
    /// Level of the heartbeat line.
    pub heartbeat: bool,
}

/// Levels of the lines to the amplifier.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Outputs {
    /// The amplifier's enable.
    pub enable: bool,
    /// The heartbeat into its one-shot, which an edge triggers.
    pub heartbeat: bool,
}

/// Reason why the enable is off although the bench had it on or requests it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopCause {
    /// No command from the bench for [`SILENCE_US`].
    BenchSilent,
    /// The e-stop loop was opened, or is open.
    Estop,
    /// The bench requests the enable, but has not requested it off since the last stop.
    NotReleased,
}

/// Watchdog, latch and heartbeat. After any stop the amplifier stays disabled until the bench requests the enable off and then,
/// with the e-stop loop closed, on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Guard {
    outputs: Outputs,
    stop: Option<StopCause>,
    /// Whether the bench has requested the enable off since the last stop.
    released: bool,
    heard_us: u64,
}

impl Guard {
    /// Takes a command from the bench, received at `now_us` of the box's monotonic clock.
    pub fn hear(&mut self, now_us: u64, order: LineRequest, estop_closed: bool) {
        // A command after the timeout must not keep the amplifier enabled.
        self.look(now_us, estop_closed);
        self.heard_us = now_us;
        if !order.enable {
            self.outputs.enable = false;
            (self.stop, self.released) = (None, true);
        } else if !self.outputs.enable {
            match (estop_closed, self.released) {
                (false, _) => self.fall(StopCause::Estop),
                // The first reason stays.
                (true, false) => self.stop = self.stop.or(Some(StopCause::NotReleased)),
                (true, true) => {
                    self.outputs.enable = true;
                    self.released = false;
                }
            }
        }
        if self.outputs.enable {
            self.outputs.heartbeat = order.heartbeat;
        }
    }

    /// Checks the timeout and the e-stop loop: call it every millisecond, and at each edge of the loop.
    pub fn look(&mut self, now_us: u64, estop_closed: bool) {
        if !self.outputs.enable {
            return;
        }
        if !estop_closed {
            self.fall(StopCause::Estop);
        } else if now_us.saturating_sub(self.heard_us) >= SILENCE_US {
            self.fall(StopCause::BenchSilent);
        }
    }

    fn fall(&mut self, stop: StopCause) {
        self.outputs.enable = false;
        (self.stop, self.released) = (Some(stop), false);
    }

    /// Returns the levels of the lines.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// Returns the reason why the enable is off; `None` if the lines are as the bench requested.
    #[must_use]
    pub fn stop(&self) -> Option<StopCause> {
        self.stop
    }
}
