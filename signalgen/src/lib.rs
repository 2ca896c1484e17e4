//! Drive signal of an ultrasonic plate, and the two directions of the sound card that carries it.
//!
//! Voltages are volts **peak** across the actuators, samples are in units of converter full scale, and phases follow
//! exp(+iωt).
//!
//! [`DriveSettings::admit`] checks a [`Waveform`] and turns it into a [`Program`]. A [`DriveCommand`] carries it over a
//! lock-free ring ([`DriveHandle::send`]) to the [`DriveRenderer`], which renders it in the output callback. The input callback
//! passes its blocks to an [`InputWriter`]; an [`InputReader`] takes them out on another thread. Neither callback allocates,
//! locks, logs or panics (`tests/integration/real_time.rs`).
//!
//! Cargo features:
//!
//! - `sound-card`: the module `audio`, which opens a sound card through cpal (ALSA, CoreAudio, WASAPI) and runs both callbacks
//!   on it. The rest does no input or output and builds for any target of the standard library.
//! - `jack`: in addition, a JACK server as the host of the sound card.

mod attendance;
#[cfg(feature = "sound-card")]
pub mod audio;
mod capture;
mod drive_handle;
mod drive_program;
mod envelope;
mod generator;
mod input_tap;
mod limiter;
mod oscillator;
mod phase_accumulator;
mod ramp;
mod renderer;
mod sample;
mod seqlock;
mod sine_table;
mod stream_health;
mod stream_layout;
mod sweep;

pub use attendance::Attendance;
pub use capture::{BlockHeader, BlockTime, InputReader, InputWriter};
pub use drive_handle::{CommandError, DriveHandle, DriveMonitor, KillSwitch};
pub use drive_program::{
    DEFAULT_RAMP_S, DriveConfig, DriveSettings, EMERGENCY_RAMP_S, LONGEST_RAMP_S, Program,
    ProgramError, Waveform,
};
pub use envelope::AmplitudeEnvelope;
pub use generator::{DriveCommand, DrivePhase, DriveState, Generator, StepState};
pub use input_tap::{InputTap, TapBlock, TapFeed};
pub use limiter::{HARD_LIMIT_V, LimitError, Limiter, TripCause};
pub use oscillator::CarrierOscillator;
pub use phase_accumulator::{PhaseAccumulator, PhaseStep};
pub use ramp::Ramp;
pub use renderer::DriveRenderer;
pub use sample::{ConverterSample, I24, StreamFormat, UnknownFormat};
pub use sine_table::SineTable;
pub use stream_health::{DirectionHealth, StreamDirection, StreamFault, StreamHealth};
pub use stream_layout::LayoutError;
pub use sweep::{MAX_TONES, SweepLaw, ToneCountError, ToneList};

/// The README's example, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
