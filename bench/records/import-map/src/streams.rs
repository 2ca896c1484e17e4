//! Streams of a recording: arrays, scales and clocks.

use serde::Deserialize;

use crate::pattern::Template;
pub use crate::value::ComplexArrays;

/// Value that the map states, or that is found in the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Stated value.
    Stated(f64),
    /// Value found in the data.
    Found,
}

impl Quantity {
    /// Returns the stated value.
    #[must_use]
    pub fn stated(self) -> Option<f64> {
        match self {
            Self::Stated(value) => Some(value),
            Self::Found => None,
        }
    }
}

/// Array of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArraySource {
    /// File of the array; `None` for the file that the map's pattern matches.
    pub file: Option<Template>,
    /// Name of the array.
    pub name: String,
}

/// Times of a stream's samples.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeBase {
    /// Constant rate.
    Rate(Rate),
    /// Array of the samples' times.
    Column {
        /// Name of the array.
        name: String,
        /// Unit of the times, s; `None` if the map does not state it: 1.
        seconds_per_unit: Option<f64>,
    },
}

/// Rate of a stream's samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Rate {
    /// Stated rate, Hz.
    Hz(f64),
    /// Scalar of the file with the rate, Hz.
    Scalar(String),
    /// Rate that the file itself states.
    File,
}

/// Clock of a stream: t_drive = offset_s + t_file (1 + ppm · 10⁻⁶).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Whether the samples are on the drive's clock.
    pub is_drives: bool,
    /// Offset, s.
    pub offset_s: Quantity,
    /// Excess of the stream's unit of time, parts per million; 0 on the drive's clock.
    pub ppm: Quantity,
}

/// Voltage across the actuators.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Array of the samples.
    pub source: ArraySource,
    /// Times of the samples, which are the recording's.
    pub time: TimeBase,
    /// Volts per unit of the samples.
    pub volts_per_unit: f64,
}

/// Quantity that a pickup measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PickupQuantity {
    /// Displacement.
    Displacement,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Charge of a piezo element, in proportion to its strain and thus to the displacement.
    Charge,
}

impl PickupQuantity {
    /// Returns the number of derivatives of the displacement with respect to time.
    #[must_use]
    pub fn derivatives(self) -> u32 {
        match self {
            Self::Displacement | Self::Charge => 0,
            Self::Velocity => 1,
            Self::Acceleration => 2,
        }
    }
}

/// Scale of a pickup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PickupScale {
    /// Metres per unit of the samples; of a velocity m/s, of an acceleration m/s².
    MetresPerUnit(f64),
    /// The scale with which the unloaded plate has the stated modal mass.
    FromModalMass,
}

/// Conversion of a pickup's samples to the plate's displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PickupConversion {
    /// Quantity that it measures.
    pub quantity: PickupQuantity,
    /// Its scale.
    pub scale: PickupScale,
    /// Time from a sample of the drive to the pickup's sample of the same index, s.
    pub skew_s: Quantity,
    /// Phase to be added to that of the samples, rad.
    pub phase_rad: Quantity,
}

/// Displacement of the plate.
#[derive(Debug, Clone, PartialEq)]
pub struct Pickup {
    /// Array of the samples.
    pub source: ArraySource,
    /// Conversion to the displacement.
    pub conversion: PickupConversion,
}

/// Sign of the time in complex envelopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum Convention {
    /// exp(+iωt).
    #[serde(rename = "exp(+iwt)")]
    Positive,
    /// exp(−iωt).
    #[serde(rename = "exp(-iwt)")]
    Negative,
}

/// Low-pass filter of a lock-in amplifier, H = 1/(1 + iωτ)^order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LockInFilter {
    /// Order.
    pub order: u32,
    /// Time constant τ, s.
    pub tau_s: f64,
}

/// Complex envelopes of drive and pickup.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelopes {
    /// File; `None` for the file that the map's pattern matches.
    pub file: Option<Template>,
    /// Envelope of the drive.
    pub drive: ComplexArrays,
    /// Envelope of the pickup.
    pub pickup: ComplexArrays,
    /// Times of the values.
    pub time: TimeBase,
    /// Volts per unit of the drive's envelope.
    pub volts_per_unit: f64,
    /// Conversion of the pickup's envelope to the displacement.
    pub conversion: PickupConversion,
    /// Sign of the time.
    pub convention: Convention,
    /// Whether the values are root mean squares.
    pub is_rms: bool,
    /// Filter that is undone.
    pub low_pass: Option<LockInFilter>,
}

/// Tare of the normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NormalTare {
    /// Stated reading without a load, N.
    Stated(f64),
    /// Reading while no finger is on the plate.
    NoContact,
}

/// Tare of the lateral force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LateralTare {
    /// Stated reading without a load, N.
    Stated(f64),
    /// Reading while no finger is on the plate.
    NoContact,
    /// Mean of the strokes in both directions at equal speed.
    SymmetricStrokes,
}

/// A component of the force.
#[derive(Debug, Clone, PartialEq)]
pub struct Force<T> {
    /// Array of the samples.
    pub source: ArraySource,
    /// Times of the samples.
    pub time: TimeBase,
    /// Clock of the samples.
    pub clock: Clock,
    /// Newtons per unit of the samples.
    pub newtons_per_unit: f64,
    /// Tare.
    pub tare: T,
}

/// Normal force.
pub type Normal = Force<NormalTare>;
/// Lateral force.
pub type Lateral = Force<LateralTare>;

/// Quantity that states the place of the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Travel {
    /// Position, or counts of an encoder.
    Position {
        /// Metres per unit.
        metres_per_unit: f64,
        /// Number of bits after which the counts begin again.
        wrap_bits: Option<u32>,
    },
    /// Velocity, which is integrated.
    Velocity {
        /// m/s per unit.
        metres_per_s_per_unit: f64,
    },
}

/// Place of the finger along the plate.
#[derive(Debug, Clone, PartialEq)]
pub struct Position {
    /// Array of the samples.
    pub source: ArraySource,
    /// Times of the samples.
    pub time: TimeBase,
    /// Clock of the samples.
    pub clock: Clock,
    /// Quantity of the samples.
    pub travel: Travel,
}
