//! The plant against closed forms: impedance, friction, levitation, amplifier gate, delays, periods and wiring.

use std::f64::consts::TAU;

use mock_world::person::FingerState;
use mock_world::plant::{InputWiring, Plant};
use mock_world::run_truth::TruthSample;
use mock_world::scenario::{FilmTable, Follows, ReferenceTable, Scenario};

use super::rig::{C, SLIDING, envelope, harmonic_impedance, ideal, measured_impedance, run};

#[test]
fn unloaded_impedance_from_samples_equals_the_closed_form() {
    for rate_hz in [192e3, 96e3, 88.2e3] {
        for carrier_hz in [34_900.0, 35_000.0, 35_100.0] {
            let mut plant = Plant::new(&ideal(), 1, rate_hz);
            let frames = run(
                &mut plant,
                |t| 0.7 * (TAU * carrier_hz * t).sin(),
                &FingerState::default(),
                0.1,
                rate_hz as usize / 100,
            );
            let measured = measured_impedance(&plant, &frames, carrier_hz);
            let omega = TAU * carrier_hz;
            let expected = harmonic_impedance(&ideal(), omega, C::from(0.0), C::from(1.0));
            let error = (measured - expected).norm() / expected.norm();
            assert!(
                error < 2e-5,
                "{rate_hz} Hz, {carrier_hz} Hz: {measured} {expected} {error:e}"
            );
        }
    }
}

#[test]
fn the_stated_impedance_at_resonance_is_the_closed_form() {
    for resonance_hz in [34_900.0, 35_000.0, 35_100.0] {
        let mut scenario = ideal();
        scenario.plate.resonance_hz = resonance_hz;
        let omega = scenario.plate.omega_rad_per_s();
        let expected = harmonic_impedance(&scenario, omega, C::from(0.0), C::from(1.0));
        let [re, im] = Plant::new(&scenario, 1, 192e3).constants().z_p_n_s_per_m;
        assert!((C::new(re, im) - expected).norm() / expected.norm() < 1e-12);
    }
}

/// Returns the forces of the asperities and of levitation at a gap, N (`Huloux 2021`, Eqs. 13–17).
fn film_forces(film: &FilmTable, sigma_m: f64, gap_m: f64, amplitude_m: f64) -> [f64; 2] {
    let modulus_pa = film.youngs_modulus_pa / (1.0 - film.poisson_ratio.powi(2));
    let asperity_pa = 0.375 * film.q0_rad_per_m * sigma_m * modulus_pa;
    let squeeze_pa = 1.25 * film.ambient_pressure_pa * (amplitude_m / gap_m).powi(2);
    [asperity_pa * (-gap_m / sigma_m).exp(), squeeze_pa].map(|pa| pa * film.contact_area_m2)
}

#[test]
fn loaded_steady_state_equals_the_harmonic_solution() {
    for rate_hz in [192e3, 96e3] {
        for level in [0.02, 0.1, 0.3, 0.7] {
            let carrier_hz = 35_000.0;
            let omega = TAU * carrier_hz;
            let mut plant = Plant::new(&ideal(), 1, rate_hz);
            let frames = run(
                &mut plant,
                |t| level * (TAU * carrier_hz * t).sin(),
                &SLIDING,
                0.1,
                rate_hz as usize / 100,
            );
            let measured = measured_impedance(&plant, &frames, carrier_hz);

            let truth = plant.truth().last().unwrap();
            let film = ideal().film;
            let forces = |gap_m| film_forces(&film, 1.7e-6, gap_m, truth.amplitude_m);
            let (mut low, mut gap_m) = (1e-7, 1e-3);
            for _ in 0..100 {
                let middle = 0.5 * (low + gap_m);
                let [asperity_n, squeeze_n] = forces(middle);
                if asperity_n + squeeze_n > 0.65 {
                    low = middle;
                } else {
                    gap_m = middle;
                }
            }
            assert!(
                (truth.gap_m / gap_m - 1.0).abs() < 1e-3,
                "{} {gap_m}",
                truth.gap_m
            );
            let [asperity_n, squeeze_n] = forces(gap_m);
            let k_c = asperity_n / 1.7e-6 + 2.0 * squeeze_n / gap_m;
            let z_c = C::new(0.3 * k_c / omega, -k_c / omega);
            let expected = harmonic_impedance(&ideal(), omega, z_c, C::new(0.47, 3.16));
            let error = (measured - expected).norm() / expected.norm();
            assert!(
                error < 5e-4,
                "{rate_hz} Hz, level {level}: {measured} {expected} {error:e}"
            );

            // The film's amplitude is that of the plate under the finger, not at the pickup.
            let pickup_m = envelope(frames.iter().map(|k| k[1]), carrier_hz / rate_hz).norm()
                * ideal().pickup.metres_per_unit;
            assert!(
                (truth.amplitude_m / pickup_m - 1.0).abs() < 0.01,
                "{} {pickup_m}",
                truth.amplitude_m
            );
        }
    }
}

/// Returns the truth after 60 ms of a constant carrier, with a constant finger.
fn settled_truth(level: f64, finger: &FingerState) -> TruthSample {
    let mut plant = Plant::new(&ideal(), 1, 192e3);
    run(
        &mut plant,
        |t| level * (TAU * 35e3 * t).sin(),
        finger,
        0.06,
        480,
    );
    *plant.truth().last().unwrap()
}

#[test]
fn friction_falls_with_the_drive_and_lateral_force_follows_the_motion() {
    let mut last = 0.8 + 1e-9;
    for level in [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8] {
        let truth = settled_truth(level, &SLIDING);
        assert!(truth.mu < last, "{} at {level}", truth.mu);
        assert!((truth.lateral_n - truth.mu * 0.65).abs() < 1e-3);
        last = truth.mu;
    }
    let still = settled_truth(0.0, &SLIDING);
    assert!(
        (still.mu - 0.8).abs() < 1e-6 && (still.k_c_n_per_m / (0.65 / 1.7e-6) - 1.0).abs() < 1e-6
    );
    let back = settled_truth(
        0.0,
        &FingerState {
            velocity_m_per_s: -0.05,
            ..SLIDING
        },
    );
    assert!((back.lateral_n + still.lateral_n).abs() < 1e-9);
}

#[test]
fn friction_builds_up_over_the_presliding_distance() {
    let mut plant = Plant::new(&ideal(), 1, 192e3);
    let mut inputs = [0.0; 192 * 4];
    let still = FingerState {
        velocity_m_per_s: 0.0,
        ..SLIDING
    };
    for _ in 0..20 {
        plant.step(&[0.0; 192], true, &still, &mut inputs);
    }
    for _ in 0..30 {
        plant.step(&[0.0; 192], true, &SLIDING, &mut inputs);
        for truth in plant.truth() {
            // Dahl's model from rest: 1 − exp(−travel/reach); the finger started within this millisecond.
            let share = truth.lateral_n / (0.8 * 0.65);
            let travelled_m = |since_s: f64| 0.05 * (truth.time_s - since_s);
            let bound = |m: f64| 1.0 - (-m / 0.3e-3).exp();
            let (low, high) = (bound(travelled_m(21e-3)), bound(travelled_m(20e-3)));
            assert!((low..=high).contains(&share), "{share} {low} {high}");
        }
    }
}

#[test]
fn a_finger_off_the_plate_touches_nothing() {
    let truth = settled_truth(
        0.7,
        &FingerState {
            touching: false,
            normal_n: 0.0,
            ..SLIDING
        },
    );
    assert_eq!(
        (truth.k_c_n_per_m, truth.normal_n, truth.lateral_n),
        (0.0, 0.0, 0.0)
    );
    assert!(truth.gap_m.is_nan() && truth.mu.is_nan());
    assert!(
        (2.2e-6..3.5e-6).contains(&truth.amplitude_m),
        "{}",
        truth.amplitude_m
    );
}

#[test]
fn the_gap_follows_a_step_of_amplitude_with_its_lag() {
    let mut scenario = ideal();
    scenario.film.lag_gap_exponent = 0.0;
    scenario.film.lag_s = 4e-3;
    // A plate so stiff that the finger does not change its amplitude.
    scenario.plate.damping_n_s_per_m = 701.0;
    scenario.plate.force_factor_n_per_v = 10.0;
    let mut plant = Plant::new(&scenario, 1, 192e3);
    let carrier = |n: usize, level: f64| (level * (TAU * 35e3 * n as f64 / 192e3).sin()) as f32;
    let mut inputs = [0.0; 192 * 4];
    let mut gaps = Vec::new();
    for ms in 0..120 {
        let level = if ms < 40 { 0.0 } else { 0.3 };
        let drive: Vec<f32> = (0..192).map(|i| carrier(ms * 192 + i, level)).collect();
        plant.step(&drive, true, &SLIDING, &mut inputs);
        gaps.extend(plant.truth().iter().map(|t| (t.time_s, t.gap_m)));
    }
    // Well after the plate's transient, the remaining gap decays as e^{−t/lag}.
    let settled_m = gaps[gaps.len() - 1].1;
    let decay: Vec<(f64, f64)> = gaps
        .into_iter()
        .filter(|(t, _)| (0.046..0.054).contains(t))
        .map(|(t, gap_m)| (t, settled_m - gap_m))
        .collect();
    assert!(decay.len() > 5);
    for pair in decay.windows(2) {
        let tau_s = (pair[1].0 - pair[0].0) / (pair[0].1 / pair[1].1).ln();
        assert!((tau_s / 4e-3 - 1.0).abs() < 0.05, "{tau_s}");
    }
}

#[test]
fn the_amplifier_gate_silences_plate_and_read_back_but_not_the_line_loop() {
    let mut plant = Plant::new(&ideal(), 1, 192e3);
    let drive: Vec<f32> = (0..1920)
        .map(|n| (0.5 * (TAU * 35e3 * f64::from(n) / 192e3).sin()) as f32)
        .collect();
    let mut inputs = vec![0.0f32; 1920 * 4];
    let peak = |inputs: &[f32], channel: usize| {
        inputs[1920 * 3..]
            .iter()
            .skip(channel)
            .step_by(4)
            .fold(0.0f32, |m, v| m.max(v.abs()))
    };
    plant.step(&drive, false, &FingerState::default(), &mut inputs);
    assert_eq!((peak(&inputs, 0), peak(&inputs, 1)), (0.0, 0.0));
    assert!(peak(&inputs, 2) > 0.49);
    plant.step(&drive, true, &FingerState::default(), &mut inputs);
    assert!((peak(&inputs, 0) - 0.5 * 40.0 * 0.985 / 50.0).abs() < 2e-3);
    assert!(peak(&inputs, 1) > 0.1);
    for _ in 0..40 {
        plant.step(&drive, false, &FingerState::default(), &mut inputs);
    }
    assert_eq!(peak(&inputs, 0), 0.0);
    assert!(peak(&inputs, 1) < 1e-6);
}

#[test]
fn the_line_loop_is_the_generator_a_fixed_number_of_frames_later() {
    let mut plant = Plant::new(&ideal(), 1, 192e3);
    let mut drive = [0.0f32; 64];
    drive[5] = 0.5;
    let mut inputs = [0.0f32; 64 * 4];
    plant.step(&drive, true, &FingerState::default(), &mut inputs);
    let line: Vec<f32> = inputs.iter().skip(2).step_by(4).copied().collect();
    for (n, &v) in line.iter().enumerate() {
        let expected = if n == 5 + Plant::loop_latency_frames() {
            0.5
        } else {
            0.0
        };
        assert!((v - expected).abs() < 1e-6, "{v} at {n}");
    }
}

#[test]
fn skew_and_phase_delay_their_channel_by_exactly_that() {
    let mut scenario = ideal();
    scenario.pickup.phase_rad = -0.4;
    scenario.converter.skew_samples = vec![0.3, 0.0, 0.7];
    let mut plant = Plant::new(&scenario, 1, 192e3);
    let straight = &mut Plant::new(&ideal(), 1, 192e3);
    let carrier = |t: f64| 0.5 * (TAU * 35e3 * t).sin();
    let skewed_frames = run(&mut plant, carrier, &FingerState::default(), 0.08, 1920);
    let plain_frames = run(straight, carrier, &FingerState::default(), 0.08, 1920);
    let cycles = 35e3 / 192e3;
    let turn = |channel: usize| {
        let tone = |k: &[[f64; 3]]| envelope(k.iter().map(|f| f[channel]), cycles);
        (tone(&skewed_frames) / tone(&plain_frames)).arg()
    };
    // Later sampling advances the phase; phase_rad lags it (0.2 in the plain bench).
    for (channel, expected) in [(0, TAU * cycles * 0.3), (1, 0.6), (2, TAU * cycles * 0.7)] {
        assert!(
            (turn(channel) - expected).abs() < 2e-5,
            "{channel}: {}",
            turn(channel)
        );
    }
}

#[test]
fn the_cut_into_periods_changes_nothing_and_the_seed_everything() {
    let drive: Vec<f32> = (0..1000)
        .map(|n| (0.5 * (f64::from(n) * 1.15).sin()) as f32)
        .collect();
    let render = |seed: u64, cut: usize| {
        let mut plant = Plant::new(&Scenario::default(), seed, 192e3);
        // Bring the finger to its constant state first, because it is interpolated over a period.
        plant.step(&[0.0], true, &SLIDING, &mut [0.0; 4]);
        let mut inputs = vec![0.0f32; 4000];
        let mut forces = Vec::new();
        for (d, i) in drive.chunks(cut).zip(inputs.chunks_mut(cut * 4)) {
            plant.step(d, true, &SLIDING, i);
            forces.extend_from_slice(plant.forces());
        }
        (inputs, forces)
    };
    let whole = render(1, 1000);
    for cut in [1, 7, 192] {
        assert_eq!(render(1, cut), whole, "cut {cut}");
    }
    assert_ne!(render(2, 1000).0, whole.0);
}

#[test]
fn time_goes_on_when_the_rate_changes_and_samples_come_when_they_are_due() {
    let mut plant = Plant::new(&ideal(), 1, 192e3);
    let mut end_s = 0.0;
    let mut times = Vec::new();
    for rate_hz in [192e3, 96e3, 192e3] {
        plant.set_rate(rate_hz, Vec::new());
        for _ in 0..20 {
            plant.step(&[0.0; 96], true, &SLIDING, &mut [0.0; 96 * 4]);
            end_s += 96.0 / rate_hz;
            assert!(plant.forces().iter().all(|s| s.time_s <= end_s + 1e-12));
            times.extend(plant.forces().iter().map(|s| s.time_s));
        }
    }
    assert!(end_s - times[times.len() - 1] < 3e-4);
    assert!(times.windows(2).all(|w| (w[1] - w[0] - 1e-4).abs() < 1e-7));
}

#[test]
fn the_dac_clips_and_makes_nothing_of_nan() {
    let line = |bad: f32| {
        let mut plant = Plant::new(&ideal(), 1, 192e3);
        let mut drive = [0.0f32; 64];
        drive[5] = bad;
        let mut inputs = [0.0f32; 64 * 4];
        plant.step(&drive, true, &FingerState::default(), &mut inputs);
        assert!(inputs.iter().all(|v| v.is_finite()));
        inputs[4 * (5 + Plant::loop_latency_frames()) + 2]
    };
    for (bad, expected) in [(f32::NAN, 0.0), (f32::INFINITY, 1.0), (-3.0, -1.0)] {
        assert!((line(bad) - expected).abs() < 1e-6);
    }
}

#[test]
fn a_patched_signal_reaches_the_inputs_and_not_the_plate() {
    const RATE_HZ: f64 = 192e3;
    let mut scenario = ideal();
    scenario.converter.skew_samples = vec![0.0, 0.4, -1.3];
    scenario.converter.gains = vec![1.0, 0.5, 1.0, -1.0];
    let mut plant = Plant::new(&scenario, 1, RATE_HZ);
    let channels = plant.channels();
    // 400 frames hold a whole number of cycles.
    let turn = TAU * 73.0 / 400.0;
    let drive: Vec<f32> = (0..4_000)
        .map(|n| (0.5 * (turn * f64::from(n)).sin()) as f32)
        .collect();
    let mut inputs = vec![0.0f32; drive.len() * channels];
    let mut tones_with = |wiring| {
        plant.wire(wiring);
        plant.step(&drive, true, &FingerState::default(), &mut inputs);
        let tone = |channel: usize| {
            let tail = inputs.chunks_exact(channels).skip(2_000);
            tail.enumerate().fold(C::new(0.0, 0.0), |sum, (n, frame)| {
                let phase = C::from_polar(1.0, -turn * n as f64);
                sum + phase * f64::from(frame[channel]) / 1_000.0
            })
        };
        let tones = [0, 1, 2, 3].map(tone);
        (tones, plant.truth().last().map(|truth| truth.amplitude_m))
    };
    let (all_inputs, amplitude_m) = tones_with(InputWiring::AllInputs);
    assert_eq!(amplitude_m, Some(0.0));
    for (channel, gain, skew) in [(1, 0.5, 0.4), (2, 1.0, -1.3), (3, -1.0, 0.0)] {
        let expected = gain * C::from_polar(1.0, turn * skew);
        let error = (all_inputs[channel] / all_inputs[0] - expected).norm();
        assert!(error < 1e-5, "{channel}: off by {error}");
    }
    let (drive_only, _) = tones_with(InputWiring::DriveOnly);
    assert!((drive_only[0] / all_inputs[0] - 1.0).norm() < 1e-6);
    assert!(drive_only[1..].iter().all(|tone| tone.norm() < 1e-8));
    let (bench, amplitude_m) = tones_with(InputWiring::Bench);
    assert!((bench[0] / all_inputs[0] - 1.0).norm() < 1e-6);
    assert!(amplitude_m.is_some_and(|amplitude_m| amplitude_m > 1e-7));
}

#[test]
fn a_vibrometer_on_an_input_follows_the_plate_with_its_own_delay_and_sensitivity() {
    let omega = TAU * 35e3;
    // Ratio of pickup and vibrometer, as complex envelopes in metres.
    let ratio = |follows: Follows, delay_s: f64, skew: f64| {
        let mut scenario = ideal();
        scenario.plate.second_mode.pickup_ratio = scenario.plate.second_mode.contact_ratio;
        scenario.pickup.phase_rad = 0.0;
        scenario.converter.skew_samples = vec![0.0, 0.0, 0.0, skew];
        scenario.reference = ReferenceTable {
            follows,
            per_volt: if follows == Follows::Velocity {
                0.5
            } else {
                2e-6
            },
            volts_per_unit: 4.0,
            delay_s,
            noise_v: 0.0,
        };
        let mut plant = Plant::new(&scenario, 1, 192e3);
        let drive: Vec<f32> = (0..15_360u32)
            .map(|n| (0.5 * (TAU * 35e3 * f64::from(n) / 192e3).sin()) as f32)
            .collect();
        let mut inputs = vec![0.0; drive.len() * plant.channels()];
        plant.step(&drive, true, &FingerState::default(), &mut inputs);
        let tone = |channel: usize| {
            let values = inputs.iter().skip(channel).step_by(4).skip(13_440);
            envelope(values.map(|&value| f64::from(value)), 35e3 / 192e3)
        };
        let displacement =
            tone(3) * scenario.reference.per_volt * scenario.reference.volts_per_unit;
        displacement / (tone(1) * scenario.pickup.metres_per_unit)
    };
    for (delay_s, skew) in [(0.0, 0.0), (6.3e-6, 0.0), (2e-5, 0.7)] {
        let turn = C::from_polar(1.0, omega * (skew / 192e3 - delay_s));
        let displacement = ratio(Follows::Displacement, delay_s, skew) / turn;
        assert!((displacement - 1.0).norm() < 1e-3, "{displacement}");
        let velocity = ratio(Follows::Velocity, delay_s, skew) / (turn * C::new(0.0, omega));
        assert!((velocity - 1.0).norm() < 1e-3, "{velocity}");
    }
}
