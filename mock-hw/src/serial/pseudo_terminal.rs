//! Serial line as a pseudo-terminal; the bench opens its far end by path.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::pty::OpenptFlags;
use rustix::termios::{OptionalActions, QueueSelector};

/// Capacity of the terminal's reading side, bytes; further bytes wait behind it and cannot be counted.
const READABLE_BYTES: u64 = 4095;

/// Time without a read after which a port counts as closed, and its bytes as lost, s.
const UNATTENDED_S: f64 = 0.3;

/// Timeout of a synchronous line for the kernel to deliver a burst.
const CARRY_LIMIT: Duration = Duration::from_secs(20);

/// A serial line, from its device to the bench's port.
#[derive(Debug)]
pub(crate) struct SerialLine {
    path: PathBuf,
    ends: Option<Ends>,
    /// Number of bytes readable if nothing has been read since the last burst.
    untouched_bytes: u64,
    last_read_s: f64,
    /// Whether every written byte must be readable before the simulation continues.
    synchronous: bool,
}

/// Both ends of the pseudo-terminal.
#[derive(Debug)]
struct Ends {
    device: File,
    /// Held open so that the line survives when the bench closes the port.
    bench: OwnedFd,
}

impl SerialLine {
    /// Opens a pseudo-terminal. On a `synchronous` line every byte sent is readable before the simulation continues.
    ///
    /// # Errors
    /// Errors of the operating system, which may have no free pseudo-terminal.
    pub(crate) fn open(synchronous: bool) -> io::Result<Self> {
        let device = open_device()?;
        rustix::pty::grantpt(&device)?;
        rustix::pty::unlockpt(&device)?;
        let name = rustix::pty::ptsname(&device, Vec::new())?
            .into_string()
            .map_err(io::Error::other)?;
        let bench = rustix::fs::open(
            &name,
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC | OFlags::NONBLOCK,
            Mode::empty(),
        )?;
        let mut settings = rustix::termios::tcgetattr(&bench)?;
        settings.make_raw();
        rustix::termios::tcsetattr(&bench, OptionalActions::Now, &settings)?;
        let flags = rustix::fs::fcntl_getfl(&device)?;
        rustix::fs::fcntl_setfl(&device, flags | OFlags::NONBLOCK)?;
        Ok(Self {
            path: PathBuf::from(name),
            ends: Some(Ends {
                device: File::from(device),
                bench,
            }),
            untouched_bytes: 0,
            last_read_s: f64::NEG_INFINITY,
            synchronous,
        })
    }

    /// Returns the path of the port for the bench.
    pub(crate) fn path(&self) -> Option<&Path> {
        Some(&self.path)
    }

    /// Disconnects the line permanently: the bench's reads end with a hang-up.
    pub(crate) fn unplug(&mut self) {
        self.ends = None;
    }

    /// Sends a burst at true time `now_s` without blocking; bytes that do not fit are lost, as in a UART.
    ///
    /// # Errors
    /// Errors of the pseudo-terminal, and `TimedOut` if a synchronous line does not deliver the burst.
    pub(crate) fn send(&mut self, burst: &[u8], now_s: f64) -> io::Result<()> {
        let Some(ends) = &mut self.ends else {
            return Ok(());
        };
        let mut unread_bytes = rustix::io::ioctl_fionread(&ends.bench)?;
        if unread_bytes < self.untouched_bytes {
            self.last_read_s = now_s;
        } else if now_s - self.last_read_s > UNATTENDED_S {
            // A bench that opens the port finds fresh samples instead of those buffered by the kernel.
            rustix::termios::tcflush(&ends.device, QueueSelector::OFlush)?;
            rustix::termios::tcflush(&ends.bench, QueueSelector::IFlush)?;
            unread_bytes = 0;
        }
        let sent_bytes = match ends.device.write(burst) {
            Ok(sent_bytes) => sent_bytes,
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => 0,
            Err(e) => return Err(e),
        };
        self.untouched_bytes = (unread_bytes + sent_bytes as u64).min(READABLE_BYTES);
        if self.synchronous {
            wait_for(&ends.bench, self.untouched_bytes)?;
        }
        Ok(())
    }
}

/// Mark written after the bench's bytes to detect that all of them have arrived: an empty frame, which a bench never sends.
const MARK: u8 = 0;

impl SerialLine {
    /// Appends the bytes received from the bench; on a synchronous line, all bytes sent until now.
    ///
    /// # Errors
    /// Errors of the pseudo-terminal, and `TimedOut` if a synchronous line does not deliver the bytes.
    pub(crate) fn receive(&mut self, received: &mut Vec<u8>) -> io::Result<()> {
        let Some(ends) = &mut self.ends else {
            return Ok(());
        };
        let mut bytes = [0; 4096];
        let mut take = |received: &mut Vec<u8>| match ends.device.read(&mut bytes) {
            Ok(read) => {
                received.extend_from_slice(&bytes[..read]);
                Ok(())
            }
            Err(e)
                if matches!(
                    e.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
                ) =>
            {
                Ok(())
            }
            Err(e) => Err(e),
        };
        if !self.synchronous {
            return take(received);
        }
        let begin = Instant::now();
        let from = received.len();
        while rustix::io::write(&ends.bench, &[MARK])? == 0 {}
        loop {
            take(received)?;
            // Frames end with a zero; the mark is another one.
            let is_marked = match received[from..] {
                [MARK] => true,
                [.., last, MARK] => last == MARK,
                _ => false,
            };
            if is_marked {
                received.pop();
                return Ok(());
            }
            if begin.elapsed() > CARRY_LIMIT {
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    format!(
                        "the serial line did not carry the bench's bytes within {CARRY_LIMIT:?}"
                    ),
                ));
            }
            std::thread::yield_now();
        }
    }
}

/// Opens the device's end of a new pseudo-terminal, without inheritance by child processes.
#[cfg(any(target_os = "linux", target_os = "android", target_os = "freebsd"))]
fn open_device() -> rustix::io::Result<OwnedFd> {
    rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
}

/// Opens the device's end of a new pseudo-terminal, without inheritance by child processes.
///
/// This system can set close-on-exec only on an open descriptor: a child started in between inherits it.
#[cfg(not(any(target_os = "linux", target_os = "android", target_os = "freebsd")))]
fn open_device() -> rustix::io::Result<OwnedFd> {
    let device = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    rustix::io::fcntl_setfd(&device, rustix::io::FdFlags::CLOEXEC)?;
    Ok(device)
}

/// Waits until `bytes` have arrived at the bench's end; a kernel worker delivers them.
fn wait_for(bench: &OwnedFd, bytes: u64) -> io::Result<()> {
    let begin = Instant::now();
    while rustix::io::ioctl_fionread(bench)? < bytes {
        if begin.elapsed() > CARRY_LIMIT {
            return Err(io::Error::new(
                io::ErrorKind::TimedOut,
                format!("the serial line did not carry {bytes} bytes within {CARRY_LIMIT:?}"),
            ));
        }
        std::thread::yield_now();
    }
    Ok(())
}
