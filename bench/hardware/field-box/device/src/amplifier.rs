//! Guard over the amplifier, in terms of the protocol's messages.

use field_box_logic::{Guard, LineRequest, Outputs, StopCause};
use field_box_wire::{StopReason, Word};

/// State of the amplifier in a report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AmplifierState {
    /// Levels of the lines.
    pub outputs: Outputs,
    /// Reason why the enable is off.
    pub stop: Option<StopReason>,
    /// Number of the latest command acted on.
    pub word_number: u16,
}

/// Enable and heartbeat of the amplifier, as commanded by the bench and allowed by the guard.
#[derive(Debug, Clone, Copy, Default)]
pub struct Amplifier {
    guard: Guard,
    word_number: u16,
}

impl Amplifier {
    /// Takes a command from the bench at `now_us` of the box's clock.
    pub fn hear(&mut self, now_us: u64, word: Word, estop_closed: bool) {
        self.word_number = word.sequence;
        let order = LineRequest {
            enable: word.enable,
            heartbeat: word.heartbeat,
        };
        self.guard.hear(now_us, order, estop_closed);
    }

    /// Checks the timeout and the e-stop loop.
    pub fn look(&mut self, now_us: u64, estop_closed: bool) {
        self.guard.look(now_us, estop_closed);
    }

    /// Returns the levels of the lines, and the state for a report.
    #[must_use]
    pub fn state(&self) -> AmplifierState {
        AmplifierState {
            outputs: self.guard.outputs(),
            stop: self.guard.stop().map(|stop| match stop {
                StopCause::BenchSilent => StopReason::BenchSilent,
                StopCause::Estop => StopReason::Estop,
                StopCause::NotReleased => StopReason::NotReleased,
            }),
            word_number: self.word_number,
        }
    }
}
