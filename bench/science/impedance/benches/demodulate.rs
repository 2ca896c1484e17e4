//! Demodulation of drive and pickup, compared with a plain lock-in amplifier that does the same sample by sample.
//!
//! `cargo bench -p impedance`; throughput is in stereo frames.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use impedance::{Demodulator, Filter, FilterSettings, InputChannel, OUTPUT_RATE_HZ};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

const RATE: u32 = 192_000;
const CARRIER_HZ: f64 = 35_000.0;
const BLOCK: usize = 2 * 1024;

/// Drive and pickup with a 6 Hz modulation of 95 %.
fn recording(seconds: u32) -> Vec<f32> {
    (0..seconds * RATE)
        .flat_map(|n| {
            let t = f64::from(n) / f64::from(RATE);
            let envelope = 0.5 * (1.0 + 0.95 * (TAU * 6.0 * t).sin());
            let (sin, cos) = (TAU * CARRIER_HZ * t).sin_cos();
            [(envelope * cos) as f32, (0.8 * envelope * sin) as f32]
        })
        .collect()
}

fn demodulate(filter: &Filter, samples: &[f32]) -> Complex64 {
    let input = |channel| InputChannel {
        channel,
        clip_level: 0.999,
    };
    let mut sum = Complex64::ZERO;
    Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(1))
        .and_then(|mut demodulator| {
            for block in samples.chunks(BLOCK) {
                demodulator.push(block, |frame| {
                    sum += frame.drive().value / frame.pickup().value
                })?;
            }
            Ok(sum)
        })
        .unwrap_or(Complex64::ZERO)
}

/// Textbook lock-in: multiplies each sample by the oscillator and applies a Hann low-pass of 2 ms at every frame.
fn lock_in(samples: &[f32]) -> Complex64 {
    let hop = (RATE / OUTPUT_RATE_HZ) as usize;
    let taps = 4 * hop;
    let window: Vec<f64> = (0..taps)
        .map(|i| (PI * i as f64 / taps as f64).sin().powi(2) * 4.0 / taps as f64)
        .collect();
    let mut mixed = [vec![], vec![]];
    for (n, pair) in samples.chunks_exact(2).enumerate() {
        let turn = TAU * CARRIER_HZ * n as f64 / f64::from(RATE);
        let oscillator = Complex64::new(turn.cos(), -turn.sin());
        for (channel, &x) in mixed.iter_mut().zip(pair) {
            channel.push(oscillator * f64::from(x));
        }
    }
    let low_pass =
        |z: &[Complex64]| -> Complex64 { z.iter().zip(&window).map(|(z, h)| z * h).sum() };
    (0..=mixed[0].len() - taps)
        .step_by(hop)
        .map(|start| {
            low_pass(&mixed[0][start..start + taps]) / low_pass(&mixed[1][start..start + taps])
        })
        .sum()
}

fn compare(c: &mut Criterion) {
    let settings = FilterSettings {
        sample_rate_hz: RATE,
        carrier_hz: CARRIER_HZ,
        output_rate_hz: OUTPUT_RATE_HZ,
    };
    let Ok(filter) = Filter::new(settings) else {
        return;
    };
    let mut group = c.benchmark_group("demodulate 2 x 192 kHz");
    group.sample_size(10);
    let minute = recording(60);
    group.throughput(Throughput::Elements(u64::from(60 * RATE)));
    group.bench_function("60 s, Demodulator", |b| {
        b.iter(|| demodulate(&filter, black_box(&minute)))
    });
    let second = &minute[..2 * RATE as usize];
    group.throughput(Throughput::Elements(u64::from(RATE)));
    group.bench_function("1 s, naive lock-in", |b| {
        b.iter(|| lock_in(black_box(second)))
    });
    group.finish();
}

criterion_group!(benches, compare);
criterion_main!(benches);
