//! The output direction: commands in through a ring, the generator rendered in the callback.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use rtrb::{Consumer, Producer, PushError, RingBuffer};
use thiserror::Error;

use crate::{
    generator::{Command, DriveState, Generator},
    health::{Direction, Health},
    published::{self, Published, Publisher},
    sample::ConverterSample,
};

/// Commands that may wait for the next callback.
const COMMAND_RING: usize = 64;
/// Frames rendered at a time.
const CHUNK_FRAMES: usize = 256;

/// The drive did not take a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SendError {
    /// The ring is full: the output callback has not run for a while.
    #[error(
        "{COMMAND_RING} commands are waiting and the output does not take them: the stream is not running"
    )]
    RingFull,
    /// The output stream is gone.
    #[error("the output stream is closed")]
    Closed,
}

/// A command with what its sender knew of kills when it was sent.
#[derive(Clone, Copy, Debug)]
struct Order {
    command: Command,
    kills_known: u64,
}

/// The commanding side of the drive. One owner; when it is dropped, a panic's unwinding included,
/// the drive makes an emergency stop.
#[derive(Debug)]
pub struct DriveHandle {
    orders: Producer<Order>,
    kill_switch: KillSwitch,
    monitor: DriveMonitor,
}

impl DriveHandle {
    /// Sends a command, in force from the next output callback on. Lock-free.
    ///
    /// A [`Command::Rearm`] releases only kills that had happened when it was sent.
    ///
    /// # Errors
    /// If the output stream is closed or does not run.
    pub fn send(&mut self, command: Command) -> Result<(), SendError> {
        let kills_known = self.kill_switch.kills();
        self.order(command, kills_known)
    }

    fn order(&mut self, command: Command, kills_known: u64) -> Result<(), SendError> {
        if self.orders.is_abandoned() {
            return Err(SendError::Closed);
        }
        let order = Order {
            command,
            kills_known,
        };
        self.orders
            .push(order)
            .map_err(|PushError::Full(_)| SendError::RingFull)
    }

    /// [`Command::Rearm`]: releases the latch, starts nothing.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn rearm(&mut self) -> Result<(), SendError> {
        self.send(Command::Rearm)
    }

    /// [`Self::rearm`], decided when there had been no more than `kills_known` kills ([`KillSwitch::kills`]): a later one holds.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn rearm_knowing(&mut self, kills_known: u64) -> Result<(), SendError> {
        self.order(Command::Rearm, kills_known)
    }

    /// The state published by the last output callback.
    #[must_use]
    pub fn published(&self) -> DriveState {
        self.monitor.published()
    }

    /// A monitor for another thread.
    #[must_use]
    pub fn monitor(&self) -> DriveMonitor {
        self.monitor.clone()
    }

    /// A kill switch for another thread.
    #[must_use]
    pub fn kill_switch(&self) -> KillSwitch {
        self.kill_switch.clone()
    }
}

/// Reads the drive's published state from any thread, lock-free.
#[derive(Clone, Debug)]
pub struct DriveMonitor(Published);

impl DriveMonitor {
    /// The state published by the last output callback.
    #[must_use]
    pub fn published(&self) -> DriveState {
        self.0.read()
    }

    pub(crate) fn try_published(&self) -> Option<DriveState> {
        self.0.try_read()
    }
}

/// Stops the drive from any thread without passing through the session; lock-free.
///
/// Kills are counted, not flagged: a re-arming decided before a kill cannot undo it.
#[derive(Clone, Debug, Default)]
pub struct KillSwitch(Arc<AtomicU64>);

impl KillSwitch {
    /// Emergency stop at the next output callback, latched until [`DriveHandle::rearm`].
    pub fn kill(&self) {
        self.0.fetch_add(1, Ordering::AcqRel);
    }

    /// Kills so far.
    #[must_use]
    pub fn kills(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }
}

/// The body of the output callback.
#[derive(Debug)]
pub(crate) struct OutputCallback {
    generator: Generator,
    orders: Consumer<Order>,
    kill_switch: KillSwitch,
    kills_obeyed: u64,
    publisher: Publisher,
    health: Health,
    channels: usize,
    drive_channel: usize,
}

/// The two ends of the output direction. `drive_channel < channels` is the caller's to check.
pub(crate) fn connect(
    generator: Generator,
    channels: usize,
    drive_channel: usize,
    health: Health,
) -> (OutputCallback, DriveHandle) {
    let (producer, consumer) = RingBuffer::new(COMMAND_RING);
    let (publisher, published) = published::channel();
    let kill_switch = KillSwitch::default();
    let callback = OutputCallback {
        generator,
        orders: consumer,
        kill_switch: kill_switch.clone(),
        kills_obeyed: 0,
        publisher,
        health,
        channels,
        drive_channel,
    };
    let handle = DriveHandle {
        orders: producer,
        kill_switch,
        monitor: DriveMonitor(published),
    };
    (callback, handle)
}

impl OutputCallback {
    /// Obeys the waiting commands, renders `out` (interleaved; every channel but the drive's is
    /// silent), publishes the state. Neither allocates, locks, logs nor panics; asserted by
    /// `tests/duplex.rs`.
    pub(crate) fn render<T: ConverterSample>(&mut self, out: &mut [T]) {
        self.health.beat(Direction::Output);
        self.obey();
        let mut drive = [0.0_f32; CHUNK_FRAMES];
        for chunk in out.chunks_mut(CHUNK_FRAMES * self.channels) {
            let frames = chunk.len() / self.channels;
            let drive = &mut drive[..frames];
            self.generator.fill(drive);
            chunk.fill(T::ZERO);
            for (frame, &value) in chunk.chunks_exact_mut(self.channels).zip(drive.iter()) {
                frame[self.drive_channel] = T::from_unit(value);
            }
        }
        self.publisher.publish(&self.generator.state());
    }

    fn obey(&mut self) {
        while let Ok(order) = self.orders.pop() {
            self.obey_kills();
            if order.command == Command::Rearm && order.kills_known != self.kills_obeyed {
                continue;
            }
            self.generator.apply(order.command);
        }
        self.obey_kills();
        if self.orders.is_abandoned() {
            self.generator.apply(Command::EmergencyStop);
        }
    }

    fn obey_kills(&mut self) {
        let kills = self.kill_switch.kills();
        if kills != self.kills_obeyed {
            self.kills_obeyed = kills;
            self.generator.apply(Command::EmergencyStop);
        }
    }
}
