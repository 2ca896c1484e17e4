//! Faults of the apparatus, injected from any thread.

use std::sync::Arc;

use cpal::ErrorKind;

use super::force_side::ForceSide;
use crate::host::{ConverterDirection, SoundCards};
use crate::pins::PinBoard;
use crate::serial::ForceFault;

/// Injects faults into the apparatus; any thread may hold a clone. Each fault takes effect with the next period.
#[derive(Clone)]
pub struct FaultPanel {
    cards: Arc<SoundCards>,
    board: Arc<PinBoard>,
    force: ForceSide,
}

impl FaultPanel {
    pub(super) fn new(cards: &Arc<SoundCards>, board: &Arc<PinBoard>, force: &ForceSide) -> Self {
        Self {
            cards: Arc::clone(cards),
            board: Arc::clone(board),
            force: force.clone(),
        }
    }

    /// Makes the converter report an error to the stream of one direction.
    pub fn inject(&self, direction: ConverterDirection, kind: ErrorKind) {
        self.cards.inject(direction, kind);
    }

    /// Makes the converter lose frames without reporting it, from the end of the buffer in progress: the output is silent for
    /// that time, or the input samples never arrive and the next buffer's time is later.
    pub fn skip_frames(&self, direction: ConverterDirection, frames: u64) {
        self.cards.skip_frames(direction, frames);
    }

    /// Makes the converter lose `frames` at the next buffer and report an xrun, as a real card does.
    pub fn xrun(&self, direction: ConverterDirection, frames: u64) {
        self.skip_frames(direction, frames);
        self.inject(direction, ErrorKind::Xrun);
    }

    /// Makes the next `frames` frames of all inputs NaN, or zero in a stream of integers.
    pub fn spoil_frames(&self, frames: u64) {
        self.cards.spoil_frames(frames);
    }

    /// Reports to the stream of one direction that the card is no longer available.
    pub fn lose_card(&self, direction: ConverterDirection) {
        self.inject(direction, ErrorKind::DeviceNotAvailable);
    }

    /// Stops the callbacks of one direction, or resumes them.
    pub fn halt_audio(&self, direction: ConverterDirection, halted: bool) {
        self.cards.halt(direction, halted);
    }

    /// Makes the force sensor show a fault.
    pub fn force(&self, fault: ForceFault) {
        self.force.inject(fault);
    }

    /// Disconnects the force sensor permanently.
    pub fn unplug_force(&self) {
        self.force.unplug();
    }

    /// Switches the amplifier off at its mains switch, or on again.
    pub fn switch_off_amplifier(&self, is_off: bool) {
        self.board.switch_off(is_off);
    }

    /// Sets the amplifier's gain to this fraction of the scenario's.
    pub fn set_amplifier_gain(&self, share: f64) {
        self.board.set_amplifier_gain(share);
    }

    /// Presses or releases the emergency stop.
    pub fn press_estop(&self, pressed: bool) {
        self.board.press_estop(pressed);
    }

    /// Cuts or mends the wire of the emergency stop.
    pub fn cut_estop_wire(&self, cut: bool) {
        self.board.cut_estop_wire(cut);
    }

    /// Holds the participant's button down or releases it, independently of the simulated person.
    pub fn hold_button(&self, held: bool) {
        self.board.hold_button(held);
    }

    /// Welds the amplifier's relay closed, or replaces it.
    pub fn weld_relay(&self, welded: bool) {
        self.board.weld_relay(welded);
    }

    /// Removes the GPIO chip, or restores it.
    pub fn remove_gpio(&self, is_gone: bool) {
        self.board.remove(is_gone);
    }
}
