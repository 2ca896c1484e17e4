//! The session's hold on the drive: a program sounds only once the safety watch has armed the amplifier.

use crossbeam_channel::Sender;
use signalgen::{
    DriveCommand, DriveHandle, DriveMonitor, DrivePhase, DriveSettings, KillSwitch, Program,
    StreamDirection, StreamHealth, Waveform,
};

use config::Config;
use safety::{Commanded, DriveGuard, SafetyCommand, SafetyState};

/// A protocol's drive as a waveform on this plate.
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

/// A protocol's carrier on this plate, Hz.
pub fn carrier_hz(carrier: protocols::Carrier, config: &Config) -> f64 {
    match carrier {
        protocols::Carrier::PlateResonance => config.plate.resonance_hz,
        protocols::Carrier::Hz(hz) => hz,
    }
}

/// Settings under which every program of this bench is admitted.
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

/// Starts and stops the drive through the safety watch.
pub struct DriveControl {
    handle: DriveHandle,
    safety: Sender<SafetyCommand>,
    /// Waits for the amplifier to be armed, with the kills there had been when it was asked for: a later one it does not undo.
    wanted: Option<(Program, u64)>,
}

impl DriveControl {
    /// Takes the drive over, silent.
    pub fn new(handle: DriveHandle, safety: Sender<SafetyCommand>) -> Self {
        Self {
            handle,
            safety,
            wanted: None,
        }
    }

    /// Asks for a program; it begins as soon as the amplifier is armed.
    pub fn start(&mut self, program: Program) {
        self.wanted = Some((program, self.handle.kill_switch().kills()));
        self.command(SafetyCommand::Arm);
    }

    /// Sounds with the amplifier off. What is read back of that has come past an open relay.
    pub fn sound_disarmed(&mut self, program: Program) {
        let kills_known = self.handle.kill_switch().kills();
        let _ = self.handle.rearm_knowing(kills_known);
        self.send(DriveCommand::Start(program));
    }

    /// Ramps to silence.
    pub fn stop(&mut self) {
        self.wanted = None;
        self.send(DriveCommand::Stop);
    }

    /// Ramps to silence and takes the amplifier off.
    pub fn disarm(&mut self) {
        self.stop();
        self.command(SafetyCommand::Disarm);
    }

    /// Stops at once and latches.
    pub fn trip(&self, trip: safety::Trip) {
        self.command(SafetyCommand::Trip(trip));
    }

    /// The operator has looked and releases the latch.
    pub fn rearm(&self) {
        self.command(SafetyCommand::Rearm);
    }

    /// Begins what waits, now that the watch says `state`.
    pub fn poll(&mut self, state: &SafetyState) {
        match state {
            SafetyState::Armed => {
                if let Some((program, kills_known)) = self.wanted.take() {
                    let _ = self.handle.rearm_knowing(kills_known);
                    self.send(DriveCommand::Start(program));
                }
            }
            SafetyState::Tripped { .. } => self.wanted = None,
            SafetyState::Disarmed => {}
        }
    }

    /// Programs begun so far.
    pub fn programs(&self) -> u32 {
        self.handle.published().programs
    }

    /// The plate is driven, or a ramp is not over.
    pub fn sounds(&self) -> bool {
        !self.handle.published().phase.is_silent()
    }

    /// The card takes no command when it is gone; the watch sees that by itself.
    fn send(&mut self, command: DriveCommand) {
        let _ = self.handle.send(command);
    }

    fn command(&self, command: SafetyCommand) {
        let _ = self.safety.send(command);
    }
}

/// The drive as the safety watch sees it.
pub struct WatchedDrive {
    kill: KillSwitch,
    monitor: DriveMonitor,
    health: StreamHealth,
}

impl WatchedDrive {
    /// A guard over the drive of these streams.
    pub fn new(handle: &DriveHandle, health: StreamHealth) -> Self {
        Self {
            kill: handle.kill_switch(),
            monitor: handle.monitor(),
            health,
        }
    }
}

impl DriveGuard for WatchedDrive {
    fn kill(&self) {
        self.kill.kill();
    }

    fn kills(&self) -> u64 {
        self.kill.kills()
    }

    fn commanded(&self) -> Option<Commanded> {
        let state = self.monitor.published();
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

    fn lost(&self) -> bool {
        self.health.read(StreamDirection::Output).device_lost
            || self.health.read(StreamDirection::Input).device_lost
    }
}
