//! Settings of the simulated apparatus.

use std::path::PathBuf;

use crate::serial::DeviceStart;
use crate::world_clock::WorldPace;
use faults::RehearsedFault;
use mock_world::scenario::Scenario;

/// Settings of the simulated apparatus.
#[derive(Debug, Clone)]
pub struct ApparatusConfig {
    /// True properties of bench and participant.
    pub scenario: Scenario,
    /// Seed of all random properties of the bench, its noise included.
    pub seed: u64,
    /// Seed of the person's skin and habits; `seed` if `None`.
    pub participant_seed: Option<u64>,
    /// Number of earlier openings of the streams; the sound layer draws a new delay for each.
    pub opening: u64,
    /// Pace of the simulation.
    pub pace: WorldPace,
    /// Whether the converter is a data acquisition card, which runs at other rates than a sound card.
    pub acquisition_card: bool,
    /// Length of a period, frames at 192 kHz: a multiple of 4 from 16 to 1920.
    pub period_frames: u32,
    /// Initial counters of the force sensor; drawn by `seed` if `None`.
    pub force_start: Option<DeviceStart>,
    /// Existing folder for `truth.json` and `truth.csv`; `None` to write neither. They begin with the first period in which a
    /// stream of the bench's converter is open.
    pub truth_path: Option<PathBuf>,
    /// File of an oscilloscope on the drive; `None` for no oscilloscope.
    pub oscilloscope_path: Option<PathBuf>,
    /// Faults to inject, each at its time from the first period in which both streams of the bench's converter play. The
    /// scenario's faults are injected only if listed here.
    pub faults: Vec<RehearsedFault>,
}

impl ApparatusConfig {
    /// Returns the settings of an apparatus with the default period and without truth files.
    #[must_use]
    pub fn new(scenario: Scenario, seed: u64, pace: WorldPace) -> Self {
        Self {
            scenario,
            seed,
            participant_seed: None,
            opening: 0,
            pace,
            acquisition_card: false,
            period_frames: 64,
            force_start: None,
            truth_path: None,
            oscilloscope_path: None,
            faults: Vec::new(),
        }
    }

    /// Returns the same apparatus with a data acquisition card; its periods of 1 ms hold whole frames at each of its rates.
    #[must_use]
    pub fn with_acquisition_card(mut self) -> Self {
        self.acquisition_card = true;
        self.period_frames = 192;
        self
    }
}
