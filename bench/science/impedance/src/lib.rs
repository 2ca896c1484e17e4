//! The plate's mechanical impedance from sampled voltages: IQ demodulation, Z_m, smoothing, clock alignment.
//!
//! | topic | item |
//! | --- | --- |
//! | the common demodulation filter and its measured response | [`Filter`] |
//! | interleaved samples → complex envelopes of drive and pickup | [`Demodulator`] |
//! | envelopes → Z_m, as published and corrected for envelope dynamics | [`Zm`] |
//! | complex envelopes in place of samples | [`EnvelopeStream`] |
//! | a carrier that moves | [`moving_carrier`] |
//! | reasons to reject a frame | [`Mask`] |
//! | detection of the carrier in a signal | [`CarrierLevel`] |
//! | a pickup's phase and delay from the unloaded plate's response to the modulation | [`Transient`] |
//! | Butterworth low-pass, zero-phase and causal | [`smoothing`] |
//! | mapping of another device's clock to the host's | [`clock_alignment`] |
//! | number of samples lost in an overrun | [`sample_loss`] |
//!
//! # From samples to Z_m
//! A channel is x(t) = Re[X̃(t) e^{iωt}] plus noise, ω = 2π · carrier. [`Filter`] is a real, even low-pass h of unit gain, and
//! [`Demodulator`] computes with it, once per frame, at the frame's time T,
//! ```text
//!  X̃(T) = 2 Σ h(T − t_n) x(t_n) e^{−iωt_n},    dX̃/dT with h′,    d²X̃/dT² with h″
//! ```
//! The factor 2 is there because half of a real signal's power lies at −ω, where h rejects it. Drive and pickup pass the
//! same h, so its gain cancels in their ratio. [`Zm`] turns both envelopes and the derivatives into Z_m by the plate's
//! equation of motion. Every frame carries the standard deviation of one quadrature, from white noise next to the carrier.
//!
//! Conventions, for the whole crate: exp(+iωt), peak amplitudes, SI units named in identifiers.
//! No input or output, no threads: `clippy.toml` next to this crate's `Cargo.toml` disallows them.

mod carrier_level;
mod carrier_phase;
pub mod clock_alignment;
mod demodulator;
mod envelope_stream;
mod filter;
mod flaws;
mod kernel;
mod mask;
pub mod moving_carrier;
mod noise;
pub mod sample_loss;
pub mod smoothing;
mod transient;
pub mod wiener;
pub mod window;
mod zm;

pub use carrier_level::{CarrierError, CarrierLevel};
pub use demodulator::{
    ChannelEnvelope, Demodulator, DemodulatorError, EnvelopeFrame, InputChannel,
};
pub use envelope_stream::EnvelopeStream;
pub use filter::{
    Filter, FilterError, FilterSettings, LEAST_ENVELOPE_RATE_HZ, OUTPUT_RATE_HZ, output_rate_hz,
    samples_per_frame,
};
pub use flaws::{ChannelFlaws, Flawed};
pub use mask::Mask;
pub use transient::Transient;
pub use zm::{ChannelScales, ConstantError, NULL_SIGMAS, PlateConstants, Zm, ZmFrame};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
