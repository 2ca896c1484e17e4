//! The bench's side of the interfaces: streams, a serial port, and a function that advances time.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, Data, DeviceId, HostId, SampleFormat, StreamConfig};
use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use serialport::SerialPort;

pub fn stepped(scenario: Scenario, seed: u64) -> Apparatus {
    Apparatus::new(ApparatusConfig::new(scenario, seed, WorldPace::Stepped)).unwrap()
}

pub fn pass(apparatus: &mut Apparatus, seconds: f64) {
    let end_ns = apparatus.now_ns() + (1e9 * seconds) as u64;
    while apparatus.now_ns() < end_ns {
        apparatus.step().unwrap();
    }
}

pub fn device(apparatus: &Apparatus, id: &str) -> cpal::Device {
    apparatus
        .host()
        .device_by_id(&DeviceId::new(HostId::Custom, id))
        .unwrap()
}

pub fn stream_config(channels: u16, rate_hz: u32) -> StreamConfig {
    StreamConfig {
        channels,
        sample_rate: rate_hz,
        buffer_size: BufferSize::Default,
    }
}

/// Samples and errors passed to an input stream.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Recorded {
    /// Interleaved, as raw bytes of the stream's format.
    pub bytes: Vec<u8>,
    /// Capture time of each buffer's first frame, ns.
    pub captured_ns: Vec<u128>,
    pub errors: Vec<cpal::ErrorKind>,
}

impl Recorded {
    pub fn channel(&self, format: SampleFormat, channels: usize, index: usize) -> Vec<f64> {
        let words = self.bytes.as_chunks::<4>().0;
        let value = |word: &[u8; 4]| match format {
            SampleFormat::F32 => f64::from(f32::from_ne_bytes(*word)),
            SampleFormat::I32 => f64::from(i32::from_ne_bytes(*word)) / 2f64.powi(31),
            format => panic!("the test does not read {format}"),
        };
        words
            .iter()
            .skip(index)
            .step_by(channels)
            .map(value)
            .collect()
    }
}

/// Opens and starts an input stream of all channels.
pub fn record(
    device: &cpal::Device,
    config: StreamConfig,
    format: SampleFormat,
) -> (cpal::Stream, Arc<Mutex<Recorded>>) {
    let recorded = Arc::new(Mutex::new(Recorded::default()));
    let (data, errors) = (Arc::clone(&recorded), Arc::clone(&recorded));
    let stream = device
        .build_input_stream_raw(
            config,
            format,
            move |samples: &Data, info| {
                let mut recorded = data.lock().unwrap();
                recorded.bytes.extend_from_slice(samples.bytes());
                let capture_time = info.timestamp().capture;
                recorded.captured_ns.push(capture_time.as_nanos());
            },
            move |error| errors.lock().unwrap().errors.push(error.kind()),
            None,
        )
        .unwrap();
    stream.play().unwrap();
    (stream, recorded)
}

/// Opens and starts an output stream that plays a sine of `amplitude` on every channel.
pub fn play_sine(
    device: &cpal::Device,
    config: StreamConfig,
    format: SampleFormat,
    frequency_hz: f64,
    amplitude: f64,
) -> cpal::Stream {
    let (channels, rate_hz) = (usize::from(config.channels), f64::from(config.sample_rate));
    let mut frame = 0u64;
    let mut next = move || {
        let phase = std::f64::consts::TAU * frequency_hz * frame as f64 / rate_hz;
        frame += 1;
        amplitude * phase.sin()
    };
    let stream = device
        .build_output_stream_raw(
            config,
            format,
            move |samples: &mut Data, _| match format {
                SampleFormat::F32 => {
                    for frame in samples.as_slice_mut::<f32>().unwrap().chunks_mut(channels) {
                        frame.fill(next() as f32);
                    }
                }
                SampleFormat::I32 => {
                    for frame in samples.as_slice_mut::<i32>().unwrap().chunks_mut(channels) {
                        frame.fill((next() * 2f64.powi(31)) as i32);
                    }
                }
                format => panic!("the test does not play {format}"),
            },
            |error| panic!("{error}"),
            None,
        )
        .unwrap();
    stream.play().unwrap();
    stream
}

/// Returns the amplitude of the component at `frequency_hz`, over whole periods.
pub fn amplitude_at(signal: &[f64], frequency_hz: f64, rate_hz: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (n, value) in signal.iter().enumerate() {
        let phase = std::f64::consts::TAU * frequency_hz * n as f64 / rate_hz;
        re += value * phase.cos();
        im += value * phase.sin();
    }
    2.0 * re.hypot(im) / signal.len() as f64
}

pub fn open_force_port(apparatus: &Apparatus) -> Box<dyn SerialPort> {
    serialport::new(apparatus.force_port().unwrap().to_str().unwrap(), 2_000_000)
        .timeout(Duration::from_millis(20))
        .open()
        .unwrap()
}

/// Reads all bytes that are readable now.
pub fn read_available(port: &mut dyn SerialPort) -> Vec<u8> {
    let mut bytes = vec![0; port.bytes_to_read().unwrap() as usize];
    if !bytes.is_empty() {
        port.read_exact(&mut bytes).unwrap();
    }
    bytes
}
