//! A vibrometer's or interferometer's analog output on a spare input, which measures complex displacements while the pickup is
//! read.

use std::f64::consts::TAU;

use anyhow::bail;
use config::{CalibrationFile, Config};
use num_complex::Complex64;
use statistics::significant;

/// |sample| above which the instrument's output counts as cut off.
const CLIPPED: f64 = 0.98;
/// Smallest ratio of the tone's amplitude to the rest of the input.
const LEAST_RATIO: f64 = 3.0;

/// Quantity measured by the instrument, with its scale per volt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeasuredQuantity {
    /// Displacement, m/V.
    Displacement(f64),
    /// Velocity, m/s/V.
    Velocity(f64),
}

/// Delay of the instrument's output behind the plate, as stated by its maker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedDelay {
    /// Delay, s.
    pub delay_s: f64,
    /// Standard uncertainty, s.
    pub error_s: f64,
}

/// An instrument on a spare input.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Input channel.
    pub channel: u16,
    follows: MeasuredQuantity,
    volts_per_unit: f64,
    delay: Option<StatedDelay>,
    /// Phase of the instrument's input minus that of the drive's, its standard error, and the frequency of the measurement, rad
    /// and Hz; `None` if `calibrate channels` has not measured it.
    input: Option<(f64, f64, f64)>,
}

/// A reading of the instrument at a tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Displacement {
    /// Envelope of the displacement at the time of the drive's input, m peak; its phase is valid only where `phase_error_rad`
    /// is.
    pub value_m: Complex64,
    /// Standard deviation of its amplitude due to noise, m.
    pub sigma_m: f64,
}

impl Reference {
    /// Checks an instrument on input `channel` of the bench of `config`, with the inputs as compared in `calibration`, if at
    /// all; `volts_per_unit` is the voltage of a full-scale sample of that input.
    ///
    /// # Errors
    /// If the input is not spare, or a number is out of its range.
    pub fn new(
        (channel, volts_per_unit): (u16, f64),
        follows: MeasuredQuantity,
        delay: Option<StatedDelay>,
        config: &Config,
        calibration: &CalibrationFile,
    ) -> anyhow::Result<Self> {
        let inputs = config.audio.input_channels;
        if channel >= inputs {
            bail!(
                "--reference-channel {channel}: the card has inputs 0 to {} (audio.input_channels = {inputs} in bench.toml)",
                inputs.saturating_sub(1)
            );
        }
        for (key, index) in [
            ("channels.drive.index", config.channels.drive.index),
            ("channels.pickup.index", config.channels.pickup.index),
        ] {
            if channel == index {
                bail!(
                    "--reference-channel {channel}: that input is {key} in bench.toml; connect the instrument to a spare one"
                );
            }
        }
        let positive = |name: &str, value: f64, most: f64| {
            if value > 0.0 && value <= most {
                return Ok(());
            }
            bail!(
                "{name} = {} must be over 0 and at most {most}",
                significant(value)
            )
        };
        match follows {
            MeasuredQuantity::Displacement(m_per_v) => {
                positive("--reference-um-per-v", m_per_v * 1e6, 1e3)?;
            }
            MeasuredQuantity::Velocity(per_v) => {
                positive("--reference-m-per-s-per-v", per_v, 100.0)?
            }
        }
        positive("--reference-volts-per-unit", volts_per_unit, 1e3)?;
        if let Some(StatedDelay { delay_s, error_s }) = delay {
            for (name, value_s) in [
                ("--reference-delay-us", delay_s),
                ("--reference-delay-error-us", error_s),
            ] {
                if !(0.0..=1e-3).contains(&value_s) {
                    bail!(
                        "{name} = {} is outside 0 to 1000",
                        significant(value_s * 1e6)
                    );
                }
            }
        }
        let input = calibration.channels.as_ref().and_then(|channels| {
            let input = channels.input(channel)?;
            let (phase, at_hz) = (&input.phase_rad, channels.carrier_hz);
            Some((phase.value, phase.standard_error, at_hz))
        });
        Ok(Self {
            channel,
            follows,
            volts_per_unit,
            delay,
            input,
        })
    }

    /// Returns the displacement for which the instrument's input reads `tone` at `carrier_hz` over `frames` frames.
    ///
    /// # Errors
    /// If the input is cut off, or reads no tone.
    pub fn displacement(
        &self,
        tone: &metrology::tone::SteadyTone,
        carrier_hz: f64,
        frames: usize,
    ) -> anyhow::Result<Displacement> {
        let channel = self.channel;
        if tone.peak >= CLIPPED {
            bail!(
                "the instrument's input {channel} (--reference-channel) is cut off: choose a larger range on the instrument, or lower --levels-v"
            );
        }
        // A dead input has neither tone nor noise.
        if tone.value.norm() <= LEAST_RATIO * tone.rest_rms {
            bail!(
                "input {channel} (--reference-channel) reads no tone at {carrier_hz:.0} Hz ({:.1e} of full scale under {:.1e} of other signal): is the instrument on that input, in focus, and is its bandwidth wide enough?",
                tone.value.norm(),
                tone.rest_rms
            );
        }
        let omega = TAU * carrier_hz;
        let (late_s, turned_rad) = (
            self.delay.map_or(0.0, |delay| delay.delay_s),
            self.input
                .map_or(0.0, |(phase, _, at_hz)| phase * carrier_hz / at_hz),
        );
        let per_volt = match self.follows {
            MeasuredQuantity::Displacement(m_per_v) => Complex64::from(m_per_v),
            MeasuredQuantity::Velocity(m_per_s_per_v) => m_per_s_per_v / Complex64::new(0.0, omega),
        };
        let per_unit = per_volt * self.volts_per_unit;
        let noise = tone.rest_rms * (3.0 / frames as f64).sqrt();
        Ok(Displacement {
            value_m: tone.value * per_unit * Complex64::cis(omega * late_s - turned_rad),
            sigma_m: per_unit.norm() * noise.hypot(1e-5 * tone.value.norm()),
        })
    }

    /// Returns the standard uncertainty of the displacement's phase at `carrier_hz`, rad, or the missing requirement as an
    /// error.
    pub fn phase_error_rad(&self, carrier_hz: f64) -> Result<f64, &'static str> {
        let delay = self
            .delay
            .ok_or("the instrument's delay is not given (--reference-delay-us)")?;
        let (_, error, at_hz) = self.input.ok_or(
            "the delay between the instrument's input and the drive's is not calibrated: run `friction-bench calibrate \
             channels` first, with that input",
        )?;
        Ok((TAU * carrier_hz * delay.error_s).hypot(error * carrier_hz / at_hz))
    }

    /// Returns a description of the instrument.
    pub fn in_words(&self) -> String {
        let follows = match self.follows {
            MeasuredQuantity::Displacement(per_v) => {
                format!("displacement, {} µm/V", significant(per_v * 1e6))
            }
            MeasuredQuantity::Velocity(per_v) => format!("velocity, {} m/s/V", significant(per_v)),
        };
        let delay = self.delay.map_or_else(
            || "delay unknown".to_owned(),
            |delay| format!("delay {:.3} µs", delay.delay_s * 1e6),
        );
        format!(
            "read on input {} ({follows}, {} V full scale, {delay})",
            self.channel, self.volts_per_unit
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metrology::tone::SteadyTone;

    fn config() -> Config {
        Config::parse(config::rigs::MOCK_BENCH, "test").unwrap()
    }

    fn none_held() -> CalibrationFile {
        let identity = config::Identity::from_config(&config(), String::new(), String::new());
        CalibrationFile::new(identity)
    }

    fn instrument_on(
        channel: u16,
        follows: MeasuredQuantity,
        volts_per_unit: f64,
        delay: Option<StatedDelay>,
    ) -> Result<Reference, String> {
        let input = (channel, volts_per_unit);
        Reference::new(input, follows, delay, &config(), &none_held()).map_err(|e| e.to_string())
    }

    const UM: MeasuredQuantity = MeasuredQuantity::Displacement(1e-6);

    #[test]
    fn a_refusal_names_the_option_or_the_line() {
        let late = |delay_s, error_s| Some(StatedDelay { delay_s, error_s });
        for (result, words) in [
            (instrument_on(0, UM, 1.0, None), "channels.drive.index"),
            (instrument_on(1, UM, 1.0, None), "channels.pickup.index"),
            (instrument_on(4, UM, 1.0, None), "audio.input_channels"),
            (
                instrument_on(3, UM, 0.0, None),
                "--reference-volts-per-unit",
            ),
            (
                instrument_on(3, UM, f64::NAN, None),
                "--reference-volts-per-unit",
            ),
            (
                instrument_on(3, MeasuredQuantity::Displacement(-1e-6), 1.0, None),
                "--reference-um-per-v",
            ),
            (
                instrument_on(3, MeasuredQuantity::Velocity(0.0), 1.0, None),
                "--reference-m-per-s-per-v",
            ),
            (
                instrument_on(3, UM, 1.0, late(-1e-6, 0.0)),
                "--reference-delay-us",
            ),
            (
                instrument_on(3, UM, 1.0, late(0.0, f64::NAN)),
                "--reference-delay-error-us",
            ),
        ] {
            let error = result.unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        assert!(
            instrument_on(3, UM, 1.0, late(0.0, 0.0)).is_ok()
                && instrument_on(2, UM, 1e3, None).is_ok()
        );
    }

    fn tone(value: Complex64, peak: f64, rest_rms: f64) -> SteadyTone {
        SteadyTone {
            value,
            peak,
            rest_rms,
        }
    }

    #[test]
    fn velocity_and_displacement_are_one_motion_and_a_delay_is_taken_off() {
        let (hz, frames) = (35e3, 96_000);
        let omega = TAU * hz;
        let late = Some(StatedDelay {
            delay_s: 2e-6,
            error_s: 1e-7,
        });
        let displacement = instrument_on(3, UM, 4.0, late).unwrap();
        let velocity = instrument_on(3, MeasuredQuantity::Velocity(0.1), 4.0, late).unwrap();
        // A displacement of 1 µm with a phase of 0.5 rad.
        let displacement_m = Complex64::from_polar(1e-6, 0.5);
        let reading = displacement_m * Complex64::cis(-omega * 2e-6) / 4.0;
        for (instrument, value) in [
            (&displacement, reading / 1e-6),
            (&velocity, reading * Complex64::new(0.0, omega) / 0.1),
        ] {
            let result = instrument.displacement(&tone(value, 0.6, 1e-4), hz, frames);
            assert!((result.unwrap().value_m - displacement_m).norm() < 1e-15);
        }
        assert!(
            displacement
                .phase_error_rad(hz)
                .unwrap_err()
                .contains("calibrate channels")
        );
        let unknown = instrument_on(3, UM, 4.0, None).unwrap();
        assert!(
            unknown
                .phase_error_rad(hz)
                .unwrap_err()
                .contains("--reference-delay-us")
        );
        for (faulty_tone, words) in [
            (tone(Complex64::ONE, 0.99, 0.0), "cut off"),
            (tone(Complex64::ZERO, 0.0, 0.0), "no tone"),
            (tone(Complex64::from(1e-3), 0.01, 1e-3), "no tone"),
        ] {
            let result = displacement
                .displacement(&faulty_tone, hz, frames)
                .map(|_| ());
            assert!(result.unwrap_err().to_string().contains(words));
        }
    }
}
