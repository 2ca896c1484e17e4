//! Scenario files: the true properties of the simulated bench and its participant.
//!
//! Every key has a default, so an empty file is the nominal bench of `Huloux 2021`, section "apparatus". The bench never reads
//! a scenario: it has only its own configuration and calibration. Each file of this folder defines one table of a scenario
//! file, with the ranges of its numbers.

mod across_table;
mod amplifier_table;
mod behaviour_table;
mod built_in;
mod converter_table;
mod drift_table;
mod encoder_table;
mod film_table;
mod force_sensor_table;
mod friction_table;
mod gauges_table;
mod jitter_table;
mod laws_table;
mod masses_table;
mod meter_table;
mod moisture_table;
mod participant_table;
mod pickup_table;
mod plate_table;
mod population_table;
mod ranges;
mod reference_table;
mod scenario_error;
mod scenario_file;
mod session_table;
mod sound_layer_table;
mod spread_table;

pub use across_table::{AcrossTable, ContactWidthTable};
pub use amplifier_table::AmplifierTable;
pub use behaviour_table::BehaviourTable;
pub use built_in::{built_in, built_in_names, built_in_text};
pub use converter_table::{ConverterTable, OfferedFormat};
pub use drift_table::DriftTable;
pub use encoder_table::EncoderTable;
pub use film_table::FilmTable;
pub use force_sensor_table::{ForceInterface, ForceLineFormat, ForceSensorTable};
pub use friction_table::FrictionTable;
pub use gauges_table::{FIRST_GAUGE, GAUGES, GaugesTable};
pub use jitter_table::JitterTable;
pub use laws_table::LawsTable;
pub use masses_table::MassesTable;
pub use meter_table::MeterTable;
pub use moisture_table::MoistureTable;
pub use participant_table::ParticipantTable;
pub use pickup_table::PickupTable;
pub use plate_table::{PlateTable, SecondModeTable};
pub use population_table::PopulationTable;
pub use reference_table::{Follows, REFERENCE_INPUT, ReferenceTable};
pub use scenario_error::ScenarioError;
pub use scenario_file::Scenario;
pub use session_table::SessionTable;
pub use sound_layer_table::{ChannelSlip, SoundLayerTable};
pub use spread_table::SpreadTable;
