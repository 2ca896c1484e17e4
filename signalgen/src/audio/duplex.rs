//! Both streams of the sound card, opened on the devices of a configuration.

use cpal::{BufferSize, Device, ErrorKind, Host, Stream, StreamConfig, traits::StreamTrait};

use super::{
    audio_error::AudioError,
    callbacks::{ThreadStart, open_input, open_output},
    card_holder,
    choice::choose,
    device_list::enumerate,
    sound_device::{DeviceInfo, Offer},
};
use crate::{
    capture::{InputReader, InputWriter},
    drive_handle::DriveHandle,
    generator::Generator,
    input_tap::InputTap,
    renderer::DriveRenderer,
    sample::StreamFormat,
    stream_health::{StreamDirection, StreamHealth},
};

/// Default length of the input ring, s.
pub const DEFAULT_RING_S: f64 = 10.0;
/// Length of the ring of a tap, s.
const TAP_RING_S: f64 = 2.0;
/// Longest input ring, s.
const LONGEST_RING_S: f64 = 120.0;
/// Fewest frames per callback for a backend that chooses the number.
const SMALL_BUFFER_FRAMES: u32 = 64;

/// One direction of a [`DuplexConfig`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamChoice {
    /// Device id, name, or a unique part of either.
    pub device: String,
    /// Number of channels to open.
    pub channels: u16,
    /// Sample format.
    pub format: StreamFormat,
}

/// The two streams to open.
#[derive(Clone, Debug, PartialEq)]
pub struct DuplexConfig {
    /// Sampling rate of both directions, Hz; must be the generator's.
    pub sample_rate_hz: u32,
    /// Output stream.
    pub output: StreamChoice,
    /// Output channel of the drive, counted from 0; the other channels are silent.
    pub drive_channel: u16,
    /// Input stream.
    pub input: StreamChoice,
    /// Frames per callback; `None` leaves it to the backend.
    pub buffer_frames: Option<u32>,
    /// Length of the input ring, s; [`DEFAULT_RING_S`] by default.
    pub ring_s: f64,
    /// Input channels that a tap reads too; empty for no tap.
    pub tap: Vec<u16>,
}

/// Both streams. Dropping them closes both.
pub struct Streams {
    // Dropped in this order: the drive goes silent before the input stops watching it.
    output: Stream,
    input: Stream,
    output_device: DeviceInfo,
    input_device: DeviceInfo,
}

/// Both directions of the sound card, opened and paused.
#[derive(Debug)]
pub struct Duplex {
    /// Starts the streams, and closes them when dropped.
    pub streams: Streams,
    /// Commands the drive.
    pub drive: DriveHandle,
    /// Reads the input.
    pub input: InputReader,
    /// Second reader, of the tapped channels.
    pub tap: Option<InputTap>,
    /// Counters of both directions.
    pub health: StreamHealth,
}

/// Opens both directions, paused, on the devices of the configuration. Each stream's own thread runs `start` before its first
/// block if no software stands between the device and the converter: a thread that such software can delay or block must not
/// have a high priority.
///
/// # Errors
/// If the configuration contradicts itself or the generator, or a device is missing, busy, or does not offer the requested
/// channels, format and rate.
pub fn open_duplex(
    host: &Host,
    config: &DuplexConfig,
    generator: Generator,
    start: Option<&ThreadStart>,
) -> Result<Duplex, AudioError> {
    check_config(config, &generator)?;
    let health = StreamHealth::new();
    let (renderer, drive) = DriveRenderer::connect(
        generator,
        usize::from(config.output.channels),
        usize::from(config.drive_channel),
        health.clone(),
    )?;
    // A backend may halve the requested buffer, but is unlikely to reduce it further.
    let fewest_frames = config
        .buffer_frames
        .map_or(SMALL_BUFFER_FRAMES, |frames| (frames / 2).max(1));
    let ring_frames = (config.ring_s * f64::from(config.sample_rate_hz)).ceil() as usize;
    let (mut writer, input) = InputWriter::connect(
        usize::from(config.input.channels),
        ring_frames,
        fewest_frames as usize,
        health.clone(),
        drive.monitor(),
    )?;
    let tap = if config.tap.is_empty() {
        None
    } else {
        let ring_frames = (TAP_RING_S * f64::from(config.sample_rate_hz)).ceil() as usize;
        Some(writer.tap(&config.tap, ring_frames, fewest_frames as usize)?)
    };

    let devices = enumerate(host)?;
    let (output_device, output_info) = find(&devices, config, StreamDirection::Output)?;
    let (input_device, input_info) = find(&devices, config, StreamDirection::Input)?;
    let direction = StreamDirection::Output;
    let output = open_output(
        output_device,
        stream_config(config, direction),
        config.output.format,
        renderer,
        &health,
        start.filter(|_| output_info.is_raw),
    )
    .map_err(|error| stream_error(&error, direction, output_info, config))?;
    let direction = StreamDirection::Input;
    let input_stream = open_input(
        input_device,
        stream_config(config, direction),
        config.input.format,
        writer,
        &health,
        start.filter(|_| input_info.is_raw),
    )
    .map_err(|error| stream_error(&error, direction, input_info, config))?;

    Ok(Duplex {
        streams: Streams {
            output,
            input: input_stream,
            output_device: output_info.clone(),
            input_device: input_info.clone(),
        },
        drive,
        input,
        tap,
        health,
    })
}

impl Streams {
    /// Starts both streams, the output first: the first input frame follows a running output.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn play(&self) -> Result<(), AudioError> {
        self.for_each_stream(Stream::play)
    }

    /// Pauses both streams if the backend can. The drive does not ramp: stop it first.
    ///
    /// # Errors
    /// If the backend fails.
    pub fn pause(&self) -> Result<(), AudioError> {
        self.for_each_stream(Stream::pause)
    }

    fn for_each_stream(
        &self,
        act: fn(&Stream) -> Result<(), cpal::Error>,
    ) -> Result<(), AudioError> {
        let failure = |direction, device: &DeviceInfo| {
            let device = device.to_string();
            move |error: cpal::Error| AudioError::Backend {
                direction,
                device,
                reason: error.to_string(),
            }
        };
        act(&self.output).map_err(failure(StreamDirection::Output, &self.output_device))?;
        act(&self.input).map_err(failure(StreamDirection::Input, &self.input_device))
    }

    /// Returns the device in use.
    #[must_use]
    pub fn device(&self, direction: StreamDirection) -> &DeviceInfo {
        match direction {
            StreamDirection::Output => &self.output_device,
            StreamDirection::Input => &self.input_device,
        }
    }

    /// Returns the frames per callback, if the backend reports them.
    #[must_use]
    pub fn buffer_frames(&self, direction: StreamDirection) -> Option<u32> {
        match direction {
            StreamDirection::Output => self.output.buffer_size().ok(),
            StreamDirection::Input => self.input.buffer_size().ok(),
        }
    }
}

impl std::fmt::Debug for Streams {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Streams")
            .field("output_device", &self.output_device)
            .field("input_device", &self.input_device)
            .finish_non_exhaustive()
    }
}

fn check_config(config: &DuplexConfig, generator: &Generator) -> Result<(), AudioError> {
    let generator_rate_hz = generator.settings().sample_rate_hz();
    if config.sample_rate_hz != generator_rate_hz {
        return Err(AudioError::Config {
            parameter: "sample_rate_hz",
            value: f64::from(config.sample_rate_hz),
            allowed: format!("the generator's {generator_rate_hz} Hz"),
        });
    }
    if !(config.ring_s > 0.0 && config.ring_s <= LONGEST_RING_S) {
        return Err(AudioError::Config {
            parameter: "ring_s",
            value: config.ring_s,
            allowed: format!("above 0 and at most {LONGEST_RING_S} s"),
        });
    }
    Ok(())
}

fn stream_choice(config: &DuplexConfig, direction: StreamDirection) -> &StreamChoice {
    match direction {
        StreamDirection::Output => &config.output,
        StreamDirection::Input => &config.input,
    }
}

/// Returns the device of the configuration, if it offers the requested channels, format and rate.
fn find<'a>(
    devices: &'a [(DeviceInfo, Device)],
    config: &DuplexConfig,
    direction: StreamDirection,
) -> Result<(&'a Device, &'a DeviceInfo), AudioError> {
    let infos: Vec<DeviceInfo> = devices.iter().map(|(info, _)| info.clone()).collect();
    let choice = stream_choice(config, direction);
    let index = choose(&infos, &choice.device, direction)?;
    let (info, device) = &devices[index];
    let offers = match info.offer(direction) {
        // A device that does not report its capabilities is tried by opening it.
        None | Some(Offer::Unreported) => true,
        Some(Offer::Listed(capabilities)) => capabilities.iter().any(|capability| {
            capability.channels == choice.channels
                && capability.format == choice.format.to_string()
                && capability.rates.contains(config.sample_rate_hz)
        }),
    };
    if offers {
        Ok((device, info))
    } else {
        Err(unsupported_error(direction, info, config))
    }
}

fn unsupported_error(
    direction: StreamDirection,
    device: &DeviceInfo,
    config: &DuplexConfig,
) -> AudioError {
    let choice = stream_choice(config, direction);
    let buffer = config
        .buffer_frames
        .map(|frames| format!(", {frames} frames per buffer"))
        .unwrap_or_default();
    let request = format!(
        "{} channels of {} at {} Hz{buffer}",
        choice.channels, choice.format, config.sample_rate_hz
    );
    match device.offer(direction) {
        Some(Offer::Listed(capabilities)) if capabilities.is_empty() => {
            AudioError::NoUsableFormat {
                direction,
                device: device.to_string(),
                request,
            }
        }
        offered => AudioError::Unsupported {
            direction,
            device: device.to_string(),
            request,
            offered: offered.cloned().unwrap_or(Offer::Unreported),
        },
    }
}

fn stream_error(
    error: &cpal::Error,
    direction: StreamDirection,
    device: &DeviceInfo,
    config: &DuplexConfig,
) -> AudioError {
    match error.kind() {
        ErrorKind::UnsupportedConfig => unsupported_error(direction, device, config),
        ErrorKind::DeviceBusy => AudioError::Busy {
            direction,
            device: device.to_string(),
            holder: card_holder::words(&device.id, direction),
            reason: error.to_string(),
        },
        _ => AudioError::Backend {
            direction,
            device: device.to_string(),
            reason: error.to_string(),
        },
    }
}

fn stream_config(config: &DuplexConfig, direction: StreamDirection) -> StreamConfig {
    StreamConfig {
        channels: stream_choice(config, direction).channels,
        sample_rate: config.sample_rate_hz,
        buffer_size: config
            .buffer_frames
            .map_or(BufferSize::Default, BufferSize::Fixed),
    }
}
