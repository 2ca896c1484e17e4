//! Rendering speed of the generator, in frames: at 192 kHz one second of drive is 192 000 frames.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use signalgen::{DriveCommand, DriveConfig, DriveSettings, Generator, SweepLaw, Waveform};

const BLOCK_FRAMES: usize = 1024;

fn fill(c: &mut Criterion) {
    let settings = DriveSettings::new(DriveConfig {
        sample_rate_hz: 192_000,
        volts_per_unit: 200.0,
        limit_v: 100.0,
        ramp_s: 0.05,
    })
    .expect("settings in range");
    let waveforms = [
        (
            "modulated",
            Waveform::Modulated {
                carrier_hz: 35_000.0,
                mean_amplitude_v: 20.0,
                modulation_hz: 6.0,
                modulation_index: 0.95,
                start_phase_rad: 0.0,
            },
        ),
        (
            "logarithmic sweep",
            Waveform::Sweep {
                from_hz: 30_000.0,
                to_hz: 40_000.0,
                duration_s: 86_400.0,
                law: SweepLaw::Logarithmic,
                amplitude_v: 20.0,
            },
        ),
    ];
    let mut group = c.benchmark_group("Generator::fill");
    group.throughput(Throughput::Elements(BLOCK_FRAMES as u64));
    for (name, waveform) in waveforms {
        let mut generator = Generator::new(settings);
        generator.apply(DriveCommand::Start(
            settings.admit(waveform).expect("waveform in range"),
        ));
        let mut block = [0.0_f32; BLOCK_FRAMES];
        group.bench_function(name, |b| b.iter(|| generator.fill(black_box(&mut block))));
    }
    group.finish();
}

criterion_group!(benches, fill);
criterion_main!(benches);
