//! Invalid numbers of channels and frames of a stream.

use thiserror::Error;

/// An invalid layout of channels and frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LayoutError {
    /// A number of channels or frames is 0.
    #[error("{parameter} = 0 must be 1 or more")]
    Zero {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// The drive's channel is not an output channel.
    #[error(
        "drive_channel = {drive_channel} must be below the number of output channels, {channels}"
    )]
    DriveChannel {
        /// Requested channel, from 0.
        drive_channel: usize,
        /// Number of output channels.
        channels: usize,
    },
}

/// Returns an error that names `parameter` if `value` is 0.
pub(crate) fn nonzero(parameter: &'static str, value: usize) -> Result<(), LayoutError> {
    if value == 0 {
        Err(LayoutError::Zero { parameter })
    } else {
        Ok(())
    }
}
