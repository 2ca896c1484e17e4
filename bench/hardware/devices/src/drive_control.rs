//! Control of the drive: a program plays only once the safety watch has armed the amplifier.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use signalgen::{
    Attendance, DirectionHealth, DriveCommand, DriveHandle, DriveMonitor, DrivePhase,
    DriveSettings, DriveState, KillSwitch, Program, StreamDirection, StreamFault, StreamHealth,
    Waveform,
};

use config::Config;
use safety::{
    Allowance, Commanded, DriveGuard, DriveStop, RearmObstacle, SafetyCommand, SafetyState,
    Signals, Trip,
};
use tasks::Mailbox;

/// Returns a protocol's drive as a waveform for the plate of `config`.
pub fn waveform(drive: &protocols::Drive, config: &Config) -> Waveform {
    let carrier_hz = carrier_hz(drive.carrier, config);
    Waveform::Modulated {
        carrier_hz,
        mean_amplitude_v: drive.mean_amplitude_v,
        modulation_hz: drive.modulation_hz,
        modulation_index: drive.modulation_index,
        start_phase_rad: 0.0,
    }
}

/// Returns a protocol's carrier on the plate of `config`, Hz.
pub fn carrier_hz(carrier: protocols::Carrier, config: &Config) -> f64 {
    match carrier {
        protocols::Carrier::PlateResonance => config.plate.resonance_hz,
        protocols::Carrier::Hz(hz) => hz,
    }
}

/// Returns the limits under which every program of this bench is admitted.
///
/// # Errors
/// When a limit or the rate is out of range.
pub fn settings(config: &Config) -> Result<DriveSettings, signalgen::ProgramError> {
    DriveSettings::new(signalgen::DriveConfig {
        sample_rate_hz: config.audio.rate_hz,
        volts_per_unit: config.output.volts_per_unit,
        limit_v: config.limits.drive_v,
        ramp_s: config.limits.ramp_s,
    })
}

/// Starts and stops the drive through the safety watch. Its owner decides about the drive and is watched: an armed
/// bench trips if it is not polled for a second.
pub struct DriveControl {
    handle: DriveHandle,
    safety: Mailbox<SafetyCommand>,
    signals: Arc<Signals>,
    /// Program that waits for the amplifier to be armed, with the number of kills at its request: later kills stay in
    /// effect.
    pending: Option<(Program, u64)>,
}

impl DriveControl {
    /// Takes over a silent drive with the watch behind `safety` and `signals`.
    pub fn new(handle: DriveHandle, safety: Mailbox<SafetyCommand>, signals: Arc<Signals>) -> Self {
        Self {
            handle,
            safety,
            signals,
            pending: None,
        }
    }

    /// Returns the stop for the threads that read keys or signals.
    #[must_use]
    pub fn stop_switch(&self) -> DriveStop {
        let kill = self.handle.kill_switch();
        DriveStop::new(self.safety.clone(), Arc::clone(&self.signals), move || {
            kill.kill();
        })
    }

    /// Requests a program; it begins as soon as the amplifier is armed.
    pub fn start(&mut self, program: Program) {
        self.pending = Some((program, self.handle.kill_switch().kills()));
        self.command(SafetyCommand::Arm);
    }

    /// Plays a program with the amplifier off: a signal that is read back has passed an open relay.
    pub fn sound_disarmed(&mut self, program: Program) {
        let kills_known = self.handle.kill_switch().kills();
        let _ = self.handle.rearm_after(kills_known);
        self.send(DriveCommand::Start(program));
    }

    /// Ramps to silence.
    pub fn stop(&mut self) {
        self.pending = None;
        self.send(DriveCommand::Stop);
    }

    /// Ramps to silence and disarms the amplifier.
    pub fn disarm(&mut self) {
        self.stop();
        self.command(SafetyCommand::Disarm);
    }

    /// Stops the drive at once and latches the trip.
    pub fn trip(&self, trip: Trip) {
        self.command(SafetyCommand::Trip(trip));
    }

    /// Counts the driving time under an allowance from now on.
    pub(crate) fn allow(&self, allowance: Allowance) {
        self.command(SafetyCommand::Allow(allowance));
    }

    /// Begins the estimate of the plate's temperature at least this much above the room, K.
    pub(crate) fn warm(&self, rise_k: f64) {
        self.command(SafetyCommand::Warm { rise_k });
    }

    /// Exercises the hardware stops that are wired, during the steady tone.
    pub fn exercise_stops(&self) {
        self.command(SafetyCommand::Exercise);
    }

    /// Releases the latch of a trip, at the operator's request, unless [`DriveControl::rearm_obstacle`] names an obstacle.
    pub fn rearm(&self) {
        self.command(SafetyCommand::Rearm);
    }

    /// Returns what keeps a trip latched although the operator re-arms; `None` if nothing does.
    pub fn rearm_obstacle(&self) -> Option<RearmObstacle> {
        self.signals.rearm_obstacle()
    }

    /// Begins the waiting program if the safety watch reports an armed amplifier, and drops it after a trip. Call it at
    /// every poll, in any state: it is the sign of life that the watch waits for.
    pub fn poll(&mut self, state: &SafetyState) {
        self.signals.decisions.fetch_add(1, Ordering::Relaxed);
        match state {
            SafetyState::Armed => {
                if let Some((program, kills_known)) = self.pending.take() {
                    let _ = self.handle.rearm_after(kills_known);
                    self.send(DriveCommand::Start(program));
                }
            }
            SafetyState::Tripped { .. } => self.pending = None,
            SafetyState::Disarmed => {}
        }
    }

    /// Returns the number of programs begun so far.
    pub fn programs(&self) -> u32 {
        self.handle.state().programs
    }

    /// Returns whether the plate is driven, ramps included.
    pub fn sounds(&self) -> bool {
        !self.handle.state().phase.is_silent()
    }

    /// Sends a command to the generator; the safety watch notices the loss of the card.
    fn send(&mut self, command: DriveCommand) {
        let _ = self.handle.send(command);
    }

    fn command(&self, command: SafetyCommand) {
        self.safety.send(command);
    }
}

/// Drive and streams as the safety watch sees them.
pub struct WatchedDrive {
    kill: KillSwitch,
    monitor: DriveMonitor,
    health: StreamHealth,
    attendance: Attendance,
    /// State of the drive when it was last looked at.
    last_state: Cell<DriveState>,
}

impl WatchedDrive {
    /// Makes the safety watch's view of the drive and of its streams. From now on the drive stops if it is not watched
    /// for `absence_frames`.
    pub fn new(handle: &DriveHandle, health: StreamHealth, absence_frames: u64) -> Self {
        let attendance = handle.attendance();
        attendance.require(absence_frames);
        Self {
            attendance,
            kill: handle.kill_switch(),
            monitor: handle.monitor(),
            health,
            last_state: Cell::new(handle.state()),
        }
    }

    /// Returns the drive's state, or the previous one while a callback publishes: the watch may have interrupted the
    /// callback, which cannot continue before the watch sleeps. A callback that never continues shows in the count of
    /// callbacks.
    fn state(&self) -> DriveState {
        if let Some(state) = self.monitor.try_state() {
            self.last_state.set(state);
        }
        self.last_state.get()
    }
}

impl DriveGuard for WatchedDrive {
    fn attend(&self) {
        self.attendance.show();
    }

    fn kill(&self) {
        self.kill.kill();
    }

    fn kills(&self) -> u64 {
        self.kill.kills()
    }

    fn commanded(&self) -> Option<Commanded> {
        let state = self.state();
        (!matches!(state.phase, DrivePhase::Tripped(_))).then_some(Commanded {
            frame: state.frames,
            envelope_v: state.envelope_v,
        })
    }

    fn callbacks(&self) -> (u64, u64) {
        (
            self.health.read(StreamDirection::Output).callbacks,
            self.health.read(StreamDirection::Input).callbacks,
        )
    }

    /// A card that overran or underran and cannot continue reports an xrun and then an invalid stream; sound cards
    /// continue.
    fn lost(&self) -> Option<Trip> {
        let [output, input] = [StreamDirection::Output, StreamDirection::Input]
            .map(|direction| self.health.read(direction));
        let stopped = |health: &DirectionHealth| {
            health.device_lost
                && health.xruns > 0
                && health.last_fault == Some(StreamFault::Invalidated)
        };
        if stopped(&output) {
            Some(Trip::AudioUnderrun)
        } else if stopped(&input) {
            Some(Trip::AudioOverrun)
        } else {
            (output.device_lost || input.device_lost).then_some(Trip::AudioLost)
        }
    }
}
