//! Demodulation, gap solutions and a fit compared with numpy and scipy in the same run. `./dev bench --vs-python` names the
//! Python and prints the ratios; without Python only this crate is measured.

#![expect(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a benchmark against another program starts it and is told where it is; the library does not"
)]

mod record;

use std::f64::consts::TAU;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use estimation::paper;
use impedance::{
    ChannelScales, Demodulator, Filter, FilterSettings, InputChannel, PlateConstants, Zm, ZmFrame,
};
use record::{CARRIER_HZ, Record, fit_trial};
use statistics::median;

const RATE_HZ: u32 = 192_000;
const SECONDS: u32 = 60;
const GAPS: usize = 100_000;

/// Largest relative difference between two answers to the same problem.
const AGREEMENT: f64 = 1e-3;
/// The same for `trial`: the Python fits ignore the correlation of the residuals, and one of them fixes the extensions of the
/// published laws at zero, while this crate fits them against their priors.
const TRIAL_AGREEMENT: f64 = 0.02;

/// Set to 1, these variables limit numpy's linear algebra to one core, which this crate uses too. With more threads than idle
/// cores numpy takes up to eight times as long.
const ONE_THREAD: [&str; 3] = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"];

/// Measures `rivals.py NAME` if Python is available; `answer` is the result of this crate.
fn rival(group: &mut BenchmarkGroup<'_, WallTime>, label: &str, name: &str, answer: f64) {
    rival_with_tolerance(group, label, name, (answer, AGREEMENT));
}

fn rival_with_tolerance(
    group: &mut BenchmarkGroup<'_, WallTime>,
    label: &str,
    name: &str,
    (answer, tolerance): (f64, f64),
) {
    let Some(python) = std::env::var_os("FRICTION_BENCH_PYTHON") else {
        return;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/rivals.py");
    group.bench_function(label, |bencher| {
        bencher.iter_custom(|iterations| {
            let output = Command::new(&python)
                .arg(&script)
                .arg(name)
                .arg(iterations.to_string())
                .envs(ONE_THREAD.map(|name| (name, "1")))
                .output()
                .expect("the Python that FRICTION_BENCH_PYTHON names");
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            let text = String::from_utf8_lossy(&output.stdout);
            let mut numbers = text
                .split_whitespace()
                .map(|number| number.parse::<f64>().expect("a number"));
            let (seconds, rival_answer) = (numbers.next(), numbers.next());
            let rival_answer = rival_answer.expect("an answer");
            assert!(
                (rival_answer / answer - 1.0).abs() < tolerance,
                "{name} comes to {rival_answer}, ours to {answer}"
            );
            Duration::from_secs_f64(seconds.expect("seconds"))
        });
    });
}

fn signals() -> Vec<f32> {
    (0..SECONDS * RATE_HZ)
        .flat_map(|n| {
            let t_s = f64::from(n) / f64::from(RATE_HZ);
            let envelope = 1.0 + 0.95 * (TAU * 6.0 * t_s).sin();
            let (sin, cos) = (TAU * CARRIER_HZ * t_s).sin_cos();
            [(0.4 * envelope * sin) as f32, (0.3 * envelope * cos) as f32]
        })
        .collect()
}

fn demodulation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("demodulate 60 s of 2 x 192 kHz to Z_m");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(u64::from(SECONDS * RATE_HZ)));
    let samples = signals();
    let settings = FilterSettings {
        sample_rate_hz: RATE_HZ,
        carrier_hz: CARRIER_HZ,
        output_rate_hz: 2000,
    };
    let filter = Filter::new(settings).expect("rates that go together");
    let plate = PlateConstants {
        resonance_hz: CARRIER_HZ,
        modal_mass_kg: 0.008,
        force_factor_n_per_v: 0.13,
    };
    let channels = ChannelScales {
        drive_volts_per_unit: 60.0,
        pickup_metres_per_unit: 5e-6,
        pickup_phase_rad: 0.0,
    };
    let zm = Zm::new(plate, channels, &filter).expect("positive constants");
    let input = |channel| InputChannel {
        channel,
        clip_level: 1.0,
    };
    let demodulate = |sink: &mut dyn FnMut(ZmFrame)| {
        let mut demodulator = Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(1))
            .expect("two channels");
        for block in samples.chunks(8192) {
            demodulator
                .push(block, |frame| sink(zm.read(frame)))
                .expect("whole frames");
        }
    };
    group.bench_function("this bench", |bencher| {
        bencher.iter(|| {
            demodulate(&mut |frame| {
                black_box(frame);
            })
        });
    });
    let mut plain_n_s_per_m = Vec::new();
    demodulate(&mut |frame| plain_n_s_per_m.push(frame.plain_n_s_per_m.norm()));
    plain_n_s_per_m.retain(|z| z.is_finite());
    let plain_n_s_per_m = median(plain_n_s_per_m).expect("frames");
    rival(&mut group, "scipy hilbert", "hilbert", plain_n_s_per_m);
    let mut corrected_n_s_per_m = Vec::new();
    demodulate(&mut |frame| corrected_n_s_per_m.push(frame.corrected_n_s_per_m.norm()));
    corrected_n_s_per_m.retain(|z| z.is_finite());
    let corrected_n_s_per_m = median(corrected_n_s_per_m).expect("frames");
    rival(&mut group, "numpy lock-in", "lock_in", corrected_n_s_per_m);
    group.finish();
}

fn gaps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("100 000 equilibrium gaps");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(GAPS as u64));
    let contact = record::contact();
    let amplitude_m: Vec<f64> = (0..GAPS)
        .map(|i| 0.05e-6 + 3.85e-6 * i as f64 / (GAPS - 1) as f64)
        .collect();
    let normal_n = vec![0.65; GAPS];
    let mut gap_m = vec![0.0; GAPS];
    group.bench_function("this bench", |bencher| {
        bencher.iter(|| {
            contact
                .equilibrium_gaps_m(black_box(&amplitude_m), &normal_n, &mut gap_m)
                .expect("physical record");
        });
    });
    let mean_m = gap_m.iter().sum::<f64>() / GAPS as f64;
    rival(&mut group, "numpy newton", "newton", mean_m);
    rival(&mut group, "scipy brentq", "brentq", mean_m);
    group.finish();
}

fn fit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("paper fit of 60 points");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    let conditions = record::conditions();
    let record = Record::at_rate(1000.0);
    let work = || {
        paper::fit(
            black_box(&record.series()),
            &conditions,
            &paper::PaperOptions::default(),
        )
        .expect("an instance that the model allows")
    };
    group.bench_function("this bench", |bencher| bencher.iter(work));
    let sigma_t_m = work().sigma_t_m;
    rival(
        &mut group,
        "scipy least_squares",
        "least_squares",
        sigma_t_m,
    );
    group.finish();
}

fn trial_fit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("trial fit of 14 instances");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    let records = Record::trial(14);
    let work = || fit_trial(black_box(&records));
    group.bench_function("this bench", |bencher| bencher.iter(work));
    let instances = work().instances;
    let mean_m = instances
        .iter()
        .map(|instance| instance.sigma_t_m)
        .sum::<f64>()
        / instances.len() as f64;
    for (label, name) in [
        ("scipy least_squares", "trial_all_laws"),
        (
            "scipy least_squares, published laws alone",
            "trial_least_squares",
        ),
    ] {
        rival_with_tolerance(&mut group, label, name, (mean_m, TRIAL_AGREEMENT));
    }
    group.finish();
}

criterion_group!(benches, demodulation, gaps, fit, trial_fit);
criterion_main!(benches);
