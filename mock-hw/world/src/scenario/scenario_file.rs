//! Complete scenario: its tables, its parser, and the bench drawn from a seed.

use faults::{RehearsedFault, require_apart};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use strict_toml::{InFile, OutOfRange, require_range};

use super::amplifier_table::AmplifierTable;
use super::converter_table::ConverterTable;
use super::encoder_table::EncoderTable;
use super::film_table::FilmTable;
use super::force_sensor_table::{ForceInterface, ForceSensorTable};
use super::friction_table::FrictionTable;
use super::gauges_table::{FIRST_GAUGE, GAUGES};
use super::jitter_table::JitterTable;
use super::laws_table::LawsTable;
use super::masses_table::MassesTable;
use super::meter_table::MeterTable;
use super::participant_table::ParticipantTable;
use super::pickup_table::PickupTable;
use super::plate_table::PlateTable;
use super::reference_table::{Follows, ReferenceTable};
use super::scenario_error::ScenarioError;
use super::session_table::SessionTable;
use super::sound_layer_table::SoundLayerTable;
use crate::seed;

/// A simulated bench with its participant: the truth, which may differ from the bench's assumptions.
///
/// ```
/// use mock_world::scenario::{Scenario, ScenarioError};
///
/// let scenario = Scenario::parse("[participant]\nmu0 = 0.9\n", "soft-skin.toml")?;
/// assert_eq!(scenario.participant.mu0, Some(0.9));
/// assert_eq!(scenario.plate, Scenario::default().plate);
///
/// let error = Scenario::parse("[participant]\nmu0 = 8.0\n", "soft-skin.toml").unwrap_err();
/// assert!(matches!(error, ScenarioError::OutOfRange { line: Some(2), .. }));
/// # Ok::<(), ScenarioError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Purpose of the scenario, in one line.
    pub purpose: String,
    /// The glass plate and its actuators.
    pub plate: PlateTable,
    /// The amplifier between generator and actuators.
    pub amplifier: AmplifierTable,
    /// The pickup disc.
    pub pickup: PickupTable,
    /// The sound card's inputs.
    pub converter: ConverterTable,
    /// The software between the program and the sound card.
    pub sound_layer: SoundLayerTable,
    /// The squeeze film and asperities, without the skin of the person.
    pub film: FilmTable,
    /// Friction beyond the published law.
    pub friction: FrictionTable,
    /// Departures from the published laws of the contact.
    pub laws: LawsTable,
    /// The two-axis force sensor and its serial device.
    pub force_sensor: ForceSensorTable,
    /// Known masses that are placed on the plate or hung over a pulley beside it.
    pub masses: MassesTable,
    /// An independent voltmeter across the actuators.
    pub meter: MeterTable,
    /// A vibrometer on a spare input of the sound card.
    pub reference: ReferenceTable,
    /// The pulley encoder.
    pub encoder: EncoderTable,
    /// The person.
    pub participant: ParticipantTable,
    /// Spread of the constants from seed to seed.
    pub jitter: JitterTable,
    /// Ranges of the constants drawn for one session.
    pub session: SessionTable,
    /// Faults to inject, each at a time from the start of the bench's sound card.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<RehearsedFault>,
}

impl Scenario {
    /// Reads a scenario strictly; `file` only names the file in errors.
    ///
    /// # Errors
    /// [`ScenarioError::Toml`] for text that is not TOML or has unknown keys or values, [`ScenarioError::OutOfRange`] for a
    /// number that the simulation cannot represent, [`ScenarioError::Fault`] or [`ScenarioError::Overlap`] for faults that
    /// cannot be injected.
    pub fn parse(text: &str, file: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = strict_toml::parse(text, file)?;
        scenario
            .check()
            .map_err(|range| ScenarioError::OutOfRange {
                file: file.to_owned(),
                line: line_of(text, &range.key),
                range,
            })?;
        for (index, fault) in scenario.faults.iter().enumerate() {
            fault.check().map_err(|error| {
                let key = format!("faults.{index}.{}", error.key());
                ScenarioError::Fault(InFile::at_key(error, &key, text, file))
            })?;
        }
        require_apart(&scenario.faults).map_err(|error| ScenarioError::Overlap {
            file: file.to_owned(),
            error,
        })?;
        Ok(scenario)
    }

    /// Returns the scenario with constants drawn from `seed`.
    ///
    /// The result has jitter disabled and no session ranges, so a second call has no effect. A scenario without jitter and
    /// ranges is returned unchanged.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Self {
        let mut out = self.with_jitter(seed);
        let session = std::mem::take(&mut out.session);
        let mut rng = seed::stream(seed, seed::RandomStream::Session);
        session.draw(&mut rng, &mut out.plate, &mut out.force_sensor);
        out
    }

    /// Returns the scenario with the constants of its jitter drawn.
    fn with_jitter(&self, seed: u64) -> Self {
        let mut out = self.clone();
        let j = &self.jitter;
        if !j.enabled {
            return out;
        }
        out.jitter.enabled = false;
        let mut rng = seed::stream(seed, seed::RandomStream::Jitter);
        let mut jitter = |half_width: f64| half_width * (2.0 * rng.random::<f64>() - 1.0);
        out.pickup.metres_per_unit *= 1.0 + jitter(j.pickup_sensitivity);
        out.pickup.phase_rad += jitter(j.pickup_phase_rad);
        out.plate.resonance_hz += jitter(j.resonance_hz);
        let [low, high] = j.quality;
        let quality = 0.5 * (low + high) + jitter(0.5 * (high - low));
        out.plate.damping_n_s_per_m =
            out.plate.omega_rad_per_s() * out.plate.modal_mass_kg / quality;
        out.plate.force_factor_n_per_v *= 1.0 + jitter(j.force_factor);
        let half = 0.5 * j.skew_samples;
        out.converter.skew_samples = (0..self.converter.channels)
            .map(|ch| {
                let skew = half + jitter(half);
                self.converter.skew(ch) + if ch == 0 { 0.0 } else { skew }
            })
            .collect();
        let force = &mut out.force_sensor;
        force.normal_gain *= 1.0 + jitter(j.force_gain);
        force.lateral_gain *= 1.0 + jitter(j.force_gain);
        force.lateral_to_normal += jitter(j.force_crosstalk);
        force.normal_to_lateral += jitter(j.force_crosstalk);
        force.normal_offset_n += jitter(j.force_offset_n);
        force.lateral_offset_n += jitter(j.force_offset_n);
        force.normal_drift_n_per_min += jitter(j.force_drift_n_per_min);
        force.lateral_drift_n_per_min += jitter(j.force_drift_n_per_min);
        let half = 0.5 * j.pulley_friction;
        out.masses.pulley_friction += half + jitter(half);
        out
    }

    /// Requires every number to be in range.
    fn check(&self) -> Result<(), OutOfRange> {
        self.plate.check()?;
        self.amplifier.check()?;
        self.pickup.check()?;
        self.converter.check()?;
        self.sound_layer.check(self.converter.channels)?;
        self.film.check()?;
        self.friction.check()?;
        self.laws.check()?;
        self.force_sensor.check()?;
        if self.force_sensor.interface == ForceInterface::Gauges {
            let (channels, min_channels) = (
                self.converter.channels as f64,
                (FIRST_GAUGE + GAUGES) as f64,
            );
            require_range("converter.channels", channels, min_channels, 32.0, "")?;
            // A gauge uses the vibrometer's input.
            let vibrometers = f64::from(self.reference.follows != Follows::Nothing);
            require_range("reference.follows", vibrometers, 0.0, 0.0, "beside gauges")?;
        }
        self.masses.check()?;
        self.meter.check()?;
        self.reference.check(self.converter.channels)?;
        self.encoder.check()?;
        self.participant.check()?;
        self.jitter.check()?;
        self.session.check()
    }
}

/// Returns the line of a key; its path may be followed by a note in brackets about a part of its value.
fn line_of(text: &str, key: &str) -> Option<usize> {
    let path = key.split_once(' ').map_or(key, |(path, _)| path);
    strict_toml::line_of(text, path)
}
