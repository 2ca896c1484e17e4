//! The guard over the amplifier, in words of the bench.

use field_box_logic::{Guard, Order, Outputs, Stop};
use field_box_wire::{StopReason, Word};

/// What a report says of the amplifier.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AmplifierState {
    /// Levels of the lines.
    pub outputs: Outputs,
    /// Why the enable is off.
    pub stop: Option<StopReason>,
    /// Number of the last word acted on.
    pub heard: u16,
}

/// The amplifier's enable and heartbeat, as bench and guard want them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Amplifier {
    guard: Guard,
    heard: u16,
}

impl Amplifier {
    /// Takes a word from the bench at `now_us` of the box's clock.
    pub fn hear(&mut self, now_us: u64, word: Word, estop_closed: bool) {
        self.heard = word.sequence;
        let order = Order {
            enable: word.enable,
            heartbeat: word.heartbeat,
        };
        self.guard.hear(now_us, order, estop_closed);
    }

    /// Looks at the clock and at the loop of the e-stop.
    pub fn look(&mut self, now_us: u64, estop_closed: bool) {
        self.guard.look(now_us, estop_closed);
    }

    /// Returns what the lines are to be, and what a report says of them.
    #[must_use]
    pub fn state(&self) -> AmplifierState {
        AmplifierState {
            outputs: self.guard.outputs(),
            stop: self.guard.stop().map(|stop| match stop {
                Stop::BenchSilent => StopReason::BenchSilent,
                Stop::Estop => StopReason::Estop,
                Stop::NotReleased => StopReason::NotReleased,
            }),
            heard: self.heard,
        }
    }
}
