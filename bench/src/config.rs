//! `bench.toml`: the hardware of one bench. Read strictly, checked once, then never changed.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};

use crate::force::{Correction, ForceProtocol, MOST_CROSSTALK};

/// The bench as its file describes it. Every number is SI, peak for peak.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Version of this file's layout; 1.
    pub format: u32,
    /// The sound card.
    pub audio: Audio,
    /// The driven output.
    pub output: Output,
    /// What is wired to the inputs.
    pub channels: Channels,
    /// The plate.
    pub plate: Plate,
    /// Limits of the drive.
    pub limits: Limits,
    /// Limits of the safety watch.
    #[serde(default)]
    pub safety: Safety,
    /// The force sensor; without it there is no participant protocol.
    pub force: Option<Force>,
    /// The position encoder; without it there is no participant protocol.
    pub encoder: Option<Encoder>,
    /// Digital lines.
    #[serde(default)]
    pub gpio: Gpio,
    /// Cues and masking noise for the participant.
    #[serde(default)]
    pub sound: Sound,
    /// What a calibration must reach, and how long it holds.
    #[serde(default)]
    pub calibration: Calibration,
}

/// Which cpal host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AudioHost {
    /// The platform's own: ALSA, CoreAudio, WASAPI.
    Native,
    /// A JACK server.
    Jack,
}

/// Sample format on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum SampleFormat {
    F32,
    I32,
    I16,
}

/// `[audio]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Audio {
    /// Which sound layer.
    pub host: AudioHost,
    /// Output device, by id or name.
    pub output_device: String,
    /// Input device, by id or name; the same card as the output, for both must share one sample clock.
    pub input_device: String,
    /// Sample rate, Hz.
    pub rate_hz: u32,
    /// Sample format.
    pub sample_format: SampleFormat,
    /// Channels of the output stream.
    pub output_channels: u16,
    /// Channels of the input stream; all of them are recorded.
    pub input_channels: u16,
    /// Frames a callback; the device's own choice when absent.
    pub buffer_frames: Option<u32>,
    /// Audio kept for a disk that stalls, s.
    #[serde(default = "Audio::default_ring_s")]
    pub ring_s: f64,
}

impl Audio {
    fn default_ring_s() -> f64 {
        10.0
    }
}

/// `[output]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Output channel that feeds the amplifier.
    pub channel: u16,
    /// Actuator volts per full scale of the output, amplifier included.
    pub volts_per_unit: f64,
}

/// `[channels]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channels {
    /// Read-back of the voltage across the actuators.
    pub drive: DriveChannel,
    /// The piezo pickup.
    pub pickup: PickupChannel,
}

/// `[channels.drive]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveChannel {
    /// Input channel.
    pub index: u16,
    /// Actuator volts per sample value.
    pub volts_per_unit: f64,
    /// |sample| from which on the input is taken to clip, of full scale.
    #[serde(default = "default_clip_units")]
    pub clip_units: f64,
}

/// Just under full scale, where every converter clips at the latest.
fn default_clip_units() -> f64 {
    0.999
}

/// `[channels.pickup]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PickupChannel {
    /// Input channel.
    pub index: u16,
    /// Plate displacement per sample value at the carrier, m.
    pub metres_per_unit: f64,
    /// Phase to add to the pickup's samples, rad.
    pub phase_rad: f64,
    /// |sample| from which on the input is taken to clip, of full scale.
    #[serde(default = "default_clip_units")]
    pub clip_units: f64,
}

/// `[plate]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Name of this very plate.
    pub id: String,
    /// Resonance of the driven mode, Hz; the carrier of protocols that ask for it.
    pub resonance_hz: f64,
    /// Modal mass, kg.
    pub modal_mass_kg: f64,
    /// Force factor γ: f_a = γ U_a, N/V.
    pub force_factor_n_per_v: f64,
    /// Length along which the finger slides, m.
    pub length_m: f64,
    /// Position of the plate's centre, m.
    pub centre_m: f64,
}

/// `[limits]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest peak voltage that this bench may ask for, V; at most the generator's compiled-in limit.
    pub drive_v: f64,
    /// Raised-cosine ramp of every start and stop, s.
    #[serde(default = "Limits::default_ramp_s")]
    pub ramp_s: f64,
}

impl Limits {
    fn default_ramp_s() -> f64 {
        0.05
    }
}

/// `[safety]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Safety {
    /// Normal force that stops the drive, N.
    pub max_normal_n: f64,
    /// Lateral force that stops the drive, either way, N. 3 N by default, an assumption: the published explorations press with
    /// 0.65 N (Huloux 2021, section IV), so that a finger has to stick with a friction coefficient over 4 to get there.
    pub max_lateral_n: f64,
    /// Allowed relative difference of the read-back from the command.
    pub readback_tolerance: f64,
    /// Read-back below this is silence, V.
    pub readback_floor_v: f64,
    /// Longest time from a command to its read-back, s.
    pub loop_latency_s: f64,
    /// Silence of the card or of the force sensor that stops the drive, s.
    pub silence_s: f64,
}

impl Default for Safety {
    fn default() -> Self {
        Self {
            max_normal_n: 3.0,
            max_lateral_n: 3.0,
            readback_tolerance: 0.25,
            readback_floor_v: 1.0,
            loop_latency_s: 0.1,
            silence_s: 0.05,
        }
    }
}

/// No bench may set its force limits outside of these, N: below, a finger cannot explore; above, it can be hurt (an assumption).
const FORCE_LIMITS_N: [f64; 2] = [0.1, 20.0];

impl Safety {
    /// Largest normal and lateral force, N.
    #[must_use]
    pub fn max_forces_n(&self) -> [f64; 2] {
        [self.max_normal_n, self.max_lateral_n]
    }

    fn check(&self) -> anyhow::Result<()> {
        let [least_n, most_n] = FORCE_LIMITS_N;
        for (key, limit_n) in [
            ("safety.max_normal_n", self.max_normal_n),
            ("safety.max_lateral_n", self.max_lateral_n),
        ] {
            within(key, limit_n, least_n, most_n, "N")?;
        }
        within(
            "safety.readback_tolerance",
            self.readback_tolerance,
            0.01,
            1.0,
            "",
        )?;
        within(
            "safety.loop_latency_s",
            self.loop_latency_s,
            0.005,
            1.0,
            "s",
        )?;
        within("safety.silence_s", self.silence_s, 0.02, 1.0, "s")
    }
}

/// `[force]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Serial port.
    pub port: PathBuf,
    /// Format on the line, see `docs/force-protocol.md`.
    pub protocol: ForceProtocol,
    /// Baud rate; ignored by USB ports.
    #[serde(default = "Force::default_baud")]
    pub baud: u32,
    /// Time from sampling to the first byte at the computer at its quickest, s.
    #[serde(default)]
    pub latency_s: f64,
    /// Newtons of normal and of lateral force, in rows, per newton that the normal and the lateral axis read.
    #[serde(default = "Force::default_matrix")]
    pub matrix: [[f64; 2]; 2],
    /// What the axes read without load, N.
    #[serde(default)]
    pub tare_n: [f64; 2],
}

impl Force {
    fn default_matrix() -> [[f64; 2]; 2] {
        Correction::default().matrix
    }

    /// By what another sensor is noticed.
    #[must_use]
    pub fn identity(&self) -> String {
        let protocol = format!("{:?}", self.protocol).to_lowercase();
        format!("{}, {protocol}", self.port.display())
    }

    /// From what the sensor says to newtons.
    #[must_use]
    pub fn correction(&self) -> Correction {
        Correction {
            matrix: self.matrix,
            tare_n: self.tare_n,
        }
    }

    /// Takes newtons from what the sensor says by `correction`.
    pub fn set_correction(&mut self, correction: Correction) {
        self.matrix = correction.matrix;
        self.tare_n = correction.tare_n;
    }

    fn default_baud() -> u32 {
        2_000_000
    }
}

/// `[encoder]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Movement per quadrature count, m; negative when the encoder counts the other way.
    pub metres_per_count: f64,
    /// Position along the plate where the bench starts counting, m.
    pub origin_m: f64,
}

/// Which GPIO library drives the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GpioBackend {
    /// Raspberry Pi.
    Rppal,
    /// Any Linux board with a GPIO character device.
    Gpiocdev,
    /// No lines.
    #[default]
    None,
}

/// `[gpio]`
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gpio {
    /// Library.
    pub backend: GpioBackend,
    /// Character device, for `gpiocdev`.
    pub chip: Option<PathBuf>,
    /// Encoder A, line number.
    pub encoder_a: Option<u8>,
    /// Encoder B, line number.
    pub encoder_b: Option<u8>,
    /// E-stop loop, line number.
    pub estop: Option<u8>,
    /// Participant's button, line number.
    pub button: Option<u8>,
    /// Amplifier enable, line number.
    pub enable: Option<u8>,
    /// Amplifier heartbeat, line number.
    pub heartbeat: Option<u8>,
}

impl Gpio {
    /// Numbers of the lines that are wired.
    pub fn lines(&self) -> impl Iterator<Item = u8> {
        let lines = [
            self.encoder_a,
            self.encoder_b,
            self.estop,
            self.button,
            self.enable,
            self.heartbeat,
        ];
        lines.into_iter().flatten()
    }
}

/// `[sound]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sound {
    /// Output device of cues and noise, by id or name: not the card that drives the plate. Empty: none.
    pub device: String,
    /// Start and end tones.
    pub cues: bool,
    /// White noise against the plate's audible squeal.
    pub masking_noise: bool,
    /// Level of both, of full scale.
    pub level: f64,
}

impl Default for Sound {
    fn default() -> Self {
        Self {
            device: String::new(),
            cues: true,
            masking_noise: false,
            level: 0.2,
        }
    }
}

/// `[calibration]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Calibration {
    /// Gains of amplifiers and inputs as they are set now, in words: a calibration holds for these.
    pub gains: String,
    /// A calibration that is older is refused, days.
    pub max_age_days: f64,
    /// Largest plate amplitude that a calibration may ask for, m.
    pub max_amplitude_m: f64,
    /// Largest departure of the pickup's points from a line, of the largest amplitude.
    pub pickup_nonlinearity: f64,
    /// Largest relative standard error of the pickup's sensitivity.
    pub pickup_error: f64,
    /// Largest departure of the plate's response from its fit, root mean square over its peak.
    pub plate_residual: f64,
    /// Quality factors of a plate that nothing touches, from and to.
    pub quality: [f64; 2],
    /// Largest change of the resonance since the calibration before, Hz.
    pub drift_hz: f64,
    /// A force sensor without load reads less than this, N.
    pub zero_n: f64,
    /// Acceleration of gravity where the bench stands, m/s²; standard gravity (9.80665) when absent, with an error that
    /// holds anywhere at sea level. National geodetic services give the local value (for most places to 1e-5 by latitude and
    /// height, GRS 80).
    pub gravity_m_per_s2: Option<f64>,
    /// A force reading is at rest when means over a tenth of a second scatter less than this, or no more than its noise
    /// makes them, N.
    pub force_rest_n: f64,
    /// Largest departure of a known mass from the fitted matrix, of the largest force on its axis.
    pub force_nonlinearity: f64,
    /// Largest relative standard error of the force sensor's sensitivity on either axis.
    pub force_error: f64,
    /// Largest crosstalk between the axes of the force sensor, N per newton read.
    pub force_crosstalk: f64,
    /// Largest noise of either axis, N/√Hz.
    pub force_noise_n_per_sqrt_hz: f64,
    /// Largest drift of either axis' zero, N/min.
    pub force_drift_n_per_min: f64,
    /// Largest departure of either axis' zero from its drift after a load was taken away, N.
    pub force_zero_return_n: f64,
    /// Largest noise density of an input about the carrier, sample units per √Hz.
    pub input_noise_units_per_sqrt_hz: f64,
    /// Largest crosstalk of the drive into another input, dB.
    pub crosstalk_db: f64,
    /// Largest departure of an input's levels from a line, of the largest level.
    pub input_nonlinearity: f64,
    /// Largest delay between an input and the drive's, samples.
    pub delay_samples: f64,
    /// Largest relative standard error of an input's gain, and of its phase in rad.
    pub input_error: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self {
            gains: String::new(),
            max_age_days: 30.0,
            max_amplitude_m: 5e-6,
            pickup_nonlinearity: 0.01,
            pickup_error: 0.01,
            plate_residual: 0.01,
            quality: [50.0, 2000.0],
            drift_hz: 100.0,
            zero_n: 0.05,
            gravity_m_per_s2: None,
            force_rest_n: 3e-4,
            force_nonlinearity: 0.01,
            force_error: 0.02,
            force_crosstalk: 0.2,
            force_noise_n_per_sqrt_hz: 1e-3,
            force_drift_n_per_min: 0.02,
            force_zero_return_n: 0.01,
            input_noise_units_per_sqrt_hz: 1e-6,
            crosstalk_db: -60.0,
            input_nonlinearity: 0.005,
            delay_samples: 8.0,
            input_error: 1e-3,
        }
    }
}

/// From the equator on a mountain to the poles, m/s².
pub const GRAVITY: [f64; 2] = [9.76, 9.84];

impl Calibration {
    fn check(&self) -> anyhow::Result<()> {
        let within = |key: &str, value: f64, low: f64, high: f64, unit: &str| {
            within(&format!("calibration.{key}"), value, low, high, unit)
        };
        within("max_age_days", self.max_age_days, 0.01, 3650.0, "days")?;
        within("max_amplitude_m", self.max_amplitude_m, 1e-8, 2e-5, "m")?;
        within(
            "pickup_nonlinearity",
            self.pickup_nonlinearity,
            1e-4,
            0.2,
            "",
        )?;
        within("pickup_error", self.pickup_error, 1e-4, 0.2, "")?;
        within("plate_residual", self.plate_residual, 1e-5, 0.2, "")?;
        within("quality", self.quality[0], 1.0, self.quality[1], "")?;
        within("drift_hz", self.drift_hz, 0.1, 5e3, "Hz")?;
        within("zero_n", self.zero_n, 1e-3, 1.0, "N")?;
        if let Some(gravity) = self.gravity_m_per_s2 {
            within("gravity_m_per_s2", gravity, GRAVITY[0], GRAVITY[1], "m/s²")?;
        }
        within("force_rest_n", self.force_rest_n, 1e-6, 0.05, "N")?;
        within("force_nonlinearity", self.force_nonlinearity, 1e-4, 0.2, "")?;
        within("force_error", self.force_error, 1e-4, 0.2, "")?;
        within(
            "force_crosstalk",
            self.force_crosstalk,
            1e-3,
            MOST_CROSSTALK,
            "N/N",
        )?;
        within(
            "force_noise_n_per_sqrt_hz",
            self.force_noise_n_per_sqrt_hz,
            1e-7,
            0.1,
            "N/√Hz",
        )?;
        within(
            "force_drift_n_per_min",
            self.force_drift_n_per_min,
            1e-5,
            1.0,
            "N/min",
        )?;
        within(
            "force_zero_return_n",
            self.force_zero_return_n,
            1e-5,
            1.0,
            "N",
        )?;
        within(
            "input_noise_units_per_sqrt_hz",
            self.input_noise_units_per_sqrt_hz,
            1e-10,
            1e-3,
            "/√Hz",
        )?;
        within("crosstalk_db", self.crosstalk_db, -160.0, -10.0, "dB")?;
        within("input_nonlinearity", self.input_nonlinearity, 1e-5, 0.2, "")?;
        within("delay_samples", self.delay_samples, 0.01, 200.0, "samples")?;
        within("input_error", self.input_error, 1e-7, 0.1, "")
    }
}

fn within(key: &str, value: f64, low: f64, high: f64, unit: &str) -> anyhow::Result<()> {
    if !(low..=high).contains(&value) {
        bail!("{key} = {value} {unit} is outside the allowed range of {low} to {high} {unit}");
    }
    Ok(())
}

impl Config {
    /// Reads and checks a configuration.
    ///
    /// # Errors
    /// Names the key, its line, the value and what is allowed.
    pub fn parse(text: &str, file: &str) -> anyhow::Result<Self> {
        let config: Self = protocols::strict_toml::parse(text, file)?;
        config
            .check()
            .with_context(|| format!("{file} cannot be used"))?;
        Ok(config)
    }

    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// As [`Config::parse`]; a missing file names the command that writes one.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| {
            format!(
                "cannot read {}: describe your hardware in it; `friction-bench run --mock --print-config > bench.toml` writes one to start from",
                path.display()
            )
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// The file's text.
    ///
    /// # Errors
    /// Never for a configuration that was parsed.
    pub fn to_toml(&self) -> anyhow::Result<String> {
        toml::to_string(self).context("the configuration cannot be written as TOML")
    }

    fn check(&self) -> anyhow::Result<()> {
        if self.format != 1 {
            bail!(
                "format = {} is not known; this version reads format 1",
                self.format
            );
        }
        let audio = &self.audio;
        within(
            "audio.rate_hz",
            f64::from(audio.rate_hz),
            44_100.0,
            768_000.0,
            "Hz",
        )?;
        within("audio.ring_s", audio.ring_s, 1.0, 60.0, "s")?;
        let channel = |key: &str, index: u16, count: u16| {
            anyhow::ensure!(
                index < count,
                "{key} = {index} but the stream has {count} channels, numbered from 0"
            );
            Ok(())
        };
        channel("output.channel", self.output.channel, audio.output_channels)?;
        channel(
            "channels.drive.index",
            self.channels.drive.index,
            audio.input_channels,
        )?;
        channel(
            "channels.pickup.index",
            self.channels.pickup.index,
            audio.input_channels,
        )?;
        anyhow::ensure!(
            self.channels.drive.index != self.channels.pickup.index,
            "channels.drive.index and channels.pickup.index are both {}",
            self.channels.drive.index
        );
        within(
            "output.volts_per_unit",
            self.output.volts_per_unit,
            1e-3,
            1e4,
            "V",
        )?;
        within(
            "channels.drive.volts_per_unit",
            self.channels.drive.volts_per_unit,
            1e-3,
            1e4,
            "V",
        )?;
        within(
            "channels.pickup.metres_per_unit",
            self.channels.pickup.metres_per_unit,
            1e-9,
            1e-3,
            "m",
        )?;
        for (key, clip_units) in [
            ("channels.drive.clip_units", self.channels.drive.clip_units),
            (
                "channels.pickup.clip_units",
                self.channels.pickup.clip_units,
            ),
        ] {
            within(key, clip_units, 1e-3, 1.0, "of full scale")?;
        }
        within(
            "channels.pickup.phase_rad",
            self.channels.pickup.phase_rad,
            -7.0,
            7.0,
            "rad",
        )?;
        within(
            "plate.resonance_hz",
            self.plate.resonance_hz,
            1e3,
            2e5,
            "Hz",
        )?;
        within(
            "plate.modal_mass_kg",
            self.plate.modal_mass_kg,
            1e-5,
            1.0,
            "kg",
        )?;
        within(
            "plate.force_factor_n_per_v",
            self.plate.force_factor_n_per_v,
            1e-4,
            1e2,
            "N/V",
        )?;
        within("plate.length_m", self.plate.length_m, 0.01, 1.0, "m")?;
        within(
            "plate.centre_m",
            self.plate.centre_m,
            0.0,
            self.plate.length_m,
            "m",
        )?;
        within(
            "limits.drive_v",
            self.limits.drive_v,
            0.0,
            signalgen::HARD_LIMIT_V,
            "V",
        )?;
        within("limits.ramp_s", self.limits.ramp_s, 0.005, 1.0, "s")?;
        self.safety.check()?;
        within("sound.level", self.sound.level, 0.0, 1.0, "")?;
        if let Some(force) = &self.force {
            force
                .correction()
                .require_plausible(self.safety.max_forces_n())?;
        }
        if let Some(encoder) = &self.encoder {
            within(
                "encoder.metres_per_count",
                encoder.metres_per_count.abs(),
                1e-7,
                1e-3,
                "m",
            )?;
        }
        self.calibration.check()?;
        self.check_gpio()
    }

    fn check_gpio(&self) -> anyhow::Result<()> {
        let gpio = &self.gpio;
        let mut used: Vec<u8> = gpio.lines().collect();
        used.sort_unstable();
        if let Some(twice) = used.windows(2).find(|pair| pair[0] == pair[1]) {
            bail!("GPIO line {} is used twice in [gpio]", twice[0]);
        }
        if gpio.backend == GpioBackend::Gpiocdev && gpio.chip.is_none() {
            bail!("gpio.backend = \"gpiocdev\" needs gpio.chip, such as \"/dev/gpiochip0\"");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BENCH: &str = include_str!("../mock-bench.toml");

    fn with_force(keys: &str) -> anyhow::Result<Config> {
        let text = BENCH.replacen("[force]\n", &format!("[force]\n{keys}\n"), 1);
        Config::parse(&text, "bench.toml")
    }

    #[test]
    fn every_limit_of_a_force_calibration_has_a_range() {
        for (key, good, bad) in [
            ("gravity_m_per_s2", "9.8128", "9.9"),
            ("force_rest_n", "0.001", "0.1"),
            ("force_nonlinearity", "0.02", "0.3"),
            ("force_error", "0.01", "0.0"),
            ("force_crosstalk", "0.1", "0.4"),
            ("force_noise_n_per_sqrt_hz", "1.0e-4", "1.0"),
            ("force_drift_n_per_min", "0.1", "2.0"),
            ("force_zero_return_n", "0.02", "0.0"),
        ] {
            let of = |value: &str| {
                Config::parse(
                    &format!("{BENCH}\n[calibration]\n{key} = {value}\n"),
                    "bench.toml",
                )
            };
            assert!(of(good).is_ok(), "{key}");
            let refused = format!("{:#}", of(bad).unwrap_err());
            assert!(
                refused.contains(&format!("calibration.{key}")) && refused.contains("range"),
                "{refused}"
            );
        }
    }

    #[test]
    fn each_force_limit_has_its_range_and_a_default() {
        for key in ["max_normal_n", "max_lateral_n"] {
            let line = BENCH.lines().find(|line| line.starts_with(key)).unwrap();
            let of = |with: &str| Config::parse(&BENCH.replace(line, with), "bench.toml");
            let said = |with: &str| format!("{:#}", of(with).unwrap_err());
            assert_eq!(of("").unwrap().safety.max_forces_n(), [3.0, 3.0]);
            for value in ["0.1", "1.5", "20.0"] {
                of(&format!("{key} = {value}")).unwrap();
            }
            for value in ["0.0", "-3.0", "20.1", "nan"] {
                let said = said(&format!("{key} = {value}"));
                assert!(
                    said.contains(&format!("safety.{key}")) && said.contains("0.1 to 20 N"),
                    "{said}"
                );
            }
            let typo = said(&format!("{} = 3.0", key.replace("max", "mx")));
            assert!(typo.contains(&format!("`{key}`")), "{typo}");
        }
    }

    #[test]
    fn a_force_matrix_that_could_hide_a_press_is_refused() {
        let config = with_force("matrix = [[1.1, 0.02], [-0.03, 0.9]]\ntare_n = [0.1, 0.2]");
        let force = config.unwrap().force.unwrap();
        assert_eq!(force.correction().tare_n, [0.1, 0.2]);
        assert_eq!(
            with_force("").unwrap().force.unwrap().correction(),
            Correction::default()
        );
        for (keys, word) in [
            ("matrix = [[0.1, 0.0], [0.0, 1.0]]", "force.matrix"),
            ("tare_n = [5.0, 0.0]", "safety.max_normal_n = 3"),
            ("tare_n = [0.0, -5.0]", "safety.max_lateral_n = 3"),
        ] {
            let refused = format!("{:#}", with_force(keys).unwrap_err());
            assert!(refused.contains(word), "{refused}");
        }
    }

    /// The simulated bench's description with `lines` at its end or in the place of others.
    fn described(change: impl FnOnce(String) -> String) -> anyhow::Result<Config> {
        Config::parse(
            &change(include_str!("../mock-bench.toml").to_owned()),
            "bench.toml",
        )
    }

    #[test]
    fn each_limit_of_the_channels_has_its_range() {
        for (key, accepted, rejected) in [
            ("input_noise_units_per_sqrt_hz", "2e-7", "0.01"),
            ("crosstalk_db", "-80.0", "3.0"),
            ("input_nonlinearity", "0.001", "0.5"),
            ("delay_samples", "2.0", "0.0"),
            ("input_error", "1e-4", "0.2"),
        ] {
            let with =
                |value: &str| described(|text| format!("{text}\n[calibration]\n{key} = {value}\n"));
            assert!(with(accepted).is_ok(), "{key} = {accepted}");
            let error = format!("{:#}", with(rejected).unwrap_err());
            assert!(error.contains(&format!("calibration.{key}")), "{error}");
            assert!(error.contains("outside the allowed range"), "{error}");
        }
    }

    #[test]
    fn a_clip_level_is_a_part_of_full_scale() {
        for channel in ["drive", "pickup"] {
            let with = |value: &str| {
                described(|text| {
                    text.replacen(
                        &format!("[channels.{channel}]"),
                        &format!("[channels.{channel}]\nclip_units = {value}"),
                        1,
                    )
                    .replacen("   # voltage", "\n# voltage", 1)
                })
            };
            assert!(with("0.5").is_ok(), "{channel}");
            let error = format!("{:#}", with("1.5").unwrap_err());
            assert!(
                error.contains(&format!("channels.{channel}.clip_units")),
                "{error}"
            );
        }
    }
}
