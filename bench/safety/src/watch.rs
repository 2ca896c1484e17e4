//! The watch: a task that judges the bench every two milliseconds and stops the drive when anything is wrong.

#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::Receiver;
use tasks::Task;

use crate::guard::{Commanded, DriveGuard};
use crate::readback::{Misfit, Readback};
use crate::safety_limits::{SENSITIVITY, SafetyLimits};
use crate::safety_lines::{GpioError, OutputLine, SafetyLines};
use crate::safety_state::{SafetyCommand, SafetyState};
use crate::signals::{Press, Signals};
use crate::trip::Trip;

/// The watch.
pub struct Watch {
    limits: SafetyLimits,
    lines: SafetyLines,
    drive: Box<dyn DriveGuard>,
    expects_force: bool,
    signals: Arc<Signals>,
    commands: Receiver<SafetyCommand>,
    state: SafetyState,
    heartbeat_high: bool,
    progress: Progress,
    readback: Readback,
    tripped_at_ns: u64,
    armed_at_ns: u64,
    /// Kills that the watch knows of: its own.
    kills_known: u64,
    polled_ns: Option<u64>,
    /// Whether the amplifier could be taken off at the end.
    disable_result: Result<(), GpioError>,
}

/// When each direction of the card last moved.
#[derive(Default)]
struct Progress {
    frames: (u64, u64),
    moved_ns: (u64, u64),
    begun: bool,
}

/// A task that was not run for this long leaves the watch without its eyes, ns.
const STALE_NS: u64 = 250_000_000;
/// The hardware's own limit: its one-shot takes the amplifier off after this long without a heartbeat, ns.
const ONE_SHOT_NS: u64 = 100_000_000;
/// At the end the emergency ramp is waited for no longer than this.
const RAMP_TIMEOUT: Duration = Duration::from_millis(30);
/// An armed bench waits no longer for the force sensor's first word, ns (FAULTS.md row 21).
const FIRST_READING_TIMEOUT_NS: u64 = 1_000_000_000;
/// The amplifier is disabled this long after a trip: the emergency ramp is over by then.
const DISABLE_AFTER_NS: u64 = 20_000_000;

impl Watch {
    /// A disarmed watch.
    pub fn new(
        limits: SafetyLimits,
        lines: SafetyLines,
        drive: Box<dyn DriveGuard>,
        expects_force: bool,
        signals: Arc<Signals>,
        commands: Receiver<SafetyCommand>,
    ) -> Self {
        let readback = Readback::new(
            limits.rate_hz,
            limits.loop_latency_ns as f64 * 1e-9,
            limits.readback_tolerance,
            limits.readback_floor_v,
        );
        Self {
            limits,
            lines,
            drive,
            expects_force,
            signals,
            commands,
            state: SafetyState::Disarmed,
            heartbeat_high: false,
            progress: Progress::default(),
            readback,
            tripped_at_ns: 0,
            armed_at_ns: 0,
            kills_known: 0,
            polled_ns: None,
            disable_result: Ok(()),
        }
    }

    fn set_state(&mut self, state: SafetyState) {
        self.state = state.clone();
        self.signals.state.set(state);
    }

    fn trip(&mut self, trip: Trip, now_ns: u64) {
        self.drive.kill();
        self.kills_known = self.drive.kills();
        // The first reason is the one to tell: what follows is its consequence.
        if !self.is_tripped() {
            self.tripped_at_ns = now_ns;
            self.set_state(SafetyState::Tripped { trip });
        }
    }

    fn is_tripped(&self) -> bool {
        matches!(self.state, SafetyState::Tripped { .. })
    }

    fn e_stop_open(&mut self) -> Result<bool, GpioError> {
        match &mut self.lines.estop {
            Some(estop) => Ok(!estop.is_high()?),
            None => Ok(false),
        }
    }

    fn handle_command(&mut self, command: SafetyCommand, now_ns: u64) -> Result<(), GpioError> {
        let releases = matches!(command, SafetyCommand::Arm | SafetyCommand::Rearm);
        let pressed = releases && self.e_stop_open()?;
        match (command, &self.state) {
            (SafetyCommand::Trip(trip), _) => self.trip(trip, now_ns),
            (SafetyCommand::Arm, SafetyState::Disarmed) if pressed => {
                self.trip(Trip::EmergencyStop, now_ns);
            }
            (SafetyCommand::Arm, SafetyState::Disarmed) => {
                set(&mut self.lines.enable, true)?;
                self.readback.forget_readings();
                self.armed_at_ns = now_ns;
                self.set_state(SafetyState::Armed);
            }
            (SafetyCommand::Disarm, SafetyState::Armed) => {
                set(&mut self.lines.enable, false)?;
                self.set_state(SafetyState::Disarmed);
            }
            // Pressed, it holds whatever the operator says.
            (SafetyCommand::Rearm, SafetyState::Tripped { .. }) if pressed => {}
            (SafetyCommand::Rearm, SafetyState::Tripped { .. }) => {
                self.readback.forget_readings();
                self.set_state(SafetyState::Disarmed);
            }
            _ => {}
        }
        Ok(())
    }

    /// The first thing that is wrong now.
    fn first_fault(&mut self, now_ns: u64) -> Result<Option<Trip>, GpioError> {
        if self.e_stop_open()? {
            return Ok(Some(Trip::EmergencyStop));
        }
        if self.drive.kills() != self.kills_known {
            return Ok(Some(Trip::Killed));
        }
        if let Some(trip) = self.frozen(now_ns) {
            return Ok(Some(trip));
        }
        if self.drive.lost() {
            return Ok(Some(Trip::AudioLost));
        }
        let Some(commanded) = self.drive.commanded() else {
            return Ok(Some(Trip::Generator));
        };
        if let Some(trip) = self.audio_silent(now_ns) {
            return Ok(Some(trip));
        }
        if let Some(trip) = self.readback_wrong(commanded, now_ns) {
            return Ok(Some(trip));
        }
        Ok(self.force_wrong(now_ns))
    }

    /// Whoever was not there for longer than the one-shot waits has seen nothing, and the amplifier has gone by itself.
    fn frozen(&mut self, now_ns: u64) -> Option<Trip> {
        let away_ns = now_ns.saturating_sub(self.polled_ns.replace(now_ns)?);
        (away_ns > self.limits.silence_ns.max(ONE_SHOT_NS)).then_some(Trip::Frozen {
            for_s: away_ns as f64 * 1e-9,
        })
    }

    fn audio_silent(&mut self, now_ns: u64) -> Option<Trip> {
        let frames = self.drive.callbacks();
        let progress = &mut self.progress;
        if !progress.begun {
            *progress = Progress {
                frames,
                moved_ns: (now_ns, now_ns),
                begun: frames.0 > 0 && frames.1 > 0,
            };
            return None;
        }
        if frames.0 != progress.frames.0 {
            progress.moved_ns.0 = now_ns;
        }
        if frames.1 != progress.frames.1 {
            progress.moved_ns.1 = now_ns;
        }
        progress.frames = frames;
        let oldest_ns = progress.moved_ns.0.min(progress.moved_ns.1);
        (now_ns.saturating_sub(oldest_ns) > self.limits.silence_ns).then_some(Trip::AudioSilent)
    }

    fn readback_wrong(&mut self, commanded: Commanded, now_ns: u64) -> Option<Trip> {
        self.readback.command(commanded.frame, commanded.envelope_v);
        let reading = self.signals.readback.get()?;
        let age_ns = now_ns.saturating_sub(reading.at_ns);
        if age_ns > self.limits.loop_latency_ns.max(STALE_NS) {
            return Some(Trip::ReadbackMissing);
        }
        let misfit = self.readback.reading(reading.sample, reading.volts)?;
        let Misfit {
            measured_v,
            commanded_v,
        } = misfit;
        if self.state == SafetyState::Armed {
            return Some(Trip::Readback {
                measured_v,
                commanded_v,
            });
        }
        // Of a disarmed amplifier silence is expected, whatever is commanded.
        (measured_v > self.limits.readback_floor_v)
            .then_some(Trip::AliveWhileDisarmed { measured_v })
    }

    fn force_wrong(&self, now_ns: u64) -> Option<Trip> {
        if !self.expects_force {
            return None;
        }
        let Some(Press {
            normal_n,
            lateral_n,
            raw_n: [raw_normal_n, raw_lateral_n],
            saturated,
            at_ns,
        }) = self.signals.press.get()
        else {
            // The preflight knew a sensor that talks; this one may need its time for the first word, and no more.
            let waited_ns = now_ns.saturating_sub(self.armed_at_ns);
            return (waited_ns > FIRST_READING_TIMEOUT_NS).then_some(Trip::ForceSilent);
        };
        let limit_n = self.limits.max_normal_n;
        if normal_n > limit_n {
            return Some(Trip::ForceLimit { normal_n, limit_n });
        }
        let limit_n = self.limits.max_lateral_n;
        if lateral_n.abs() > limit_n {
            return Some(Trip::LateralForceLimit { lateral_n, limit_n });
        }
        // A plausible calibration makes at least this much of a newton read, so a right one is never stopped here first.
        let raw = |axis, raw_n: f64, over_n: f64, limit_n: f64| {
            let limit_n = limit_n / SENSITIVITY[0];
            (over_n > limit_n).then_some(Trip::RawForceLimit {
                axis,
                raw_n,
                limit_n,
            })
        };
        let trip = raw(
            "normal",
            raw_normal_n,
            raw_normal_n,
            self.limits.max_normal_n,
        )
        .or_else(|| {
            raw(
                "lateral",
                raw_lateral_n,
                raw_lateral_n.abs(),
                self.limits.max_lateral_n,
            )
        });
        if trip.is_some() {
            return trip;
        }
        // A saturated lateral axis is a flag of the recording and no stop: what the finger is pulled with stays bounded by the
        // normal force, which is known, and a drive that goes off raises the friction.
        if saturated {
            return Some(Trip::ForceSaturated);
        }
        // Silent is who was listened to and said nothing; a listener who was kept from listening is another fault.
        let polled_ns = self.signals.force_polled_ns.get()?;
        if now_ns.saturating_sub(polled_ns) > STALE_NS {
            return Some(Trip::Fault {
                message: "the force sensor was not read for a quarter of a second".to_owned(),
            });
        }
        (polled_ns.saturating_sub(at_ns) > self.limits.silence_ns).then_some(Trip::ForceSilent)
    }

    fn watch(&mut self, now_ns: u64) -> Result<(), GpioError> {
        while let Ok(command) = self.commands.try_recv() {
            self.handle_command(command, now_ns)?;
        }
        let wrong = self.first_fault(now_ns)?;
        match (&self.state, wrong) {
            (SafetyState::Armed, None) => {
                self.heartbeat_high = !self.heartbeat_high;
                set(&mut self.lines.heartbeat, self.heartbeat_high)?;
            }
            (SafetyState::Armed, Some(trip)) => self.trip(trip, now_ns),
            // Nothing drives a disarmed plate, so only a drive that is alive all the same matters, and a failure that is to latch.
            (
                SafetyState::Disarmed,
                Some(trip @ (Trip::AliveWhileDisarmed { .. } | Trip::Killed)),
            ) => self.trip(trip, now_ns),
            _ => {}
        }
        Ok(())
    }
}

fn set(line: &mut Option<Box<dyn OutputLine>>, high: bool) -> Result<(), GpioError> {
    line.as_mut().map_or(Ok(()), |line| line.set(high))
}

impl Task for Watch {
    fn name(&self) -> &'static str {
        "safety"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let mut watched = self.watch(now_ns);
        if self.is_tripped() && now_ns.saturating_sub(self.tripped_at_ns) >= DISABLE_AFTER_NS {
            // Also when another line cannot be read.
            watched = watched.and(set(&mut self.lines.enable, false));
        }
        if let Err(error) = watched {
            let message = error.to_string();
            self.trip(Trip::Gpio { message }, now_ns);
        }
        Ok(())
    }

    fn stop(&mut self) {
        self.drive.kill();
        // The amplifier goes after the ramp, or at once from a card that no longer calls.
        let begun = Instant::now();
        let is_driven =
            |drive: &dyn DriveGuard| drive.commanded().is_some_and(|c| c.envelope_v != 0.0);
        while is_driven(self.drive.as_ref()) && begun.elapsed() < RAMP_TIMEOUT {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.disable_result = set(&mut self.lines.enable, false);
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(std::mem::replace(&mut self.disable_result, Ok(()))?)
    }
}
