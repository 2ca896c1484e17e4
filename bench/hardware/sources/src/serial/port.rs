//! The serial port as a source of bytes that never blocks.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use anyhow::Context;

/// Largest number of bytes per read, so that an endless sender cannot block the reader. Further bytes wait for the next read.
pub(crate) const MOST_BYTES: usize = 1 << 14;

/// A source of bytes that never blocks.
pub trait ForcePort: Send {
    /// Appends the bytes that have arrived, up to 16 KiB.
    ///
    /// # Errors
    /// If the port no longer exists.
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()>;
}

struct SerialPort {
    port: Box<dyn serialport::SerialPort>,
    buffer: Box<[u8]>,
}

impl ForcePort for SerialPort {
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
        let waiting = |port: &(dyn serialport::SerialPort + 'static)| Ok(port.bytes_to_read()?);
        take_waiting(&mut *self.port, waiting, &mut self.buffer, bytes)
    }
}

fn take_waiting<P: Read + ?Sized>(
    port: &mut P,
    waiting: impl Fn(&P) -> std::io::Result<u32>,
    buffer: &mut [u8],
    bytes: &mut Vec<u8>,
) -> std::io::Result<()> {
    let mut room = MOST_BYTES;
    while room > 0 && waiting(port)? > 0 {
        let most = room.min(buffer.len());
        match port.read(&mut buffer[..most]) {
            Ok(0) => return Err(ErrorKind::BrokenPipe.into()),
            Ok(read) => {
                bytes.extend_from_slice(&buffer[..read]);
                room -= read;
            }
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                return Ok(());
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Opens a serial port for reading.
///
/// # Errors
/// If the port is missing, busy or forbidden.
pub fn open_port(path: &Path, baud: u32) -> anyhow::Result<Box<dyn ForcePort>> {
    let port = open(path, baud).with_context(|| cannot_open("force sensor", path, "force.port"))?;
    Ok(Box::new(listening(port)))
}

/// The writing end of a port.
pub(crate) type Speaking = Box<dyn Write + Send>;

/// Opens a serial port for reading and writing; `device` and `key` name it in errors.
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
        // Devices on USB send only while DTR is set, which some systems do not do by default.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A device that sends faster than it is read, without end.
    struct Endless(u32);

    impl Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.0 += 1;
            assert!(self.0 < 1000, "read without end");
            // Reads of a port return pieces of any size.
            let read = buffer.len().min(3001);
            buffer[..read].fill(0x7e);
            Ok(read)
        }
    }

    /// Fault 22.
    #[test]
    fn a_device_that_sends_without_end_is_left_after_a_bounded_look() {
        let mut buffer = vec![0; 4096];
        let mut port = Endless(0);
        for _ in 0..3 {
            let mut bytes = Vec::new();
            take_waiting(&mut port, |_| Ok(4096), &mut buffer, &mut bytes).unwrap();
            assert_eq!(bytes.len(), MOST_BYTES);
        }
    }
}
