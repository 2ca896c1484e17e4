//! One exploration of the published protocol: a person on a modulated plate, without a bench.

use std::f64::consts::TAU;

use mock_world::person::{PerceivedInstruction, Percept, VirtualPerson};
use mock_world::plant::{Plant, SensorSample};
use mock_world::run_truth::TruthSample;
use mock_world::scenario::{Scenario, built_in};

const RATE_HZ: f64 = 192e3;
const PERIOD: usize = 384;
/// Mean of the envelope, actuator volts: 3.9 µm at the crest of an unloaded nominal plate.
const MEAN_V: f64 = 24.0;

struct Exploration {
    truth: Vec<TruthSample>,
    forces: Vec<SensorSample>,
    /// Largest magnitude of drive read-back and pickup.
    peaks: [f32; 2],
}

fn explore(scenario: &Scenario, seed: u64) -> Exploration {
    let mean_level = MEAN_V / scenario.amplifier.volts_per_unit;
    let mut plant = Plant::new(scenario, seed, RATE_HZ);
    let mut person = VirtualPerson::draw(&scenario.participant, seed);
    let mut out = Exploration {
        truth: Vec::new(),
        forces: Vec::new(),
        peaks: [0.0; 2],
    };
    let (mut drive, mut inputs) = ([0.0f32; PERIOD], [0.0f32; PERIOD * 4]);
    let dt_s = PERIOD as f64 / RATE_HZ;
    // 4 s to place the finger, then 1.7 s at 50 mm/s.
    for period in 0..(5.7 / dt_s) as usize {
        let t_s = period as f64 * dt_s;
        let percept = Percept {
            instruction: if t_s < 4.0 {
                PerceivedInstruction::PlaceFinger
            } else {
                PerceivedInstruction::FollowSlider
            },
            slider_m: Some(0.01 + 0.05 * (t_s - 4.0).max(0.0)),
            force_band_n: Some((0.5, 0.8)),
            ..Percept::default()
        };
        let act = person.step(t_s, dt_s, &percept);
        for (i, sample) in drive.iter_mut().enumerate() {
            let t = t_s + i as f64 / RATE_HZ;
            let envelope = mean_level * (1.0 + 0.95 * (TAU * 6.0 * t).sin());
            *sample = (envelope * (TAU * 35e3 * t).sin()) as f32;
        }
        plant.step(&drive, true, &act.finger, &mut inputs);
        out.truth.extend_from_slice(plant.truth());
        out.forces.extend_from_slice(plant.forces());
        for frame in inputs.chunks(4) {
            for (peak, sample) in out.peaks.iter_mut().zip(frame) {
                *peak = peak.max(sample.abs());
            }
        }
    }
    out
}

fn sliding_samples(truth: &[TruthSample]) -> Vec<&TruthSample> {
    truth
        .iter()
        .filter(|t| t.time_s > 4.0 && (0.0225..0.0825).contains(&t.position_m))
        .collect()
}

#[test]
fn the_published_drive_modulates_the_friction_of_the_nominal_person_without_clipping() {
    let nominal = built_in("nominal").unwrap();
    let run = explore(&nominal, 1);
    assert!(
        run.peaks.iter().all(|p| (0.6..0.9).contains(p)),
        "{:?}",
        run.peaks
    );

    let samples = sliding_samples(&run.truth);
    let range = |f: fn(&TruthSample) -> f64| {
        samples.iter().fold((f64::MAX, f64::MIN), |(low, high), t| {
            (low.min(f(t)), high.max(f(t)))
        })
    };
    let (least_m, most_m) = range(|t| t.amplitude_m);
    assert!(
        least_m < 0.2e-6 && (3e-6..4e-6).contains(&most_m),
        "{least_m:e} {most_m:e}"
    );
    let (least_mu, most_mu) = range(|t| t.mu / t.mu0);
    assert!(least_mu < 0.02 && most_mu > 0.95, "{least_mu} {most_mu}");
    let (least_k, most_k) = range(|t| t.k_c_n_per_m);
    assert!(most_k / least_k > 3.0, "{least_k:e} {most_k:e}");
    assert!(samples.iter().all(|t| (0.3..1.1).contains(&t.normal_n)));
}

#[test]
fn the_force_sensor_reads_the_friction_that_is_true() {
    let run = explore(&Scenario::default(), 3);
    let mut squares = Vec::new();
    for truth in sliding_samples(&run.truth) {
        let i = run.forces.partition_point(|s| s.time_s < truth.time_s);
        let (lateral_n, normal_n) = run.forces[i..i + 10]
            .iter()
            .fold((0.0, 0.0), |(l, n), s| (l + s.lateral_n, n + s.normal_n));
        squares.push((lateral_n / normal_n - truth.mu).powi(2));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // Noise of 2 mN over ten samples, and averaging over 1 ms on a slope of up to 40 /s.
    assert!(rms < 0.02, "{rms}");
}

#[test]
fn many_people_on_many_benches_stay_finite() {
    let mut unknown = Scenario::default();
    unknown.jitter.enabled = true;
    let mut unkind = built_in("population-unkind").unwrap();
    unkind.jitter.enabled = true;
    let (unknown, unkind) = ([&unknown; 4], [&unkind; 4]);
    for (seed, scenario) in (0..).zip(unknown.into_iter().chain(unkind)) {
        let run = explore(scenario, seed);
        assert!(run.peaks.iter().all(|p| p.is_finite() && *p > 0.1));
        let samples = sliding_samples(&run.truth);
        assert!(samples.len() > 800, "{}", samples.len());
        for t in samples {
            assert!(t.amplitude_m.is_finite() && t.amplitude_m < 10e-6);
            assert!(
                t.normal_n == 0.0 || (0.5e-6..1e-3).contains(&t.gap_m),
                "{t:?}"
            );
        }
    }
}
