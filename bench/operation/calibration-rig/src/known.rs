//! Sources of known amplitudes: typed in, a table, or an instrument that sends lines of text.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use serialport::SerialPort;
use text_tables::Columns;

use crate::instrument_line::{self, LineFault, LineUnit};
use crate::operator::MICROMETRE_M;
use crate::reference::Reference;
use crate::typed_table;

/// Largest length of a line with a number, bytes.
const LONGEST_LINE: usize = 256;
/// Number of consecutive lines without a number that indicate another device or another baud rate.
const NONSENSE_LINES: u32 = 20;
/// Number of consecutive lines that report an overload, after which it does not pass by itself.
const OVERLOADS: u32 = 5;
/// Largest number of reads per poll, so that an endless sender cannot block the task that drives the plate.
const MOST_READS: usize = 16;
/// Largest number of consecutive polls that do not empty the port's buffer.
const MOST_UNENDED: u32 = 200;

/// Known peak amplitudes of a ladder of drive levels.
#[derive(Debug, Clone, PartialEq)]
pub enum Known {
    /// One amplitude for each level, m.
    Values(Vec<f64>),
    /// Rows of a table.
    Table(Vec<KnownRow>),
    /// Measured by an instrument on a serial port.
    Instrument,
    /// Measured with their phase by an instrument with its analog output on a spare input.
    Reference(Reference),
    /// Typed by the operator while the plate moves.
    Typed,
}

/// A row of a table of known amplitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownRow {
    /// Drive level, V peak.
    pub drive_v: f64,
    /// Peak amplitude, m.
    pub known_m: f64,
    /// Frequency at which the amplitude holds, Hz; `None` if the table has no such column.
    pub at_hz: Option<f64>,
}

/// Reads a table with the columns `drive_v`, `known_um` and, optionally, `known_at_hz`, or `known_m` in place of `known_um`, as in
/// the table that `calibrate pickup` writes.
///
/// # Errors
/// If the table cannot be read, or a column is missing.
pub fn read_table(path: &Path) -> anyhow::Result<Vec<KnownRow>> {
    const MICROMETRES: Columns = Columns {
        required: &["drive_v", "known_um"],
        optional: &["known_at_hz"],
    };
    const METRES: Columns = Columns {
        required: &["drive_v", "known_m"],
        optional: &["known_at_hz"],
    };
    let (layout, rows) = typed_table::rows_of_either(path, [&MICROMETRES, &METRES])?;
    let unit_m = [MICROMETRE_M, 1.0][layout];
    let known = rows.iter().filter_map(|row| {
        Some(KnownRow {
            drive_v: row.number(0)?,
            known_m: row.number(1)? * unit_m,
            at_hz: row.number(2),
        })
    });
    Ok(known.collect())
}

/// Converts typed micrometres to metres.
#[must_use]
pub fn from_um(known_um: &[f64]) -> Vec<f64> {
    known_um.iter().map(|um| um * MICROMETRE_M).collect()
}

/// A serial port that is read only when bytes have arrived.
struct NeverWaiting(Box<dyn SerialPort>);

impl Read for NeverWaiting {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self.0.bytes_to_read()? {
            0 => Err(std::io::ErrorKind::WouldBlock.into()),
            _ => self.0.read(buffer),
        }
    }
}

/// An instrument on a serial port that sends one number per line: an interferometer or vibrometer sends its amplitude, a meter
/// its volts.
pub struct Instrument {
    port: Box<dyn Read + Send>,
    /// Unit of a line that states none; a line in another unit is refused.
    unit: LineUnit,
    path: PathBuf,
    line: Vec<u8>,
    nonsense: u32,
    overloads: u32,
    /// Note on the first line with a decimal comma.
    note: Option<String>,
    /// Number of consecutive polls that did not empty the port's buffer.
    unended: u32,
}

impl Instrument {
    /// Opens the serial port of an instrument that sends lines in `unit`.
    ///
    /// # Errors
    /// If the port does not exist or is busy.
    pub fn open(path: &Path, baud: u32, unit: LineUnit) -> anyhow::Result<Self> {
        let port = serialport::new(path.to_string_lossy(), baud)
            .timeout(Duration::from_millis(1))
            .open()
            .with_context(|| {
                format!(
                    "cannot open the instrument's port {}: is it plugged in, free, and may you use it? `friction-bench devices` lists the ports",
                    path.display()
                )
            })?;
        Ok(Self::with_port(Box::new(NeverWaiting(port)), path, unit))
    }

    /// Returns whether its lines are in volts.
    #[must_use]
    pub fn reads_volts(&self) -> bool {
        self.unit.is_volts()
    }

    /// Returns a note on the form of its numbers if they have decimal commas.
    pub(crate) fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Reads lines in `unit` from `port`, which must not block; `path` names it in errors.
    #[must_use]
    pub fn with_port(port: Box<dyn Read + Send>, path: &Path, unit: LineUnit) -> Self {
        Self {
            port,
            unit,
            path: path.to_owned(),
            line: Vec::new(),
            nonsense: 0,
            overloads: 0,
            note: None,
            unended: 0,
        }
    }

    /// Passes each number that has arrived to `reading`, m or V.
    ///
    /// # Errors
    /// If the port no longer exists, sends no numbers, or sends them in another unit.
    pub fn poll(&mut self, mut reading: impl FnMut(f64)) -> anyhow::Result<()> {
        let mut bytes = [0; 512];
        for _ in 0..MOST_READS {
            let n = match self.port.read(&mut bytes) {
                Ok(0) => return Ok(()),
                Ok(n) => n,
                Err(error) => {
                    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
                    return match error.kind() {
                        TimedOut | WouldBlock | Interrupted => Ok(()),
                        _ => Err(error).with_context(|| {
                            format!("the instrument at {} is gone", self.path.display())
                        }),
                    };
                }
            };
            for &byte in &bytes[..n] {
                if byte != b'\n' && byte != b'\r' {
                    self.line.push(byte);
                    if self.line.len() <= LONGEST_LINE {
                        continue;
                    }
                }
                if let Some(amplitude_m) = self.take_line()? {
                    reading(amplitude_m);
                }
            }
            if n < bytes.len() {
                self.unended = 0;
                return Ok(());
            }
        }
        self.unended += 1;
        if self.unended > MOST_UNENDED {
            bail!(
                "the instrument at {} sends faster than it can be read: check the port; it must send a few lines a second",
                self.path.display()
            );
        }
        Ok(())
    }

    /// Returns the number of the line that has arrived, m or V.
    fn take_line(&mut self) -> anyhow::Result<Option<f64>> {
        let line = std::mem::take(&mut self.line);
        match instrument_line::read(&line, self.unit) {
            Ok(Some(reading)) => {
                (self.nonsense, self.overloads) = (0, 0);
                if reading.decimal_comma && self.note.is_none() {
                    self.note = Some(format!(
                        "the instrument at {} sends decimal commas: {:?} is read as {:e} {}",
                        self.path.display(),
                        String::from_utf8_lossy(line.trim_ascii()),
                        reading.si,
                        if self.reads_volts() { "V" } else { "m" }
                    ));
                }
                Ok(Some(reading.si))
            }
            Ok(None) => self.without_number(&line).map(|()| None),
            // Some instruments report one while they change their range.
            Err(LineFault::Overload { .. }) if self.overloads + 1 < OVERLOADS => {
                self.overloads += 1;
                Ok(None)
            }
            Err(fault) => bail!("the instrument at {} {fault}", self.path.display()),
        }
    }

    /// Counts a line without a number.
    fn without_number(&mut self, line: &[u8]) -> anyhow::Result<()> {
        let text = String::from_utf8_lossy(line);
        let Some(word) = text.split_whitespace().next() else {
            return Ok(());
        };
        self.nonsense += 1;
        if self.nonsense >= NONSENSE_LINES {
            bail!(
                "the instrument at {} sends no numbers ({word:?}): check port and baud; it must send one a line, an amplitude in {} or a meter's volts",
                self.path.display(),
                LineUnit::micrometres()
            );
        }
        Ok(())
    }
}

/// Longest time from a change of the amplitude to the first line that no longer depends on the old one, s (an assumption).
pub const INSTRUMENT_LAG_S: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn micrometre_instrument(port: impl Read + Send + 'static) -> Instrument {
        Instrument::with_port(Box::new(port), Path::new("x"), LineUnit::micrometres())
    }

    fn read(text: &[u8]) -> anyhow::Result<Vec<f64>> {
        let mut instrument = micrometre_instrument(Cursor::new(text.to_vec()));
        let mut amplitudes_m = Vec::new();
        instrument.poll(|m| amplitudes_m.push(m))?;
        Ok(amplitudes_m)
    }

    #[test]
    fn lines_are_micrometres_and_half_a_line_waits() {
        assert_eq!(
            read(b"1.5\r\n 2.0 um\n#begin\n\n3.25").unwrap(),
            [1.5e-6, 2.0e-6]
        );
    }

    #[test]
    fn a_line_in_another_unit_ends_the_measurement_and_an_overload_passes_if_it_is_short() {
        let error = read(b"0.5 um\n0.0005 mm\n").unwrap_err().to_string();
        assert!(error.contains("--instrument-unit \"mm\""), "{error}");
        assert_eq!(read(b"9.9E37\n9.9E37\n0.5 um\n").unwrap(), [0.5e-6]);
        let error = read(&b"9.9E37\n".repeat(8)).unwrap_err().to_string();
        assert!(error.contains("overload"), "{error}");
    }

    #[test]
    fn the_first_decimal_comma_is_noted() {
        let mut instrument = micrometre_instrument(Cursor::new(b"0,5 um\n0,6 um\n".to_vec()));
        let mut count = 0;
        instrument.poll(|_| count += 1).unwrap();
        assert_eq!(count, 2);
        let note = instrument.note();
        assert!(note.is_some_and(|note| note.contains("decimal commas: \"0,5 um\"")));
    }

    /// Fault 49.
    #[test]
    fn an_instrument_that_sends_without_end_holds_no_poll_and_is_named() {
        struct Endless;
        impl Read for Endless {
            fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
                buffer.fill(b'\n');
                buffer.iter_mut().step_by(2).for_each(|byte| *byte = b'1');
                Ok(buffer.len())
            }
        }
        let mut instrument = micrometre_instrument(Endless);
        let error = (0..1000).find_map(|_| {
            let mut lines = 0;
            let polled = instrument.poll(|_| {
                lines += 1;
                assert!(lines < 1_000_000, "read without end");
            });
            polled.err()
        });
        let error = error.map(|error| error.to_string());
        assert!(error.is_some_and(|error| error.contains("sends faster")));
    }

    #[test]
    fn a_device_that_sends_no_numbers_is_named() {
        let error = read(&b"hello\n".repeat(30)).unwrap_err().to_string();
        assert!(error.contains("sends no numbers"), "{error}");
    }

    #[test]
    fn a_table_names_its_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("known.csv");
        std::fs::write(&path, "drive_v,known_um\n5, 0.42\n10,0.84\n").unwrap();
        let row = |drive_v, known_m, at_hz| KnownRow {
            drive_v,
            known_m,
            at_hz,
        };
        let known = [row(5.0, 0.42 * 1e-6, None), row(10.0, 0.84 * 1e-6, None)];
        assert_eq!(read_table(&path).unwrap(), known);
        std::fs::write(&path, "drive_v,known_um,known_at_hz\n5,0.42,35012.5\n").unwrap();
        let known = [row(5.0, 0.42 * 1e-6, Some(35_012.5))];
        assert_eq!(read_table(&path).unwrap(), known);
        std::fs::write(&path, "known_m,drive_v\n4.2e-7,5\n").unwrap();
        assert_eq!(read_table(&path).unwrap(), [row(5.0, 4.2e-7, None)]);
        std::fs::write(&path, "known_m,drive_v\n4.2e-7,5\nhalf,6\n").unwrap();
        let error = format!("{:#}", read_table(&path).unwrap_err());
        assert!(
            error.contains("line 3") && error.contains("known_m"),
            "{error}"
        );
        std::fs::write(&path, "volts,um\n5,0.42\n").unwrap();
        let error = format!("{:#}", read_table(&path).unwrap_err());
        assert!(error.contains("drive_v and known_um"), "{error}");
        std::fs::write(&path, "known_um;drive_v\r\n0,42;5\r\n").unwrap();
        assert_eq!(read_table(&path).unwrap(), [row(5.0, 0.42 * 1e-6, None)]);
        std::fs::write(&path, "drive_v,known_nm\n5,420\n").unwrap();
        let error = format!("{:#}", read_table(&path).unwrap_err());
        assert!(
            error.contains("known.csv") && error.contains("`known_nm`"),
            "{error}"
        );
    }
}
