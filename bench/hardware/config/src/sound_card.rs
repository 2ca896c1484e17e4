//! The sound card and its connections.

use serde::{Deserialize, Serialize};

use super::refusal::{Refused, require_range};

/// Sound layer on which streams are opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum AudioHost {
    /// The platform's own layer: ALSA, CoreAudio or WASAPI.
    Native,
    /// A JACK server.
    Jack,
    /// A National Instruments data acquisition card, through its NI-DAQmx library.
    Nidaqmx,
}

/// Sample format between program and sound layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum SampleFormat {
    F32,
    I32,
    I24,
    I16,
}

/// `[audio]`: the sound card's devices, rate, format and buffers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Audio {
    /// Sound layer.
    pub host: AudioHost,
    /// Output device, by id or name.
    pub output_device: String,
    /// Input device, by id or name; on the same card as the output, because both must share one sample clock.
    pub input_device: String,
    /// Sample rate, Hz.
    pub rate_hz: u32,
    /// Sample format.
    pub sample_format: SampleFormat,
    /// Number of channels of the output stream.
    pub output_channels: u16,
    /// Number of channels of the input stream; all of them are recorded.
    pub input_channels: u16,
    /// Frames per callback; chosen by the device if absent.
    pub buffer_frames: Option<u32>,
    /// Length of the ring buffer for audio while a disk stalls, s.
    #[serde(default = "Audio::default_ring_s")]
    pub ring_s: f64,
    /// Whether the program's memory is locked against being paged out; a bench that lacks the permission is refused.
    #[serde(default)]
    pub lock_memory: bool,
}

impl Audio {
    pub(super) fn check(&self) -> Result<(), Refused> {
        let rate_hz = f64::from(self.rate_hz);
        require_range("audio.rate_hz", rate_hz, 44_100.0, 768_000.0, "Hz")?;
        require_range("audio.ring_s", self.ring_s, 1.0, 60.0, "s")
    }

    fn default_ring_s() -> f64 {
        10.0
    }
}

/// `[output]`: the channel that drives the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OutputChannel {
    /// Output channel that feeds the amplifier.
    pub channel: u16,
    /// Actuator volts per full scale of the output, amplifier included.
    pub volts_per_unit: f64,
}

impl OutputChannel {
    pub(super) fn check(&self, audio: &Audio) -> Result<(), Refused> {
        numbered("output.channel", self.channel, audio.output_channels)?;
        let volts_per_unit = self.volts_per_unit;
        require_range("output.volts_per_unit", volts_per_unit, 1e-3, 1e4, "V")
    }
}

/// `[channels]`: inputs that read the drive and the pickup, and their units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct InputMap {
    /// Read-back of the voltage across the actuators.
    pub drive: DriveInput,
    /// Reading of the piezo pickup.
    pub pickup: PickupInput,
}

impl InputMap {
    pub(super) fn check(&self, audio: &Audio) -> Result<(), Refused> {
        let Self { drive, pickup } = self;
        numbered("channels.drive.index", drive.index, audio.input_channels)?;
        numbered("channels.pickup.index", pickup.index, audio.input_channels)?;
        if drive.index == pickup.index {
            return Err(Refused::new(
                "channels.pickup.index",
                format!(
                    "channels.drive.index and channels.pickup.index are both {}",
                    drive.index
                ),
            ));
        }
        let (volts, metres) = (drive.volts_per_unit, pickup.metres_per_unit);
        require_range("channels.drive.volts_per_unit", volts, 1e-3, 1e4, "V")?;
        require_range("channels.pickup.metres_per_unit", metres, 1e-9, 1e-3, "m")?;
        for (key, clip_units) in [
            ("channels.drive.clip_units", drive.clip_units),
            ("channels.pickup.clip_units", pickup.clip_units),
        ] {
            require_range(key, clip_units, 1e-3, 1.0, "of full scale")?;
        }
        let phase_rad = pickup.phase_rad;
        require_range("channels.pickup.phase_rad", phase_rad, -7.0, 7.0, "rad")
    }
}

/// Requires that `index` numbers one of `count` channels.
fn numbered(key: &str, index: u16, count: u16) -> Result<(), Refused> {
    if index < count {
        return Ok(());
    }
    let why = format!("{key} = {index} but the stream has {count} channels, numbered from 0");
    Err(Refused::new(key, why))
}

/// `[channels.drive]`: the input that reads back the voltage across the actuators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DriveInput {
    /// Input channel, from 0.
    pub index: u16,
    /// Actuator volts per sample value.
    pub volts_per_unit: f64,
    /// |sample| at and above which the input counts as clipped, as a share of full scale.
    #[serde(default = "default_clip_units")]
    pub clip_units: f64,
}

/// Returns a level just under full scale, where every converter clips at the latest.
fn default_clip_units() -> f64 {
    0.999
}

/// `[channels.pickup]`: the input that reads the plate's displacement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PickupInput {
    /// Input channel, from 0.
    pub index: u16,
    /// Plate displacement per sample value at the carrier, m.
    pub metres_per_unit: f64,
    /// Phase to add to the pickup's samples, rad.
    pub phase_rad: f64,
    /// |sample| at and above which the input counts as clipped, as a share of full scale.
    #[serde(default = "default_clip_units")]
    pub clip_units: f64,
}
