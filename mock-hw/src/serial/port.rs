//! The serial port: a pseudo-terminal whose far end the bench opens by path.

use std::fs::File;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::pty::OpenptFlags;
use rustix::termios::{OptionalActions, QueueSelector};

/// Bytes that the terminal's reading side holds; more wait behind it, where nobody can count them.
const READABLE_BYTES: u64 = 4095;

/// A port that nobody has read for this long counts as not open, and what it holds as lost.
const UNATTENDED_S: f64 = 0.3;

/// How long a stepped world waits for the kernel to carry a burst across.
const CARRY_LIMIT: Duration = Duration::from_secs(20);

#[derive(Debug)]
pub(crate) struct SerialLine {
    path: PathBuf,
    ends: Option<Ends>,
    /// What a reader had before it at the last burst if it took nothing since, bytes.
    untouched_bytes: u64,
    last_read_s: f64,
    dropped_bytes: u64,
    /// Every written byte must be readable before the world goes on.
    synchronous: bool,
}

#[derive(Debug)]
struct Ends {
    device: File,
    /// Held open so that a bench that closes the port hangs nothing up.
    bench: OwnedFd,
}

impl SerialLine {
    pub(crate) fn open(synchronous: bool) -> io::Result<Self> {
        let device =
            rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
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

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes lost because nobody took them in time, as a UART loses them.
    pub(crate) fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    /// Pulls the plug: the bench's reads end with a hang-up.
    pub(crate) fn unplug(&mut self) {
        self.ends = None;
    }

    /// Sends a burst at true time `now_s`. Never blocks: what does not fit is lost.
    pub(crate) fn send(&mut self, burst: &[u8], now_s: f64) -> io::Result<()> {
        let Some(ends) = &mut self.ends else {
            return Ok(());
        };
        let mut waiting = rustix::io::ioctl_fionread(&ends.bench)?;
        if waiting < self.untouched_bytes {
            self.last_read_s = now_s;
        } else if now_s - self.last_read_s > UNATTENDED_S {
            // Whoever opens the port finds fresh samples, not what the kernel kept.
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

/// A pseudo-terminal hands bytes over in a kernel worker: waits until `bytes` have arrived.
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
