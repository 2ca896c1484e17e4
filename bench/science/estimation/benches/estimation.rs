//! Gap solutions, fits and the live frame.

mod record;

use std::hint::black_box;

use contact::FittedFinger;
use contact::live_estimator::{LiveEstimator, LiveFrame};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use estimation::{dynamic, paper};
use record::{CARRIER_HZ, Record, Z_P, Z_T, amplitude_m, contact, fit_trial, normal_n};

fn gaps(c: &mut Criterion) {
    const N: usize = 100_000;
    let contact = contact();
    let record: (Vec<f64>, Vec<f64>) = (0..N)
        .map(|i| i as f64 / 2000.0)
        .map(|t| (amplitude_m(t), normal_n(t)))
        .unzip();
    // The same samples in an order without neighbours: 48 271 is prime to N.
    let permutation: (Vec<f64>, Vec<f64>) = (0..N)
        .map(|i| i * 48_271 % N)
        .map(|i| (record.0[i], record.1[i]))
        .unzip();
    let mut gap_m = vec![0.0; N];
    for (name, (amplitude_m, normal_n)) in [
        ("100 000 gaps of a record", &record),
        ("100 000 gaps without order", &permutation),
    ] {
        c.bench_function(name, |b| {
            b.iter(|| {
                contact.equilibrium_gaps_m(black_box(amplitude_m), black_box(normal_n), &mut gap_m)
            });
        });
    }
    let k_c: Vec<f64> = gap_m
        .iter()
        .zip(&permutation.1)
        .map(|(&gap, &n)| contact.balance_stiffness_n_per_m(gap, n))
        .collect();
    c.bench_function("100 000 gaps from stiffness in balance", |b| {
        b.iter(|| contact.gaps_from_balance_stiffness(black_box(&k_c), 0.65, &mut gap_m));
    });
}

fn fits(c: &mut Criterion) {
    let conditions = record::conditions();
    let paper_record = Record::at_rate(1000.0);
    c.bench_function("paper fit, 60 points", |b| {
        b.iter(|| {
            paper::fit(
                black_box(&paper_record.series()),
                &conditions,
                &paper::PaperOptions::default(),
            )
        });
    });
    let dynamic_record = Record::at_rate(2000.0);
    c.bench_function("dynamic fit, 120 points", |b| {
        b.iter(|| {
            dynamic::fit(
                black_box(&dynamic_record.series()),
                &conditions,
                &dynamic::DynamicOptions::default(),
            )
        });
    });
    let records = Record::trial(14);
    c.bench_function("trial fit, 14 instances", |b| {
        b.iter(|| fit_trial(black_box(&records)));
    });
}

fn live(c: &mut Criterion) {
    let finger = FittedFinger::with_parameters(contact(), Z_T, 1e-3, Z_P, CARRIER_HZ)
        .expect("physical finger");
    let record = Record::at_rate(2000.0);
    let frames: Vec<LiveFrame> = record
        .z_m
        .iter()
        .zip(&record.amplitude_m)
        .map(|(&z_m, &amplitude_m)| LiveFrame {
            z_m_corrected_n_s_per_m: z_m,
            amplitude_m,
            normal_n: None,
        })
        .collect();
    c.bench_function("160 live frames", |b| {
        b.iter_batched(
            || LiveEstimator::new(finger, 5e-4).expect("positive interval"),
            |mut live| {
                frames
                    .iter()
                    .filter(|frame| live.update(black_box(frame)).is_ok())
                    .count()
            },
            BatchSize::SmallInput,
        );
    });
}

criterion_group!(benches, gaps, fits, live);
criterion_main!(benches);
