//! Wall time per simulated second, s: 192 kHz, four channels, one core.
#![allow(missing_docs, reason = "criterion_group! makes public items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::scenario::{Scenario, built_in};

const RATE_HZ: f64 = 192e3;
const PERIOD: usize = 1024;

fn modulated_carrier() -> Vec<f32> {
    (0..RATE_HZ as usize)
        .map(|n| {
            let t = n as f64 / RATE_HZ;
            let envelope = 1.0 + 0.95 * (std::f64::consts::TAU * 6.0 * t).sin();
            (0.3 * envelope * (std::f64::consts::TAU * 35e3 * t).sin()) as f32
        })
        .collect()
}

fn one_second(c: &mut Criterion) {
    let drive = modulated_carrier();
    let mut group = c.benchmark_group("plant");
    group.sample_size(10);
    group.throughput(Throughput::Elements(drive.len() as u64));
    let sliding = FingerState {
        position_m: 0.05,
        velocity_m_per_s: 0.05,
        normal_n: 0.65,
        touching: true,
    };
    let published = Scenario::default();
    let scenario = |name| built_in(name).unwrap_or_default();
    let (unkind, gaussian) = (
        scenario("population-unkind"),
        scenario("laws/asperities-gaussian"),
    );
    for (name, scenario, finger) in [
        ("unloaded", &published, FingerState::default()),
        ("finger sliding", &published, sliding),
        ("unkind, unloaded", &unkind, FingerState::default()),
        ("unkind, finger sliding", &unkind, sliding),
        ("asperities-gaussian, finger sliding", &gaussian, sliding),
    ] {
        let mut plant = Plant::new(scenario, 1, RATE_HZ);
        let mut inputs = vec![0.0; PERIOD * plant.channels()];
        group.bench_function(name, |b| {
            b.iter(|| {
                for period in drive.chunks(PERIOD) {
                    let frames = period.len() * plant.channels();
                    plant.step(period, true, &finger, &mut inputs[..frames]);
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, one_second);
criterion_main!(benches);
