//! From sampled voltages to the plate's mechanical impedance: IQ demodulation, Z_m, smoothing, clock alignment.
//!
//! Conventions, for the whole crate: exp(+iωt), peak amplitudes, SI units named in identifiers.
//! No input or output, no threads.

mod carrier;
pub mod clock;
mod demodulator;
mod filter;
mod flaws;
pub mod gap;
mod kernel;
mod mask;
mod noise;
mod phase;
pub mod smoothing;
mod transient;
mod window;
mod zm;

pub use carrier::{CarrierError, CarrierLevel};
pub use demodulator::{Demodulator, DemodulatorError, Envelope, Frame, Input};
pub use filter::{Filter, FilterError, OUTPUT_RATE_HZ, Settings};
pub use flaws::{ChannelFlaws, Flawed};
pub use mask::Mask;
pub use transient::Transient;
pub use zm::{Channels, ConstantError, NULL_SIGMAS, PlateConstants, Zm, ZmFrame};
