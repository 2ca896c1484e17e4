//! The serial line as a pseudo-terminal, whose far end the bench opens by path.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::pty::OpenptFlags;
use rustix::termios::{OptionalActions, QueueSelector};

/// Bytes that the reading side of the terminal holds; further ones wait behind it and cannot be counted.
const READABLE_BYTES: u64 = 4095;

/// Time without a read after which a port counts as not open, and the bytes in it as lost, s.
const UNATTENDED_S: f64 = 0.3;

/// Longest time that a synchronous line waits for the kernel to carry a burst across.
const CARRY_LIMIT: Duration = Duration::from_secs(20);

/// A serial line, from its device to the port that the bench opens.
#[derive(Debug)]
pub(crate) struct SerialLine {
    path: PathBuf,
    ends: Option<Ends>,
    /// Bytes that a reader would find if it took nothing since the last burst.
    untouched_bytes: u64,
    last_read_s: f64,
    dropped_bytes: u64,
    /// Whether every written byte must be readable before the simulation goes on.
    synchronous: bool,
}

/// Both ends of the pseudo-terminal.
#[derive(Debug)]
struct Ends {
    device: File,
    /// Held open so that the line survives a bench that closes the port.
    bench: OwnedFd,
}

impl SerialLine {
    /// Opens a pseudo-terminal. On a `synchronous` line every byte sent is readable before the simulation goes on.
    ///
    /// # Errors
    /// Errors of the operating system, which may have no pseudo-terminal left.
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
            dropped_bytes: 0,
            synchronous,
        })
    }

    /// Returns the port that the bench opens.
    pub(crate) fn path(&self) -> Option<&Path> {
        Some(&self.path)
    }

    /// Returns the number of bytes lost because nobody read them in time, as a UART loses them.
    pub(crate) fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    /// Disconnects the line for good: the bench's reads end with a hang-up.
    pub(crate) fn unplug(&mut self) {
        self.ends = None;
    }

    /// Sends a burst at true time `now_s` without blocking; bytes that do not fit are lost.
    ///
    /// # Errors
    /// Errors of the pseudo-terminal, and `TimedOut` when a synchronous line does not carry the burst across.
    pub(crate) fn send(&mut self, burst: &[u8], now_s: f64) -> io::Result<()> {
        let Some(ends) = &mut self.ends else {
            return Ok(());
        };
        let mut waiting = rustix::io::ioctl_fionread(&ends.bench)?;
        if waiting < self.untouched_bytes {
            self.last_read_s = now_s;
        } else if now_s - self.last_read_s > UNATTENDED_S {
            // A bench that opens the port finds fresh samples, not those that the kernel kept.
            rustix::termios::tcflush(&ends.device, QueueSelector::OFlush)?;
            rustix::termios::tcflush(&ends.bench, QueueSelector::IFlush)?;
            waiting = 0;
        }
        let written = match ends.device.write(burst) {
            Ok(written) => written,
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => 0,
            Err(e) => return Err(e),
        };
        self.dropped_bytes += (burst.len() - written) as u64;
        self.untouched_bytes = (waiting + written as u64).min(READABLE_BYTES);
        if self.synchronous {
            wait_for(&ends.bench, self.untouched_bytes)?;
        }
        Ok(())
    }
}

/// What is written behind the bench's bytes to know that all of them have come: an empty frame, which nobody sends.
const MARK: u8 = 0;

impl SerialLine {
    /// Appends what the bench has sent. On a synchronous line that is all that it has sent until now.
    ///
    /// # Errors
    /// Errors of the pseudo-terminal, and `TimedOut` when a synchronous line does not carry the bytes across.
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
            // Frames end with a zero; a mark is one more.
            let marked = match received[from..] {
                [MARK] => true,
                [.., last, MARK] => last == MARK,
                _ => false,
            };
            if marked {
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

/// Opens the device's end of a new pseudo-terminal, not to be inherited by child processes.
#[cfg(any(target_os = "linux", target_os = "android", target_os = "freebsd"))]
fn open_device() -> rustix::io::Result<OwnedFd> {
    rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
}

/// Opens the device's end of a new pseudo-terminal, not to be inherited by child processes.
///
/// This system accepts close-on-exec only on an open descriptor: a child started in between inherits it.
#[cfg(not(any(target_os = "linux", target_os = "android", target_os = "freebsd")))]
fn open_device() -> rustix::io::Result<OwnedFd> {
    let device = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    rustix::io::fcntl_setfd(&device, rustix::io::FdFlags::CLOEXEC)?;
    Ok(device)
}

/// Waits until `bytes` have arrived at the bench's end; a kernel worker carries them across.
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
