//! Identity of the bench to which a calibration belongs.

use serde::{Deserialize, Serialize};

use crate::Config;

/// Devices, channels, plate and gains for which a calibration is valid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Audio input device, as named by the sound layer.
    pub input_device: String,
    /// Audio output device, as named by the sound layer.
    pub output_device: String,
    /// Sample rate of both, Hz.
    pub rate_hz: u32,
    /// Sample format.
    pub sample_format: String,
    /// Output channel that feeds the amplifier.
    pub output_channel: u16,
    /// Input channel of the drive's read-back.
    pub drive_channel: u16,
    /// Input channel of the pickup.
    pub pickup_channel: u16,
    /// Actuator volts per full scale of the output, as typed in.
    pub output_volts_per_unit: f64,
    /// Actuator volts per sample value, as typed in.
    pub drive_volts_per_unit: f64,
    /// Name of the plate.
    pub plate_id: String,
    /// Modal mass of the plate, as typed in, kg.
    pub modal_mass_kg: f64,
    /// Gains of the amplifiers, as described by the operator.
    pub gains: String,
    /// Identification of the force sensor, such as its port and protocol; absent if no measurement has used one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_sensor: Option<String>,
    /// Identification of the sound card among others of the same name: its serial number, or the port it is plugged into;
    /// absent if the system reports neither, and in calibrations of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sound_card: Option<String>,
}

/// The first difference between the calibrated bench and the present one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the calibration was made with {part} {calibrated}, but the bench has {present}: {remedy}")]
pub struct Mismatch {
    /// Name of the property that differs.
    pub part: &'static str,
    /// Value on the calibrated bench.
    pub calibrated: String,
    /// Present value.
    pub present: String,
    /// Remedy for the operator.
    pub remedy: &'static str,
}

const RECALIBRATE: &str = "calibrate again, or go back to what was calibrated";

impl Identity {
    /// Returns the identity of the bench described by `config`, with the opened devices.
    #[must_use]
    pub fn from_config(config: &Config, input_device: String, output_device: String) -> Self {
        Self {
            input_device,
            output_device,
            rate_hz: config.audio.rate_hz,
            sample_format: format!("{:?}", config.audio.sample_format).to_lowercase(),
            output_channel: config.output.channel,
            drive_channel: config.channels.drive.index,
            pickup_channel: config.channels.pickup.index,
            output_volts_per_unit: config.output.volts_per_unit,
            drive_volts_per_unit: config.channels.drive.volts_per_unit,
            plate_id: config.plate.id.clone(),
            modal_mass_kg: config.plate.modal_mass_kg,
            gains: config.calibration.gains.clone(),
            force_sensor: config.force_identity(),
            sound_card: None,
        }
    }

    /// Returns the identity with an identification of the sound card that distinguishes cards of the same name.
    #[must_use]
    pub fn with_sound_card(self, sound_card: Option<String>) -> Self {
        Self { sound_card, ..self }
    }

    /// Requires that `present` is the calibrated bench; force sensors are compared only if one was calibrated, sound cards of
    /// the same name only if both identifications are known.
    ///
    /// # Errors
    /// [`Mismatch`] with the first difference.
    pub fn require(&self, present: &Self) -> Result<(), Mismatch> {
        let number = |value: f64| value.to_string();
        let channels = |identity: &Self| {
            format!(
                "drive on input {}, pickup on input {}, amplifier on output {}",
                identity.drive_channel, identity.pickup_channel, identity.output_channel
            )
        };
        let quoted = |text: &str| format!("\"{text}\"");
        let sensor = |name: &Option<String>| quoted(name.as_deref().unwrap_or("none"));
        let cards = self.sound_card.as_ref().zip(present.sound_card.as_ref());
        let (card, present_card) =
            cards.map_or_else(Default::default, |(a, b)| (quoted(a), quoted(b)));
        let compared: [(&'static str, String, String, &'static str); 12] = [
            (
                "the input device",
                self.input_device.clone(),
                present.input_device.clone(),
                RECALIBRATE,
            ),
            (
                "the output device",
                self.output_device.clone(),
                present.output_device.clone(),
                RECALIBRATE,
            ),
            (
                "the sound card",
                card,
                present_card,
                "another card of the same model: plug the calibrated one in again, into the port that it was in, or calibrate \
                 this one",
            ),
            (
                "a rate in Hz of",
                self.rate_hz.to_string(),
                present.rate_hz.to_string(),
                RECALIBRATE,
            ),
            (
                "the sample format",
                self.sample_format.clone(),
                present.sample_format.clone(),
                RECALIBRATE,
            ),
            (
                "the channels",
                channels(self),
                channels(present),
                "the map in bench.toml was changed: go back to the old one or calibrate again",
            ),
            (
                "output.volts_per_unit",
                number(self.output_volts_per_unit),
                number(present.output_volts_per_unit),
                RECALIBRATE,
            ),
            (
                "channels.drive.volts_per_unit",
                number(self.drive_volts_per_unit),
                number(present.drive_volts_per_unit),
                RECALIBRATE,
            ),
            (
                "the plate",
                quoted(&self.plate_id),
                quoted(&present.plate_id),
                "another plate has another resonance: calibrate it",
            ),
            (
                "plate.modal_mass_kg",
                number(self.modal_mass_kg),
                number(present.modal_mass_kg),
                RECALIBRATE,
            ),
            (
                "the gains",
                quoted(&self.gains),
                quoted(&present.gains),
                "set the gains back or calibrate again",
            ),
            (
                "the force sensor",
                sensor(&self.force_sensor),
                match self.force_sensor {
                    Some(_) => sensor(&present.force_sensor),
                    None => sensor(&None),
                },
                "plug the calibrated one in again, or run `friction-bench calibrate force`",
            ),
        ];
        match compared.into_iter().find(|(_, a, b, _)| a != b) {
            None => Ok(()),
            Some((part, calibrated, present, remedy)) => Err(Mismatch {
                part,
                calibrated,
                present,
                remedy,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 50.
    #[test]
    fn another_card_of_the_same_name_is_another_bench_and_an_untold_one_is_not() {
        let config = Config::parse(crate::TEMPLATE, "bench.toml").unwrap();
        let bench = |card: Option<&str>| {
            let device = || "hw:CARD=USB,DEV=0".to_owned();
            Identity::from_config(&config, device(), device())
                .with_sound_card(card.map(str::to_owned))
        };
        let calibrated = bench(Some("serial number 23A"));
        for present in [Some("serial number 23A"), None] {
            assert_eq!(calibrated.require(&bench(present)), Ok(()));
        }
        assert_eq!(bench(None).require(&calibrated), Ok(()));
        let result = calibrated.require(&bench(Some("serial number 23B")));
        let result = result.map_err(|mismatch| (mismatch.part, mismatch.present));
        assert_eq!(
            result,
            Err(("the sound card", "\"serial number 23B\"".to_owned()))
        );
    }
}
