//! Digital lines of a field box.

use std::sync::Arc;

use field_box_wire::{Levels, Word};
use safety::{GpioError, InputLine, OutputLine};

use super::link::Link;
use super::loss::FieldBoxGone;
use crate::lines::Lines;

/// Returns all lines of a box; the box itself counts its encoder.
pub(super) fn lines(link: &Arc<Link>) -> Lines {
    let input = |high, is_stop| -> Option<Box<dyn InputLine>> {
        Some(Box::new(BoxInput {
            link: Arc::clone(link),
            high,
            is_stop,
        }))
    };
    let output = |set| -> Option<Box<dyn OutputLine>> {
        Some(Box::new(BoxOutput {
            link: Arc::clone(link),
            set,
        }))
    };
    Lines {
        encoder: None,
        counter: None,
        estop: input(|levels| levels.estop_closed, true),
        button: input(|levels| levels.button, false),
        dead_man: input(|levels| levels.dead_man, false),
        enable: output(|word, high| word.enable = high),
        heartbeat: output(|word, high| word.heartbeat = high),
    }
}

/// An input line of the box. It reads low, as an open contact, before the first report.
struct BoxInput {
    link: Arc<Link>,
    high: fn(&Levels) -> bool,
    /// Whether a failure to read the box is an error. Other contacts then read as open: the stop line reports the failure.
    is_stop: bool,
}

impl InputLine for BoxInput {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        match self.link.report() {
            Ok(report) => Ok(report.is_some_and(|report| (self.high)(&report.levels))),
            Err(gone) if self.is_stop => Err(failed(&gone)),
            Err(_) => Ok(false),
        }
    }
}

/// An output line of the box, set by the bench's command words.
struct BoxOutput {
    link: Arc<Link>,
    set: fn(&mut Word, bool),
}

impl OutputLine for BoxOutput {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        let set = self.set;
        self.link
            .say(|word| set(word, high))
            .map_err(|loss| failed(&loss))
    }
}

fn failed(loss: &FieldBoxGone) -> GpioError {
    GpioError::Device {
        why: loss.to_string(),
    }
}
