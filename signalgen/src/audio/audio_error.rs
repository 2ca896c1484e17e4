//! Errors of hosts, devices and streams.

use thiserror::Error;

use super::{choice::ChoiceError, sound_device::Offer};
use crate::{stream_health::StreamDirection, stream_layout::LayoutError};

/// Reason why a device, host or stream is not available.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AudioError {
    /// The host does not exist or does not answer.
    #[error("audio host {host} is not available: {reason}")]
    HostUnavailable {
        /// Name of the host.
        host: String,
        /// Message of the backend, with a remedy if one is known.
        reason: String,
    },
    /// The device name matches no device, or several.
    #[error(transparent)]
    Device(#[from] ChoiceError),
    /// The device does not offer the requested rate, format and channels.
    #[error("{direction} device {device} does not offer {request}; it offers: {offered}")]
    Unsupported {
        /// Direction of the stream.
        direction: StreamDirection,
        /// Id and name of the device.
        device: String,
        /// Requested channels, format, rate and buffer.
        request: String,
        /// Capabilities of the device.
        offered: Offer,
    },
    /// The device offers no sample format that the host can express.
    #[error(
        "{direction} device {device} offers no sample format that this audio host can express, so not {request}: it may \
         have packed 24-bit samples alone (ALSA S24_3LE); run a JACK server on it (jackd -d alsa) and choose the host \
         \"jack\""
    )]
    NoUsableFormat {
        /// Direction of the stream.
        direction: StreamDirection,
        /// Id and name of the device.
        device: String,
        /// Requested channels, format, rate and buffer.
        request: String,
    },
    /// Another program holds the device.
    #[error("{direction} device {device} is busy: {holder} ({reason})")]
    Busy {
        /// Direction of the stream.
        direction: StreamDirection,
        /// Id and name of the device.
        device: String,
        /// Program that holds it, if known, and the remedy.
        holder: String,
        /// Message of the backend.
        reason: String,
    },
    /// The backend failed for another reason.
    #[error("{direction} device {device}: {reason}")]
    Backend {
        /// Direction of the stream.
        direction: StreamDirection,
        /// Id and name of the device.
        device: String,
        /// Message of the backend.
        reason: String,
    },
    /// The configuration contradicts itself or the generator.
    #[error("{parameter} = {value} must be {allowed}")]
    Config {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Allowed values, as text.
        allowed: String,
    },
    /// The requested channels or frames are invalid.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}
