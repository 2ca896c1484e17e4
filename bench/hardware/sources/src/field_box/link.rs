//! The serial line to a field box, shared by its sources and outputs.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

use config::FieldBox as FieldBoxTable;
use field_box_wire::{BoxIdentity, Report, StopReason, Word};
use tasks::{Clock, Slot};

use super::loss::FieldBoxGone;
use super::reader::Reader;
use super::writer::Writer;
use crate::serial::split_port;

/// Baud rate; ignored by the box, because its port is USB.
const BAUD: u32 = 2_000_000;
/// Timeout of a box's identification, ns.
const ANSWER_NS: u64 = 2_000_000_000;
/// Time after which the identification is requested again, ns.
const ASK_AGAIN_NS: u64 = 250_000_000;

/// The line to the box. Each poll reads for all users; the safety watch reads concurrently with the task that processes forces
/// and positions, and never waits for a lock.
pub(super) struct Link {
    port: PathBuf,
    /// Serial number in `bench.toml`.
    named: Option<String>,
    silence_ns: u64,
    clock: Arc<dyn Clock>,
    opened_ns: u64,
    reader: Mutex<Reader>,
    writer: Mutex<Writer>,
    /// Newest report with its time of arrival, ns.
    latest: Slot<(Report, u64)>,
    request_ns: Slot<u64>,
    identity: OnceLock<BoxIdentity>,
    gone: OnceLock<FieldBoxGone>,
}

impl Link {
    /// Opens the line to the box of `table` at `port`.
    pub(super) fn open(
        table: &FieldBoxTable,
        port: &Path,
        silence_s: f64,
        clock: Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        let (listening, speaking) = split_port(port, BAUD, "field box", "field_box.port")?;
        let now_ns = clock.now_ns();
        let link = Self {
            port: port.to_owned(),
            named: table
                .serial
                .as_ref()
                .map(|serial| serial.to_ascii_uppercase()),
            silence_ns: (silence_s * 1e9) as u64,
            opened_ns: now_ns,
            reader: Mutex::new(Reader::new(listening, table.latency_s)),
            writer: Mutex::new(Writer::new(speaking)),
            latest: Slot::default(),
            request_ns: Slot::default(),
            identity: OnceLock::new(),
            gone: OnceLock::new(),
            clock,
        };
        link.ask(now_ns);
        // Clears the stop of a box after the previous bench program died.
        link.say(|word| word.enable = false)?;
        Ok(link)
    }

    /// Returns the box's identity, once received.
    pub(super) fn identity(&self) -> Option<&BoxIdentity> {
        self.identity.get()
    }

    /// Queues forces from now on.
    pub(super) fn keep_forces(&self) {
        lock(&self.reader).forces.keep();
    }

    /// Queues positions from now on.
    pub(super) fn keep_positions(&self) {
        lock(&self.reader).positions.keep();
    }

    /// Locks the reader and reads the bytes that have arrived.
    pub(super) fn read(
        &self,
        now_s: &dyn Fn() -> f64,
    ) -> Result<MutexGuard<'_, Reader>, FieldBoxGone> {
        let mut reader = lock(&self.reader);
        self.read_into(&mut reader, now_s)?;
        Ok(reader)
    }

    /// Returns the newest report, after reading the line unless another thread is reading it; `None` before the first report of
    /// an identified box.
    pub(super) fn report(&self) -> Result<Option<Report>, FieldBoxGone> {
        let clock = &self.clock;
        match self.reader.try_lock() {
            Ok(mut reader) => self.read_into(&mut reader, &|| clock.now_ns() as f64 * 1e-9)?,
            Err(TryLockError::Poisoned(poisoned)) => {
                self.read_into(&mut poisoned.into_inner(), &|| clock.now_ns() as f64 * 1e-9)?;
            }
            Err(TryLockError::WouldBlock) => {}
        }
        if let Some(loss) = self.gone.get() {
            return Err(loss.clone());
        }
        let now_ns = clock.now_ns();
        let port = || self.port.clone();
        let latest = self.latest.get().filter(|_| self.identity.get().is_some());
        let Some((report, at_ns)) = latest else {
            let waited_ns = now_ns.saturating_sub(self.opened_ns);
            let mute = waited_ns > ANSWER_NS;
            return if mute {
                Err(FieldBoxGone::Mute { port: port() })
            } else {
                Ok(None)
            };
        };
        let silent_ns = now_ns.saturating_sub(at_ns);
        if silent_ns > self.silence_ns {
            return Err(FieldBoxGone::Silent {
                port: port(),
                silent_ms: silent_ns / 1_000_000,
            });
        }
        Ok(Some(report))
    }

    /// Sends a command word with a changed level. While the enable is on, requires that the box hears it and acts on it.
    pub(super) fn say(&self, change: impl FnOnce(&mut Word)) -> Result<(), FieldBoxGone> {
        let now_ns = self.clock.now_ns();
        let mut writer = lock(&self.writer);
        self.require_sent(writer.say(now_ns, change))?;
        let Some((report, _)) = self.latest.get() else {
            return Ok(());
        };
        if let (true, Some(stop)) = (writer.acknowledge(&report), report.stop) {
            return Err(FieldBoxGone::Stopped {
                why: in_words(stop),
            });
        }
        let unheard_ns = writer.unheard_ns(now_ns);
        if unheard_ns > self.silence_ns {
            return Err(FieldBoxGone::Deaf {
                port: self.port.clone(),
                unheard_ms: unheard_ns / 1_000_000,
            });
        }
        Ok(())
    }

    fn read_into(&self, reader: &mut Reader, now_s: &dyn Fn() -> f64) -> Result<(), FieldBoxGone> {
        if let Some(loss) = self.gone.get() {
            return Err(loss.clone());
        }
        let newest = reader.read(now_s).map_err(|error| self.is_gone(&error))?;
        let now_ns = self.clock.now_ns();
        if let Some(report) = newest {
            self.latest.set((report, now_ns));
        }
        if let Some(for_s) = reader.flood_s {
            let (port, for_ms) = (self.port.clone(), (1e3 * for_s) as u64);
            return Err(self.end(FieldBoxGone::Flood { port, for_ms }));
        }
        match (reader.identity, reader.other_version) {
            (Some(identity), _) => self.introduce(identity),
            (None, Some(version)) => {
                let port = self.port.clone();
                Err(self.end(FieldBoxGone::Version {
                    port,
                    theirs: version,
                }))
            }
            (None, None) => {
                let request_ns = self.request_ns.get().unwrap_or(0);
                if now_ns.saturating_sub(request_ns) > ASK_AGAIN_NS {
                    self.ask(now_ns);
                }
                Ok(())
            }
        }
    }

    fn introduce(&self, identity: BoxIdentity) -> Result<(), FieldBoxGone> {
        if self.identity.get().is_some() {
            return Ok(());
        }
        let present = serial_number(&identity);
        if let Some(named) = self.named.as_ref().filter(|named| **named != present) {
            return Err(self.end(FieldBoxGone::Other {
                port: self.port.clone(),
                present,
                named: named.clone(),
            }));
        }
        let _ = self.identity.set(identity);
        Ok(())
    }

    /// Requests the identification; a lost request is repeated.
    fn ask(&self, now_ns: u64) {
        self.request_ns.set(now_ns);
        let _ = lock(&self.writer).ask();
    }

    /// Converts the result of sending: a word that did not fit the system's buffer counts as lost on the line, since the box's
    /// acknowledgement decides.
    fn require_sent(&self, result: io::Result<()>) -> Result<(), FieldBoxGone> {
        use ErrorKind::{Interrupted, TimedOut, WouldBlock};
        match result {
            Err(error) if !matches!(error.kind(), Interrupted | TimedOut | WouldBlock) => {
                Err(self.is_gone(&error))
            }
            _ => Ok(()),
        }
    }

    fn is_gone(&self, error: &io::Error) -> FieldBoxGone {
        self.end(FieldBoxGone::Port {
            port: self.port.clone(),
            why: bounded_files::cause(error),
        })
    }

    /// Ends the line for good; the first reason is kept.
    fn end(&self, loss: FieldBoxGone) -> FieldBoxGone {
        self.gone.get_or_init(|| loss).clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn serial_number(identity: &BoxIdentity) -> String {
    let digits = identity.serial.iter();
    digits.map(|byte| format!("{byte:02X}")).collect()
}

fn in_words(stop: StopReason) -> &'static str {
    match stop {
        StopReason::BenchSilent => {
            "it received nothing from this program for 80 ms: the computer was delayed, or its cable is loose"
        }
        StopReason::Estop => "the loop of its e-stop was open for a moment",
        StopReason::NotReleased => "the enable was requested before it was released; re-arm",
    }
}
