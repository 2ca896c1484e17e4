//! Sound card that the test advances period by period, and the configuration that opens it.

#![expect(
    unsafe_code,
    reason = "cpal hands raw buffers between a host and its streams; this is the host"
)]

use std::{
    hash::{Hash, Hasher},
    sync::{
        Arc, Mutex,
        atomic::{AtomicU32, Ordering},
    },
    time::Duration,
};

use assert_no_alloc::assert_no_alloc;
use cpal::{
    BufferSize, Data, DeviceDescription, DeviceDescriptionBuilder, DeviceDirection, DeviceId,
    Error, ErrorKind, FrameCount, HostId, InputCallbackInfo, InputStreamTimestamp,
    OutputCallbackInfo, OutputStreamTimestamp, SampleFormat as CpalFormat, StreamConfig,
    StreamInstant, SupportedBufferSize, SupportedStreamConfig, SupportedStreamConfigRange,
    traits::{DeviceTrait, HostTrait, StreamTrait},
};
use signalgen::{
    ConverterSample, DriveConfig, DriveSettings, Generator, Program, StreamDirection, StreamFormat,
    Waveform,
    audio::{
        Duplex, DuplexConfig, Host, HostChoice, StreamChoice, ThreadStart, open_duplex, open_host,
    },
};

pub const RATE_HZ: u32 = 192_000;
pub const FULL_SCALE_V: f64 = 100.0;
pub const BLOCK: usize = 512;
/// More than one chunk of the output callback, and not a multiple of it.
pub const ODD_BLOCK: usize = 700;
pub const INPUT_CHANNELS: usize = 2;
pub const OUTPUT_CHANNELS: usize = 3;
pub const DRIVE_CHANNEL: usize = 1;

pub type OutputBody = Box<dyn FnMut(&mut Data, &OutputCallbackInfo) + Send>;
pub type InputBody = Box<dyn FnMut(&Data, &InputCallbackInfo) + Send>;
pub type ErrorBody = Box<dyn FnMut(Error) + Send>;

pub struct Open<B> {
    body: B,
    error: ErrorBody,
    format: CpalFormat,
    playing: bool,
}

/// State of one device with all input channels wired to the drive's output channel.
#[derive(Default)]
pub struct Card {
    pub output: Option<Open<OutputBody>>,
    pub input: Option<Open<InputBody>>,
    frames: u64,
}

impl Card {
    /// Runs one period: output callback, then input callback, with allocation forbidden in both. Returns the rendered output,
    /// interleaved, in units of full scale.
    pub fn period(&mut self, frames: usize) -> Vec<f32> {
        let instant =
            |frame: u64| StreamInstant::from_nanos(frame * 1_000_000_000 / u64::from(RATE_HZ));
        let (begin, end) = (instant(self.frames), instant(self.frames + frames as u64));
        self.frames += frames as u64;
        let mut output_block = vec![0.0; frames * OUTPUT_CHANNELS];
        if let Some(output) = self.output.as_mut().filter(|o| o.playing) {
            let info = OutputCallbackInfo::new(OutputStreamTimestamp {
                callback: begin,
                playback: end,
            });
            match output.format {
                CpalFormat::F32 => render::<f32>(output, &info, &mut output_block),
                CpalFormat::I32 => render::<i32>(output, &info, &mut output_block),
                CpalFormat::I24 => render::<cpal::I24>(output, &info, &mut output_block),
                CpalFormat::I16 => render::<i16>(output, &info, &mut output_block),
                format => panic!("{format} was never offered"),
            }
        }
        if let Some(input) = self.input.as_mut().filter(|i| i.playing) {
            let drive = output_block.chunks_exact(OUTPUT_CHANNELS);
            let input_block: Vec<f32> = drive
                .flat_map(|frame| [frame[DRIVE_CHANNEL]; INPUT_CHANNELS])
                .collect();
            let info = InputCallbackInfo::new(InputStreamTimestamp {
                callback: end,
                capture: begin,
            });
            match input.format {
                CpalFormat::F32 => take::<f32>(input, &info, &input_block),
                CpalFormat::I32 => take::<i32>(input, &info, &input_block),
                CpalFormat::I24 => take::<cpal::I24>(input, &info, &input_block),
                CpalFormat::I16 => take::<i16>(input, &info, &input_block),
                format => panic!("{format} was never offered"),
            }
        }
        output_block
    }

    pub fn report(&mut self, direction: StreamDirection, kind: ErrorKind) {
        let error = match direction {
            StreamDirection::Output => self.output.as_mut().map(|o| &mut o.error),
            StreamDirection::Input => self.input.as_mut().map(|i| &mut i.error),
        };
        assert_no_alloc(|| error.expect("an open stream")(Error::new(kind)));
    }
}

fn render<T: ConverterSample>(
    output: &mut Open<OutputBody>,
    info: &OutputCallbackInfo,
    rendered: &mut [f32],
) {
    // Not silence: the callback must overwrite every sample.
    let mut raw = vec![T::from_unit(0.5); rendered.len()];
    // SAFETY: the pointer and length are those of `raw`, whose type the format names.
    let mut data = unsafe { Data::from_parts(raw.as_mut_ptr().cast(), raw.len(), output.format) };
    assert_no_alloc(|| (output.body)(&mut data, info));
    for (sample, raw) in rendered.iter_mut().zip(raw) {
        *sample = raw.to_unit();
    }
}

fn take<T: ConverterSample>(
    input: &mut Open<InputBody>,
    info: &InputCallbackInfo,
    samples: &[f32],
) {
    let mut raw: Vec<T> = samples.iter().map(|&s| T::from_unit(s)).collect();
    // SAFETY: as above.
    let data = unsafe { Data::from_parts(raw.as_mut_ptr().cast(), raw.len(), input.format) };
    assert_no_alloc(|| (input.body)(&data, info));
}

/// A host with the stepped card as its only device.
#[derive(Clone)]
pub struct Bench {
    card: Arc<Mutex<Card>>,
    /// Number of times that the output's and the input's thread started.
    pub started: Arc<[AtomicU32; 2]>,
    formats: &'static [CpalFormat],
}

impl Default for Bench {
    fn default() -> Self {
        Self::with_formats(&[
            CpalFormat::F32,
            CpalFormat::I32,
            CpalFormat::I24,
            CpalFormat::I16,
        ])
    }
}

impl Bench {
    /// Returns a bench with a card of these sample formats.
    pub fn with_formats(formats: &'static [CpalFormat]) -> Self {
        Self {
            card: Arc::default(),
            started: Arc::default(),
            formats,
        }
    }

    pub fn card(&self) -> std::sync::MutexGuard<'_, Card> {
        self.card.lock().unwrap()
    }

    pub fn host(&self) -> Host {
        let custom = cpal::platform::CustomHost::from_host(self.clone());
        open_host(HostChoice::Supplied(Host::from(custom))).unwrap()
    }

    pub fn open(&self, config: &DuplexConfig) -> Duplex {
        let started = Arc::clone(&self.started);
        let start: ThreadStart = Arc::new(move |direction| {
            let count = usize::from(direction == StreamDirection::Input);
            started[count].fetch_add(1, Ordering::Relaxed);
        });
        let generator = Generator::new(settings());
        let duplex = open_duplex(&self.host(), config, generator, Some(&start)).unwrap();
        duplex.streams.play().unwrap();
        duplex
    }

    pub fn periods(&self, count: usize) {
        for _ in 0..count {
            self.card().period(BLOCK);
        }
    }
}

type Ranges = std::vec::IntoIter<SupportedStreamConfigRange>;

impl Bench {
    fn ranges(&self, channels: usize) -> Ranges {
        let range = |&format| {
            let sizes = SupportedBufferSize::Unknown;
            SupportedStreamConfigRange::new(channels as u16, RATE_HZ, RATE_HZ, sizes, format)
        };
        let ranges: Vec<_> = self.formats.iter().map(range).collect();
        ranges.into_iter()
    }

    fn check(config: &StreamConfig) -> Result<(), Error> {
        match config.buffer_size {
            BufferSize::Default => Ok(()),
            BufferSize::Fixed(_) => Err(ErrorKind::UnsupportedConfig.into()),
        }
    }
}

impl HostTrait for Bench {
    type Devices = std::iter::Once<Self>;
    type Device = Self;
    fn is_available() -> bool {
        true
    }
    fn devices(&self) -> Result<Self::Devices, Error> {
        Ok(std::iter::once(self.clone()))
    }
    fn default_input_device(&self) -> Option<Self> {
        Some(self.clone())
    }
    fn default_output_device(&self) -> Option<Self> {
        Some(self.clone())
    }
}

impl PartialEq for Bench {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.card, &other.card)
    }
}
impl Eq for Bench {}
impl Hash for Bench {
    fn hash<H: Hasher>(&self, state: &mut H) {
        Arc::as_ptr(&self.card).hash(state);
    }
}
impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stepped card")
    }
}
impl std::fmt::Display for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stepped card")
    }
}

impl DeviceTrait for Bench {
    type SupportedInputConfigs = Ranges;
    type SupportedOutputConfigs = Ranges;
    type Stream = CardStream;
    fn description(&self) -> Result<DeviceDescription, Error> {
        Ok(DeviceDescriptionBuilder::new("stepped card")
            .direction(DeviceDirection::Duplex)
            .build())
    }
    fn id(&self) -> Result<DeviceId, Error> {
        Ok(DeviceId::new(HostId::Custom, "stepped"))
    }
    fn supported_input_configs(&self) -> Result<Ranges, Error> {
        Ok(self.ranges(INPUT_CHANNELS))
    }
    fn supported_output_configs(&self) -> Result<Ranges, Error> {
        Ok(self.ranges(OUTPUT_CHANNELS))
    }
    fn default_input_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(ErrorKind::UnsupportedOperation.into())
    }
    fn default_output_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(ErrorKind::UnsupportedOperation.into())
    }
    fn build_input_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: CpalFormat,
        data: D,
        error: E,
        _timeout: Option<Duration>,
    ) -> Result<CardStream, Error>
    where
        D: FnMut(&Data, &InputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        Self::check(&config)?;
        let mut card = self.card();
        if card.input.is_some() {
            return Err(ErrorKind::DeviceBusy.into());
        }
        card.input = Some(Open {
            body: Box::new(data),
            error: Box::new(error),
            format,
            playing: false,
        });
        Ok(CardStream(self.clone(), StreamDirection::Input))
    }
    fn build_output_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: CpalFormat,
        data: D,
        error: E,
        _timeout: Option<Duration>,
    ) -> Result<CardStream, Error>
    where
        D: FnMut(&mut Data, &OutputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        Self::check(&config)?;
        let mut card = self.card();
        if card.output.is_some() {
            return Err(ErrorKind::DeviceBusy.into());
        }
        card.output = Some(Open {
            body: Box::new(data),
            error: Box::new(error),
            format,
            playing: false,
        });
        Ok(CardStream(self.clone(), StreamDirection::Output))
    }
}

pub struct CardStream(Bench, StreamDirection);

impl CardStream {
    fn set_playing(&self, playing: bool) {
        let mut card = self.0.card();
        match self.1 {
            StreamDirection::Output => card.output.iter_mut().for_each(|o| o.playing = playing),
            StreamDirection::Input => card.input.iter_mut().for_each(|i| i.playing = playing),
        }
    }
}

impl StreamTrait for CardStream {
    fn play(&self) -> Result<(), Error> {
        self.set_playing(true);
        Ok(())
    }
    fn pause(&self) -> Result<(), Error> {
        self.set_playing(false);
        Ok(())
    }
    fn now(&self) -> StreamInstant {
        StreamInstant::ZERO
    }
    fn buffer_size(&self) -> Result<FrameCount, Error> {
        Ok(BLOCK as FrameCount)
    }
}

impl Drop for CardStream {
    fn drop(&mut self) {
        let mut card = self.0.card();
        match self.1 {
            StreamDirection::Output => card.output = None,
            StreamDirection::Input => card.input = None,
        }
    }
}

pub fn settings() -> DriveSettings {
    DriveSettings::new(DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: FULL_SCALE_V,
        limit_v: 100.0,
        ramp_s: 0.005,
    })
    .unwrap()
}

pub fn config(format: StreamFormat) -> DuplexConfig {
    DuplexConfig {
        sample_rate_hz: RATE_HZ,
        output: StreamChoice {
            device: "stepped card".to_owned(),
            channels: OUTPUT_CHANNELS as u16,
            format,
        },
        drive_channel: DRIVE_CHANNEL as u16,
        input: StreamChoice {
            device: "stepped".to_owned(),
            channels: INPUT_CHANNELS as u16,
            format,
        },
        buffer_frames: None,
        ring_s: 1.0,
        tap: Vec::new(),
    }
}

pub fn modulated_program() -> Program {
    let waveform = Waveform::Modulated {
        carrier_hz: 35_000.0,
        mean_amplitude_v: 50.0,
        modulation_hz: 6.0,
        modulation_index: 0.95,
        start_phase_rad: 0.0,
    };
    settings().admit(waveform).unwrap()
}
