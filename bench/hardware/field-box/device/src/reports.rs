//! Reports of the box.

use field_box_wire::{Levels, Report};

use crate::amplifier::AmplifierState;
use crate::moments::EncoderMoment;

/// Counts at the ends of the converter's range.
const ENDS: [i32; 2] = [-(1 << 23), (1 << 23) - 1];

/// Contacts read by the box.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Whether the e-stop loop is closed.
    pub estop_closed: bool,
    /// Whether the participant's button is pressed.
    pub button: bool,
    /// Whether the dead-man switch is held.
    pub dead_man: bool,
}

/// Source of numbered reports.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reports {
    sequence: u16,
}

impl Reports {
    /// Returns the next report; without `counts` it marks the converter as silent.
    pub fn next(
        &mut self,
        moment: EncoderMoment,
        counts: Option<[i32; 2]>,
        inputs: Inputs,
        amplifier: AmplifierState,
    ) -> Report {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        let [normal, lateral] = counts.unwrap_or_default();
        let outputs = amplifier.outputs;
        Report {
            sequence,
            device_us: moment.at_us as u32,
            counts: [normal, lateral],
            position: moment.position,
            levels: Levels {
                estop_closed: inputs.estop_closed,
                button: inputs.button,
                dead_man: inputs.dead_man,
                enable: outputs.enable,
                heartbeat: outputs.heartbeat,
                normal_saturated: ENDS.contains(&normal),
                lateral_saturated: ENDS.contains(&lateral),
                converter_silent: counts.is_none(),
            },
            stop: amplifier.stop,
            word_number: amplifier.word_number,
        }
    }
}
