//! The calibrations of a bench, and their order.

/// Calibration of a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationKind {
    /// The volts, against an independent meter.
    Output,
    /// The inputs, against each other.
    Channels,
    /// The pickup, against a known amplitude.
    Pickup,
    /// The plate, with nothing on it.
    Plate,
    /// The force sensor, with known masses.
    Force,
}

impl CalibrationKind {
    /// All calibrations in their order: the volts, on which every limit depends; the inputs, with which the others measure; the
    /// pickup, with whose sensitivity the plate's force factor is computed; the plate; the force sensor, which depends on none.
    pub const ORDER: [Self; 5] = [
        Self::Output,
        Self::Channels,
        Self::Pickup,
        Self::Plate,
        Self::Force,
    ];

    /// Returns the name of its command.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Channels => "channels",
            Self::Pickup => "pickup",
            Self::Plate => "plate",
            Self::Force => "force",
        }
    }

    /// Returns the measured quantities.
    #[must_use]
    pub fn purpose(self) -> &'static str {
        match self {
            Self::Output => "the volts, against a meter",
            Self::Channels => "inputs against each other, loop delay",
            Self::Pickup => "its sensitivity, against a known amplitude",
            Self::Plate => "resonance, damping, force factor",
            Self::Force => "zero, sensitivity, crosstalk, with known masses",
        }
    }

    /// Returns the names of all calibrations in their order, separated by commas.
    #[must_use]
    pub fn names_in_order() -> String {
        Self::ORDER.map(Self::name).join(", ")
    }
}
