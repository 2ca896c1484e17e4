//! What apparatus to simulate, and how.

use std::path::PathBuf;

use crate::serial::DeviceStart;
use crate::world_clock::Pace;
use mock_world::scenario::Scenario;
use rehearsal::RehearsedFault;

/// What apparatus to simulate, and how.
#[derive(Debug, Clone)]
pub struct ApparatusConfig {
    /// What is true of bench and participant.
    pub scenario: Scenario,
    /// Seed of everything random about the bench, its noise included.
    pub seed: u64,
    /// Seed of the person's skin and habits; `seed` when absent.
    pub participant_seed: Option<u64>,
    /// How many times the streams were opened before: the sound layer draws its delay anew each time.
    pub opening: u64,
    /// Who advances the simulation.
    pub pace: Pace,
    /// Whether the converter is a data acquisition card, which runs at other rates than a sound card.
    pub acquisition_card: bool,
    /// Length of a period, frames at 192 kHz: a multiple of 4 from 16 to 1920.
    pub period_frames: u32,
    /// Where the force sensor's counters begin; drawn by `seed` when absent.
    pub force_start: Option<DeviceStart>,
    /// An existing folder for `truth.json` and `truth.csv`; they are not written when absent. They begin with the first
    /// period in which a stream of the bench's converter is open.
    pub truth_path: Option<PathBuf>,
    /// File of an oscilloscope on the drive; there is none when absent.
    pub oscilloscope_path: Option<PathBuf>,
    /// Faults that are injected, each at its time from the first period in which both streams of the bench's converter
    /// play. Those of the scenario are not injected by themselves.
    pub faults: Vec<RehearsedFault>,
}

impl ApparatusConfig {
    /// Returns the settings of an apparatus with the default period and without truth files.
    #[must_use]
    pub fn new(scenario: Scenario, seed: u64, pace: Pace) -> Self {
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

    /// Returns the same apparatus with a data acquisition card, in whose periods of a millisecond there are whole frames
    /// at each of its rates.
    #[must_use]
    pub fn with_acquisition_card(mut self) -> Self {
        self.acquisition_card = true;
        self.period_frames = 192;
        self
    }
}
