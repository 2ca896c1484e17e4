//! What an analysis found, with everything that results, tables and figures are made of.

use std::path::PathBuf;

use contact::FittedFinger;
use protocols::{Direction, SelectionRules};

use crate::analysis_settings::Settings;
pub use crate::estimate::{Deltas, Estimated, InstanceAnalysis, MeasuredSamples, Method};
pub use crate::exploration_findings::ExplorationFindings;
use crate::flaw::Flaw;
pub use crate::instance::PlateReading;
pub use crate::model_check::Band;
use recording::manifest::{Manifest, RecordedPlate};
use recording::pipeline::PickupOffset;
use recording::pipeline::RecordedError;
use recording::reader::ReadError;

/// All recordings of one analysis.
#[derive(Debug)]
pub struct Analysed {
    /// What was assumed.
    pub settings: Settings,
    /// In the order in which they were named.
    pub recordings: Vec<RecordingAnalysis>,
}

impl Analysed {
    /// Every estimated instance with the recording that it is of.
    pub fn instances(&self) -> impl Iterator<Item = (&RecordingFindings, &InstanceAnalysis)> {
        self.findings().flat_map(|found| {
            found
                .instances
                .iter()
                .map(move |instance| (found, instance))
        })
    }

    /// The recordings that could be read.
    pub fn findings(&self) -> impl Iterator<Item = &RecordingFindings> {
        self.recordings.iter().filter_map(|r| r.found.as_ref().ok())
    }
}

/// One recording.
#[derive(Debug)]
pub struct RecordingAnalysis {
    /// Its folder, as named.
    pub path: PathBuf,
    /// What was found, or why it cannot be read.
    pub found: Result<RecordingFindings, RecordingError>,
}

/// Why a recording cannot be analysed at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A file is missing, damaged beyond reading or against the format.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its audio cannot be demodulated as it says.
    #[error(transparent)]
    Demodulation(#[from] RecordedError),
}

/// What was found in a recording.
#[derive(Debug)]
pub struct RecordingFindings {
    /// Its folder, as named.
    pub path: PathBuf,
    /// What it is of.
    pub manifest: Manifest,
    /// What a stretch had to be to hold an instance.
    pub rules: SelectionRules,
    /// What of the pickup the unloaded plate showed to be otherwise than stated, and was undone.
    pub pickup: PickupOffset,
    /// The plate's own impedance; `None` if it could not be read.
    pub z_p: Option<PlateReading>,
    /// The explorations in time.
    pub explorations: Vec<ExplorationFindings>,
    /// What was estimated, in time order.
    pub instances: Vec<InstanceAnalysis>,
    /// Self-sensed against measured normal force, by amplitude.
    pub model_check: Vec<Band>,
    /// Stretches without an estimate.
    pub rejected: Vec<Rejected>,
    /// What is wrong with the recording.
    pub flaws: Vec<Flaw>,
}

impl RecordingFindings {
    /// Who took part, if it is known.
    pub fn participant(&self) -> Option<&str> {
        self.manifest.participant.as_ref().map(|p| p.id.as_str())
    }

    /// The plate's constants.
    pub fn plate(&self) -> &RecordedPlate {
        &self.manifest.plate
    }

    /// The finger fitted on the first instance, which the model check extrapolates.
    pub fn first_finger(&self) -> Option<&FittedFinger> {
        self.instances.first().map(|instance| &instance.finger)
    }
}

/// A stretch of rising amplitude that gave no estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    /// Direction of its exploration.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Why.
    pub reason: String,
}
