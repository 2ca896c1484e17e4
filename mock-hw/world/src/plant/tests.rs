//! Comparison of the plant with itself at finer steps.

use std::f64::consts::TAU;

use super::*;
use crate::scenario::ParticipantTable;

include!("../../tests/integration/fixture/ideal.rs");

#[test]
fn both_rates_give_the_same_motion_under_modulation() {
    let drive = |t: f64| 0.35 * (1.0 + 0.95 * (TAU * 6.0 * t).sin()) * (TAU * 35e3 * t).sin();
    let series = |rate_hz: f64, slow_step_s: f64| {
        let scenario = ideal();
        let fingertip = Fingertip::draw(&scenario, 1);
        let mut plant = Plant::build(scenario, fingertip, 1, rate_hz, slow_step_s);
        // Delayed by one generator latency at each rate.
        let latency_s = Plant::loop_latency_frames() as f64 * plant.interval_s;
        let mut out = Vec::new();
        let (mut samples, mut inputs) = (vec![0.0; 480], vec![0.0; 480 * 4]);
        for period in 0..(0.35 * rate_hz / 480.0) as usize {
            for (i, sample) in samples.iter_mut().enumerate() {
                let t = (period * 480 + i) as f64 * plant.interval_s;
                *sample = drive(t + latency_s) as f32;
            }
            plant.step(&samples, true, &SLIDING, &mut inputs);
            out.extend_from_slice(plant.truth());
        }
        out
    };
    let sample_at = |series: &[TruthSample], t: f64| -> (f64, f64) {
        let i = series.partition_point(|s| s.time_s <= t);
        let (a, b) = (&series[i - 1], &series[i]);
        let share = (t - a.time_s) / (b.time_s - a.time_s);
        (
            a.mu + share * (b.mu - a.mu),
            a.amplitude_m + share * (b.amplitude_m - a.amplitude_m),
        )
    };
    let reference = series(192e3, 2.5e-5);
    for (rate_hz, slow_step_s, limit) in
        [(192e3, 1e-4, 4e-4), (192e3, 5e-5, 1e-4), (96e3, 1e-4, 1e-3)]
    {
        let candidate = series(rate_hz, slow_step_s);
        let mut worst: f64 = 0.0;
        for i in 0..600 {
            let t = 0.02 + 5e-4 * f64::from(i);
            worst = worst.max((sample_at(&reference, t).0 - sample_at(&candidate, t).0).abs());
        }
        println!("{rate_hz} {slow_step_s} {worst:e}");
        assert!(
            worst < limit,
            "{rate_hz} Hz, step {slow_step_s}: friction differs by {worst:e}"
        );
    }
}
