//! The participant's screen on a separate terminal, for example a second monitor's `/dev/tty2`.
//!
//! It needs a Unix terminal device. Elsewhere the crate compiles, and [`ParticipantTerminal::open`] returns
//! [`DisplayError::NeedsUnix`].

mod error;
mod loss;
#[cfg(unix)]
mod unix;
#[cfg(not(unix))]
mod unsupported;

pub use error::DisplayError;
pub use loss::DisplayLoss;
#[cfg(unix)]
pub use unix::ParticipantTerminal;
#[cfg(not(unix))]
pub use unsupported::ParticipantTerminal;
