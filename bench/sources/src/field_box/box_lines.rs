//! The digital lines of a field box.

use std::sync::Arc;

use field_box_wire::{Levels, Word};
use safety::{GpioError, InputLine, OutputLine};

use super::gone::FieldBoxGone;
use super::link::Link;
use crate::lines::Lines;

/// Returns all lines of a box; its encoder is counted by the box itself.
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

/// A line that the box reads. Before its first report it reads low, as an open contact.
struct BoxInput {
    link: Arc<Link>,
    high: fn(&Levels) -> bool,
    /// Whether a box that cannot be read is a failure to be named. Other contacts then read as open: the stop says the
    /// rest.
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

/// A line that the box drives as the bench's words say.
struct BoxOutput {
    link: Arc<Link>,
    set: fn(&mut Word, bool),
}

impl OutputLine for BoxOutput {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        let set = self.set;
        self.link
            .say(|word| set(word, high))
            .map_err(|gone| failed(&gone))
    }
}

fn failed(gone: &FieldBoxGone) -> GpioError {
    GpioError::Device {
        why: gone.to_string(),
    }
}
