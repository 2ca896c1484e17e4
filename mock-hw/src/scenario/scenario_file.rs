//! A whole scenario: its tables, how it is read, and the bench that a seed makes of it.

use rand::RngExt;
use serde::{Deserialize, Serialize};
use strict::OutOfRange;

use super::amplifier_table::AmplifierTable;
use super::converter_table::ConverterTable;
use super::encoder_table::EncoderTable;
use super::film_table::FilmTable;
use super::force_sensor_table::ForceSensorTable;
use super::jitter_table::JitterTable;
use super::masses_table::MassesTable;
use super::participant_table::ParticipantTable;
use super::pickup_table::PickupTable;
use super::plate_table::PlateTable;
use super::scenario_error::ScenarioError;
use super::sound_layer_table::SoundLayerTable;
use crate::seed;

/// A simulated bench with its participant: the truth, which may differ from what the bench assumes.
///
/// ```
/// use mock_hw::scenario::{Scenario, ScenarioError};
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
    /// The two-axis force sensor and its serial device.
    pub force_sensor: ForceSensorTable,
    /// Known masses that are placed on the plate or hung over a pulley beside it.
    pub masses: MassesTable,
    /// The pulley encoder.
    pub encoder: EncoderTable,
    /// The person.
    pub participant: ParticipantTable,
    /// Spread of the constants from seed to seed.
    pub jitter: JitterTable,
}

impl Scenario {
    /// Reads a scenario strictly; `file` only names the file in errors.
    ///
    /// # Errors
    /// [`ScenarioError::Toml`] for text that is not TOML or has keys or values that no scenario has,
    /// [`ScenarioError::OutOfRange`] for a number that the simulation cannot represent.
    pub fn parse(text: &str, file: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = strict::parse(text, file)?;
        scenario
            .check()
            .map_err(|range| ScenarioError::OutOfRange {
                file: file.to_owned(),
                line: line_of(text, &range.key),
                range,
            })?;
        Ok(scenario)
    }

    /// Returns the scenario with constants drawn by `seed`.
    ///
    /// Its jitter is then disabled, so that a second call changes nothing. A scenario whose jitter is disabled is returned unchanged.
    #[must_use]
    pub fn realised(&self, seed: u64) -> Self {
        let mut out = self.clone();
        let j = &self.jitter;
        if !j.enabled {
            return out;
        }
        out.jitter.enabled = false;
        let mut rng = seed::stream(seed, seed::Stream::Jitter);
        let mut within = |half_width: f64| half_width * (2.0 * rng.random::<f64>() - 1.0);
        out.pickup.metres_per_unit *= 1.0 + within(j.pickup_sensitivity);
        out.pickup.phase_rad += within(j.pickup_phase_rad);
        out.plate.resonance_hz += within(j.resonance_hz);
        let [low, high] = j.quality;
        let quality = 0.5 * (low + high) + within(0.5 * (high - low));
        out.plate.damping_n_s_per_m =
            out.plate.omega_rad_per_s() * out.plate.modal_mass_kg / quality;
        out.plate.force_factor_n_per_v *= 1.0 + within(j.force_factor);
        let half = 0.5 * j.skew_samples;
        out.converter.skew_samples = (0..self.converter.channels)
            .map(|ch| {
                let drawn = half + within(half);
                self.converter.skew(ch) + if ch == 0 { 0.0 } else { drawn }
            })
            .collect();
        let force = &mut out.force_sensor;
        force.normal_gain *= 1.0 + within(j.force_gain);
        force.lateral_gain *= 1.0 + within(j.force_gain);
        force.lateral_to_normal += within(j.force_crosstalk);
        force.normal_to_lateral += within(j.force_crosstalk);
        force.normal_offset_n += within(j.force_offset_n);
        force.lateral_offset_n += within(j.force_offset_n);
        force.normal_drift_n_per_min += within(j.force_drift_n_per_min);
        force.lateral_drift_n_per_min += within(j.force_drift_n_per_min);
        let half = 0.5 * j.pulley_friction;
        out.masses.pulley_friction += half + within(half);
        out
    }

    /// Requires every number to lie in its range.
    fn check(&self) -> Result<(), OutOfRange> {
        self.plate.check()?;
        self.amplifier.check()?;
        self.pickup.check()?;
        self.converter.check()?;
        self.sound_layer.check(self.converter.channels)?;
        self.film.check()?;
        self.force_sensor.check()?;
        self.masses.check()?;
        self.encoder.check()?;
        self.participant.check()?;
        self.jitter.check()
    }
}

/// Returns the line of a key, whose path may be followed by a note in brackets about a part of its value.
fn line_of(text: &str, key: &str) -> Option<usize> {
    let path = key.split_once(' ').map_or(key, |(path, _)| path);
    strict::line_of(text, path)
}

#[cfg(test)]
mod tests {
    use strict::TomlError;

    use super::super::sound_layer_table::ChannelSlip;
    use super::*;

    fn parse(text: &str) -> Result<Scenario, ScenarioError> {
        Scenario::parse(text, "test.toml")
    }

    /// The key that is out of range, and its line.
    fn out_of_range(text: &str) -> (String, Option<usize>) {
        match parse(text) {
            Err(ScenarioError::OutOfRange { line, range, .. }) => (range.key, line),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn an_empty_file_is_the_nominal_bench() {
        assert_eq!(parse(""), Ok(Scenario::default()));
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_key() {
        for (text, (line, wrong, right)) in [
            (
                "[plate]\nresonance_hz = 35000.0\nmodal_mas_kg = 0.008\n",
                (3, "modal_mas_kg", "modal_mass_kg"),
            ),
            ("[platte]\n", (1, "platte", "plate")),
            ("[sound_layer]\nrate = 48000.0\n", (2, "rate", "rate_hz")),
        ] {
            match parse(text) {
                Err(ScenarioError::Toml(TomlError::UnknownKey {
                    file,
                    line: at,
                    key,
                    nearest,
                    ..
                })) => assert_eq!(
                    (file.as_str(), at, key.as_str(), nearest.as_deref()),
                    ("test.toml", line, wrong, Some(right))
                ),
                other => panic!("{text}: {other:?}"),
            }
        }
    }

    #[test]
    fn a_wrong_type_is_named_with_its_line() {
        let wrong = parse("\n[plate]\nresonance_hz = \"high\"\n").unwrap_err();
        assert!(
            matches!(
                wrong,
                ScenarioError::Toml(TomlError::Invalid { line: 3, .. })
            ),
            "{wrong}"
        );
    }

    #[test]
    fn a_number_out_of_range_names_file_line_key_value_and_range() {
        let error = parse("[participant]\nmu0 = 8.0\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "test.toml, line 2: participant.mu0 = 8 is outside the allowed range of 0.05 to 3"
        );
        let at = |key: &str, line| (key.to_owned(), Some(line));
        assert_eq!(out_of_range("[film]\nlag_s = nan\n"), at("film.lag_s", 2));
        assert_eq!(
            out_of_range("\n[participant]\nz_t_n_s_per_m = [0.5, 0.1]\n"),
            at("participant.z_t_n_s_per_m (imaginary)", 3)
        );
        assert_eq!(
            out_of_range("[jitter]\nquality = [300.0, 200.0]\n"),
            at("jitter.quality", 2)
        );
    }

    #[test]
    fn a_sound_layer_is_held_to_the_channels_of_the_converter() {
        let sound = "[converter]\ngains = [1.0, -2.0]\n[sound_layer]\nrate_hz = 48000.0\nanti_alias = false\n\
                     inputs = [1, 0]\nslip = { channel = 1, samples = 2, after_s = 3.0 }\n";
        let layer = parse(sound).unwrap().sound_layer;
        assert_eq!((layer.rate_hz, layer.inputs), (Some(48e3), vec![1, 0]));
        let slip = |channel: u8, samples: u8, after_s: f64| {
            format!(
                "[sound_layer]\nslip = {{ channel = {channel}, samples = {samples}, after_s = {after_s:?} }}\n"
            )
        };
        for (text, key) in [
            ("[converter]\ngains = [1.0, 200.0]\n", "converter.gains"),
            (
                "[converter]\ngains = [1, 1, 1, 1, 1]\n",
                "converter.gains (entries)",
            ),
            ("[sound_layer]\nrate_hz = 1000.0\n", "sound_layer.rate_hz"),
            ("[sound_layer]\ninputs = [4]\n", "sound_layer.inputs"),
            (
                "[sound_layer]\ninputs = [0, 1, 2, 3, 3]\n",
                "sound_layer.inputs (entries)",
            ),
            (&slip(9, 1, 1.0), "sound_layer.slip.channel"),
            (&slip(1, 0, 1.0), "sound_layer.slip.samples"),
            (&slip(1, 1, -1.0), "sound_layer.slip.after_s"),
        ] {
            assert_eq!(out_of_range(text), (key.to_owned(), Some(2)));
        }
    }

    #[test]
    fn a_scenario_survives_writing_and_reading() {
        let scenario = Scenario {
            sound_layer: SoundLayerTable {
                rate_hz: Some(44_100.0),
                slip: Some(ChannelSlip {
                    channel: 1,
                    samples: 1,
                    after_s: 2.0,
                }),
                ..SoundLayerTable::default()
            },
            participant: ParticipantTable {
                mu0: Some(0.9),
                z_t_n_s_per_m: Some([0.4, 3.0]),
                ..ParticipantTable::default()
            },
            ..Scenario::default()
        };
        let text = toml::to_string(&scenario).unwrap();
        assert_eq!(parse(&text).unwrap(), scenario);
    }

    #[test]
    fn jitter_is_off_by_default_deterministic_and_within_its_limits() {
        let nominal = Scenario::default();
        assert_eq!(nominal.realised(7), nominal);
        let mut on = nominal.clone();
        on.jitter.enabled = true;
        assert_eq!(on.realised(7), on.realised(7));
        assert_ne!(on.realised(7), on.realised(8));
        assert_eq!(on.realised(7).realised(7), on.realised(7));
        for seed in 0..200 {
            let r = on.realised(seed);
            let q = r.plate.omega_rad_per_s() * r.plate.modal_mass_kg / r.plate.damping_n_s_per_m;
            assert!((150.0..=350.0).contains(&q));
            assert!((r.plate.resonance_hz - 35e3).abs() <= 300.0);
            assert!((r.pickup.metres_per_unit / 5.0e-6 - 1.0).abs() <= 0.2);
            assert!((r.pickup.phase_rad - 0.2).abs() <= 0.5);
            assert!((r.plate.force_factor_n_per_v / 0.13 - 1.0).abs() <= 0.2);
            assert!(
                r.converter
                    .skew_samples
                    .iter()
                    .all(|s| (0.0..=1.0).contains(s))
            );
            let force = &r.force_sensor;
            for gain in [force.normal_gain, force.lateral_gain] {
                assert!((gain - 1.0).abs() <= 0.2);
            }
            for crosstalk in [force.lateral_to_normal, force.normal_to_lateral] {
                assert!(crosstalk.abs() <= 0.05);
            }
            for offset_n in [force.normal_offset_n, force.lateral_offset_n] {
                assert!(offset_n.abs() <= 0.03);
            }
            for drift in [force.normal_drift_n_per_min, force.lateral_drift_n_per_min] {
                assert!(drift.abs() <= 0.005);
            }
            assert!((0.0..=0.003).contains(&r.masses.pulley_friction));
        }
    }
}
