//! Generator: renders programs sample by sample under commands, and keeps the state of the drive.

use crate::{
    drive_program::{DriveSettings, Program, Waveform},
    envelope::AmplitudeEnvelope,
    limiter::TripCause,
    oscillator::CarrierOscillator,
    ramp::Ramp,
    sine_table::SineTable,
    sweep::{CarrierMotion, Glide, Steps, Timeline},
};

/// A command to the generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveCommand {
    /// Ramps from the present output to the beginning of this program.
    Start(Program),
    /// Ramps as [`DriveCommand::Start`] does, but a modulated program continues at the present modulation phase instead of its
    /// start phase: for a change of amplitude, index or frequency during a program.
    Adjust(Program),
    /// Ramps to silence.
    Stop,
    /// Ramps to silence in [`crate::EMERGENCY_RAMP_S`] and latches: all later commands except [`DriveCommand::Rearm`] are
    /// refused.
    EmergencyStop,
    /// Releases the latch of an emergency stop or a trip, once the drive is silent; starts nothing.
    Rearm,
}

/// Phase of the drive between silence and full amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrivePhase {
    /// Silent, ready for a program.
    #[default]
    Silent,
    /// Ramping from silence or the previous program to the program.
    RampingIn,
    /// Rendering the program at its full amplitude.
    Steady,
    /// Ramping to silence.
    RampingOut,
    /// Ramping to silence at the emergency rate.
    EmergencyRamp,
    /// Silent and latched by an emergency stop.
    EmergencyStopped,
    /// Silent and latched by the limiter, or by a program admitted under other settings.
    Tripped(TripCause),
}

impl DrivePhase {
    /// Returns whether the drive refuses programs until re-armed.
    #[must_use]
    pub fn is_latched(self) -> bool {
        matches!(
            self,
            Self::EmergencyRamp | Self::EmergencyStopped | Self::Tripped(_)
        )
    }

    /// Returns whether the commanded amplitude is zero.
    #[must_use]
    pub fn is_silent(self) -> bool {
        matches!(
            self,
            Self::Silent | Self::EmergencyStopped | Self::Tripped(_)
        )
    }
}

/// Tone of a stepped program that plays at full amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepState {
    /// Index of the tone in the program's list.
    pub index: u16,
    /// Output frame of the tone's first sample.
    pub first_frame: u64,
}

/// State of the drive after a block of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveState {
    /// Number of frames rendered since the generator was created; the index of the next frame.
    pub frames: u64,
    /// Phase of the drive from the next frame on.
    pub phase: DrivePhase,
    /// Commanded amplitude at the last rendered frame, V peak across the actuators, ramps included.
    pub envelope_v: f64,
    /// Carrier frequency at the last rendered frame, Hz; 0 before the first program.
    pub carrier_hz: f64,
    /// Current step of a stepped program; `None` during its ramps and for other programs.
    pub step: Option<StepState>,
    /// Number of accepted programs: rises with each accepted [`DriveCommand::Start`] or [`DriveCommand::Adjust`].
    pub programs: u32,
    /// Number of commands refused while latched.
    pub refusals: u32,
}

/// Renders the drive in units of output full scale.
///
/// The envelope is continuous through every command: a new program is blended in from the amplitude of the last frame by a
/// raised cosine. Between two frames it therefore changes by at most `Δ·π/(2N)` for the ramp (Δ the larger of the amplitudes on
/// its two sides, N its number of frames) plus the program's own modulation slope; asserted by `envelope_never_steps` in
/// `tests/integration/generator`. Only a trip goes to zero at once.
///
/// ```
/// use signalgen::{DriveCommand, DriveConfig, DrivePhase, DriveSettings, Generator, Waveform};
///
/// let settings = DriveSettings::new(DriveConfig {
///     sample_rate_hz: 192_000,
///     volts_per_unit: 100.0,
///     limit_v: 80.0,
///     ramp_s: 0.05,
/// })?;
/// let mut generator = Generator::new(settings);
/// let tone = Waveform::Tone { carrier_hz: 35_000.0, amplitude_v: 40.0 };
/// generator.apply(DriveCommand::Start(settings.admit(tone)?));
///
/// let mut samples = vec![0.0; 19_200];
/// generator.fill(&mut samples);
/// assert_eq!(generator.state().phase, DrivePhase::Steady);
/// // 40 V peak of 100 V full scale, after a ramp of 50 ms from silence.
/// let peak = samples.iter().fold(0.0_f32, |peak, s| peak.max(s.abs()));
/// assert_eq!(samples[0], 0.0);
/// assert!((peak - 0.4).abs() < 1e-3);
/// # Ok::<(), signalgen::ProgramError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Generator {
    settings: DriveSettings,
    table: SineTable,
    carrier: CarrierOscillator,
    envelope: AmplitudeEnvelope,
    timeline: Timeline,
    ramp: Ramp,
    ramp_from_v: f64,
    state: DriveState,
}

impl Generator {
    /// Creates a silent generator.
    #[must_use]
    pub fn new(settings: DriveSettings) -> Self {
        let rate = settings.sample_rate_hz();
        Self {
            settings,
            table: SineTable::new(),
            carrier: CarrierOscillator::new(0.0, rate),
            envelope: AmplitudeEnvelope::constant(0.0, rate),
            timeline: Timeline::Constant,
            ramp: Ramp::new(settings.ramp_frames()),
            ramp_from_v: 0.0,
            state: DriveState::default(),
        }
    }

    /// Returns the settings under which programs must be admitted.
    #[must_use]
    pub fn settings(&self) -> &DriveSettings {
        &self.settings
    }

    /// Returns the state after the last rendered frame.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// Takes a command, which takes effect at the next frame. Neither allocates nor blocks.
    ///
    /// While latched, the generator refuses and counts every command that starts a program, and a re-arming before the
    /// emergency ramp is over. A program admitted under other settings trips the drive.
    pub fn apply(&mut self, command: DriveCommand) {
        match command {
            DriveCommand::Start(program) => self.start(&program, false),
            DriveCommand::Adjust(program) => self.start(&program, true),
            DriveCommand::Stop => self.stop(),
            DriveCommand::EmergencyStop => self.emergency_stop(),
            DriveCommand::Rearm => self.rearm(),
        }
    }

    /// Renders the next `out.len()` frames. Neither allocates nor blocks.
    pub fn fill(&mut self, out: &mut [f32]) {
        for sample in out {
            *sample = self.next_frame();
        }
    }

    fn start(&mut self, program: &Program, keep_modulation_phase: bool) {
        if self.state.phase.is_latched() {
            self.refuse();
            return;
        }
        if *program.settings() != self.settings {
            self.trip(TripCause::ForeignProgram);
            return;
        }
        self.state.programs = self.state.programs.wrapping_add(1);
        let rate = self.settings.sample_rate_hz();
        let constant = |amplitude_v| AmplitudeEnvelope::constant(amplitude_v, rate);
        let (carrier_hz, envelope, timeline) = match *program.waveform() {
            Waveform::Silence => {
                self.stop();
                return;
            }
            Waveform::Tone {
                carrier_hz,
                amplitude_v,
            } => (carrier_hz, constant(amplitude_v), Timeline::Constant),
            Waveform::Modulated {
                carrier_hz,
                mean_amplitude_v,
                modulation_hz,
                modulation_index,
                start_phase_rad,
            } => {
                let envelope = AmplitudeEnvelope::modulated(
                    mean_amplitude_v,
                    modulation_hz,
                    modulation_index,
                    start_phase_rad,
                    rate,
                );
                let envelope = if keep_modulation_phase && self.envelope.is_modulated() {
                    envelope.in_phase_with(&self.envelope)
                } else {
                    envelope
                };
                (carrier_hz, envelope, Timeline::Constant)
            }
            Waveform::Sweep {
                from_hz,
                to_hz,
                duration_s,
                law,
                amplitude_v,
            } => {
                let glide = Glide::new(from_hz, to_hz, law, self.settings.frames(duration_s));
                (from_hz, constant(amplitude_v), Timeline::Sweep(glide))
            }
            Waveform::SteppedTones {
                tones,
                dwell_s,
                amplitude_v,
            } => {
                let steps = Steps::new(tones, self.settings.frames(dwell_s));
                (
                    tones.first_hz(),
                    constant(amplitude_v),
                    Timeline::Steps(steps),
                )
            }
        };
        self.carrier.set_frequency(carrier_hz);
        self.timeline = timeline;
        self.ramp_to(envelope, self.settings.ramp_frames(), DrivePhase::RampingIn);
    }

    fn stop(&mut self) {
        match self.state.phase {
            DrivePhase::RampingIn | DrivePhase::Steady => {
                self.ramp_to_silence(self.settings.ramp_frames(), DrivePhase::RampingOut);
            }
            // Already silent or ramping down; a second ramp would only delay it.
            DrivePhase::Silent
            | DrivePhase::RampingOut
            | DrivePhase::EmergencyRamp
            | DrivePhase::EmergencyStopped
            | DrivePhase::Tripped(_) => {}
        }
    }

    fn emergency_stop(&mut self) {
        if !self.state.phase.is_latched() {
            self.ramp_to_silence(
                self.settings.emergency_ramp_frames(),
                DrivePhase::EmergencyRamp,
            );
        }
    }

    fn rearm(&mut self) {
        match self.state.phase {
            DrivePhase::EmergencyStopped | DrivePhase::Tripped(_) => {
                self.state.phase = DrivePhase::Silent;
            }
            DrivePhase::EmergencyRamp => self.refuse(),
            DrivePhase::Silent
            | DrivePhase::RampingIn
            | DrivePhase::Steady
            | DrivePhase::RampingOut => {}
        }
    }

    fn refuse(&mut self) {
        self.state.refusals = self.state.refusals.wrapping_add(1);
    }

    fn ramp_to(&mut self, envelope: AmplitudeEnvelope, frames: u32, phase: DrivePhase) {
        self.ramp_from_v = self.state.envelope_v;
        self.ramp = Ramp::new(frames);
        self.envelope = envelope;
        self.state.phase = phase;
        self.state.step = None;
    }

    fn ramp_to_silence(&mut self, frames: u32, phase: DrivePhase) {
        self.timeline = Timeline::Constant;
        self.carrier.hold();
        let silence = AmplitudeEnvelope::constant(0.0, self.settings.sample_rate_hz());
        self.ramp_to(silence, frames, phase);
    }

    fn trip(&mut self, cause: TripCause) {
        self.ramp_to_silence(1, DrivePhase::Tripped(cause));
        self.ramp_from_v = 0.0;
        self.state.envelope_v = 0.0;
    }

    fn next_frame(&mut self) -> f32 {
        let frame = self.state.frames;
        self.state.frames += 1;
        if self.state.phase.is_silent() {
            self.carrier.advance();
            self.state.envelope_v = 0.0;
            return 0.0;
        }

        // The timeline advances at full amplitude only; at its end this frame becomes the first of the ramp out.
        let motion = if self.state.phase == DrivePhase::Steady {
            self.timeline.advance()
        } else {
            CarrierMotion::Hold
        };
        match motion {
            CarrierMotion::Hold | CarrierMotion::Glide(_) => {}
            CarrierMotion::Jump(frequency_hz) => {
                self.carrier.set_frequency(frequency_hz);
                self.state.step = self.timeline.step_index().map(|index| StepState {
                    index,
                    first_frame: frame,
                });
            }
            CarrierMotion::Over(frequency_hz) => {
                self.carrier.set_frequency(frequency_hz);
                self.stop();
            }
        }

        let weight = self.ramp.weight(&self.table);
        let target_v = self.envelope.value_v(&self.table);
        let envelope_v = self.ramp_from_v + (target_v - self.ramp_from_v) * weight;
        let volts = match self
            .settings
            .limiter()
            .check(envelope_v * self.carrier.value(&self.table))
        {
            Ok(volts) => volts,
            Err(cause) => {
                self.trip(cause);
                self.carrier.advance();
                return 0.0;
            }
        };
        self.state.envelope_v = envelope_v;

        self.envelope.advance();
        self.advance_ramp();
        match motion {
            CarrierMotion::Glide(mean_hz) => self.carrier.glide(mean_hz),
            CarrierMotion::Hold | CarrierMotion::Jump(_) | CarrierMotion::Over(_) => {
                self.carrier.advance()
            }
        }
        self.state.carrier_hz = self.carrier.frequency_hz();
        (volts / self.settings.volts_per_unit()) as f32
    }

    fn advance_ramp(&mut self) {
        self.ramp.advance();
        if self.ramp.is_over() {
            self.state.phase = match self.state.phase {
                DrivePhase::RampingIn => DrivePhase::Steady,
                DrivePhase::RampingOut => DrivePhase::Silent,
                DrivePhase::EmergencyRamp => DrivePhase::EmergencyStopped,
                phase => phase,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive_program::DriveConfig;

    /// Returns a generator at 60 V with a limit of 80 V.
    fn steady() -> Generator {
        let settings = DriveSettings::new(DriveConfig {
            sample_rate_hz: 192_000,
            volts_per_unit: 100.0,
            limit_v: 80.0,
            ramp_s: 0.05,
        })
        .unwrap();
        let tone = Waveform::Tone {
            carrier_hz: 35_000.0,
            amplitude_v: 60.0,
        };
        let mut generator = Generator::new(settings);
        generator.apply(DriveCommand::Start(settings.admit(tone).unwrap()));
        generator.fill(&mut [0.0; 10_000]);
        assert_eq!(generator.state().phase, DrivePhase::Steady);
        generator
    }

    /// FAULTS 8: the amplitude becomes invalid during a program, after all checks.
    /// Fault 8.
    /// Hazards 3, 6.
    #[test]
    fn bad_amplitudes_reach_zero_and_latch() {
        for (amplitude_v, cause) in [
            (f64::NAN, TripCause::NotFinite),
            (f64::INFINITY, TripCause::NotFinite),
            (f64::NEG_INFINITY, TripCause::NotFinite),
            (1e6, TripCause::OverRange),
        ] {
            let mut generator = steady();
            let envelope = AmplitudeEnvelope::constant(amplitude_v, 192_000);
            generator.ramp_to(envelope, 1, DrivePhase::RampingIn);
            let mut out = [1.0_f32; 1_000];
            generator.fill(&mut out);
            assert!(out.iter().all(|s| s.abs() <= 0.8), "{amplitude_v}");
            assert_eq!(generator.state().phase, DrivePhase::Tripped(cause));
            assert_eq!(generator.state().envelope_v, 0.0);

            let tone = Waveform::Tone {
                carrier_hz: 35_000.0,
                amplitude_v: 60.0,
            };
            let program = generator.settings().admit(tone).unwrap();
            generator.apply(DriveCommand::Start(program));
            generator.fill(&mut out);
            assert_eq!(out, [0.0; 1_000]);
            assert_eq!(generator.state().refusals, 1);

            generator.apply(DriveCommand::Rearm);
            generator.apply(DriveCommand::Start(program));
            generator.fill(&mut [0.0; 10_000]);
            assert_eq!(generator.state().phase, DrivePhase::Steady);
            assert!((generator.state().envelope_v - 60.0).abs() < 1e-9);
        }
    }
}
