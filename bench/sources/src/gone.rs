//! Sources that have disappeared.

use safety::GpioError;

use crate::field_box::FieldBoxGone;

/// A source that has disappeared, for good.
#[derive(Debug, thiserror::Error)]
pub enum SourceGone {
    /// The serial port no longer exists.
    #[error("the force sensor's port is gone: {0}")]
    Port(std::io::Error),
    /// The network is down.
    #[error("the force sensor's network is gone: {0}")]
    Network(std::io::Error),
    /// The sensor's clock is not what it is configured as.
    #[error(
        "the force sensor counts {counted_hz:.0} samples a second, and force.netft.sample_hz = {stated_hz}: forces would be \
         placed wrongly; set it to the device's rate"
    )]
    Rate {
        /// Configured rate, Hz.
        stated_hz: f64,
        /// Rate by the host's clock, Hz.
        counted_hz: f64,
    },
    /// A line of this computer cannot be read.
    #[error(transparent)]
    Line(#[from] GpioError),
    /// The card whose counter counts cannot be read any more.
    #[error("{0}")]
    Card(String),
    /// The field box cannot be read any more, or is none that this version can use.
    #[error(transparent)]
    FieldBox(#[from] FieldBoxGone),
}
