//! Built-in scenarios that break one law each.

use std::f64::consts::TAU;

use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthSample;
use mock_world::scenario::{Scenario, built_in, built_in_names};

use super::rig::SLIDING;

/// Returns a scenario without noise and drift of the skin, so that it differs from another only by its law.
fn quiet_scenario(name: &str) -> Scenario {
    let mut scenario = built_in(name).unwrap();
    scenario.participant.moisture.relative_sd = 0.0;
    scenario.converter.noise_units_per_sqrt_hz = 0.0;
    scenario.force_sensor.noise_n = 0.0;
    scenario
}

/// One third of a second of the published drive under a sliding finger.
struct Run {
    truth: Vec<TruthSample>,
    pickup: Vec<f32>,
    lateral_n: Vec<f64>,
}

fn run(name: &str) -> Run {
    let mut plant = Plant::new(&quiet_scenario(name), 1, 96e3);
    let (mut drive, mut inputs) = (vec![0.0; 960], vec![0.0; 960 * 4]);
    let mut out = Run {
        truth: Vec::new(),
        pickup: Vec::new(),
        lateral_n: Vec::new(),
    };
    for period in 0..33 {
        for (i, sample) in drive.iter_mut().enumerate() {
            let t = f64::from(period * 960 + i as u32) / 96e3;
            let envelope = 0.4 * (1.0 - 0.95 * (TAU * 6.0 * t).cos());
            *sample = (envelope * (TAU * 35e3 * t).sin()) as f32;
        }
        let normal_n = 0.65 + 0.003 * f64::from(period);
        plant.step(
            &drive,
            true,
            &FingerState {
                normal_n,
                ..SLIDING
            },
            &mut inputs,
        );
        out.truth.extend_from_slice(plant.truth());
        out.pickup.extend(inputs.chunks(4).map(|frame| frame[1]));
        out.lateral_n
            .extend(plant.forces().iter().map(|read| read.lateral_n));
    }
    // The finger lands in the first period.
    out.truth.drain(..20);
    out
}

/// Returns the least and greatest value of a true quantity.
fn extremes(run: &Run, value: fn(&TruthSample) -> f64) -> (f64, f64) {
    run.truth
        .iter()
        .map(value)
        .fold((f64::MAX, f64::MIN), |(low, high), value| {
            (low.min(value), high.max(value))
        })
}

#[test]
fn each_broken_law_reaches_the_pickup_or_the_friction_and_nothing_leaves_the_finite() {
    let nominal = run("nominal");
    for name in built_in_names()
        .iter()
        .filter(|name| name.starts_with("laws/"))
    {
        let broken = run(name);
        assert!(
            broken.pickup.iter().all(|v| v.is_finite() && v.abs() < 1.0),
            "{name}"
        );
        for truth in &broken.truth {
            assert!((0.2e-6..100e-6).contains(&truth.gap_m), "{name}: {truth:?}");
            assert!(
                truth.k_c_n_per_m > 0.0 && truth.mu >= 0.0,
                "{name}: {truth:?}"
            );
        }
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = values.fold((0.0, 0u32), |(sum, n), v| (sum + v * v, n + 1));
            (sum / f64::from(n)).sqrt()
        };
        let pickups = broken.pickup.iter().zip(&nominal.pickup);
        let pickup_rms = rms(&mut pickups.map(|(a, b)| f64::from(a - b)));
        let forces = broken.lateral_n.iter().zip(&nominal.lateral_n);
        let pulled_n = rms(&mut forces.map(|(a, b)| a - b));
        println!("{name}: {pickup_rms:.5} {pulled_n:.4} N");
        if name.starts_with("laws/friction") {
            assert!(
                pickup_rms == 0.0 && pulled_n > 5e-3,
                "{name}: {pickup_rms} {pulled_n} N"
            );
        } else {
            assert!(pickup_rms > 5e-4, "{name}: {pickup_rms} {pulled_n} N");
        }
    }
}

#[test]
fn asperities_of_limited_height_let_go_altogether() {
    let (nominal, gaussian) = (run("nominal"), run("laws/asperities-gaussian"));
    assert!(extremes(&nominal, |t| t.mu).0 > 0.0);
    assert_eq!(extremes(&gaussian, |t| t.mu).0, 0.0);
    // The stiffness at rest is about the published one.
    let ratio = extremes(&gaussian, |t| t.k_c_n_per_m).1 / extremes(&nominal, |t| t.k_c_n_per_m).1;
    assert!((0.8..1.3).contains(&ratio), "{ratio}");
}

#[test]
fn an_attraction_lowers_the_finger_and_a_leak_too() {
    let nominal = run("nominal");
    let (least_m, most_m) = extremes(&nominal, |t| t.gap_m);
    let (stuck_m, _) = extremes(&run("laws/adhesion"), |t| t.gap_m);
    assert!(stuck_m < least_m, "{stuck_m:e} {least_m:e}");
    let (rest_m, leaked_m) = extremes(&run("laws/film-leaks"), |t| t.gap_m);
    assert!(
        leaked_m < 0.95 * most_m && rest_m > 0.98 * least_m,
        "{leaked_m:e} {most_m:e}"
    );
}

#[test]
fn lag_and_tissue_follow_gap_and_force() {
    for truth in &run("laws/lag-gap-dependent").truth {
        assert!(
            (truth.lag_s / (1e-3 * truth.gap_m / 10e-6) - 1.0).abs() < 1e-9,
            "{truth:?}"
        );
    }
    for truth in &run("laws/tissue-force").truth {
        let factor = truth.normal_n.powf(0.4);
        assert!(
            (truth.z_t_n_s_per_m[1] / (3.16 * factor) - 1.0).abs() < 1e-9,
            "{truth:?}"
        );
    }
}
