//! Patch cable in place of the plate, from the amplifier's output through the read-back's divider to the inputs.

use super::converter::{Delay, Tap};
use super::reconstruction::{Polynomial, evaluate};
use crate::scenario::ConverterTable;

/// Connections of the inputs' cables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputWiring {
    /// Drive read-back, pickup and line on channels 0, 1 and 2, as the bench requires.
    #[default]
    Bench,
    /// Divided drive voltage to every input; the plate is not driven.
    AllInputs,
    /// Divided drive voltage to channel 0, the other inputs terminated; the plate is not driven.
    DriveOnly,
}

/// Patched inputs, each sampled at its own moment and without the pickup's delay.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    wiring: InputWiring,
    inputs: Vec<(f64, Delay)>,
}

impl Patch {
    pub fn new(converter: &ConverterTable) -> Self {
        let input = |channel| {
            let tap = Tap::new(converter.skew(channel));
            (tap.moment, Delay::new(tap))
        };
        Self {
            wiring: InputWiring::default(),
            inputs: (0..converter.channels).map(input).collect(),
        }
    }

    pub fn wiring(&self) -> InputWiring {
        self.wiring
    }

    pub fn wire(&mut self, wiring: InputWiring) {
        self.wiring = wiring;
        self.inputs.iter_mut().for_each(|(_, delay)| delay.clear());
    }

    /// Writes the values of all inputs for the voltage of one sample interval.
    #[inline]
    pub fn feed(&mut self, voltage: &Polynomial, divider: f64, ideal: &mut [f64]) {
        let has_all_inputs = self.wiring == InputWiring::AllInputs;
        for (channel, ((moment, delay), input)) in self.inputs.iter_mut().zip(ideal).enumerate() {
            let is_plugged = has_all_inputs || channel == 0;
            *input = delay.push(if is_plugged {
                evaluate(voltage, *moment) / divider
            } else {
                0.0
            });
        }
    }
}
