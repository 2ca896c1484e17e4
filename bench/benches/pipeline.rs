//! The audio path behind the sound card's ring, four channels at 192 kHz: demodulation and impedance, also with the
//! recorder writing every sample to disk.
//!
//! `cargo bench -p friction-bench --bench pipeline`; throughput is in frames, 192 000 per second. The demodulator alone:
//! `cargo bench -p impedance`.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use live::live_meter::LiveMeter;
use recorder::{Begin, RecorderMessage, RecorderNotice, recorder};
use recording::AudioFormat;
use recording::manifest::{
    Carrier, FORMAT, Manifest, Modulation, RecordedChannels, RecordedContact, RecordedDrive,
    RecordedPickup, RecordedPlate, RecordedSignals, Streams,
};
use recording::pipeline::{Batch, Pipeline};
use recording::writer::Ending;

const AUDIO: AudioFormat = AudioFormat {
    sample_rate_hz: 192_000,
    channels: 4,
};
const CARRIER_HZ: f64 = 35_000.0;
const SECONDS: u32 = 5;
const BLOCK_FRAMES: usize = 1024;

fn manifest() -> Manifest {
    Manifest {
        format: FORMAT,
        streams: Streams::Signals(RecordedSignals {
            carrier: Carrier::Steady(CARRIER_HZ),
            modulation: Modulation {
                frequency_hz: 6.0,
                index: 0.95,
            },
            channels: RecordedChannels {
                rate_hz: None,
                drive: RecordedDrive {
                    index: 0,
                    volts_per_unit: 60.0,
                    clip_units: None,
                },
                pickup: RecordedPickup {
                    index: 1,
                    metres_per_unit: 5e-6,
                    phase_rad: 0.2,
                    clip_units: None,
                },
            },
            plate: RecordedPlate {
                resonance_hz: CARRIER_HZ,
                modal_mass_kg: 0.008,
                force_factor_n_per_v: 0.13,
                centre_m: 0.0525,
                profile: None,
                across: None,
            },
        }),
        contact: RecordedContact::default(),
        standard_errors: None,
        room: None,
        intervals: Vec::new(),
        participant: None,
        trial: None,
        hardware: None,
        software: None,
        origin: None,
        clocks: Vec::new(),
        events: Vec::new(),
    }
}

/// Returns drive and pickup under the published modulation, and two channels of other signals.
fn audio() -> Vec<f32> {
    (0..SECONDS * AUDIO.sample_rate_hz)
        .flat_map(|n| {
            let t_s = f64::from(n) / f64::from(AUDIO.sample_rate_hz);
            let envelope = 0.4 * (1.0 + 0.95 * (TAU * 6.0 * t_s).sin());
            let (sin, cos) = (TAU * CARRIER_HZ * t_s).sin_cos();
            [envelope * cos, envelope * sin, 1e-3 * cos, 1e-3 * sin].map(|x| x as f32)
        })
        .collect()
}

fn demodulate(samples: &[f32]) -> anyhow::Result<u64> {
    let mut pipeline = Pipeline::from_recording(&manifest(), AUDIO)?;
    let mut meter = LiveMeter::default();
    for block in samples.chunks(BLOCK_FRAMES * usize::from(AUDIO.channels)) {
        meter.take(&acquire(&mut pipeline, block)?);
    }
    Ok(pipeline.account().frames)
}

fn acquire(pipeline: &mut Pipeline, block: &[f32]) -> anyhow::Result<Batch> {
    let mut batch = Batch::default();
    pipeline.process(block, &mut batch.frames)?;
    batch.audio_s = pipeline.audio_s();
    batch.account = pipeline.account();
    Ok(batch)
}

/// Demodulates and records in turn, as the acquisition and the recorder do.
fn demodulate_and_record(samples: &[f32], folder: &Path) -> anyhow::Result<u64> {
    let blocks = samples.chunks(BLOCK_FRAMES * usize::from(AUDIO.channels));
    let (mut sender, notices, mut task) = recorder(blocks.len() + 1);
    let refusal = |error| anyhow::anyhow!("the recorder refuses a message: {error:?}");
    let begin = Begin {
        folder: folder.to_owned(),
        manifest: manifest(),
        format: AUDIO,
    };
    sender
        .send(RecorderMessage::Begin(Box::new(begin)))
        .map_err(refusal)?;
    let mut pipeline = Pipeline::from_recording(&manifest(), AUDIO)?;
    let mut meter = LiveMeter::default();
    for block in blocks {
        meter.take(&acquire(&mut pipeline, block)?);
        sender
            .send(RecorderMessage::Audio(block.to_vec()))
            .map_err(refusal)?;
        task.poll(Instant::now());
    }
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .map_err(refusal)?;
    task.poll(Instant::now());
    let is_saved = notices
        .try_iter()
        .any(|notice| matches!(notice, RecorderNotice::Saved { .. }));
    anyhow::ensure!(is_saved, "the recording is not on disk");
    Ok(pipeline.account().frames)
}

fn pipeline(c: &mut Criterion) {
    let samples = audio();
    let frames = u64::from(SECONDS * AUDIO.sample_rate_hz);
    let mut group = c.benchmark_group("pipeline 4 x 192 kHz");
    group.sample_size(10);
    group.throughput(Throughput::Elements(frames));
    group.bench_function("demodulate", |b| {
        b.iter(|| {
            let result = demodulate(black_box(&samples));
            assert_eq!(result.ok(), Some(frames));
        });
    });
    group.bench_function("demodulate and record to disk", |b| {
        b.iter_batched(
            || tempfile::tempdir().ok(),
            |folder| {
                let path = folder
                    .as_ref()
                    .map(|folder| folder.path().join("recording"));
                let frame_count =
                    path.and_then(|path| demodulate_and_record(black_box(&samples), &path).ok());
                assert_eq!(frame_count, Some(frames));
                folder
            },
            criterion::BatchSize::PerIteration,
        );
    });
    group.finish();
}

criterion_group!(benches, pipeline);
criterion_main!(benches);
