//! Gap solutions, fits and the live frame.

use std::f64::consts::TAU;
use std::hint::black_box;

use contact::fit::{FitConditions, InstanceSeries, Samples, dynamic, paper};
use contact::live::{Frame, LiveEstimator};
use contact::{AssumedConstants, Contact, FittedFinger, harmonic};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use num_complex::Complex64;

const CARRIER_HZ: f64 = 35_000.0;
const Z_P: Complex64 = Complex64::new(7.01, 0.0);
const Z_T: Complex64 = Complex64::new(0.47, 3.16);
const SIGMA_T_M: f64 = 1.7e-6;

fn contact() -> Contact {
    Contact::new(&AssumedConstants::default(), SIGMA_T_M).expect("physical constants")
}

/// 6 Hz at 95 %, as the published protocol drives the plate.
fn amplitude_m(time_s: f64) -> f64 {
    1.95e-6 * (1.0 + 0.95 * (TAU * 6.0 * time_s).sin())
}

fn normal_n(time_s: f64) -> f64 {
    0.65 + 0.03 * (TAU * 1.3 * time_s).cos()
}

/// Steady-state samples of one rising stretch; the fits take as long on them as on any.
struct Record {
    time_s: Vec<f64>,
    z_m: Vec<Complex64>,
    amplitude_m: Vec<f64>,
    normal_n: Vec<f64>,
    mu: Vec<f64>,
    lead: usize,
}

impl Record {
    fn at_rate(rate_hz: f64) -> Self {
        let contact = contact();
        let lead = (0.02 * rate_hz) as usize;
        let time_s: Vec<f64> = (0..lead + (0.06 * rate_hz) as usize)
            .map(|i| i as f64 / rate_hz - 0.05)
            .collect();
        let amplitude_m: Vec<f64> = time_s.iter().map(|&t| amplitude_m(t)).collect();
        let normal_n: Vec<f64> = time_s.iter().map(|&t| normal_n(t)).collect();
        let mut gap_m = vec![0.0; time_s.len()];
        contact
            .equilibrium_gaps_m(&amplitude_m, &normal_n, &mut gap_m)
            .expect("physical record");
        let z_m = gap_m
            .iter()
            .zip(&amplitude_m)
            .enumerate()
            .map(|(i, (&gap, &a))| {
                let z_c = contact
                    .impedance_n_s_per_m(contact.stiffness_n_per_m(gap, a), TAU * CARRIER_HZ);
                let ripple = Complex64::from_polar(0.01, i as f64);
                harmonic::observed(Z_P, Z_T, z_c) + ripple
            })
            .collect();
        let mu = gap_m
            .iter()
            .zip(&normal_n)
            .map(|(&gap, &n)| 0.8 * contact.friction_ratio(gap, n))
            .collect();
        Self {
            time_s,
            z_m,
            amplitude_m,
            normal_n,
            mu,
            lead,
        }
    }

    fn series(&self) -> InstanceSeries<'_> {
        let samples = Samples {
            time_s: &self.time_s,
            z_m_plain_n_s_per_m: &self.z_m,
            z_m_corrected_n_s_per_m: &self.z_m,
            amplitude_m: &self.amplitude_m,
            normal_n: &self.normal_n,
            mu: &self.mu,
        };
        InstanceSeries::new(samples, self.lead).expect("valid record")
    }
}

fn gaps(c: &mut Criterion) {
    const N: usize = 100_000;
    let contact = contact();
    let record: (Vec<f64>, Vec<f64>) = (0..N)
        .map(|i| i as f64 / 2000.0)
        .map(|t| (amplitude_m(t), normal_n(t)))
        .unzip();
    // The same samples in an order without neighbours: 48 271 is prime to N.
    let scattered: (Vec<f64>, Vec<f64>) = (0..N)
        .map(|i| i * 48_271 % N)
        .map(|i| (record.0[i], record.1[i]))
        .unzip();
    let mut gap_m = vec![0.0; N];
    for (name, (amplitude_m, normal_n)) in [
        ("100 000 gaps of a record", &record),
        ("100 000 gaps without order", &scattered),
    ] {
        c.bench_function(name, |b| {
            b.iter(|| {
                contact.equilibrium_gaps_m(black_box(amplitude_m), black_box(normal_n), &mut gap_m)
            });
        });
    }
    let k_c: Vec<f64> = gap_m
        .iter()
        .zip(&scattered.1)
        .map(|(&gap, &n)| contact.balance_stiffness_n_per_m(gap, n))
        .collect();
    c.bench_function("100 000 gaps from stiffness in balance", |b| {
        b.iter(|| contact.gaps_from_balance_stiffness(black_box(&k_c), 0.65, &mut gap_m));
    });
}

fn fits(c: &mut Criterion) {
    let conditions = FitConditions {
        assumed: AssumedConstants::default(),
        carrier_hz: CARRIER_HZ,
        z_p_plain_n_s_per_m: Z_P,
        z_p_corrected_n_s_per_m: Z_P,
    };
    let sixty = Record::at_rate(1000.0);
    c.bench_function("paper fit, 60 points", |b| {
        b.iter(|| {
            paper::fit(
                black_box(&sixty.series()),
                &conditions,
                &paper::Options::default(),
            )
        });
    });
    let at_frame_rate = Record::at_rate(2000.0);
    c.bench_function("dynamic fit, 120 points", |b| {
        b.iter(|| {
            dynamic::fit(
                black_box(&at_frame_rate.series()),
                &conditions,
                &dynamic::Options::default(),
            )
        });
    });
}

fn live(c: &mut Criterion) {
    let finger = FittedFinger::with_parameters(contact(), Z_T, 1e-3, Z_P, CARRIER_HZ)
        .expect("physical finger");
    let record = Record::at_rate(2000.0);
    let frames: Vec<Frame> = record
        .z_m
        .iter()
        .zip(&record.amplitude_m)
        .map(|(&z_m, &amplitude_m)| Frame {
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
