//! Drive signal of the plate and the sound card's two directions.
//!
//! Voltages are volts **peak** across the actuators; samples are in units of converter full scale;
//! phases follow exp(+iωt). [`Generator`] is pure; [`audio`] alone meets the hardware.
//!
//! A waveform is admitted under checked settings ([`DriveSettings::admit`]), travels as a
//! [`Command`] over a lock-free ring ([`DriveHandle::send`]) and is rendered in the output callback.

pub mod audio;
mod capture;
mod carrier;
mod device;
mod drive;
mod envelope;
mod generator;
mod health;
mod limiter;
mod phase;
mod program;
mod published;
mod quiet;
mod ramp;
mod sample;
mod sweep;

pub use capture::{BlockHeader, BlockTime, InputReader};
pub use carrier::Carrier;
pub use device::{Capability, ChoiceError, DeviceInfo, summarise};
pub use drive::{DriveHandle, DriveMonitor, KillSwitch, SendError};
pub use envelope::Envelope;
pub use generator::{Command, DrivePhase, DriveState, Generator, StepState};
pub use health::{Direction, DirectionHealth, Health, StreamFault};
pub use limiter::{HARD_LIMIT_V, LimitError, Limiter, TripCause};
pub use phase::{Phase, PhaseStep, SineTable};
pub use program::{
    DEFAULT_RAMP_S, DriveConfig, DriveSettings, EMERGENCY_RAMP_S, LONGEST_RAMP_S, Program,
    ProgramError, Waveform,
};
pub use ramp::Ramp;
pub use sample::{ConverterSample, SampleFormat, UnknownFormat};
pub use sweep::{MAX_TONES, SweepLaw, ToneCountError, ToneList};
