//! The serial port as a source of bytes that never blocks.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use anyhow::Context;

/// A source of bytes that never blocks.
pub trait ForcePort: Send {
    /// Appends the bytes that have arrived.
    ///
    /// # Errors
    /// When the port has disappeared.
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()>;
}

struct SerialPort {
    port: Box<dyn serialport::SerialPort>,
    buffer: Box<[u8]>,
}

impl ForcePort for SerialPort {
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
        while self.port.bytes_to_read()? > 0 {
            match self.port.read(&mut self.buffer) {
                Ok(0) => return Err(ErrorKind::BrokenPipe.into()),
                Ok(read) => bytes.extend_from_slice(&self.buffer[..read]),
                Err(error)
                    if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) =>
                {
                    return Ok(());
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Opens a serial port for listening.
///
/// # Errors
/// When the port is missing, busy or forbidden.
pub fn open_port(path: &Path, baud: u32) -> anyhow::Result<Box<dyn ForcePort>> {
    let port = open(path, baud).with_context(|| cannot_open("force sensor", path, "force.port"))?;
    Ok(Box::new(listening(port)))
}

/// The end of a port that speaks.
pub(crate) type Speaking = Box<dyn Write + Send>;

/// Opens a serial port for listening and speaking; `device` and `key` name it in errors.
pub(crate) fn split_port(
    path: &Path,
    baud: u32,
    device: &str,
    key: &str,
) -> anyhow::Result<(Box<dyn ForcePort>, Speaking)> {
    let port = open(path, baud).with_context(|| cannot_open(device, path, key))?;
    let speaking = port
        .try_clone()
        .with_context(|| cannot_open(device, path, key))?;
    Ok((Box::new(listening(port)), Box::new(speaking)))
}

fn open(path: &Path, baud: u32) -> serialport::Result<Box<dyn serialport::SerialPort>> {
    serialport::new(path.to_string_lossy(), baud)
        .timeout(Duration::from_millis(1))
        // Devices on USB send only while it is set, which not every system does by itself.
        .dtr_on_open(true)
        .open()
}

fn listening(port: Box<dyn serialport::SerialPort>) -> SerialPort {
    SerialPort {
        port,
        buffer: vec![0; 4096].into(),
    }
}

fn cannot_open(device: &str, path: &Path, key: &str) -> String {
    format!(
        "cannot open the {device}'s port {}, {key} in bench.toml: is it plugged in, free, and may you use it? \
         `friction-bench devices` lists the ports",
        path.display()
    )
}
