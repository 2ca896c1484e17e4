//! Safety is nobody's passenger: this task watches the apparatus from its own thread and needs neither the screen nor the
//! disk nor the protocol. Whatever it finds wrong ends the same way: the drive ramps to zero, the amplifier's heartbeat
//! stops, and the state latches until the operator re-arms.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::Receiver;
use serde::Serialize;

use crate::force::SENSITIVITY;
use crate::gpio::{GpioError, Input, Output};
use crate::readback::{Misfit, Readback};
use crate::schedule::Task;
use crate::shared::{Press, Shared};

/// Limits that the watch enforces; from `[safety]` in `bench.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetyLimits {
    /// Largest normal force a finger may be met with, N.
    pub max_normal_n: f64,
    /// Largest lateral force either way, N.
    pub max_lateral_n: f64,
    /// Relative difference of the read-back from the commanded envelope.
    pub readback_tolerance: f64,
    /// Read-back below this is silence, V.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, ns.
    pub loop_latency_ns: u64,
    /// Rate of the samples, Hz.
    pub rate_hz: f64,
    /// Longest silence of the sound card or of the force sensor, ns.
    pub silence_ns: u64,
}

/// Why the bench stopped.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum Trip {
    /// The operator's key, or a program that asked for it.
    Operator,
    /// The e-stop loop is open: pressed, or its wire cut.
    EmergencyStop,
    /// A GPIO line failed.
    Gpio {
        /// What the backend said.
        message: String,
    },
    /// The sound card stopped calling.
    AudioSilent,
    /// The sound card is gone.
    AudioLost,
    /// The force sensor stopped sending.
    ForceSilent,
    /// Too much normal force.
    ForceLimit {
        /// Measured, N.
        normal_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// Too much lateral force, either way.
    LateralForceLimit {
        /// Measured, N.
        lateral_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// Too much on the force sensor itself, whatever its calibration makes of it: a wrong calibration hides no press.
    RawForceLimit {
        /// Which of its axes.
        axis: &'static str,
        /// What the sensor says, N.
        raw_n: f64,
        /// Allowed, N.
        limit_n: f64,
    },
    /// The normal axis is at the end of its range: how hard the finger presses is not known.
    ForceSaturated,
    /// The read-back is not what was commanded: amplifier off, cable out, gain changed.
    Readback {
        /// Measured peak, V.
        measured_v: f64,
        /// Least and greatest command within the loop's latency, V.
        commanded_v: (f64, f64),
    },
    /// The drive is alive although the bench is disarmed: a welded relay, another generator.
    AliveWhileDisarmed {
        /// Measured peak, V.
        measured_v: f64,
    },
    /// The generator refused its own output.
    Generator,
    /// The kill switch was thrown by another than the watch: a part of the program panicked.
    Killed,
    /// The watch itself did not run: the program was frozen, or the computer too busy to be trusted.
    Frozen {
        /// For so long, s.
        for_s: f64,
    },
    /// Nothing is read back of the drive.
    ReadbackMissing,
    /// A part of the bench failed.
    Fault {
        /// What it said.
        message: String,
    },
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operator => f.write_str("stopped by the operator"),
            Self::EmergencyStop => f.write_str("e-stop pressed or its wire cut"),
            Self::Gpio { message } => f.write_str(message),
            Self::AudioSilent => f.write_str("the sound card stopped calling"),
            Self::AudioLost => f.write_str("the sound card is gone"),
            Self::ForceSilent => f.write_str("the force sensor is silent"),
            Self::ForceLimit { normal_n, limit_n } => {
                write!(
                    f,
                    "normal force {normal_n:.2} N over the limit of {limit_n:.2} N"
                )
            }
            Self::LateralForceLimit { lateral_n, limit_n } => {
                write!(
                    f,
                    "lateral force {lateral_n:.2} N over the limit of {limit_n:.2} N either way"
                )
            }
            Self::RawForceLimit {
                axis,
                raw_n,
                limit_n,
            } => write!(
                f,
                "the force sensor itself reads {raw_n:.2} N on its {axis} axis, over the limit of {limit_n:.2} N for any calibration: calibrate it again"
            ),
            Self::ForceSaturated => {
                f.write_str("the normal force is beyond the force sensor's range")
            }
            Self::Readback {
                measured_v,
                commanded_v: (low_v, high_v),
            } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V, commanded {low_v:.1} to {high_v:.1} V"
                )
            }
            Self::AliveWhileDisarmed { measured_v } => {
                write!(
                    f,
                    "drive reads back {measured_v:.1} V although disarmed: switch the amplifier off at the mains"
                )
            }
            Self::Generator => f.write_str("the generator refused an impossible output"),
            Self::Killed => f.write_str("a part of the program failed and stopped the drive"),
            Self::Frozen { for_s } => {
                write!(f, "the safety watch itself did not run for {for_s:.2} s")
            }
            Self::ReadbackMissing => f.write_str("the drive is not read back any more"),
            Self::Fault { message } => f.write_str(message),
        }
    }
}

/// State of the watch, for every screen and file.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum SafetyState {
    /// Amplifier off.
    #[default]
    Disarmed,
    /// Amplifier enabled, heartbeat running.
    Armed,
    /// Stopped and latched.
    Tripped {
        /// Why.
        trip: Trip,
    },
}

/// What the rest of the bench may ask of the watch.
#[derive(Debug, Clone, PartialEq)]
pub enum SafetyCommand {
    /// Enable the amplifier; refused while tripped.
    Arm,
    /// Disable the amplifier in an orderly way.
    Disarm,
    /// Stop at once.
    Trip(Trip),
    /// The operator has looked: back to disarmed.
    Rearm,
}

/// What the drive was last told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Commanded {
    /// The latest rendered frame.
    pub frame: u64,
    /// Envelope there, V peak.
    pub envelope_v: f64,
}

/// The drive, as far as safety is concerned.
pub trait DriveGuard: Send {
    /// Ramps the drive to zero at once and latches it, until its owner releases it after a new arming.
    fn kill(&self);
    /// How often it was killed, by anybody.
    fn kills(&self) -> u64;
    /// What is commanded; `None` once the generator refused its own output.
    fn commanded(&self) -> Option<Commanded>;
    /// Callbacks of the card so far, (output, input).
    fn callbacks(&self) -> (u64, u64);
    /// The card was lost.
    fn lost(&self) -> bool;
}

/// Lines that belong to the watch alone.
#[derive(Default)]
pub struct SafetyLines {
    /// See [`crate::gpio::Lines`].
    pub estop: Option<Box<dyn Input>>,
    /// See [`crate::gpio::Lines`].
    pub enable: Option<Box<dyn Output>>,
    /// See [`crate::gpio::Lines`].
    pub heartbeat: Option<Box<dyn Output>>,
}

/// The watch.
pub struct Safety {
    limits: SafetyLimits,
    lines: SafetyLines,
    drive: Box<dyn DriveGuard>,
    expects_force: bool,
    shared: Arc<Shared>,
    commands: Receiver<SafetyCommand>,
    state: SafetyState,
    beat: bool,
    progress: Progress,
    readback: Readback,
    tripped_at_ns: u64,
    armed_at_ns: u64,
    /// Kills that the watch knows of: its own.
    kills_known: u64,
    polled_ns: Option<u64>,
    /// Whether the amplifier could be taken off at the end.
    farewell: Result<(), GpioError>,
}

/// When each direction of the card last moved.
#[derive(Default)]
struct Progress {
    frames: (u64, u64),
    moved_ns: (u64, u64),
    begun: bool,
}

/// A task that was not run for this long leaves the watch without its eyes, ns.
const DEAF_NS: u64 = 250_000_000;
/// The hardware's own limit: its one-shot takes the amplifier off after this long without a heartbeat, ns.
const ONE_SHOT_NS: u64 = 100_000_000;
/// At the end the emergency ramp is waited for no longer than this.
const LONGEST_FAREWELL: Duration = Duration::from_millis(30);
/// An armed bench waits no longer for the force sensor's first word, ns (FAULTS.md row 21).
const FIRST_WORD_NS: u64 = 1_000_000_000;
/// The amplifier is disabled this long after a trip: the emergency ramp is over by then.
const DISABLE_AFTER_NS: u64 = 20_000_000;

impl Safety {
    /// A disarmed watch.
    pub fn new(
        limits: SafetyLimits,
        lines: SafetyLines,
        drive: Box<dyn DriveGuard>,
        expects_force: bool,
        shared: Arc<Shared>,
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
            shared,
            commands,
            state: SafetyState::Disarmed,
            beat: false,
            progress: Progress::default(),
            readback,
            tripped_at_ns: 0,
            armed_at_ns: 0,
            kills_known: 0,
            polled_ns: None,
            farewell: Ok(()),
        }
    }

    fn set_state(&mut self, state: SafetyState) {
        self.state = state.clone();
        self.shared.safety.set(state);
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

    fn obey(&mut self, command: SafetyCommand, now_ns: u64) -> Result<(), GpioError> {
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
    fn wrong(&mut self, now_ns: u64) -> Result<Option<Trip>, GpioError> {
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
        let reading = self.shared.readback.get()?;
        let age_ns = now_ns.saturating_sub(reading.at_ns);
        if age_ns > self.limits.loop_latency_ns.max(DEAF_NS) {
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
        }) = self.shared.press.get()
        else {
            // The preflight knew a sensor that talks; this one may need its time for the first word, and no more.
            let mute_ns = now_ns.saturating_sub(self.armed_at_ns);
            return (mute_ns > FIRST_WORD_NS).then_some(Trip::ForceSilent);
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
        let polled_ns = self.shared.force_polled_ns.get()?;
        if now_ns.saturating_sub(polled_ns) > DEAF_NS {
            return Some(Trip::Fault {
                message: "the force sensor was not read for a quarter of a second".to_owned(),
            });
        }
        (polled_ns.saturating_sub(at_ns) > self.limits.silence_ns).then_some(Trip::ForceSilent)
    }

    fn watch(&mut self, now_ns: u64) -> Result<(), GpioError> {
        while let Ok(command) = self.commands.try_recv() {
            self.obey(command, now_ns)?;
        }
        let wrong = self.wrong(now_ns)?;
        match (&self.state, wrong) {
            (SafetyState::Armed, None) => {
                self.beat = !self.beat;
                set(&mut self.lines.heartbeat, self.beat)?;
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

fn set(line: &mut Option<Box<dyn Output>>, high: bool) -> Result<(), GpioError> {
    line.as_mut().map_or(Ok(()), |line| line.set(high))
}

impl Task for Safety {
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
        let sounds =
            |drive: &dyn DriveGuard| drive.commanded().is_some_and(|c| c.envelope_v != 0.0);
        while sounds(self.drive.as_ref()) && begun.elapsed() < LONGEST_FAREWELL {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.farewell = set(&mut self.lines.enable, false);
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(std::mem::replace(&mut self.farewell, Ok(()))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::DriveReading;
    use std::sync::atomic::{AtomicU64, Ordering};

    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};

    #[derive(Clone)]
    struct Card {
        kills: Arc<AtomicU64>,
        frames: Arc<AtomicU64>,
        commanded_v: Arc<crate::shared::Slot<f64>>,
    }

    impl DriveGuard for Card {
        fn kill(&self) {
            self.kills.fetch_add(1, Ordering::Relaxed);
        }
        fn kills(&self) -> u64 {
            self.kills.load(Ordering::Relaxed)
        }
        fn commanded(&self) -> Option<Commanded> {
            self.commanded_v.get().map(|envelope_v| Commanded {
                frame: self.frames.load(Ordering::Relaxed),
                envelope_v,
            })
        }
        fn callbacks(&self) -> (u64, u64) {
            let frames = self.frames.load(Ordering::Relaxed);
            (frames, frames)
        }
        fn lost(&self) -> bool {
            false
        }
    }

    fn press(normal_n: f64, at_ns: u64) -> Press {
        Press {
            normal_n,
            lateral_n: 0.3,
            raw_n: [normal_n, 0.3],
            saturated: false,
            at_ns,
        }
    }

    struct Rig {
        safety: Safety,
        card: Card,
        shared: Arc<Shared>,
        ask: crossbeam_channel::Sender<SafetyCommand>,
        now_ms: u64,
        /// The force sensor says nothing that can be read.
        mute: bool,
    }

    impl Rig {
        fn new(lines: SafetyLines) -> Self {
            let limits = SafetyLimits {
                max_normal_n: 3.0,
                max_lateral_n: 2.0,
                readback_tolerance: 0.2,
                readback_floor_v: 0.5,
                loop_latency_ns: 50_000_000,
                rate_hz: 192e3,
                silence_ns: 50_000_000,
            };
            let card = Card {
                kills: Arc::default(),
                frames: Arc::default(),
                commanded_v: Arc::default(),
            };
            card.commanded_v.set(0.0);
            let shared = Arc::new(Shared::default());
            let (ask, commands) = crossbeam_channel::unbounded();
            let safety = Safety::new(
                limits,
                lines,
                Box::new(card.clone()),
                true,
                shared.clone(),
                commands,
            );
            let mut rig = Self {
                safety,
                card,
                shared,
                ask,
                now_ms: 0,
                mute: false,
            };
            rig.pass(10, |_| ());
            rig
        }

        fn read_back(&self, volts: f64) {
            self.shared.readback.set(DriveReading {
                volts,
                sample: self.card.frames.load(Ordering::Relaxed),
                at_ns: self.now_ms * 1_000_000,
            });
        }

        /// Lets time pass with everything alive but for what `change` does each millisecond.
        fn pass(&mut self, ms: u64, change: impl Fn(&Self)) {
            for _ in 0..ms {
                self.now_ms += 1;
                let now_ns = self.now_ms * 1_000_000;
                self.card.frames.fetch_add(192, Ordering::Relaxed);
                self.shared.force_polled_ns.set(now_ns);
                if !self.mute {
                    self.shared.press.set(press(0.65, now_ns));
                }
                let commanded_v = self.card.commanded_v.get().unwrap_or(0.0);
                self.read_back(commanded_v);
                change(self);
                self.safety.poll(now_ns).unwrap();
            }
        }

        fn armed(lines: SafetyLines) -> Self {
            let mut rig = Self::new(lines);
            rig.ask.send(SafetyCommand::Arm).unwrap();
            rig.card.commanded_v.set(20.0);
            rig.pass(100, |_| ());
            assert_eq!(rig.safety.state, SafetyState::Armed);
            rig
        }

        fn trip(&self) -> Option<Trip> {
            match &self.safety.state {
                SafetyState::Tripped { trip } => Some(trip.clone()),
                _ => None,
            }
        }
    }

    #[test]
    fn a_wrong_readback_stops_the_drive_within_50_ms() {
        let mut rig = Rig::armed(SafetyLines::default());
        let dead = |rig: &Rig| rig.read_back(0.0);
        rig.pass(15, dead);
        assert_eq!(rig.trip(), None);
        rig.pass(15, dead);
        assert!(matches!(rig.trip(), Some(Trip::Readback { .. })));
        assert!(rig.card.kills() > 0);
    }

    #[test]
    fn modulation_within_the_loops_latency_is_not_a_wrong_readback() {
        let mut rig = Rig::armed(SafetyLines::default());
        for ms in 0..400u64 {
            let volts = |ms: u64| {
                20.0 * (1.0 + 0.95 * (std::f64::consts::TAU * 6.0 * ms as f64 * 1e-3).sin())
            };
            rig.card.commanded_v.set(volts(ms + 40));
            rig.pass(1, |rig| rig.read_back(volts(ms)));
        }
        assert_eq!(rig.trip(), None);
    }

    #[test]
    fn a_drive_that_is_alive_while_disarmed_is_an_alarm() {
        let mut rig = Rig::new(SafetyLines::default());
        rig.pass(60, |rig| rig.read_back(12.0));
        assert!(matches!(rig.trip(), Some(Trip::AliveWhileDisarmed { .. })));
    }

    #[test]
    fn silence_of_the_force_sensor_or_of_the_card_stops_the_drive() {
        let mut rig = Rig::armed(SafetyLines::default());
        rig.pass(60, |rig| {
            rig.shared.press.set(press(0.6, 100_000_000));
        });
        assert_eq!(rig.trip(), Some(Trip::ForceSilent));

        let mut rig = Rig::armed(SafetyLines::default());
        let frames = rig.card.frames.load(Ordering::Relaxed);
        rig.pass(60, |rig| rig.card.frames.store(frames, Ordering::Relaxed));
        assert_eq!(rig.trip(), Some(Trip::AudioSilent));
    }

    #[test]
    fn a_force_sensor_that_never_speaks_stops_the_drive_after_a_second() {
        let mut rig = Rig::new(SafetyLines::default());
        rig.shared = Arc::new(Shared::default());
        rig.safety.shared = rig.shared.clone();
        rig.mute = true;
        rig.pass(2000, |_| ());
        assert_eq!(rig.trip(), None, "nothing is armed");
        rig.ask.send(SafetyCommand::Arm).unwrap();
        rig.pass(1000, |_| ());
        assert_eq!(rig.safety.state, SafetyState::Armed);
        rig.pass(2, |_| ());
        assert_eq!(rig.trip(), Some(Trip::ForceSilent));
    }

    #[test]
    fn too_much_force_stops_the_drive_and_only_the_operator_releases_it() {
        let mut rig = Rig::armed(SafetyLines::default());
        rig.pass(1, |rig| {
            rig.shared.press.set(press(3.5, rig.now_ms * 1_000_000));
        });
        assert_eq!(
            rig.trip(),
            Some(Trip::ForceLimit {
                normal_n: 3.5,
                limit_n: 3.0
            })
        );
        rig.card.commanded_v.set(0.0);
        rig.ask.send(SafetyCommand::Arm).unwrap();
        rig.pass(100, |_| ());
        assert!(rig.trip().is_some(), "arming must not release a trip");
        rig.ask.send(SafetyCommand::Rearm).unwrap();
        rig.pass(1, |_| ());
        assert_eq!(rig.safety.state, SafetyState::Disarmed);
    }

    #[test]
    fn too_much_lateral_force_stops_the_drive_whichever_way_it_pulls() {
        for sign in [1.0, -1.0] {
            let mut rig = Rig::armed(SafetyLines::default());
            let pulled = |lateral_n: f64| {
                move |rig: &Rig| {
                    rig.shared.press.set(Press {
                        lateral_n,
                        ..press(0.6, rig.now_ms * 1_000_000)
                    });
                }
            };
            rig.pass(10, pulled(sign * 1.99));
            assert_eq!(rig.trip(), None, "the normal limit is another");
            rig.pass(1, pulled(sign * 2.01));
            let trip = rig.trip().unwrap();
            assert_eq!(
                trip,
                Trip::LateralForceLimit {
                    lateral_n: sign * 2.01,
                    limit_n: 2.0
                }
            );
            let said = trip.to_string();
            assert!(
                said.contains("lateral force") && said.contains("2.01 N"),
                "{said}"
            );
            rig.pass(100, |_| ());
            assert!(rig.trip().is_some(), "it latches");
        }
    }

    #[test]
    fn a_wrong_calibration_or_a_sensor_at_its_end_hides_no_press() {
        let hidden = |raw_n: [f64; 2]| {
            move |rig: &Rig| {
                rig.shared.press.set(Press {
                    raw_n,
                    ..press(0.5, rig.now_ms * 1_000_000)
                });
            }
        };
        // Twice the limits of 3 N and of 2 N.
        for (under_n, over_n, axis, raw_n, limit_n) in [
            ([5.9, 0.0], [6.1, 0.0], "normal", 6.1, 6.0),
            ([0.5, 3.9], [0.5, 4.1], "lateral", 4.1, 4.0),
            ([0.5, -3.9], [0.5, -4.1], "lateral", -4.1, 4.0),
        ] {
            let mut rig = Rig::armed(SafetyLines::default());
            rig.pass(10, hidden(under_n));
            assert_eq!(rig.trip(), None);
            rig.pass(1, hidden(over_n));
            assert_eq!(
                rig.trip(),
                Some(Trip::RawForceLimit {
                    axis,
                    raw_n,
                    limit_n
                })
            );
        }

        let mut rig = Rig::armed(SafetyLines::default());
        rig.pass(1, |rig| {
            rig.shared.press.set(Press {
                saturated: true,
                ..press(2.0, rig.now_ms * 1_000_000)
            });
        });
        assert_eq!(rig.trip(), Some(Trip::ForceSaturated));
    }

    #[test]
    fn a_watch_that_was_frozen_does_not_go_on_as_if_nothing_had_been() {
        let mut rig = Rig::armed(SafetyLines::default());
        rig.now_ms += 90;
        rig.pass(1, |_| ());
        assert_eq!(rig.trip(), None, "the one-shot still waits");
        rig.now_ms += 300;
        rig.pass(1, |_| ());
        assert!(matches!(rig.trip(), Some(Trip::Frozen { for_s }) if (for_s - 0.301).abs() < 1e-9));
        rig.pass(1000, |_| ());
        assert!(rig.trip().is_some(), "it latches");
    }

    #[test]
    fn a_kill_by_another_latches_armed_or_not() {
        for mut rig in [
            Rig::armed(SafetyLines::default()),
            Rig::new(SafetyLines::default()),
        ] {
            rig.card.kill();
            rig.pass(1, |_| ());
            assert_eq!(rig.trip(), Some(Trip::Killed));
            rig.card.commanded_v.set(0.0);
            rig.pass(100, |_| ());
            rig.ask.send(SafetyCommand::Rearm).unwrap();
            rig.pass(100, |_| ());
            assert_eq!(rig.trip(), None, "its own kills are known to the watch");
        }
    }

    #[test]
    fn a_drive_that_is_not_read_back_any_more_is_stopped() {
        let mut rig = Rig::armed(SafetyLines::default());
        let last = rig.shared.readback.get();
        rig.pass(300, |rig| rig.shared.readback.set(last.unwrap()));
        assert_eq!(rig.trip(), Some(Trip::ReadbackMissing));
    }

    #[test]
    fn a_pressed_e_stop_outlasts_the_operators_rearming_and_raises_no_enable() {
        let estop = Mock::new(&[
            Transaction::get(State::Low),  // rearm asked for
            Transaction::get(State::Low),  // watched
            Transaction::get(State::High), // rearm asked for again
            Transaction::get(State::High), // watched
            Transaction::get(State::Low),  // arm asked for
            Transaction::get(State::Low),  // watched
        ]);
        let enable = Mock::new(&[Transaction::set(State::Low)]);
        let mut rig = Rig::new(SafetyLines::default());
        rig.ask.send(SafetyCommand::Trip(Trip::Operator)).unwrap();
        rig.pass(1, |_| ());
        let mut pins = (estop.clone(), enable.clone());
        rig.safety.lines.estop = Some(crate::gpio::input("e-stop", estop));
        rig.safety.lines.enable = Some(crate::gpio::output("enable", enable));
        rig.ask.send(SafetyCommand::Rearm).unwrap();
        rig.pass(1, |_| ());
        assert_eq!(rig.trip(), Some(Trip::Operator));
        rig.ask.send(SafetyCommand::Rearm).unwrap();
        rig.pass(1, |_| ());
        assert_eq!(rig.trip(), None);
        rig.ask.send(SafetyCommand::Arm).unwrap();
        rig.now_ms += 30;
        rig.pass(1, |_| ());
        assert_eq!(rig.trip(), Some(Trip::EmergencyStop));
        rig.safety.lines.estop = None;
        rig.pass(20, |_| ());
        pins.0.done();
        pins.1.done();
    }

    #[test]
    fn an_e_stop_line_that_cannot_be_read_takes_the_amplifier_off_all_the_same() {
        use embedded_hal_mock::eh1::MockError;
        let unplugged = || MockError::Io(std::io::ErrorKind::NotConnected);
        let reads: Vec<Transaction> = (0..40)
            .map(|_| Transaction::get(State::High).with_error(unplugged()))
            .collect();
        let estop = Mock::new(&reads);
        let lows: Vec<Transaction> = (0..20).map(|_| Transaction::set(State::Low)).collect();
        let enable = Mock::new(&lows);
        let mut rig = Rig::armed(SafetyLines::default());
        let mut pins = (estop.clone(), enable.clone());
        rig.safety.lines.estop = Some(crate::gpio::input("e-stop", estop));
        rig.safety.lines.enable = Some(crate::gpio::output("enable", enable));
        rig.pass(40, |_| ());
        assert!(matches!(rig.trip(), Some(Trip::Gpio { .. })));
        pins.0.done();
        pins.1.done();
    }

    #[test]
    fn a_cut_e_stop_wire_stops_heartbeat_and_enable() {
        let estop = Mock::new(
            &[
                State::High,
                State::High,
                State::High,
                State::Low,
                State::Low,
            ]
            .map(Transaction::get),
        );
        let enable = Mock::new(&[State::High, State::Low].map(Transaction::set));
        // One beat, then none.
        let heartbeat = Mock::new(&[Transaction::set(State::High)]);
        let pins = (estop.clone(), enable.clone(), heartbeat.clone());
        let lines = SafetyLines {
            estop: Some(crate::gpio::input("e-stop", estop)),
            enable: Some(crate::gpio::output("enable", enable)),
            heartbeat: Some(crate::gpio::output("heartbeat", heartbeat)),
        };
        let shared = Arc::new(Shared::default());
        let (ask, commands) = crossbeam_channel::unbounded();
        let card = Card {
            kills: Arc::default(),
            frames: Arc::default(),
            commanded_v: Arc::default(),
        };
        card.commanded_v.set(0.0);
        let limits = SafetyLimits {
            max_normal_n: 3.0,
            max_lateral_n: 2.0,
            readback_tolerance: 0.2,
            readback_floor_v: 0.5,
            loop_latency_ns: 50_000_000,
            rate_hz: 192e3,
            silence_ns: 50_000_000,
        };
        let mut safety = Safety::new(
            limits,
            lines,
            Box::new(card.clone()),
            false,
            shared,
            commands,
        );
        safety.poll(0).unwrap();
        ask.send(SafetyCommand::Arm).unwrap();
        safety.poll(1_000_000).unwrap();
        safety.poll(2_000_000).unwrap();
        assert_eq!(
            safety.state,
            SafetyState::Tripped {
                trip: Trip::EmergencyStop
            }
        );
        assert!(card.kills() > 0);
        safety.poll(30_000_000).unwrap();
        let (mut estop, mut enable, mut heartbeat) = pins;
        estop.done();
        enable.done();
        heartbeat.done();
    }
}
