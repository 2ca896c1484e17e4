//! The sound card's two directions. The only file of the crate that names `cpal`.

use std::time::Duration;

use cpal::{
    BufferSize, DeviceDirection, ErrorKind, HostId, InputCallbackInfo, OutputCallbackInfo,
    SizedSample, Stream, StreamConfig, StreamInstant, SupportedStreamConfigRange,
    traits::{DeviceTrait, HostTrait, StreamTrait},
};
use thiserror::Error;

pub use cpal::{Device, Host};

use crate::{
    capture::{self, BlockTime, InputCallback, InputReader},
    device::{self, Capability, ChoiceError, DeviceInfo},
    drive::{self, DriveHandle, OutputCallback},
    generator::Generator,
    health::{Direction, Health, StreamFault},
    quiet,
    sample::{ConverterSample, SampleFormat},
};

/// Default length of the input ring, s.
pub const DEFAULT_RING_S: f64 = 10.0;
/// Longest input ring, s.
const LONGEST_RING_S: f64 = 120.0;
/// As small as the buffers of a backend left to itself are.
const SMALL_BUFFER_FRAMES: u32 = 64;
/// How long JACK may take to open a stream, and how often ALSA looks whether a silent one is lost.
const BACKEND_TIMEOUT: Duration = Duration::from_secs(2);

/// Which host to open.
pub enum HostChoice {
    /// The platform's own: ALSA on Linux.
    Default,
    /// ALSA.
    Alsa,
    /// A running JACK server (the one named by `JACK_DEFAULT_SERVER`).
    Jack,
    /// A host made elsewhere, such as the simulated apparatus.
    Supplied(Host),
}

/// A device, host or stream that cannot be had.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum AudioError {
    /// The host is not there.
    #[error("audio host {host} is not available: {reason}")]
    HostUnavailable {
        /// Name of the host.
        host: String,
        /// What the backend said, and what to do.
        reason: String,
    },
    /// The device name means none or several.
    #[error(transparent)]
    Device(#[from] ChoiceError),
    /// The device does not offer the rate, format and channels asked for.
    #[error(
        "{direction} device {device} does not offer {wanted}; it offers: {}",
        device::summarise(.offered)
    )]
    Unsupported {
        /// Direction of the stream.
        direction: Direction,
        /// The device.
        device: String,
        /// What was asked for.
        wanted: String,
        /// What the device has.
        offered: Vec<Capability>,
    },
    /// Another program holds the device.
    #[error("{direction} device {device} is busy: close the program that uses it ({reason})")]
    Busy {
        /// Direction of the stream.
        direction: Direction,
        /// The device.
        device: String,
        /// What the backend said.
        reason: String,
    },
    /// The backend refused for another reason.
    #[error("{direction} device {device}: {reason}")]
    Backend {
        /// Direction of the stream.
        direction: Direction,
        /// The device.
        device: String,
        /// What the backend said.
        reason: String,
    },
    /// A configuration that contradicts itself.
    #[error("{parameter} = {value} must be {allowed}")]
    Config {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
}

/// One direction of a [`DuplexConfig`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamChoice {
    /// Device id, name, or a part of either that is unique.
    pub device: String,
    /// Channels to open.
    pub channels: u16,
    /// Sample format.
    pub format: SampleFormat,
}

/// What to open.
#[derive(Clone, Debug, PartialEq)]
pub struct DuplexConfig {
    /// Sample rate of both directions, Hz; the generator's.
    pub sample_rate_hz: u32,
    /// The output.
    pub output: StreamChoice,
    /// Output channel of the drive, from 0; the others are silent.
    pub drive_channel: u16,
    /// The input.
    pub input: StreamChoice,
    /// Frames per callback; `None` leaves it to the backend.
    pub buffer_frames: Option<u32>,
    /// Length of the input ring, s; [`DEFAULT_RING_S`].
    pub ring_s: f64,
}

/// The two streams. Dropping them closes both.
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
    /// Starts and, dropped, closes the streams.
    pub streams: Streams,
    /// Commands the drive.
    pub drive: DriveHandle,
    /// Reads the input.
    pub input: InputReader,
    /// Counters of both directions.
    pub health: Health,
}

/// Opens a host. Never panics for want of sound on the machine.
///
/// # Errors
/// If the host is not there: no ALSA configuration, no JACK server.
pub fn open_host(choice: HostChoice) -> Result<Host, AudioError> {
    quiet::silence_alsa();
    match choice {
        HostChoice::Supplied(host) => Ok(host),
        HostChoice::Alsa => host_named("alsa"),
        HostChoice::Jack => {
            quiet::silence_jack();
            let host = host_named("jack")?;
            let has_devices = host
                .devices()
                .is_ok_and(|mut devices| devices.next().is_some());
            if has_devices {
                Ok(host)
            } else {
                Err(AudioError::HostUnavailable {
                    host: "jack".to_owned(),
                    reason:
                        "no JACK server answers; start jackd, or name it in JACK_DEFAULT_SERVER"
                            .to_owned(),
                })
            }
        }
        HostChoice::Default => {
            if cfg!(target_os = "linux") {
                return host_named("alsa");
            }
            // Not `default_host()`, which panics where there is none.
            cpal::available_hosts()
                .into_iter()
                .find(|id| !["jack", "custom"].contains(&id.to_string().as_str()))
                .ok_or_else(|| AudioError::HostUnavailable {
                    host: "default".to_owned(),
                    reason: "this system has none".to_owned(),
                })
                .and_then(host_by_id)
        }
    }
}

fn host_named(name: &str) -> Result<Host, AudioError> {
    let id: HostId = name
        .parse()
        .map_err(|error: cpal::Error| AudioError::HostUnavailable {
            host: name.to_owned(),
            reason: error.to_string(),
        })?;
    host_by_id(id)
}

fn host_by_id(id: HostId) -> Result<Host, AudioError> {
    cpal::host_from_id(id).map_err(|error| AudioError::HostUnavailable {
        host: id.to_string(),
        reason: error.to_string(),
    })
}

/// Every device of the host with what it can do.
///
/// # Errors
/// If the host is no longer there.
pub fn list_devices(host: &Host) -> Result<Vec<DeviceInfo>, AudioError> {
    Ok(enumerate(host)?.into_iter().map(|(info, _)| info).collect())
}

fn enumerate(host: &Host) -> Result<Vec<(DeviceInfo, Device)>, AudioError> {
    // Again here, for the handler is the thread's.
    quiet::silence_alsa();
    let devices = host
        .devices()
        .map_err(|error| AudioError::HostUnavailable {
            host: host.id().to_string(),
            reason: error.to_string(),
        })?;
    Ok(devices
        .filter_map(|device| {
            let id = device.id().ok()?;
            let description = device.description().ok()?;
            // A JACK device lists the configurations of both directions, whichever is its own.
            let unknown = description.direction() == DeviceDirection::Unknown;
            let has_output = description.supports_output() || (unknown && device.supports_output());
            let has_input = description.supports_input() || (unknown && device.supports_input());
            let is_alsa = id.host().to_string() == "alsa";
            let info = DeviceInfo {
                id: id.to_string(),
                name: description.name().to_owned(),
                is_raw: !is_alsa || id.id().starts_with("hw:"),
                output: has_output.then(|| capabilities(device.supported_output_configs())),
                input: has_input.then(|| capabilities(device.supported_input_configs())),
            };
            Some((info, device))
        })
        .collect())
}

fn capabilities(
    ranges: Result<impl Iterator<Item = SupportedStreamConfigRange>, cpal::Error>,
) -> Vec<Capability> {
    ranges
        .into_iter()
        .flatten()
        .map(|range| Capability {
            channels: range.channels(),
            min_rate_hz: range.min_sample_rate(),
            max_rate_hz: range.max_sample_rate(),
            format: range.sample_format().to_string(),
        })
        .collect()
}

/// The output device that `wanted` means, for sound that is not the drive's.
///
/// # Errors
/// If there is no such device or `wanted` means several; the error lists what exists.
pub fn output_device(host: &Host, wanted: &str) -> Result<Device, AudioError> {
    let (infos, mut devices): (Vec<_>, Vec<_>) = enumerate(host)?.into_iter().unzip();
    let index = device::choose(&infos, wanted, Direction::Output)?;
    Ok(devices.swap_remove(index))
}

/// Opens both directions, paused, on the devices that the configuration means.
///
/// # Errors
/// If the configuration contradicts itself or the generator, or a device is missing, busy or does
/// not offer what is asked for.
pub fn open_duplex(
    host: &Host,
    config: &DuplexConfig,
    generator: Generator,
) -> Result<Duplex, AudioError> {
    check_config(config, &generator)?;
    let devices = enumerate(host)?;
    let (output_device, output_info) = find(&devices, config, Direction::Output)?;
    let (input_device, input_info) = find(&devices, config, Direction::Input)?;

    let health = Health::new();
    let (output_callback, drive) = drive::connect(
        generator,
        usize::from(config.output.channels),
        usize::from(config.drive_channel),
        health.clone(),
    );
    // A backend may halve the buffer that it is asked for, hardly do more.
    let fewest_frames = config
        .buffer_frames
        .map_or(SMALL_BUFFER_FRAMES, |frames| (frames / 2).max(1));
    let ring_frames = (config.ring_s * f64::from(config.sample_rate_hz)).ceil() as usize;
    let (input_callback, input) = capture::connect(
        usize::from(config.input.channels),
        ring_frames,
        fewest_frames as usize,
        health.clone(),
        drive.monitor(),
    );

    let output = match config.output.format {
        SampleFormat::F32 => build_output::<f32>(output_device, config, output_callback, &health),
        SampleFormat::I32 => build_output::<i32>(output_device, config, output_callback, &health),
        SampleFormat::I16 => build_output::<i16>(output_device, config, output_callback, &health),
    }
    .map_err(|error| stream_error(&error, Direction::Output, output_info, config))?;
    let input_stream = match config.input.format {
        SampleFormat::F32 => build_input::<f32>(input_device, config, input_callback, &health),
        SampleFormat::I32 => build_input::<i32>(input_device, config, input_callback, &health),
        SampleFormat::I16 => build_input::<i16>(input_device, config, input_callback, &health),
    }
    .map_err(|error| stream_error(&error, Direction::Input, input_info, config))?;

    Ok(Duplex {
        streams: Streams {
            output,
            input: input_stream,
            output_device: output_info.clone(),
            input_device: input_info.clone(),
        },
        drive,
        input,
        health,
    })
}

impl Streams {
    /// Starts both streams, the output first: the first input frame follows a running output.
    ///
    /// # Errors
    /// If the backend refuses.
    pub fn play(&self) -> Result<(), AudioError> {
        self.each(Stream::play)
    }

    /// Pauses both streams where the backend can. The drive does not ramp: stop it first.
    ///
    /// # Errors
    /// If the backend refuses.
    pub fn pause(&self) -> Result<(), AudioError> {
        self.each(Stream::pause)
    }

    fn each(&self, act: fn(&Stream) -> Result<(), cpal::Error>) -> Result<(), AudioError> {
        let failed = |direction, device: &DeviceInfo| {
            let device = device.to_string();
            move |error: cpal::Error| AudioError::Backend {
                direction,
                device,
                reason: error.to_string(),
            }
        };
        act(&self.output).map_err(failed(Direction::Output, &self.output_device))?;
        act(&self.input).map_err(failed(Direction::Input, &self.input_device))
    }

    /// The device in use.
    #[must_use]
    pub fn device(&self, direction: Direction) -> &DeviceInfo {
        match direction {
            Direction::Output => &self.output_device,
            Direction::Input => &self.input_device,
        }
    }

    /// Frames per callback, if the backend tells.
    #[must_use]
    pub fn buffer_frames(&self, direction: Direction) -> Option<u32> {
        match direction {
            Direction::Output => self.output.buffer_size().ok(),
            Direction::Input => self.input.buffer_size().ok(),
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
    for (parameter, channels) in [
        ("output.channels", config.output.channels),
        ("input.channels", config.input.channels),
    ] {
        if channels == 0 {
            return Err(AudioError::Config {
                parameter,
                value: 0.0,
                allowed: "1 or more".to_owned(),
            });
        }
    }
    if config.drive_channel >= config.output.channels {
        return Err(AudioError::Config {
            parameter: "drive_channel",
            value: f64::from(config.drive_channel),
            allowed: format!(
                "below the number of output channels, {}",
                config.output.channels
            ),
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

fn stream_choice(config: &DuplexConfig, direction: Direction) -> &StreamChoice {
    match direction {
        Direction::Output => &config.output,
        Direction::Input => &config.input,
    }
}

/// The device that the configuration means, if it offers what is asked for.
fn find<'a>(
    devices: &'a [(DeviceInfo, Device)],
    config: &DuplexConfig,
    direction: Direction,
) -> Result<(&'a Device, &'a DeviceInfo), AudioError> {
    let infos: Vec<DeviceInfo> = devices.iter().map(|(info, _)| info.clone()).collect();
    let choice = stream_choice(config, direction);
    let index = device::choose(&infos, &choice.device, direction)?;
    let (info, device) = &devices[index];
    let offered = info.capabilities(direction).unwrap_or_default();
    let offers = offered.iter().any(|capability| {
        capability.channels == choice.channels
            && capability.format == choice.format.to_string()
            && (capability.min_rate_hz..=capability.max_rate_hz).contains(&config.sample_rate_hz)
    });
    // A device that does not say what it offers is asked by opening it.
    if offers || offered.is_empty() {
        Ok((device, info))
    } else {
        Err(unsupported(direction, info, config))
    }
}

fn unsupported(direction: Direction, device: &DeviceInfo, config: &DuplexConfig) -> AudioError {
    let choice = stream_choice(config, direction);
    let buffer = config
        .buffer_frames
        .map(|frames| format!(", {frames} frames per buffer"))
        .unwrap_or_default();
    AudioError::Unsupported {
        direction,
        device: device.to_string(),
        wanted: format!(
            "{} channels of {} at {} Hz{buffer}",
            choice.channels, choice.format, config.sample_rate_hz
        ),
        offered: device.capabilities(direction).unwrap_or_default().to_vec(),
    }
}

fn stream_error(
    error: &cpal::Error,
    direction: Direction,
    device: &DeviceInfo,
    config: &DuplexConfig,
) -> AudioError {
    match error.kind() {
        ErrorKind::UnsupportedConfig => unsupported(direction, device, config),
        ErrorKind::DeviceBusy => AudioError::Busy {
            direction,
            device: device.to_string(),
            reason: error.to_string(),
        },
        _ => AudioError::Backend {
            direction,
            device: device.to_string(),
            reason: error.to_string(),
        },
    }
}

fn stream_config(config: &DuplexConfig, direction: Direction) -> StreamConfig {
    StreamConfig {
        channels: stream_choice(config, direction).channels,
        sample_rate: config.sample_rate_hz,
        buffer_size: config
            .buffer_frames
            .map_or(BufferSize::Default, BufferSize::Fixed),
    }
}

fn build_output<T: ConverterSample + SizedSample>(
    device: &Device,
    config: &DuplexConfig,
    mut callback: OutputCallback,
    health: &Health,
) -> Result<Stream, cpal::Error> {
    let health = health.clone();
    device.build_output_stream(
        stream_config(config, Direction::Output),
        move |out: &mut [T], _: &OutputCallbackInfo| callback.render(out),
        move |error: cpal::Error| health.report(Direction::Output, fault(error.kind())),
        Some(BACKEND_TIMEOUT),
    )
}

fn build_input<T: ConverterSample + SizedSample>(
    device: &Device,
    config: &DuplexConfig,
    mut callback: InputCallback,
    health: &Health,
) -> Result<Stream, cpal::Error> {
    let health = health.clone();
    device.build_input_stream(
        stream_config(config, Direction::Input),
        move |block: &[T], info: &InputCallbackInfo| {
            let timestamp = info.timestamp();
            let time = BlockTime {
                callback_ns: nanos(timestamp.callback),
                capture_ns: nanos(timestamp.capture),
            };
            callback.take(block, time);
        },
        move |error: cpal::Error| health.report(Direction::Input, fault(error.kind())),
        Some(BACKEND_TIMEOUT),
    )
}

/// Wraps after 584 years.
fn nanos(instant: StreamInstant) -> u64 {
    instant.as_nanos() as u64
}

fn fault(kind: ErrorKind) -> StreamFault {
    match kind {
        ErrorKind::Xrun => StreamFault::Xrun,
        ErrorKind::DeviceNotAvailable | ErrorKind::HostUnavailable => StreamFault::DeviceLost,
        ErrorKind::StreamInvalidated => StreamFault::Invalidated,
        ErrorKind::DeviceChanged => StreamFault::Rerouted,
        ErrorKind::RealtimeDenied => StreamFault::RealtimeDenied,
        _ => StreamFault::Backend,
    }
}
