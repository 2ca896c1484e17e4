//! The map as it is used: every combination of its values makes a recording.

use interval_rules::Rule;
use serde::Deserialize;

use crate::pattern::{FilePattern, Template};
use crate::streams::{Drive, Envelopes, Lateral, Normal, Pickup, Position, Quantity};

/// Map of files of other programs onto recordings.
#[derive(Debug, Clone)]
pub struct ImportMap {
    /// Files with a recording each.
    pub pattern: FilePattern,
    /// Drive and pickup.
    pub electrical: Electrical,
    /// Normal force.
    pub normal: Option<Normal>,
    /// Lateral force.
    pub lateral: Option<Lateral>,
    /// Place of the finger.
    pub position: Option<Position>,
    /// Body that touches the plate.
    pub body: Body,
    /// Intervals.
    pub intervals: Intervals,
    /// Table of participants, relative to the map's folder.
    pub participants: Option<String>,
}

/// Kind of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// Samples of drive and pickup.
    A,
    /// Complex envelopes of both.
    B,
    /// Forces and position alone.
    C,
}

/// Drive and pickup of a recording, by its kind.
#[derive(Debug, Clone)]
pub enum Electrical {
    /// Samples of drive and pickup.
    Signals {
        /// Carrier.
        carrier: Carrier,
        /// Modulation.
        modulation: Modulation,
        /// Drive.
        drive: Drive,
        /// Pickup.
        pickup: Pickup,
        /// Plate.
        plate: Plate,
        /// Files with the plate alone.
        baseline: Option<Template>,
    },
    /// Complex envelopes of both.
    Envelopes {
        /// Carrier, Hz.
        carrier_hz: f64,
        /// Modulation.
        modulation: Modulation,
        /// Envelopes.
        envelopes: Envelopes,
        /// Plate.
        plate: Plate,
    },
    /// Forces alone, with the drive's voltage as stimulus if it is known.
    Stimulus(Option<Drive>),
}

/// Carrier of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carrier {
    /// Stated or found frequency, Hz, constant within the recording.
    Constant(Quantity),
    /// It moves within the recording.
    Follows,
}

/// Modulation of the amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulation {
    /// Frequency, Hz.
    pub hz: Quantity,
    /// Index, 0 to 1.
    pub index: Quantity,
}

/// Plate under the finger.
#[derive(Debug, Clone, PartialEq)]
pub struct Plate {
    /// Modal mass, kg.
    pub modal_mass_kg: f64,
    /// The other constants.
    pub constants: PlateConstants,
    /// Position of its centre.
    pub centre: Centre,
}

/// Constants of a plate besides the modal mass.
#[derive(Debug, Clone, PartialEq)]
pub enum PlateConstants {
    /// Stated constants.
    Stated {
        /// Resonance, Hz.
        resonance_hz: f64,
        /// Quality factor, if stated.
        quality: Option<f64>,
        /// Force factor, N/V.
        force_factor_n_per_v: f64,
    },
    /// Sweep that was measured elsewhere.
    Sweep {
        /// Its file, relative to the map's folder.
        file: String,
        /// Force factor, N/V, if the map states it.
        force_factor_n_per_v: Option<f64>,
    },
}

/// Position of a plate's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Centre {
    /// Stated position, m.
    Stated(f64),
    /// Middle between the ends of the finger's travel.
    MiddleOfTravel,
}

/// Body that touches the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// Finger.
    #[default]
    Finger,
    /// Other body, for which the ranges of fingers do not apply.
    Other,
}

/// Intervals with a known meaning.
#[derive(Debug, Clone, PartialEq)]
pub enum Intervals {
    /// Rules.
    Rules {
        /// Stretches without a finger.
        unloaded: Option<Rule>,
        /// Strokes of the finger.
        exploration: Option<Rule>,
    },
    /// Table of marks.
    Marks(Template),
}

impl ImportMap {
    /// Returns the kind of the recordings.
    #[must_use]
    pub fn tier(&self) -> Tier {
        match self.electrical {
            Electrical::Signals { .. } => Tier::A,
            Electrical::Envelopes { .. } => Tier::B,
            Electrical::Stimulus(_) => Tier::C,
        }
    }
}
