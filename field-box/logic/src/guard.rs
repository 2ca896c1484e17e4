//! The box's guard over the amplifier.

/// Time after the last word from the bench at which the box takes the enable off, µs. With a look every few milliseconds
/// at most it is off within the 100 ms of FAULTS.md, row 41.
pub const SILENCE_US: u64 = 80_000;

/// What a word from the bench asks of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Order {
    /// Whether the amplifier is to be enabled.
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

/// Why the enable is off, though the bench had it on or asks for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// No word from the bench for [`SILENCE_US`].
    BenchSilent,
    /// The loop of the e-stop was opened, or is open.
    Estop,
    /// The bench asks for the enable, and has not asked for it to be off since the last stop.
    NotReleased,
}

/// Watchdog, latch and heartbeat. After any stop nothing enables the amplifier again but a bench that first asks for
/// the enable to be off and then, with the e-stop closed, to be on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Guard {
    outputs: Outputs,
    stop: Option<Stop>,
    /// Whether the bench has asked for the enable to be off since the last stop.
    released: bool,
    heard_us: u64,
}

impl Guard {
    /// Takes a word from the bench, heard at `now_us` of the box's clock, which never goes back.
    pub fn hear(&mut self, now_us: u64, order: Order, estop_closed: bool) {
        // A word that comes too late keeps nothing on.
        self.look(now_us, estop_closed);
        self.heard_us = now_us;
        if !order.enable {
            self.outputs.enable = false;
            (self.stop, self.released) = (None, true);
        } else if !self.outputs.enable {
            match (estop_closed, self.released) {
                (false, _) => self.fall(Stop::Estop),
                // It says why it stopped first.
                (true, false) => self.stop = self.stop.or(Some(Stop::NotReleased)),
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

    /// Looks at the clock and at the loop of the e-stop: to be called every millisecond, and at each edge of the loop.
    pub fn look(&mut self, now_us: u64, estop_closed: bool) {
        if !self.outputs.enable {
            return;
        }
        if !estop_closed {
            self.fall(Stop::Estop);
        } else if now_us.saturating_sub(self.heard_us) >= SILENCE_US {
            self.fall(Stop::BenchSilent);
        }
    }

    fn fall(&mut self, stop: Stop) {
        self.outputs.enable = false;
        (self.stop, self.released) = (Some(stop), false);
    }

    /// Returns the levels of the lines.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// Returns why the enable is off; `None` if the lines are as the bench says.
    #[must_use]
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }
}
