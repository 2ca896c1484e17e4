//! Sources of known amplitudes: typed in, a table, or an instrument that sends lines of text.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use serialport::SerialPort;
use text_tables::Columns;

use crate::operator::MICROMETRE_M;
use crate::reference::Reference;
use crate::typed_table;

/// Largest length of a line with a number, bytes.
const LONGEST_LINE: usize = 256;
/// Number of consecutive lines without a number that indicate another device or another baud rate.
const NONSENSE_LINES: u32 = 20;
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

/// Reads a table with the columns `drive_v`, `known_um` and, optionally, `known_at_hz`.
///
/// # Errors
/// If the table cannot be read, or a column is missing.
pub fn read_table(path: &Path) -> anyhow::Result<Vec<KnownRow>> {
    const COLUMNS: Columns = Columns {
        required: &["drive_v", "known_um"],
        optional: &["known_at_hz"],
    };
    let rows = typed_table::rows(path, &COLUMNS)?;
    let known = rows.iter().filter_map(|row| {
        Some(KnownRow {
            drive_v: row.number(0)?,
            known_m: row.number(1)? * MICROMETRE_M,
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

/// An instrument on a serial port that sends one number per line: an interferometer or vibrometer sends its peak amplitude in
/// micrometres, a meter its volts.
pub struct Instrument {
    port: Box<dyn Read + Send>,
    /// Unit of the lines, in SI.
    si_per_unit: f64,
    path: PathBuf,
    line: Vec<u8>,
    nonsense: u32,
    /// Number of consecutive polls that did not empty the port's buffer.
    unended: u32,
}

impl Instrument {
    /// Opens the instrument's serial port.
    ///
    /// # Errors
    /// If the port does not exist or is busy.
    pub fn open(path: &Path, baud: u32) -> anyhow::Result<Self> {
        let port = serialport::new(path.to_string_lossy(), baud)
            .timeout(Duration::from_millis(1))
            .open()
            .with_context(|| {
                format!(
                    "cannot open the instrument's port {}: is it plugged in, free, and may you use it? `friction-bench devices` lists the ports",
                    path.display()
                )
            })?;
        Ok(Self::with_port(Box::new(NeverWaiting(port)), path))
    }

    /// Interprets the lines as volts.
    #[must_use]
    pub fn in_volts(mut self) -> Self {
        self.si_per_unit = 1.0;
        self
    }

    /// Returns whether its lines are in volts.
    #[must_use]
    pub fn reads_volts(&self) -> bool {
        self.si_per_unit == 1.0
    }

    /// Reads from `port`, which must not block; `path` names it in errors.
    #[must_use]
    pub fn with_port(port: Box<dyn Read + Send>, path: &Path) -> Self {
        Self {
            port,
            si_per_unit: MICROMETRE_M,
            path: path.to_owned(),
            line: Vec::new(),
            nonsense: 0,
            unended: 0,
        }
    }

    /// Passes each number that has arrived to `reading`, m or V.
    ///
    /// # Errors
    /// If the port no longer exists, or sends no numbers.
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

    /// Returns the first number of a line, m or V; units and words after it are ignored.
    fn take_line(&mut self) -> anyhow::Result<Option<f64>> {
        let text = String::from_utf8_lossy(&self.line).into_owned();
        self.line.clear();
        let Some(word) = text.split_whitespace().next() else {
            return Ok(None);
        };
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.nonsense = 0;
                Ok(Some(number * self.si_per_unit))
            }
            _ => {
                self.nonsense += 1;
                if self.nonsense >= NONSENSE_LINES {
                    bail!(
                        "the instrument at {} sends no numbers ({word:?}): check port and baud; it must send one a line, a peak amplitude in µm or a meter's volts",
                        self.path.display()
                    );
                }
                Ok(None)
            }
        }
    }
}

/// Longest time from a change of the amplitude to the first line that no longer depends on the old one, s (an assumption).
pub const INSTRUMENT_LAG_S: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn read(text: &[u8]) -> anyhow::Result<Vec<f64>> {
        let mut instrument =
            Instrument::with_port(Box::new(Cursor::new(text.to_vec())), Path::new("x"));
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
    fn an_instrument_says_whether_it_reads_volts() {
        let instrument =
            || Instrument::with_port(Box::new(Cursor::new(Vec::new())), Path::new("x"));
        assert!(!instrument().reads_volts());
        assert!(instrument().in_volts().reads_volts());
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
        let mut instrument = Instrument::with_port(Box::new(Endless), Path::new("x"));
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
