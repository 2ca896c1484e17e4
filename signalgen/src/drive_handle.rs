//! Commanding side of the drive: commands, kills and the published state, all lock-free.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use rtrb::{Consumer, Producer, PushError, RingBuffer};
use thiserror::Error;

use crate::{
    attendance::Attendance,
    generator::{DriveCommand, DriveState},
    seqlock::{self, PublishedState, StatePublisher},
};

/// Commands that can wait for the next output callback.
const COMMAND_RING: usize = 64;

/// Reason why the drive did not accept a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CommandError {
    /// The ring is full: the output callback has not run for a while.
    #[error(
        "{COMMAND_RING} commands are waiting and the output does not read them: the stream is not running"
    )]
    RingFull,
    /// The output stream is closed.
    #[error("the output stream is closed")]
    Closed,
}

/// A command and the number of kills known to its sender.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SentCommand {
    pub(crate) command: DriveCommand,
    pub(crate) kills_known: u64,
}

/// Commanding side of the drive, with one owner.
///
/// Dropping it, for example while a panic unwinds, makes an emergency stop.
///
/// ```
/// use signalgen::{
///     DriveCommand, DriveConfig, DrivePhase, DriveRenderer, DriveSettings, Generator, StreamHealth, Waveform,
/// };
///
/// let settings = DriveSettings::new(DriveConfig {
///     sample_rate_hz: 192_000,
///     volts_per_unit: 100.0,
///     limit_v: 80.0,
///     ramp_s: 0.005,
/// })?;
/// // One output channel, which is the drive's. A sound card calls `render`; here the example does.
/// let (mut renderer, mut drive) =
///     DriveRenderer::connect(Generator::new(settings), 1, 0, StreamHealth::new())?;
/// let mut block = [0.0_f32; 1_920];
///
/// let tone = settings.admit(Waveform::Tone { carrier_hz: 35_000.0, amplitude_v: 40.0 })?;
/// drive.send(DriveCommand::Start(tone))?;
/// renderer.render(&mut block);
/// assert_eq!(drive.state().phase, DrivePhase::Steady);
///
/// drive.kill_switch().kill();
/// renderer.render(&mut block);
/// assert_eq!(drive.state().phase, DrivePhase::EmergencyStopped);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct DriveHandle {
    commands: Producer<SentCommand>,
    kill_switch: KillSwitch,
    attendance: Attendance,
    monitor: DriveMonitor,
}

impl DriveHandle {
    /// Returns a handle, its command queue, its kill switch, and the publisher of the state that it reads.
    pub(crate) fn connect() -> (Self, Consumer<SentCommand>, KillSwitch, StatePublisher) {
        let (producer, consumer) = RingBuffer::new(COMMAND_RING);
        let (publisher, published) = seqlock::channel();
        let kill_switch = KillSwitch::default();
        let handle = Self {
            commands: producer,
            kill_switch: kill_switch.clone(),
            attendance: Attendance::default(),
            monitor: DriveMonitor(published),
        };
        (handle, consumer, kill_switch, publisher)
    }

    /// Sends a command, which takes effect at the next output callback. Lock-free.
    ///
    /// A [`DriveCommand::Rearm`] releases only kills that had happened when it was sent.
    ///
    /// # Errors
    /// If the output stream is closed or not running.
    pub fn send(&mut self, command: DriveCommand) -> Result<(), CommandError> {
        let kills_known = self.kill_switch.kills();
        self.send_after(command, kills_known)
    }

    fn send_after(&mut self, command: DriveCommand, kills_known: u64) -> Result<(), CommandError> {
        if self.commands.is_abandoned() {
            return Err(CommandError::Closed);
        }
        let sent = SentCommand {
            command,
            kills_known,
        };
        self.commands
            .push(sent)
            .map_err(|PushError::Full(_)| CommandError::RingFull)
    }

    /// Sends [`DriveCommand::Rearm`], which releases the latch and starts nothing.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn rearm(&mut self) -> Result<(), CommandError> {
        self.send(DriveCommand::Rearm)
    }

    /// Re-arms on a decision made after `kills_known` kills ([`KillSwitch::kills`]): a later kill stays in effect.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn rearm_after(&mut self, kills_known: u64) -> Result<(), CommandError> {
        self.send_after(DriveCommand::Rearm, kills_known)
    }

    /// Returns the state published by the last output callback.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.monitor.state()
    }

    /// Returns a monitor for another thread.
    #[must_use]
    pub fn monitor(&self) -> DriveMonitor {
        self.monitor.clone()
    }

    /// Returns the handle for threads that monitor the drive.
    #[must_use]
    pub fn attendance(&self) -> Attendance {
        self.attendance.clone()
    }

    /// Returns a kill switch for another thread.
    #[must_use]
    pub fn kill_switch(&self) -> KillSwitch {
        self.kill_switch.clone()
    }
}

/// Reads the drive's published state from any thread, lock-free.
#[derive(Clone, Debug)]
pub struct DriveMonitor(PublishedState);

impl DriveMonitor {
    /// Returns the state published by the last output callback.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.0.read()
    }

    /// Returns the published state, or `None` while it is being written: for callbacks and high-priority threads, which must
    /// not wait.
    #[must_use]
    pub fn try_state(&self) -> Option<DriveState> {
        self.0.try_read()
    }
}

/// Stops the drive from any thread without passing through the session; lock-free.
///
/// Kills are counted, not flagged: a re-arming decided before a kill cannot undo it.
#[derive(Clone, Debug, Default)]
pub struct KillSwitch(Arc<AtomicU64>);

impl KillSwitch {
    /// Makes an emergency stop at the next output callback, latched until [`DriveHandle::rearm`].
    pub fn kill(&self) {
        self.0.fetch_add(1, Ordering::AcqRel);
    }

    /// Returns the number of kills so far.
    #[must_use]
    pub fn kills(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }
}
