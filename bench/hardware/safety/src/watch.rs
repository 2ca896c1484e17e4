//! The watch: a task that judges the bench every two milliseconds and stops the drive on any fault.

mod decider;
mod person;
mod read_back;
mod readings;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use tasks::{Mailbox, Task, scheduling};

use crate::dead_man::DeadMan;
use crate::dose::{Allowance, Dose};
use crate::exercise::{Demand, Exercise};
use crate::guard::DriveGuard;
use crate::loop_delay::DelayMeter;
use crate::losses::LostDevice;
use crate::readback::Readback;
use crate::safety_limits::{SENSITIVITY, SafetyLimits};
use crate::safety_lines::{GpioError, LineLevels, OutputLine, SafetyLines};
use crate::safety_state::{SafetyCommand, SafetyState};
use crate::signals::{Nonsense, Press, Signals};
use crate::stop_times::StopLine;
use crate::trip::Trip;
use decider::Decider;
use readings::{LatestReadings, Unpublished};

/// Task that judges the bench every two milliseconds and stops the drive; see [`Watch::new`] for an example.
pub struct Watch {
    limits: SafetyLimits,
    lines: SafetyLines,
    drive: Box<dyn DriveGuard>,
    expects_force: bool,
    signals: Arc<Signals>,
    readings: LatestReadings,
    commands: Mailbox<SafetyCommand>,
    state: SafetyState,
    /// Values to be published as soon as their slots are free.
    unpublished: Unpublished,
    heartbeat_high: bool,
    levels: LineLevels,
    progress: Progress,
    decider: Decider,
    readback: Readback,
    delay: DelayMeter,
    exercise: Option<Exercise>,
    dose: Dose,
    /// `None` on a bench without one.
    dead_man: Option<DeadMan>,
    /// Estimated temperature of the plate above the room, K.
    rise_k: f64,
    tripped_at_ns: u64,
    armed_at_ns: u64,
    /// Kills caused by the watch.
    kills_known: u64,
    polled_ns: Option<u64>,
    /// Outcome of disabling the amplifier at the end.
    disable_result: Result<(), GpioError>,
}

/// Callback counts of both directions of the card, and the time at which each last changed, ns.
#[derive(Default)]
struct Progress {
    frames: (u64, u64),
    moved_ns: (u64, u64),
    has_begun: bool,
}

/// Real-time priority of the watch's thread: below the sound card's callbacks, which have closer deadlines, and far
/// below the kernel's threads for interrupts.
const PRIORITY: u8 = 10;
/// Age above which the force sensor counts as not polled, ns.
const STALE_NS: u64 = 250_000_000;
/// Longest wait for the emergency ramp at the end.
const RAMP_TIMEOUT: Duration = Duration::from_millis(30);
/// Longest wait of an armed bench for the first force reading, ns (FAULTS.md row 21).
const FIRST_READING_TIMEOUT_NS: u64 = 1_000_000_000;
/// Bytes without a reading from which on a port does not count as silent; a truncated frame has fewer.
const NONSENSE_BYTES: u64 = 256;
/// Time from a trip to disabling the amplifier, when the emergency ramp is over, ns.
const DISABLE_AFTER_NS: u64 = 20_000_000;
/// Time from a trip, in addition to the loop's latency, after which no voltage may be read back, ns.
const OFF_AFTER_NS: u64 = DISABLE_AFTER_NS + 80_000_000;

impl Watch {
    /// Makes a disarmed watch.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use std::sync::atomic::{AtomicU64, Ordering};
    ///
    /// use safety::{
    ///     Commanded, DriveGuard, Pace, PlateHeat, Press, SafetyLimits, SafetyLines, SafetyState, Signals, Trip, Watch,
    /// };
    /// use tasks::Task;
    ///
    /// /// A drive that only counts how often it was killed.
    /// struct Drive(Arc<AtomicU64>);
    /// impl DriveGuard for Drive {
    ///     fn attend(&self) {}
    ///     fn kill(&self) {
    ///         self.0.fetch_add(1, Ordering::Relaxed);
    ///     }
    ///     fn kills(&self) -> u64 {
    ///         self.0.load(Ordering::Relaxed)
    ///     }
    ///     fn commanded(&self) -> Option<Commanded> {
    ///         Some(Commanded::default())
    ///     }
    ///     fn callbacks(&self) -> (u64, u64) {
    ///         (0, 0)
    ///     }
    ///     fn lost(&self) -> Option<Trip> {
    ///         None
    ///     }
    /// }
    ///
    /// let limits = SafetyLimits {
    ///     max_normal_n: 3.0,
    ///     max_lateral_n: 2.0,
    ///     readback_tolerance: 0.2,
    ///     readback_floor_v: 0.5,
    ///     loop_latency_ns: 50_000_000,
    ///     measured_delay_s: None,
    ///     max_amplitude_m: 5e-6,
    ///     heat: PlateHeat {
    ///         force_factor_n_per_v: 0.13,
    ///         omega_rad_per_s: 219_911.5,
    ///         capacity_j_per_k: 14.0,
    ///         loss_w_per_k: 0.1,
    ///         room_c: 25.0,
    ///         limit_c: 40.0,
    ///     },
    ///     driving_s_per_hour: 730.0,
    ///     dead_man_release_ns: None,
    ///     rate_hz: 192e3,
    ///     silence_ns: 50_000_000,
    ///     pace: Pace::Card,
    /// };
    /// let (kills, signals) = (Arc::default(), Arc::new(Signals::default()));
    /// let drive = Box::new(Drive(Arc::clone(&kills)));
    /// let commands = tasks::Mailbox::default();
    /// let mut watch = Watch::new(limits, SafetyLines::default(), drive, true, Arc::clone(&signals), commands.clone());
    ///
    /// commands.send(safety::SafetyCommand::Arm);
    /// let press = |normal_n, at_ns| Press {
    ///     normal_n,
    ///     lateral_n: 0.0,
    ///     raw_n: [normal_n, 0.0],
    ///     saturated: false,
    ///     at_ns,
    /// };
    /// for (normal_n, now_ns) in [(2.9, 1_000_000), (3.1, 2_000_000)] {
    ///     signals.press.set(press(normal_n, now_ns));
    ///     signals.force_polled_ns.set(now_ns);
    ///     watch.poll(now_ns).unwrap();
    /// }
    /// let trip = Trip::ForceLimit { normal_n: 3.1, limit_n: 3.0 };
    /// assert_eq!(signals.state.get(), Some(SafetyState::Tripped { trip }));
    /// assert_eq!(kills.load(Ordering::Relaxed), 1);
    /// ```
    pub fn new(
        limits: SafetyLimits,
        lines: SafetyLines,
        drive: Box<dyn DriveGuard>,
        expects_force: bool,
        signals: Arc<Signals>,
        commands: Mailbox<SafetyCommand>,
    ) -> Self {
        let (rate_hz, latency_s) = (limits.rate_hz, limits.loop_latency_ns as f64 * 1e-9);
        let (tolerance, floor_v) = (limits.readback_tolerance, limits.readback_floor_v);
        let learnt = Readback::new(rate_hz, latency_s, tolerance, floor_v);
        let (readback, measured_s) = match limits.measured_delay_s {
            Some(delay_s) => (learnt.with_measured_delay(delay_s, rate_hz), delay_s),
            None => (learnt, 0.0),
        };
        Self {
            dose: Dose::new(Allowance::per_hour(limits.driving_s_per_hour)),
            dead_man: limits.dead_man_release_ns.map(DeadMan::new),
            limits,
            lines,
            drive,
            expects_force,
            signals,
            readings: LatestReadings::default(),
            commands,
            state: SafetyState::Disarmed,
            unpublished: Unpublished::default(),
            heartbeat_high: false,
            levels: LineLevels::default(),
            progress: Progress::default(),
            decider: Decider::default(),
            readback,
            delay: DelayMeter::new(rate_hz, latency_s.max(2.0 * measured_s)),
            exercise: None,
            rise_k: 0.0,
            tripped_at_ns: 0,
            armed_at_ns: 0,
            kills_known: 0,
            polled_ns: None,
            disable_result: Ok(()),
        }
    }

    fn set_state(&mut self, state: SafetyState) {
        self.state = state.clone();
        self.unpublished.state = Some(state);
        self.unpublished.offer(&self.signals);
    }

    fn trip(&mut self, trip: Trip, now_ns: u64) {
        self.drive.kill();
        self.kills_known = self.drive.kills();
        // Later reasons are consequences of the first.
        self.exercise = None;
        if !self.is_tripped() {
            self.tripped_at_ns = now_ns;
            self.set_state(SafetyState::Tripped { trip });
        }
    }

    /// Kills a drive that sounds although the trip has latched.
    fn kill_again(&mut self) {
        if self.drive.commanded().is_some_and(|c| c.envelope_v != 0.0) {
            self.drive.kill();
            self.kills_known = self.drive.kills();
        }
    }

    fn is_tripped(&self) -> bool {
        matches!(self.state, SafetyState::Tripped { .. })
    }

    fn e_stop_open(&mut self) -> Result<bool, GpioError> {
        match &mut self.lines.estop {
            Some(estop) => {
                let open = !estop.is_high()?;
                self.levels.estop_open = Some(open);
                Ok(open)
            }
            None => Ok(false),
        }
    }

    fn handle_command(&mut self, command: SafetyCommand, now_ns: u64) -> Result<(), GpioError> {
        let releases = matches!(command, SafetyCommand::Arm | SafetyCommand::Rearm);
        let pressed = releases && self.e_stop_open()?;
        let has_losses = self.signals.losses.first().is_some();
        match (command, &self.state) {
            (SafetyCommand::Trip(trip), _) => self.trip(trip, now_ns),
            (SafetyCommand::Allow(allowance), _) => self.dose.allow(allowance),
            (SafetyCommand::Warm { rise_k }, _) => self.rise_k = self.rise_k.max(rise_k),
            (SafetyCommand::Arm, SafetyState::Disarmed) if pressed => {
                self.trip(Trip::EmergencyStop, now_ns);
            }
            (SafetyCommand::Arm, SafetyState::Disarmed) => {
                // The caller has checked the limits and named the remedy; if it did not, a blind watch is still not
                // armed.
                if let Err(blind) = self.limits.require_sighted() {
                    let message = blind.to_string();
                    self.trip(Trip::Fault { message }, now_ns);
                    return Ok(());
                }
                let obstacle = self
                    .too_warm()
                    .or(self.dose_refuses(now_ns))
                    .or(self.hold_trip());
                if let Some(trip) = obstacle {
                    self.trip(trip, now_ns);
                    return Ok(());
                }
                set(&mut self.lines.enable, true)?;
                self.readback.forget_readings();
                self.armed_at_ns = now_ns;
                self.set_state(SafetyState::Armed);
            }
            (SafetyCommand::Exercise, SafetyState::Armed) => {
                let wired = [
                    (StopLine::Heartbeat, self.lines.heartbeat.is_some()),
                    (StopLine::Enable, self.lines.enable.is_some()),
                ];
                let lines = wired.into_iter().filter(|(_, wired)| *wired);
                self.exercise = Some(Exercise::new(lines.map(|(line, _)| line).collect()));
            }
            (SafetyCommand::Disarm, SafetyState::Armed) => {
                self.exercise = None;
                set(&mut self.lines.enable, false)?;
                self.set_state(SafetyState::Disarmed);
            }
            // A pressed e-stop and a lost device keep the trip, for any command of the operator.
            (SafetyCommand::Rearm, SafetyState::Tripped { .. }) if pressed || has_losses => {}
            (SafetyCommand::Rearm, SafetyState::Tripped { .. }) => {
                self.readback.forget_readings();
                // Kills that came with the trip are known; a later one trips again.
                self.kills_known = self.drive.kills();
                self.set_state(SafetyState::Disarmed);
            }
            _ => {}
        }
        Ok(())
    }

    /// Advances the estimate of the plate's temperature to `now_ns`.
    fn warm_up(&mut self, now_ns: u64) {
        let Some(previous_ns) = self.polled_ns else {
            return;
        };
        let seconds = now_ns.saturating_sub(previous_ns) as f64 * 1e-9;
        let drive_v = self.readings.readback.map_or(0.0, |reading| reading.volts);
        let amplitude_m = self.readings.amplitude_m.unwrap_or(0.0);
        let power_w = self.limits.heat.power_w(drive_v, amplitude_m);
        self.rise_k = self.limits.heat.rise_after(self.rise_k, power_w, seconds);
        self.unpublished.rise_k = Some(self.rise_k);
    }

    /// Returns the trip of a plate at its limit; before arming, also of a plate that could not be driven for long.
    fn too_warm(&self) -> Option<Trip> {
        let heat = &self.limits.heat;
        let surface_c = heat.surface_c(self.rise_k);
        let arms = self.state == SafetyState::Disarmed;
        let warm = surface_c >= heat.limit_c || arms && heat.wait_s(self.rise_k) > 0.0;
        let warm = warm.then(|| Trip::Warm {
            surface_c,
            limit_c: heat.limit_c,
            wait_s: heat.wait_s(self.rise_k),
        });
        warm.or(self.warmth_unkept())
    }

    /// Returns the first fault that is present now.
    fn first_fault(&mut self, now_ns: u64) -> Result<Option<Trip>, GpioError> {
        // Time is counted at each poll, for any outcome.
        self.warm_up(now_ns);
        let suspension = self.decider.suspended(&self.signals);
        let frozen = self.frozen(now_ns).or(suspension);
        let dose_trip = self.count_dose(now_ns);
        let undecided = self.decider.look(&self.signals, self.armed_at_ns, now_ns);
        let hold_trip = self.watch_hold(now_ns)?;
        if self.e_stop_open()? {
            return Ok(Some(Trip::EmergencyStop));
        }
        // Before the kill that the drive has made meanwhile.
        if let Some(trip) = frozen {
            return Ok(Some(trip));
        }
        if let Some(trip) = hold_trip.or(dose_trip) {
            return Ok(Some(trip));
        }
        if self.drive.kills() != self.kills_known && !self.signals.ends.load(Ordering::SeqCst) {
            return Ok(Some(Trip::Killed));
        }
        if self.state == SafetyState::Armed
            && let Some(trip) = undecided.or(self.too_warm())
        {
            return Ok(Some(trip));
        }
        if let Some(trip) = self.drive.lost() {
            self.signals.losses.report(LostDevice::SoundCard);
            return Ok(Some(trip));
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
        if let Some(trip) = self.amplitude_wrong() {
            return Ok(Some(trip));
        }
        Ok(self.force_wrong(now_ns))
    }

    fn amplitude_wrong(&self) -> Option<Trip> {
        let amplitude_m = self.readings.amplitude_m?;
        let limit_m = self.limits.max_amplitude_m;
        (amplitude_m > limit_m).then_some(Trip::Amplitude {
            amplitude_um: 1e6 * amplitude_m,
            limit_um: 1e6 * limit_m,
        })
    }

    /// Returns the trip of a watch that did not run for longer than the one-shot waits: it saw nothing, and the
    /// one-shot has disabled the amplifier.
    fn frozen(&mut self, now_ns: u64) -> Option<Trip> {
        let absence_ns = now_ns.saturating_sub(self.polled_ns.replace(now_ns)?);
        self.signals
            .longest_away_ns
            .fetch_max(absence_ns, Ordering::Relaxed);
        (absence_ns > self.limits.longest_absence_ns()).then_some(Trip::Frozen {
            for_s: absence_ns as f64 * 1e-9,
        })
    }

    fn audio_silent(&mut self, now_ns: u64) -> Option<Trip> {
        let frames = self.drive.callbacks();
        let progress = &mut self.progress;
        if !progress.has_begun {
            *progress = Progress {
                frames,
                moved_ns: (now_ns, now_ns),
                has_begun: frames.0 > 0 && frames.1 > 0,
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

    fn force_wrong(&self, now_ns: u64) -> Option<Trip> {
        if !self.expects_force {
            return None;
        }
        let Nonsense { bytes, lasts } = self.readings.nonsense.unwrap_or_default();
        if lasts {
            return Some(Trip::ForceNonsense { bytes });
        }
        let silent = if bytes >= NONSENSE_BYTES {
            Trip::ForceNonsense { bytes }
        } else {
            Trip::ForceSilent
        };
        let Some(Press {
            normal_n,
            lateral_n,
            raw_n: [raw_normal_n, raw_lateral_n],
            saturated,
            at_ns,
        }) = self.readings.press
        else {
            // The preflight check saw readings, so the watch waits for the first one, but not for ever.
            let waited_ns = now_ns.saturating_sub(self.armed_at_ns);
            return (waited_ns > FIRST_READING_TIMEOUT_NS).then_some(silent);
        };
        let limit_n = self.limits.max_normal_n;
        if exceeds(normal_n, limit_n) {
            return Some(Trip::ForceLimit { normal_n, limit_n });
        }
        let limit_n = self.limits.max_lateral_n;
        if exceeds(lateral_n, limit_n) {
            return Some(Trip::LateralForceLimit { lateral_n, limit_n });
        }
        // A plausible calibration reads at least this share of the sensor's own reading, so a correct one always trips
        // at its own limit first.
        let raw = |axis, raw_n: f64, limit_n: f64| {
            let limit_n = limit_n / SENSITIVITY[0];
            exceeds(raw_n, limit_n).then_some(Trip::RawForceLimit {
                axis,
                raw_n,
                limit_n,
            })
        };
        let trip = raw("normal", raw_normal_n, self.limits.max_normal_n)
            .or_else(|| raw("lateral", raw_lateral_n, self.limits.max_lateral_n));
        if trip.is_some() {
            return trip;
        }
        // A saturated lateral axis flags the recording but does not trip: the lateral force stays bounded by the normal
        // force, which is known, and stopping the drive would raise the friction.
        if saturated {
            return Some(Trip::ForceSaturated);
        }
        // The sensor is silent only if it was polled and sent nothing; not being polled is another fault.
        let polled_ns = self.readings.force_polled_ns?;
        if now_ns.saturating_sub(polled_ns) > STALE_NS {
            return Some(Trip::ForceUnread);
        }
        (polled_ns.saturating_sub(at_ns) > self.limits.silence_ns).then_some(silent)
    }

    /// Advances a running exercise, with the enable line; returns the required state of the lines.
    fn exercised(&mut self, now_ns: u64) -> Result<Demand, GpioError> {
        let Some(exercise) = &mut self.exercise else {
            return Ok(Demand::All);
        };
        let demand = exercise.poll(now_ns, self.readings.readback);
        set(
            &mut self.lines.enable,
            demand != Some(Demand::AllBut(StopLine::Enable)),
        )?;
        if demand.is_none()
            && let Some(exercise) = self.exercise.take()
        {
            // The read-back did not follow the commands meanwhile.
            self.readback.forget_readings();
            self.unpublished.stop_times = Some(exercise.times());
        }
        Ok(demand.unwrap_or(Demand::All))
    }

    fn watch(&mut self, now_ns: u64) -> Result<(), GpioError> {
        self.drive.attend();
        self.readings.look(&self.signals);
        while let Some(command) = self.commands.take() {
            self.handle_command(command, now_ns)?;
        }
        let fault = self.first_fault(now_ns)?;
        let beat = self.heartbeat_high;
        match (&self.state, fault) {
            (SafetyState::Armed, None) => {
                let demand = self.exercised(now_ns)?;
                if demand != Demand::AllBut(StopLine::Heartbeat) {
                    self.heartbeat_high = !self.heartbeat_high;
                    set(&mut self.lines.heartbeat, self.heartbeat_high)?;
                }
            }
            (SafetyState::Armed, Some(trip)) => self.trip(trip, now_ns),
            // While disarmed, only a drive that is alive nevertheless, and a failure that must latch, matter.
            (SafetyState::Disarmed, Some(trip)) if trip.latches_disarmed() => {
                self.trip(trip, now_ns);
            }
            _ => {}
        }
        if let Some(trip) = self.alive_after_stop(now_ns) {
            self.set_state(SafetyState::Tripped { trip });
        }
        let wired = self.lines.heartbeat.is_some();
        if self.levels.estop_open == Some(true) {
            self.levels.estop_open_ns = Some(now_ns);
        }
        self.levels.beats = wired.then_some(self.heartbeat_high != beat);
        self.levels.has_failed = false;
        self.unpublished.lines = Some(self.levels);
        Ok(())
    }
}

/// Returns whether a force of either sign is over its limit; a force that is not a number counts as over.
fn exceeds(force_n: f64, limit_n: f64) -> bool {
    force_n.is_nan() || force_n.abs() > limit_n
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

    fn begin(&mut self) {
        self.signals.scheduling.set(scheduling::ask(PRIORITY));
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let mut watched = self.watch(now_ns);
        if self.is_tripped() && now_ns.saturating_sub(self.tripped_at_ns) >= DISABLE_AFTER_NS {
            // Even if another line cannot be read.
            watched = watched.and(set(&mut self.lines.enable, false));
            self.kill_again();
        }
        if let Err(error) = watched {
            let message = error.to_string();
            self.trip(Trip::Gpio { message }, now_ns);
            self.levels.has_failed = true;
            self.unpublished.lines = Some(self.levels);
        }
        self.unpublished.offer(&self.signals);
        Ok(())
    }

    fn stop(&mut self) {
        self.drive.kill();
        // The amplifier is disabled after the ramp, or after the timeout if audio callbacks have stopped.
        let start = Instant::now();
        let is_driven =
            |drive: &dyn DriveGuard| drive.commanded().is_some_and(|c| c.envelope_v != 0.0);
        while is_driven(self.drive.as_ref()) && start.elapsed() < RAMP_TIMEOUT {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.disable_result = set(&mut self.lines.enable, false);
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(std::mem::replace(&mut self.disable_result, Ok(()))?)
    }
}
