//! The participant's screen on a separate terminal, for example a second monitor's `/dev/tty2`.
//!
//! It needs a Unix terminal device. Elsewhere the crate compiles, and [`ParticipantDisplay::open`] returns
//! [`DisplayError::NeedsUnix`].

#[cfg(not(unix))]
mod elsewhere;
mod error;
mod loss;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub use elsewhere::ParticipantDisplay;
pub use error::DisplayError;
pub use loss::DisplayLoss;
#[cfg(unix)]
pub use unix::ParticipantDisplay;
