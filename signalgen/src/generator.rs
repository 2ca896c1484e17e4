//! The generator: programs and commands in, samples and a state out.

use crate::{
    carrier::Carrier,
    envelope::Envelope,
    limiter::TripCause,
    phase::SineTable,
    program::{DriveSettings, Program, Waveform},
    ramp::Ramp,
    sweep::{Glide, Motion, Steps, Timeline},
};

/// What a generator can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Ramps from whatever sounds to this program, from the program's beginning.
    Start(Program),
    /// The same, but a modulated program goes on with the present modulation phase instead of its
    /// start phase: for changing amplitude, index or frequency under way.
    Adjust(Program),
    /// Ramps to silence.
    Stop,
    /// Ramps to silence in [`crate::EMERGENCY_RAMP_S`] and latches: only [`Command::Rearm`] makes
    /// it obey again.
    EmergencyStop,
    /// Releases the latch of an emergency stop or a trip, once the drive is silent; starts nothing.
    Rearm,
}

/// Where the drive is between silence and full amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrivePhase {
    /// No drive; ready for a program.
    #[default]
    Silent,
    /// Ramping from silence or the last program to the program.
    RampingIn,
    /// The program at its full amplitude.
    Steady,
    /// Ramping to silence.
    RampingOut,
    /// Ramping to silence at the emergency rate.
    EmergencyRamp,
    /// Silent and latched by an emergency stop.
    EmergencyStopped,
    /// Silent and latched by the limiter, or by a program of other settings.
    Tripped(TripCause),
}

impl DrivePhase {
    /// Whether the drive refuses programs until re-armed.
    #[must_use]
    pub fn is_latched(self) -> bool {
        matches!(
            self,
            Self::EmergencyRamp | Self::EmergencyStopped | Self::Tripped(_)
        )
    }

    /// Whether the commanded amplitude is zero.
    #[must_use]
    pub fn is_silent(self) -> bool {
        matches!(
            self,
            Self::Silent | Self::EmergencyStopped | Self::Tripped(_)
        )
    }
}

/// Which tone of a stepped program sounds at full amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepState {
    /// Index into the program's tones.
    pub index: u16,
    /// Output frame of the tone's first sample.
    pub first_frame: u64,
}

/// State of the drive after a block of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveState {
    /// Frames rendered since the generator was made; the index of the next frame.
    pub frames: u64,
    /// Phase of the drive from the next frame on.
    pub phase: DrivePhase,
    /// Commanded amplitude at the last rendered frame, V peak across the actuators, ramps included.
    pub envelope_v: f64,
    /// Carrier frequency at the last rendered frame, Hz; 0 before the first program.
    pub carrier_hz: f64,
    /// The current step of a stepped program; `None` during its ramps and for other programs.
    pub step: Option<StepState>,
    /// Programs accepted so far: tells that a [`Command::Start`] or [`Command::Adjust`] was taken.
    pub programs: u32,
    /// Commands refused because of a latch.
    pub refused: u32,
}

/// Renders the drive in units of output full scale.
///
/// The envelope is continuous through every command: a new program is blended in from the
/// amplitude of the last frame by a raised cosine, so between two frames it changes by at most
/// `Δ·π/(2N)` for the ramp (Δ the larger of the amplitudes on its two sides, N its frames) plus the
/// program's own modulation slope. Asserted by `envelope_never_steps` in `tests/generator.rs`.
/// A trip alone goes to zero at once.
#[derive(Clone, Debug)]
pub struct Generator {
    settings: DriveSettings,
    table: SineTable,
    carrier: Carrier,
    envelope: Envelope,
    timeline: Timeline,
    ramp: Ramp,
    ramp_from_v: f64,
    state: DriveState,
}

impl Generator {
    /// A silent generator.
    #[must_use]
    pub fn new(settings: DriveSettings) -> Self {
        let rate = settings.sample_rate_hz();
        Self {
            settings,
            table: SineTable::new(),
            carrier: Carrier::new(0.0, rate),
            envelope: Envelope::constant(0.0, rate),
            timeline: Timeline::Constant,
            ramp: Ramp::new(settings.ramp_frames()),
            ramp_from_v: 0.0,
            state: DriveState::default(),
        }
    }

    /// The settings that programs must be admitted under.
    #[must_use]
    pub fn settings(&self) -> &DriveSettings {
        &self.settings
    }

    /// The state after the last rendered frame.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// Takes a command, in force from the next frame on. Neither allocates nor blocks.
    ///
    /// While latched, everything but [`Command::Rearm`] is refused and counted; so is a re-arming
    /// before the emergency ramp is over. A program of other settings trips the drive.
    pub fn apply(&mut self, command: Command) {
        match command {
            Command::Start(program) => self.start(&program, false),
            Command::Adjust(program) => self.start(&program, true),
            Command::Stop => self.stop(),
            Command::EmergencyStop => self.emergency_stop(),
            Command::Rearm => self.rearm(),
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
        let constant = |amplitude_v| Envelope::constant(amplitude_v, rate);
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
                let envelope = Envelope::modulated(
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
            // Already silent, or on the way there: a second ramp would only delay it.
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
        self.state.refused = self.state.refused.wrapping_add(1);
    }

    fn ramp_to(&mut self, envelope: Envelope, frames: u32, phase: DrivePhase) {
        self.ramp_from_v = self.state.envelope_v;
        self.ramp = Ramp::new(frames);
        self.envelope = envelope;
        self.state.phase = phase;
        self.state.step = None;
    }

    fn ramp_to_silence(&mut self, frames: u32, phase: DrivePhase) {
        self.timeline = Timeline::Constant;
        self.carrier.hold();
        let silence = Envelope::constant(0.0, self.settings.sample_rate_hz());
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

        // The timeline runs at full amplitude only, and at its end makes this frame the first of
        // the ramp out.
        let motion = if self.state.phase == DrivePhase::Steady {
            self.timeline.advance()
        } else {
            Motion::Hold
        };
        match motion {
            Motion::Hold | Motion::Glide(_) => {}
            Motion::Jump(frequency_hz) => {
                self.carrier.set_frequency(frequency_hz);
                self.state.step = self.timeline.step_index().map(|index| StepState {
                    index,
                    first_frame: frame,
                });
            }
            Motion::Over(frequency_hz) => {
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
            Motion::Glide(mean_hz) => self.carrier.glide(mean_hz),
            Motion::Hold | Motion::Jump(_) | Motion::Over(_) => self.carrier.advance(),
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
                settled => settled,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::DriveConfig;

    /// A generator at 60 V of a limit of 80 V.
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
        generator.apply(Command::Start(settings.admit(tone).unwrap()));
        generator.fill(&mut [0.0; 10_000]);
        assert_eq!(generator.state().phase, DrivePhase::Steady);
        generator
    }

    /// FAULTS 8, past every check: the amplitude itself goes bad under way.
    #[test]
    fn bad_amplitudes_reach_zero_and_latch() {
        for (amplitude_v, cause) in [
            (f64::NAN, TripCause::NotFinite),
            (f64::INFINITY, TripCause::NotFinite),
            (f64::NEG_INFINITY, TripCause::NotFinite),
            (1e6, TripCause::OverRange),
        ] {
            let mut generator = steady();
            let envelope = Envelope::constant(amplitude_v, 192_000);
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
            generator.apply(Command::Start(program));
            generator.fill(&mut out);
            assert_eq!(out, [0.0; 1_000]);
            assert_eq!(generator.state().refused, 1);

            generator.apply(Command::Rearm);
            generator.apply(Command::Start(program));
            generator.fill(&mut [0.0; 10_000]);
            assert_eq!(generator.state().phase, DrivePhase::Steady);
            assert!((generator.state().envelope_v - 60.0).abs() < 1e-9);
        }
    }
}
