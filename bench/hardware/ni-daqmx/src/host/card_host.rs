//! The cpal traits of a card.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use config::Nidaqmx;
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    BufferSize, Data, DeviceDescription, DeviceDescriptionBuilder, DeviceDirection, DeviceId,
    Error, ErrorKind, FrameCount, HostId, InputCallbackInfo, OutputCallbackInfo, SampleFormat,
    StreamConfig, StreamInstant, SupportedBufferSize, SupportedStreamConfig,
    SupportedStreamConfigRange,
};

use super::duplex::{
    Callbacks, ErrorCallback, InputCallback, NotStarted, OutputCallback, Running, start,
};
use super::plan::{Plan, advice, obstacle};
use crate::library::{Card, Daqmx};

/// Lowest rate that is offered, Hz.
const LOWEST_HZ: u32 = 1000;
/// Lengths of a block, frames.
const BLOCKS: std::ops::RangeInclusive<u32> = 16..=65_536;

/// Returns the cards of NI-DAQmx as a host, with the channels that `table` names, read in blocks of `block_frames`
/// unless a stream requests another length; without a table they can only be listed.
pub(crate) fn host(library: &Daqmx, table: Option<Nidaqmx>, block_frames: u32) -> cpal::Host {
    let host = Host {
        library: library.clone(),
        table,
        block_frames,
    };
    cpal::Host::from(cpal::platform::CustomHost::from_host(host))
}

#[derive(Clone)]
struct Host {
    library: Daqmx,
    table: Option<Nidaqmx>,
    block_frames: u32,
}

impl HostTrait for Host {
    type Devices = std::vec::IntoIter<Device>;
    type Device = Device;

    fn is_available() -> bool {
        true
    }

    fn devices(&self) -> Result<Self::Devices, Error> {
        let cards = self
            .library
            .cards()
            .map_err(|error| Error::with_message(ErrorKind::HostUnavailable, error.to_string()))?;
        let device = |card| Device {
            library: self.library.clone(),
            table: self.table.clone(),
            block_frames: self.block_frames,
            card,
            halves: Arc::default(),
        };
        Ok(cards
            .into_iter()
            .map(device)
            .collect::<Vec<_>>()
            .into_iter())
    }

    /// Returns `None`: only the named card may drive a plate.
    fn default_input_device(&self) -> Option<Device> {
        None
    }

    fn default_output_device(&self) -> Option<Device> {
        None
    }
}

/// Both directions of a card, one of which may be missing.
#[derive(Default)]
struct Halves {
    output: Option<(OutputCallback, ErrorCallback)>,
    input: Option<(InputCallback, ErrorCallback)>,
    plan: Option<Plan>,
    running: Option<Running>,
}

type Shared = Arc<Mutex<Halves>>;

fn lock(halves: &Shared) -> MutexGuard<'_, Halves> {
    halves.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A card.
#[derive(Clone)]
struct Device {
    library: Daqmx,
    table: Option<Nidaqmx>,
    block_frames: u32,
    card: Card,
    halves: Shared,
}

impl PartialEq for Device {
    fn eq(&self, other: &Self) -> bool {
        self.card.name == other.card.name
    }
}

impl Eq for Device {}

impl Hash for Device {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.card.name.hash(state);
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Device").field(&self.card.name).finish()
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, serial {:X}", self.card.product, self.card.serial)
    }
}

impl Device {
    /// Returns the configurations of a direction: with all named channels, at rates up to those of one channel.
    /// The limits of several channels are checked, with the arithmetic, when a stream is opened.
    fn configs(&self, channels: usize, most_hz: f64) -> Vec<SupportedStreamConfigRange> {
        if most_hz < f64::from(LOWEST_HZ) {
            return Vec::new();
        }
        let blocks = SupportedBufferSize::Range {
            min: *BLOCKS.start(),
            max: *BLOCKS.end(),
        };
        vec![SupportedStreamConfigRange::new(
            channels as u16,
            LOWEST_HZ,
            most_hz as u32,
            blocks,
            SampleFormat::F32,
        )]
    }

    fn most_hz(&self) -> f64 {
        let Card {
            single_hz,
            multi_hz,
            ..
        } = self.card;
        single_hz.max(multi_hz)
    }

    fn default_config(
        &self,
        configs: &[SupportedStreamConfigRange],
    ) -> Result<SupportedStreamConfig, Error> {
        let config = configs.first().ok_or_else(|| {
            Error::with_message(
                ErrorKind::UnsupportedOperation,
                format!("{self}: not this direction"),
            )
        })?;
        Ok(config.with_max_sample_rate())
    }

    /// Returns the plan of the streams.
    ///
    /// # Errors
    /// `InvalidInput`, with the line of `bench.toml` to change.
    fn plan(&self, config: &StreamConfig, format: SampleFormat) -> Result<Plan, Error> {
        let invalid = |why: String| Error::with_message(ErrorKind::InvalidInput, why);
        let table = self.table.clone().ok_or_else(|| {
            invalid("no table [nidaqmx] in bench.toml says which channels to use".to_owned())
        })?;
        if format != SampleFormat::F32 {
            return Err(invalid(
                "set audio.sample_format = \"f32\" in bench.toml".to_owned(),
            ));
        }
        let block_frames = match config.buffer_size {
            BufferSize::Fixed(frames) => frames,
            BufferSize::Default => self.block_frames,
        };
        if !BLOCKS.contains(&block_frames) {
            return Err(invalid(format!(
                "audio.buffer_frames = {block_frames} must be within {BLOCKS:?} in bench.toml"
            )));
        }
        let plan = Plan {
            device: self.card.name.clone(),
            table,
            rate_hz: config.sample_rate,
            block_frames,
        };
        match obstacle(&self.card, &plan) {
            Some(why) => Err(invalid(why)),
            None => Ok(plan),
        }
    }

    fn stream(&self, side: Side, frames: FrameCount) -> Stream {
        Stream {
            library: self.library.clone(),
            halves: Arc::clone(&self.halves),
            side,
            frames,
        }
    }
}

impl DeviceTrait for Device {
    type SupportedInputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type SupportedOutputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type Stream = Stream;

    fn description(&self) -> Result<DeviceDescription, Error> {
        let direction = match (self.card.output_hz > 0.0, self.card.single_hz > 0.0) {
            (true, true) => DeviceDirection::Duplex,
            (true, false) => DeviceDirection::Output,
            _ => DeviceDirection::Input,
        };
        Ok(DeviceDescriptionBuilder::new(self.to_string())
            .direction(direction)
            .build())
    }

    fn id(&self) -> Result<DeviceId, Error> {
        Ok(DeviceId::new(HostId::Custom, &self.card.name))
    }

    fn supported_input_configs(&self) -> Result<Self::SupportedInputConfigs, Error> {
        let channels = self.table.as_ref().map_or(1, |table| table.inputs.len());
        Ok(self.configs(channels, self.most_hz()).into_iter())
    }

    fn supported_output_configs(&self) -> Result<Self::SupportedOutputConfigs, Error> {
        let channels = self.table.as_ref().map_or(1, |table| table.outputs.len());
        // A rate that only the outputs cannot keep is refused with the reason.
        let most_hz = if self.card.output_hz > 0.0 {
            self.card.output_hz.max(self.most_hz())
        } else {
            0.0
        };
        Ok(self.configs(channels, most_hz).into_iter())
    }

    fn default_input_config(&self) -> Result<SupportedStreamConfig, Error> {
        self.default_config(&self.configs(1, self.most_hz()))
    }

    fn default_output_config(&self) -> Result<SupportedStreamConfig, Error> {
        self.default_config(&self.configs(1, self.card.output_hz))
    }

    fn build_input_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        sample_format: SampleFormat,
        data_callback: D,
        error_callback: E,
        _timeout: Option<Duration>,
    ) -> Result<Stream, Error>
    where
        D: FnMut(&Data, &InputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        let plan = self.plan(&config, sample_format)?;
        let frames = plan.block_frames;
        let mut halves = lock(&self.halves);
        halves.input = Some((Box::new(data_callback), Box::new(error_callback)));
        halves.plan = Some(plan);
        Ok(self.stream(Side::Input, frames))
    }

    fn build_output_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        sample_format: SampleFormat,
        data_callback: D,
        error_callback: E,
        _timeout: Option<Duration>,
    ) -> Result<Stream, Error>
    where
        D: FnMut(&mut Data, &OutputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        let plan = self.plan(&config, sample_format)?;
        let frames = plan.block_frames;
        let mut halves = lock(&self.halves);
        halves.output = Some((Box::new(data_callback), Box::new(error_callback)));
        halves.plan = Some(plan);
        Ok(self.stream(Side::Output, frames))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Output,
    Input,
}

/// One direction of a card. The card runs once both are started, and stops when the first is dropped.
struct Stream {
    library: Daqmx,
    halves: Shared,
    side: Side,
    frames: FrameCount,
}

cpal::assert_stream_send!(Stream);
cpal::assert_stream_sync!(Stream);

impl StreamTrait for Stream {
    /// Starts the card with the input, which the bench starts after the output.
    fn play(&self) -> Result<(), Error> {
        if self.side == Side::Output {
            return Ok(());
        }
        let mut halves = lock(&self.halves);
        let halves = &mut *halves;
        let (Some(plan), Some(output), Some(input)) =
            (&halves.plan, halves.output.take(), halves.input.take())
        else {
            return Err(Error::with_message(
                ErrorKind::UnsupportedOperation,
                "an NI card is started once, both directions together",
            ));
        };
        let callbacks = Callbacks {
            output: output.0,
            output_error: output.1,
            input: input.0,
            input_error: input.1,
        };
        let running = start(&self.library, plan, callbacks).map_err(|error| {
            let why = match &error {
                NotStarted::Library(error) => advice(error, plan),
                other => other.to_string(),
            };
            Error::with_message(ErrorKind::InvalidInput, why)
        })?;
        halves.running = Some(running);
        Ok(())
    }

    fn pause(&self) -> Result<(), Error> {
        Err(Error::with_message(
            ErrorKind::UnsupportedOperation,
            "an NI card streams until it is closed",
        ))
    }

    fn buffer_size(&self) -> Result<FrameCount, Error> {
        Ok(self.frames)
    }

    /// Returns the start of the card's clock; only the callbacks state its time.
    fn now(&self) -> StreamInstant {
        StreamInstant::from_nanos(0)
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // Joined outside the lock: a callback may hold another stream.
        let running = lock(&self.halves).running.take();
        drop(running);
        let mut halves = lock(&self.halves);
        match self.side {
            Side::Output => halves.output = None,
            Side::Input => halves.input = None,
        }
    }
}
