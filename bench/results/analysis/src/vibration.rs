//! Vibration of the plate in a recording with an impedance: its carrier, its modulation, and the plate.

use recording::Manifest;
use recording::manifest::{Modulation, RecordedPlate};
use serde::{Deserialize, Serialize};

/// Vibration of the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Vibration {
    /// Frequency to which impedances refer, Hz: that of the carrier, or the mean of one that moves.
    pub carrier_hz: f64,
    /// Whether the carrier moves.
    pub moves: bool,
    /// Modulation of the drive.
    pub modulation: Modulation,
    /// Constants of the plate.
    pub plate: RecordedPlate,
}

impl Vibration {
    /// Returns the vibration of a recording at its stated carrier; `None` if the carrier moves, or without an impedance.
    #[must_use]
    pub fn stated(manifest: &Manifest) -> Option<Self> {
        Self::at(manifest, manifest.carrier_hz()?)
    }

    /// Returns the vibration of a recording at a carrier; `None` without an impedance.
    pub(crate) fn at(manifest: &Manifest, carrier_hz: f64) -> Option<Self> {
        Some(Self {
            carrier_hz,
            moves: manifest.carrier_hz().is_none(),
            modulation: manifest.modulation()?,
            plate: manifest.plate()?.clone(),
        })
    }
}
