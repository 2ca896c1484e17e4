//! Life of a bench: opened, made safe, played, run, silenced, closed, always in this order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use safety::DriveStop;
use signalgen::audio::{Host, Streams};
use signalgen::{KillSwitch, StreamDirection};
use tasks::{Clock, Panicked, Schedule, StopFlag, Task};

use crate::signals::{Listening, stop_drive_on_signals};

/// An opened bench that has not run yet. From here on a panic first silences the drive, and signals request an orderly
/// stop. Dropped without having run, it closes the streams.
pub struct Life {
    host: Host,
    streams: Streams,
    kill: KillSwitch,
    drive_stop: DriveStop,
    stop: StopFlag,
    /// Whether any thread of the program has panicked since the bench was opened.
    panicked: Arc<AtomicBool>,
    clock: Arc<dyn Clock>,
    schedule: Schedule,
    /// Value that must outlive the streams.
    guard: Box<dyn Send>,
    /// Registration by which signals end this bench in good order.
    listening: Listening,
}

impl Life {
    pub(crate) fn begin(
        host: Host,
        streams: Streams,
        (kill, drive_stop): (KillSwitch, DriveStop),
        clock: Arc<dyn Clock>,
        schedule: Schedule,
        guard: Box<dyn Send>,
    ) -> anyhow::Result<Self> {
        let (stop, panicked) = (StopFlag::default(), Arc::default());
        end_on_panic(kill.clone(), stop.clone(), Arc::clone(&panicked));
        let listening = stop_drive_on_signals(&stop, drive_stop.clone())?;
        Ok(Self {
            host,
            streams,
            kill,
            drive_stop,
            stop,
            panicked,
            clock,
            schedule,
            guard,
            listening,
        })
    }

    /// Returns the flag that ends the bench.
    #[must_use]
    pub fn stop(&self) -> &StopFlag {
        &self.stop
    }

    /// Returns the bench's clock.
    #[must_use]
    pub fn clock(&self) -> &Arc<dyn Clock> {
        &self.clock
    }

    /// Returns the sound layer of the participant's cues.
    #[must_use]
    pub fn host(&self) -> &Host {
        &self.host
    }

    /// Returns the opened streams.
    #[must_use]
    pub fn streams(&self) -> &Streams {
        &self.streams
    }

    /// Returns the name of the device opened in a direction.
    #[must_use]
    pub fn device(&self, direction: StreamDirection) -> String {
        self.streams.device(direction).to_string()
    }

    /// Returns the switch that silences the drive from anywhere.
    #[must_use]
    pub fn kill_switch(&self) -> &KillSwitch {
        &self.kill
    }

    /// Returns the stop for the threads that read keys or signals.
    #[must_use]
    pub fn drive_stop(&self) -> &DriveStop {
        &self.drive_stop
    }

    /// Plays the streams and runs `tasks` until the bench is stopped or one of them fails; then silences the drive,
    /// closes the streams, and calls `close_screen` to wait for the operator's terminal.
    ///
    /// # Errors
    /// The first error of any task, or else the screen's error.
    pub fn run(
        self,
        tasks: Vec<Box<dyn Task>>,
        close_screen: impl FnOnce() -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let outcome = match self.streams.play() {
            Ok(()) => self.schedule.run(tasks, &self.clock, &self.stop),
            Err(error) => {
                // Without its tasks the screen has nothing to show, and closes.
                drop(tasks);
                Err(error.into())
            }
        };
        self.kill.kill();
        drop(self.streams);
        drop(self.guard);
        let screen_result = close_screen();
        drop(self.listening);
        let result = outcome.and(screen_result);
        if self.panicked.load(Ordering::Acquire) {
            return Err(match result {
                Err(error) if !error.is::<Panicked>() => error.context(EndedByPanic),
                // The panic hook has named the part.
                _ => EndedByPanic.into(),
            });
        }
        result
    }
}

/// An error of the program ended a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "an error in the program itself ended the bench: the drive was stopped first, and the recording up to then is \
     kept; look at the plate and at the amplifier, then run the command again (`run` with --resume), and report the \
     line above"
)]
pub struct EndedByPanic;

/// Installs a panic hook that silences the drive and ends the bench in good order on a panic of any thread; it then
/// calls the previous hook, which reports.
fn end_on_panic(kill: KillSwitch, stop: StopFlag, panicked: Arc<AtomicBool>) {
    let previous_hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        kill.kill();
        panicked.store(true, Ordering::Release);
        let thread = std::thread::current();
        let part = thread.name().unwrap_or("without a name");
        stop.fail(format!(
            "an error in the program itself, in its part `{part}`"
        ));
        previous_hook(info);
    }));
}
