//! The serial port as a source of bytes that never blocks.

use std::io::{ErrorKind, Read};
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
    let port = serialport::new(path.to_string_lossy(), baud)
        .timeout(Duration::from_millis(1))
        .open()
        .with_context(|| {
            format!(
                "cannot open the force sensor's port {}, force.port in bench.toml: is it plugged in, free, and may you use \
                 it? `friction-bench devices` lists the ports",
                path.display()
            )
        })?;
    Ok(Box::new(SerialPort {
        port,
        buffer: vec![0; 4096].into(),
    }))
}
