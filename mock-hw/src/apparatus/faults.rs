//! What can be made to go wrong with the apparatus, from any thread.

use std::sync::Arc;

use cpal::ErrorKind;

use super::world::ForceSide;
use crate::host::{Audio, Direction};
use crate::pins::PinBoard;
use crate::serial::ForceFault;

/// Switches and plugs of the apparatus. Each takes effect with the next period.
#[derive(Clone)]
pub struct FaultPanel {
    audio: Arc<Audio>,
    board: Arc<PinBoard>,
    force: ForceSide,
}

impl FaultPanel {
    pub(super) fn new(audio: &Arc<Audio>, board: &Arc<PinBoard>, force: &ForceSide) -> Self {
        Self {
            audio: Arc::clone(audio),
            board: Arc::clone(board),
            force: force.clone(),
        }
    }

    /// The converter reports an error to the stream of one direction.
    pub fn inject(&self, direction: Direction, kind: ErrorKind) {
        self.audio.inject(direction, kind);
    }

    /// The converter loses frames without a word, from the end of the buffer in progress: output
    /// is silent for as long, input samples never arrive and the next buffer's time is later.
    pub fn skip_frames(&self, direction: Direction, frames: u64) {
        self.audio.skip_frames(direction, frames);
    }

    /// What a card does that ran over: `frames` are lost at the next buffer, and an xrun is reported.
    pub fn xrun(&self, direction: Direction, frames: u64) {
        self.skip_frames(direction, frames);
        self.inject(direction, ErrorKind::Xrun);
    }

    /// The next `frames` frames of all inputs are NaN; a stream of integers, which knows none, gets zeros.
    pub fn spoil_frames(&self, frames: u64) {
        self.audio.spoil_frames(frames);
    }

    /// The card is gone, as the stream of one direction learns.
    pub fn lose_card(&self, direction: Direction) {
        self.inject(direction, ErrorKind::DeviceNotAvailable);
    }

    /// Callbacks of one direction stop coming, or come again.
    pub fn halt_audio(&self, direction: Direction, halted: bool) {
        self.audio.halt(direction, halted);
    }

    /// A fault of the force sensor.
    pub fn force(&self, fault: ForceFault) {
        self.force.lay(fault);
    }

    /// Pulls the force sensor's plug; it stays out.
    pub fn unplug_force(&self) {
        self.force.unplug();
    }

    /// Presses or releases the emergency stop.
    pub fn press_estop(&self, pressed: bool) {
        self.board.press_estop(pressed);
    }

    /// Cuts or mends the emergency stop's wire.
    pub fn cut_estop_wire(&self, cut: bool) {
        self.board.cut_estop_wire(cut);
    }

    /// Holds down or releases the participant's button, whatever the person does with it.
    pub fn hold_button(&self, held: bool) {
        self.board.hold_button(held);
    }

    /// Takes the GPIO chip away, or brings it back.
    pub fn remove_gpio(&self, gone: bool) {
        self.board.remove(gone);
    }
}
