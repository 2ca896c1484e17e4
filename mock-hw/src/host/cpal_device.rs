//! cpal traits of the simulated devices.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    BufferSize, Data, DeviceDescription, DeviceDescriptionBuilder, DeviceDirection, DeviceId,
    Error, ErrorKind, FrameCount, HostId, InputCallbackInfo, OutputCallbackInfo, SampleFormat,
    StreamConfig, StreamInstant, SupportedBufferSize, SupportedStreamConfig,
    SupportedStreamConfigRange,
};

use super::sound_cards::{
    BENCH_ID, BENCH_OUTPUTS, BenchCard, SPEAKERS_ID, SPEAKERS_RATE_HZ, SoundCards, lock,
};
use super::stream::{Buffer, ErrorCallback, InputStream, OutputStream};

const SPEAKERS_OUTPUTS: u16 = 2;
const SPEAKERS_FORMATS: [SampleFormat; 3] =
    [SampleFormat::F32, SampleFormat::I32, SampleFormat::I16];
const BUFFER_FRAMES: std::ops::RangeInclusive<u32> = 16..=65_536;

/// Host of the simulated devices; wrapped in a [`cpal::Host`] by the apparatus.
#[derive(Clone)]
pub struct Host(Arc<SoundCards>);

/// Wraps the sound cards in a cpal host.
pub(crate) fn cpal_host(cards: &Arc<SoundCards>) -> cpal::Host {
    let host = Host(Arc::clone(cards));
    cpal::Host::from(cpal::platform::CustomHost::from_host(host))
}

impl Host {
    fn device(&self, card: Card) -> Device {
        Device {
            cards: Arc::clone(&self.0),
            card,
        }
    }
}

impl HostTrait for Host {
    type Devices = std::array::IntoIter<Device, 2>;
    type Device = Device;

    fn is_available() -> bool {
        true
    }

    fn devices(&self) -> Result<Self::Devices, Error> {
        Ok([self.device(Card::Bench), self.device(Card::Speakers)].into_iter())
    }

    fn default_input_device(&self) -> Option<Device> {
        Some(self.device(Card::Bench))
    }

    /// Returns the speakers, as on any machine; the bench's converter must be selected by its id.
    fn default_output_device(&self) -> Option<Device> {
        Some(self.device(Card::Speakers))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Card {
    Bench,
    Speakers,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Port {
    BenchOutput,
    BenchInput,
    Speakers,
}

/// A simulated sound card.
#[derive(Clone)]
pub struct Device {
    cards: Arc<SoundCards>,
    card: Card,
}

impl PartialEq for Device {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.cards, &other.cards) && self.card == other.card
    }
}

impl Eq for Device {}

impl Hash for Device {
    fn hash<H: Hasher>(&self, state: &mut H) {
        Arc::as_ptr(&self.cards).hash(state);
        self.card.hash(state);
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Device").field(&self.card).finish()
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.card {
            Card::Bench => "simulated bench",
            Card::Speakers => "simulated speakers",
        })
    }
}

impl Device {
    /// Returns the numbers of output and of input channels.
    fn channels(&self) -> (u16, u16) {
        match self.card {
            Card::Bench => (BENCH_OUTPUTS, self.cards.inputs),
            Card::Speakers => (SPEAKERS_OUTPUTS, 0),
        }
    }

    fn rates_hz(&self) -> &'static [u32] {
        match self.card {
            Card::Bench => self.cards.rates_hz,
            Card::Speakers => &[SPEAKERS_RATE_HZ],
        }
    }

    fn formats(&self) -> &[SampleFormat] {
        match self.card {
            Card::Bench => &self.cards.formats,
            Card::Speakers => &SPEAKERS_FORMATS,
        }
    }

    fn configs(&self, channels: u16) -> Vec<SupportedStreamConfigRange> {
        let mut configs = Vec::new();
        for &format in self.formats() {
            for &rate_hz in self.rates_hz() {
                for count in 1..=channels {
                    configs.push(SupportedStreamConfigRange::new(
                        count,
                        rate_hz,
                        rate_hz,
                        buffer_range(),
                        format,
                    ));
                }
            }
        }
        configs
    }

    fn default_config(&self, channels: u16) -> Result<SupportedStreamConfig, Error> {
        if channels == 0 {
            return Err(Error::with_message(
                ErrorKind::UnsupportedOperation,
                format!("{self}: no input"),
            ));
        }
        // Like most cards, the bench's does not default to its highest rate.
        let rate_hz = self.rates_hz()[0];
        Ok(SupportedStreamConfig::new(
            channels,
            rate_hz,
            buffer_range(),
            self.formats()[0],
        ))
    }

    /// Returns the buffer of a stream and its length, frames.
    ///
    /// # Errors
    /// `UnsupportedConfig`, with the unsupported setting.
    fn buffer(
        &self,
        config: &StreamConfig,
        format: SampleFormat,
        most_channels: u16,
        running: &Arc<AtomicBool>,
        on_error: ErrorCallback,
    ) -> Result<(Buffer, FrameCount), Error> {
        let unsupported = |fault: String| {
            Error::with_message(ErrorKind::UnsupportedConfig, format!("{self}: {fault}"))
        };
        let rate_hz = config.sample_rate;
        if !self.rates_hz().contains(&rate_hz) {
            return Err(unsupported(format!(
                "{rate_hz} Hz is not one of {:?}",
                self.rates_hz()
            )));
        }
        if !(1..=most_channels).contains(&config.channels) {
            return Err(unsupported(format!(
                "{} channels are not within 1 to {most_channels}",
                config.channels
            )));
        }
        if !self.formats().contains(&format) {
            return Err(unsupported(format!(
                "{format} is not one of {:?}",
                self.formats()
            )));
        }
        let frames = match (config.buffer_size, self.card) {
            (BufferSize::Fixed(frames), _) => frames,
            (BufferSize::Default, Card::Bench) => self.cards.clock.period_frames_at(rate_hz) as u32,
            (BufferSize::Default, Card::Speakers) => 512,
        };
        if !BUFFER_FRAMES.contains(&frames) {
            return Err(unsupported(format!(
                "a buffer of {frames} frames is not within {BUFFER_FRAMES:?}"
            )));
        }
        let running = Arc::clone(running);
        let buffer = Buffer::new(format, config.channels, frames, running, on_error)
            .ok_or_else(|| unsupported(format!("{format} is offered but not simulated")))?;
        Ok((buffer, frames))
    }

    fn stream(&self, port: Port, running: Arc<AtomicBool>, frames: FrameCount) -> Stream {
        Stream {
            cards: Arc::clone(&self.cards),
            port,
            running,
            frames,
        }
    }

    fn busy_error(&self) -> Error {
        Error::with_message(ErrorKind::DeviceBusy, format!("{self} is already open"))
    }

    /// Returns the error for a rate that differs from the other direction's: both directions share one clock.
    fn other_rate(&self, wanted_hz: u32, running_hz: u32) -> Error {
        Error::with_message(
            ErrorKind::UnsupportedConfig,
            format!("{self}: {wanted_hz} Hz while the other direction runs at {running_hz} Hz"),
        )
    }
}

fn buffer_range() -> SupportedBufferSize {
    SupportedBufferSize::Range {
        min: *BUFFER_FRAMES.start(),
        max: *BUFFER_FRAMES.end(),
    }
}

impl DeviceTrait for Device {
    type SupportedInputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type SupportedOutputConfigs = std::vec::IntoIter<SupportedStreamConfigRange>;
    type Stream = Stream;

    fn description(&self) -> Result<DeviceDescription, Error> {
        let direction = match self.card {
            Card::Bench => DeviceDirection::Duplex,
            Card::Speakers => DeviceDirection::Output,
        };
        Ok(DeviceDescriptionBuilder::new(self.to_string())
            .direction(direction)
            .build())
    }

    fn id(&self) -> Result<DeviceId, Error> {
        let id = match self.card {
            Card::Bench => BENCH_ID,
            Card::Speakers => SPEAKERS_ID,
        };
        Ok(DeviceId::new(HostId::Custom, id))
    }

    fn supported_input_configs(&self) -> Result<Self::SupportedInputConfigs, Error> {
        Ok(self.configs(self.channels().1).into_iter())
    }

    fn supported_output_configs(&self) -> Result<Self::SupportedOutputConfigs, Error> {
        Ok(self.configs(self.channels().0).into_iter())
    }

    fn default_input_config(&self) -> Result<SupportedStreamConfig, Error> {
        self.default_config(self.channels().1)
    }

    fn default_output_config(&self) -> Result<SupportedStreamConfig, Error> {
        self.default_config(self.channels().0)
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
        let running = Arc::new(AtomicBool::new(false));
        let (buffer, frames) = self.buffer(
            &config,
            sample_format,
            self.channels().1,
            &running,
            Box::new(error_callback),
        )?;
        let mut bench = lock(&self.cards.bench);
        if bench.input.is_open() {
            return Err(self.busy_error());
        }
        if bench.output.is_open() && bench.rate_hz != config.sample_rate {
            return Err(self.other_rate(config.sample_rate, bench.rate_hz));
        }
        bench.rate_hz = config.sample_rate;
        bench
            .input
            .open(InputStream::new(buffer, Box::new(data_callback)));
        Ok(self.stream(Port::BenchInput, running, frames))
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
        let running = Arc::new(AtomicBool::new(false));
        let (buffer, frames) = self.buffer(
            &config,
            sample_format,
            self.channels().0,
            &running,
            Box::new(error_callback),
        )?;
        let stream = OutputStream::new(buffer, Box::new(data_callback));
        let port = match self.card {
            Card::Bench => {
                let mut bench = lock(&self.cards.bench);
                if bench.output.is_open() {
                    return Err(self.busy_error());
                }
                if bench.input.is_open() && bench.rate_hz != config.sample_rate {
                    return Err(self.other_rate(config.sample_rate, bench.rate_hz));
                }
                bench.rate_hz = config.sample_rate;
                bench.output.open(stream);
                Port::BenchOutput
            }
            Card::Speakers => {
                let mut speakers = lock(&self.cards.speakers);
                if speakers.is_open() {
                    return Err(self.busy_error());
                }
                speakers.open(stream);
                Port::Speakers
            }
        };
        Ok(self.stream(port, running, frames))
    }
}

/// An open stream; dropping it closes the device's direction.
pub struct Stream {
    cards: Arc<SoundCards>,
    port: Port,
    running: Arc<AtomicBool>,
    frames: FrameCount,
}

cpal::assert_stream_send!(Stream);
cpal::assert_stream_sync!(Stream);

impl StreamTrait for Stream {
    fn play(&self) -> Result<(), Error> {
        self.running.store(true, Ordering::Release);
        Ok(())
    }

    fn pause(&self) -> Result<(), Error> {
        self.running.store(false, Ordering::Release);
        Ok(())
    }

    fn buffer_size(&self) -> Result<FrameCount, Error> {
        Ok(self.frames)
    }

    fn now(&self) -> StreamInstant {
        StreamInstant::from_nanos(self.cards.clock.now_ns())
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // The callbacks are dropped after the lock is released, because they may own another stream.
        match self.port {
            Port::BenchOutput => drop(close(&self.cards, |b| b.output.close(&self.running))),
            Port::BenchInput => drop(close(&self.cards, |b| b.input.close(&self.running))),
            Port::Speakers => {
                let stream = lock(&self.cards.speakers).close(&self.running);
                drop(stream);
            }
        }
    }
}

fn close<S>(cards: &SoundCards, take: impl FnOnce(&mut BenchCard) -> Option<S>) -> Option<S> {
    take(&mut lock(&cards.bench))
}
