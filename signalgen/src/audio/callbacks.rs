//! Callbacks of both streams, bound to cpal.

use std::sync::Arc;
use std::time::Duration;

use cpal::{
    Device, ErrorKind, InputCallbackInfo, OutputCallbackInfo, SizedSample, Stream, StreamConfig,
    StreamInstant, traits::DeviceTrait,
};

use crate::{
    capture::{BlockTime, InputWriter},
    renderer::DriveRenderer,
    sample::{ConverterSample, StreamFormat},
    stream_health::{StreamDirection, StreamFault, StreamHealth},
};

/// Hook run by a stream's own thread before its first block. It must neither allocate nor block.
pub type ThreadStart = Arc<dyn Fn(StreamDirection) + Send + Sync>;

/// A [`ThreadStart`] that runs once. It is never freed on the stream's thread.
struct Once {
    start: Option<ThreadStart>,
    done: bool,
}

impl Once {
    fn new(start: Option<&ThreadStart>) -> Self {
        Self {
            start: start.cloned(),
            done: false,
        }
    }

    fn run(&mut self, direction: StreamDirection) {
        if !std::mem::replace(&mut self.done, true)
            && let Some(start) = &self.start
        {
            start(direction);
        }
    }
}

/// Timeout of JACK for opening a stream, and period at which ALSA checks whether a silent one is lost.
const BACKEND_TIMEOUT: Duration = Duration::from_secs(2);

/// Opens an output stream, paused; its callback renders the drive.
pub(super) fn open_output(
    device: &Device,
    config: StreamConfig,
    format: StreamFormat,
    renderer: DriveRenderer,
    health: &StreamHealth,
    start: Option<&ThreadStart>,
) -> Result<Stream, cpal::Error> {
    match format {
        StreamFormat::F32 => output_of::<f32>(device, config, renderer, health, start),
        StreamFormat::I32 => output_of::<i32>(device, config, renderer, health, start),
        StreamFormat::I24 => output_of::<cpal::I24>(device, config, renderer, health, start),
        StreamFormat::I16 => output_of::<i16>(device, config, renderer, health, start),
    }
}

/// Opens an input stream, paused; its callback passes its blocks to `writer`.
pub(super) fn open_input(
    device: &Device,
    config: StreamConfig,
    format: StreamFormat,
    writer: InputWriter,
    health: &StreamHealth,
    start: Option<&ThreadStart>,
) -> Result<Stream, cpal::Error> {
    match format {
        StreamFormat::F32 => input_of::<f32>(device, config, writer, health, start),
        StreamFormat::I32 => input_of::<i32>(device, config, writer, health, start),
        StreamFormat::I24 => input_of::<cpal::I24>(device, config, writer, health, start),
        StreamFormat::I16 => input_of::<i16>(device, config, writer, health, start),
    }
}

fn output_of<T: ConverterSample + SizedSample>(
    device: &Device,
    config: StreamConfig,
    mut renderer: DriveRenderer,
    health: &StreamHealth,
    start: Option<&ThreadStart>,
) -> Result<Stream, cpal::Error> {
    let (health, mut start) = (health.clone(), Once::new(start));
    device.build_output_stream(
        config,
        move |out: &mut [T], _: &OutputCallbackInfo| {
            start.run(StreamDirection::Output);
            renderer.render(out);
        },
        move |error: cpal::Error| health.report(StreamDirection::Output, fault(error.kind())),
        Some(BACKEND_TIMEOUT),
    )
}

fn input_of<T: ConverterSample + SizedSample>(
    device: &Device,
    config: StreamConfig,
    mut writer: InputWriter,
    health: &StreamHealth,
    start: Option<&ThreadStart>,
) -> Result<Stream, cpal::Error> {
    let (health, mut start) = (health.clone(), Once::new(start));
    device.build_input_stream(
        config,
        move |block: &[T], info: &InputCallbackInfo| {
            start.run(StreamDirection::Input);
            let timestamp = info.timestamp();
            let time = BlockTime {
                callback_ns: nanos(timestamp.callback),
                capture_ns: nanos(timestamp.capture),
            };
            writer.take(block, time);
        },
        move |error: cpal::Error| health.report(StreamDirection::Input, fault(error.kind())),
        Some(BACKEND_TIMEOUT),
    )
}

/// Returns the nanoseconds of an instant; they wrap after 584 years.
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
