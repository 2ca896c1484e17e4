//! Digital lines and the counter of the card, read and driven on demand, each by a separate task.

use std::io;

use anyhow::Context;
use config::{Config, EncoderSource, GpioBackend, Nidaqmx};
use safety::{GpioError, InputLine, OutputLine};
use sources::position::{Counted, POSITION_HZ, PositionSource};
use sources::{LineSource, Lines, SourceGone, take_lines};

use crate::library::{CounterInput, DaqError, DaqFault, Daqmx, LineInput, LineOutput};

/// Takes the lines and the counter of the card that `table` and `config` name, and the others from `other_lines`.
///
/// # Errors
/// The line that is unavailable, and the reason.
pub(crate) fn take(
    library: &Daqmx,
    config: &Config,
    table: &Nidaqmx,
    other_lines: Lines,
) -> anyhow::Result<Lines> {
    let device = &config.audio.output_device;
    let mut lines = other_lines;
    if config.gpio.backend == GpioBackend::Nidaqmx {
        let ports = Ports {
            library,
            device,
            table,
        };
        let card_lines = take_lines(&config.gpio, &ports)?;
        lines = Lines {
            // A simulated person holds a separate switch.
            dead_man: lines.dead_man.or(card_lines.dead_man),
            ..card_lines
        };
    }
    let encoder = config.encoder.as_ref().map(|encoder| encoder.source);
    if encoder == Some(EncoderSource::Nidaqmx) {
        let counter = format!("{device}/{}", table.counter);
        let input = CounterInput::new(library, &counter).with_context(|| {
            format!("the encoder's counter {counter}: look at nidaqmx.counter in bench.toml")
        })?;
        lines.counter = Some(Box::new(CardCounter {
            input,
            previous: None,
            count: 0,
            due_ns: 0,
        }));
    }
    Ok(lines)
}

/// The two ports of a card with the lines that `[gpio]` numbers.
struct Ports<'a> {
    library: &'a Daqmx,
    device: &'a str,
    table: &'a Nidaqmx,
}

impl LineSource for Ports<'_> {
    fn chip(&self) -> String {
        format!(
            "{} (inputs: port {}, outputs: port {}, as [nidaqmx] says)",
            self.device, self.table.input_port, self.table.output_port
        )
    }

    fn input(&self, name: &'static str, line: u8) -> io::Result<Box<dyn InputLine>> {
        let terminal = format!("{}/port{}/line{line}", self.device, self.table.input_port);
        let input = LineInput::new(self.library, &terminal).map_err(system_error)?;
        Ok(Box::new(CardInput {
            name,
            is_stop: name != "button",
            input,
        }))
    }

    fn output(&self, name: &'static str, line: u8) -> io::Result<Box<dyn OutputLine>> {
        let terminal = format!("{}/port{}/line{line}", self.device, self.table.output_port);
        let output = LineOutput::new(self.library, &terminal).map_err(system_error)?;
        Ok(Box::new(CardOutput { name, output }))
    }

    fn consumer(&self, _line: u8) -> Option<String> {
        None
    }
}

/// Returns the system's error with the same meaning as the library's.
fn system_error(error: DaqError) -> io::Error {
    match error.fault() {
        DaqFault::Reserved => io::ErrorKind::ResourceBusy.into(),
        DaqFault::Gone => io::ErrorKind::NotFound.into(),
        DaqFault::NoTerminal => io::ErrorKind::InvalidInput.into(),
        _ => io::Error::other(error),
    }
}

fn device_error(line: &str, error: &DaqError) -> GpioError {
    GpioError::Device {
        why: format!("the {line} on the NI card: {error}"),
    }
}

struct CardInput {
    name: &'static str,
    /// Whether it stops the drive: such a line fails if it cannot be read. Other lines then read low, as an open
    /// contact.
    is_stop: bool,
    input: LineInput,
}

impl InputLine for CardInput {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        match self.input.is_high() {
            Err(error) if self.is_stop => Err(device_error(self.name, &error)),
            read => Ok(read.unwrap_or(false)),
        }
    }
}

struct CardOutput {
    name: &'static str,
    output: LineOutput,
}

impl OutputLine for CardOutput {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        self.output
            .set(high)
            .map_err(|error| device_error(self.name, &error))
    }
}

/// Encoder on a counter of the card, which misses no edge between two readings.
struct CardCounter {
    input: CounterInput,
    previous: Option<u32>,
    count: i64,
    due_ns: u64,
}

const PERIOD_NS: u64 = (1e9 / POSITION_HZ) as u64;

impl PositionSource for CardCounter {
    fn poll(
        &mut self,
        now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Counted),
    ) -> Result<(), SourceGone> {
        if now_ns < self.due_ns {
            return Ok(());
        }
        self.due_ns = now_ns + PERIOD_NS;
        let count = self.input.count().map_err(|error| {
            SourceGone::Card(format!("the encoder's counter on the NI card: {error}"))
        })?;
        let host_s = now_s();
        self.count += movement(self.previous.replace(count), count);
        take(Counted {
            host_s,
            source_s: host_s,
            count: self.count,
            missed: 0,
            lost: false,
        });
        Ok(())
    }
}

/// Returns the movement of a 32-bit counter, which wraps, also below 0.
fn movement(previous: Option<u32>, now: u32) -> i64 {
    let step = previous.map_or(0, |previous| now.wrapping_sub(previous));
    i64::from(step.cast_signed())
}

#[cfg(test)]
mod tests {
    use super::movement;

    #[test]
    fn a_counter_that_wraps_goes_on() {
        assert_eq!(movement(None, 7), 0);
        assert_eq!(movement(Some(7), 9), 2);
        assert_eq!(movement(Some(1), u32::MAX), -2);
        assert_eq!(movement(Some(u32::MAX), 1), 2);
    }
}
