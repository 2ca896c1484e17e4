//! Devices that the program has lost, and the obstacles to a re-arming.

use std::fmt;
use std::sync::atomic::{AtomicU8, Ordering};

/// Device that the program does not open again once it is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LostDevice {
    /// The force sensor.
    ForceSensor,
    /// The encoder.
    Encoder,
    /// The sound card.
    SoundCard,
}

impl LostDevice {
    const ALL: [Self; 3] = [Self::ForceSensor, Self::Encoder, Self::SoundCard];

    fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl fmt::Display for LostDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ForceSensor => "force sensor",
            Self::Encoder => "encoder",
            Self::SoundCard => "sound card",
        })
    }
}

/// Devices lost since the bench was opened; published by the tasks that read them.
///
/// ```
/// use safety::{LostDevice, Losses};
///
/// let losses = Losses::default();
/// assert_eq!(losses.first(), None);
/// losses.report(LostDevice::Encoder);
/// assert_eq!(losses.first(), Some(LostDevice::Encoder));
/// assert!(!losses.includes(LostDevice::SoundCard));
/// ```
#[derive(Debug, Default)]
pub struct Losses(AtomicU8);

impl Losses {
    /// Records the loss of `device`.
    pub fn report(&self, device: LostDevice) {
        self.0.fetch_or(device.bit(), Ordering::Relaxed);
    }

    /// Returns whether `device` is lost.
    #[must_use]
    pub fn includes(&self, device: LostDevice) -> bool {
        self.0.load(Ordering::Relaxed) & device.bit() != 0
    }

    /// Returns the first lost device, in the order of [`LostDevice`].
    #[must_use]
    pub fn first(&self) -> Option<LostDevice> {
        let mut devices = LostDevice::ALL.into_iter();
        devices.find(|device| self.includes(*device))
    }
}

/// Obstacle to a re-arming, with the operator's remedy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RearmObstacle {
    /// The e-stop's loop is open.
    #[error("not re-armed: the e-stop is still pressed: release it, then press x")]
    EmergencyStop,
    /// A line cannot be read or driven.
    #[error(
        "not re-armed: the lines of e-stop and amplifier still cannot be read or driven: plug their chip in, then press x"
    )]
    Lines,
    /// A device is lost until the program ends.
    #[error(
        "not re-armed: the {0} is lost to this program: q, y ends it; plug it in, then start again (`run` with --resume)"
    )]
    Lost(LostDevice),
}
