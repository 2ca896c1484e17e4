//! Effects by which plate and finger deviate from the published model, one at a time.

use std::f64::consts::TAU;

use mock_world::fingertip::{Fingertip, Pad};
use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthSample;
use mock_world::scenario::{DriftTable, Scenario};

use super::rig::{C, SLIDING, harmonic_impedance, ideal, measured_impedance, run};

const CARRIER_HZ: f64 = 35_000.0;

/// Returns a carrier of constant amplitude.
fn carrier(level: f64) -> impl Fn(f64) -> f64 {
    move |t| level * (TAU * CARRIER_HZ * t).sin()
}

/// Returns the truth at the end of `seconds` of a constant carrier.
fn truth_after(scenario: &Scenario, level: f64, finger: &FingerState, seconds: f64) -> TruthSample {
    let mut plant = Plant::new(scenario, 1, 96e3);
    run(&mut plant, carrier(level), finger, seconds, 480);
    *plant.truth().last().unwrap()
}

/// Requires Z_p from the samples to equal that of a plate with the true resonance and damping, to `tolerance`, N·s/m;
/// 0.1 N·s/m correspond to 1 Hz.
fn requires_plate_of_the_truth(
    plant: &mut Plant,
    scenario: &Scenario,
    tolerance: f64,
) -> TruthSample {
    let frames = run(plant, carrier(0.7), &FingerState::default(), 0.1, 1920);
    let truth = *plant.truth().last().unwrap();
    let mut shifted_scenario = scenario.clone();
    let hz = scenario.plate.resonance_hz;
    shifted_scenario.plate.resonance_hz += truth.resonance_shift_hz;
    shifted_scenario.plate.second_mode.resonance_hz *= 1.0 + truth.resonance_shift_hz / hz;
    let damping = truth.damping_n_s_per_m / scenario.plate.damping_n_s_per_m;
    shifted_scenario.plate.damping_n_s_per_m *= damping;
    shifted_scenario.plate.second_mode.quality /=
        damping * hz / shifted_scenario.plate.resonance_hz;
    let expected = harmonic_impedance(
        &shifted_scenario,
        TAU * CARRIER_HZ,
        C::from(0.0),
        C::from(1.0),
    );
    let measured = measured_impedance(plant, &frames, CARRIER_HZ);
    let error = (measured - expected).norm();
    assert!(error < tolerance, "{measured} {expected}: off by {error:e}");
    truth
}

#[test]
fn the_room_moves_the_free_plate_at_its_rate() {
    let mut scenario = ideal();
    scenario.plate.drift.room_hz_per_min = 3.0;
    scenario.plate.drift.room_damping_per_min = 0.05;
    let mut plant = Plant::new(&scenario, 1, 192e3);
    run(&mut plant, |_| 0.0, &FingerState::default(), 3.9, 480);
    let truth = requires_plate_of_the_truth(&mut plant, &scenario, 1e-3);
    assert!((truth.resonance_shift_hz - 0.2).abs() < 1e-3, "{truth:?}");
    let damping = 7.01 * (0.05 * 4.0 / 60.0f64).exp();
    assert!(
        (truth.damping_n_s_per_m - damping).abs() < 1e-3,
        "{truth:?}"
    );
}

#[test]
fn a_finger_warms_the_plate_while_it_touches_and_the_plate_cools_after() {
    let mut scenario = ideal();
    scenario.plate.drift = DriftTable {
        warmth_hz: -10.0,
        warmth_damping: 0.1,
        warmth_time_s: 1.0,
        ..DriftTable::default()
    };
    let mut plant = Plant::new(&scenario, 1, 192e3);
    run(&mut plant, carrier(0.1), &SLIDING, 1.0, 480);
    let warm = *plant.truth().last().unwrap();
    let share = 1.0 - (-1.0f64).exp();
    assert!(
        (warm.resonance_shift_hz + 10.0 * share).abs() < 0.05,
        "{warm:?}"
    );
    assert!((warm.damping_n_s_per_m / 7.01 - 1.0 - 0.1 * share).abs() < 1e-3);
    // The samples cover the 10 ms before the truth, in which it cools by 0.06 Hz.
    let cooling_truth = requires_plate_of_the_truth(&mut plant, &scenario, 6e-3);
    assert!(cooling_truth.resonance_shift_hz > 0.92 * warm.resonance_shift_hz);
    // A reopened card finds the plate still warm.
    plant.set_rate(96e3, Vec::new());
    run(&mut plant, carrier(0.1), &FingerState::default(), 0.02, 480);
    let reopened_shift_hz = plant.truth().last().unwrap().resonance_shift_hz;
    assert!(
        (reopened_shift_hz / cooling_truth.resonance_shift_hz - 0.98).abs() < 0.01,
        "{reopened_shift_hz}"
    );
}

#[test]
fn the_amplitude_pulls_the_resonance() {
    let mut scenario = ideal();
    scenario.plate.drift.amplitude_hz_per_um2 = -0.5;
    let mut plant = Plant::new(&scenario, 1, 192e3);
    let truth = requires_plate_of_the_truth(&mut plant, &scenario, 1e-3);
    let um2 = (1e6 * truth.amplitude_m).powi(2);
    assert!(
        um2 > 3.0 && (truth.resonance_shift_hz / um2 + 0.5).abs() < 0.01,
        "{truth:?}"
    );
}

#[test]
fn the_amplitude_under_the_finger_follows_the_profile_along_the_plate() {
    let mut scenario = ideal();
    scenario.plate.end_drop = 0.1;
    scenario.plate.end_tilt = -0.05;
    // A plate of one mode, so stiff that the finger does not change its amplitude.
    scenario.plate.damping_n_s_per_m = 701.0;
    scenario.plate.force_factor_n_per_v = 10.0;
    scenario.plate.second_mode.contact_ratio = 0.0;
    let truth_at = |position_m: f64| {
        truth_after(
            &scenario,
            0.3,
            &FingerState {
                position_m,
                ..SLIDING
            },
            0.03,
        )
    };
    let middle = truth_at(0.0525);
    assert_eq!(middle.amplitude_ratio, 1.0);
    for (position_m, ratio) in [(0.0, 0.95), (0.02625, 1.0), (0.105, 0.85)] {
        let truth = truth_at(position_m);
        assert!(
            (truth.amplitude_ratio - ratio).abs() < 1e-12,
            "{position_m}: {truth:?}"
        );
        let measured = truth.amplitude_m / middle.amplitude_m;
        assert!(
            (measured / ratio - 1.0).abs() < 5e-3,
            "{position_m}: {measured} {ratio}"
        );
    }
}

#[test]
fn at_a_node_of_the_second_mode_the_finger_does_not_feel_it() {
    let mut scenario = ideal();
    scenario.plate.second_mode.resonance_hz = 35_800.0;
    scenario.plate.second_mode.half_waves = 2.0;
    let impedance = |contact_ratio: Option<f64>, position_m: f64| {
        let mut scenario = scenario.clone();
        if let Some(ratio) = contact_ratio {
            scenario.plate.second_mode.half_waves = 0.0;
            scenario.plate.second_mode.contact_ratio = ratio;
        }
        let mut plant = Plant::new(&scenario, 1, 192e3);
        let finger = FingerState {
            position_m,
            ..SLIDING
        };
        let frames = run(&mut plant, carrier(0.1), &finger, 0.06, 1920);
        measured_impedance(&plant, &frames, CARRIER_HZ)
    };
    // cos(π·2·(x/L − ½)): 1 in the middle, 0 at a quarter, −1 at the end.
    for (position_m, ratio) in [(0.0525, 0.8), (0.02625, 0.0), (0.0, -0.8)] {
        let error = (impedance(None, position_m) - impedance(Some(ratio), position_m)).norm();
        assert!(error < 1e-6, "{position_m}: {error:e}");
    }
    assert!((impedance(Some(0.8), 0.05) - impedance(Some(-0.8), 0.05)).norm() > 0.05);
}

#[test]
fn the_contact_area_grows_with_the_force_by_its_power() {
    let mut scenario = ideal();
    scenario.film.contact_area_m2 = 150e-6;
    scenario.film.area_force_exponent = 0.5;
    for normal_n in [0.16, 0.64, 2.56f64] {
        let truth = truth_after(
            &scenario,
            0.0,
            &FingerState {
                normal_n,
                ..SLIDING
            },
            0.02,
        );
        let area_m2 = 150e-6 * normal_n.sqrt();
        assert!((truth.contact_area_m2 / area_m2 - 1.0).abs() < 1e-12);
        // σ_t ln(p_c S/f) with p_c = 0.375 q0 σ_t E/(1 − ν²).
        let carried_n = 0.375 * 1.4e4 * 1.7e-6 * 20e6 / 0.75 * area_m2;
        let gap_m = 1.7e-6 * (carried_n / normal_n).ln();
        assert!(
            (truth.gap_m / gap_m - 1.0).abs() < 1e-6,
            "{truth:?} {gap_m:e}"
        );
    }
}

#[test]
fn friction_keeps_its_floor_however_high_the_finger_floats() {
    let mut scenario = ideal();
    let without_floor = truth_after(&scenario, 0.9, &SLIDING, 0.04);
    assert!(
        without_floor.mu < 0.02 * without_floor.mu0,
        "{without_floor:?}"
    );
    scenario.friction.floor = 0.15;
    let with_floor = truth_after(&scenario, 0.9, &SLIDING, 0.04);
    let expected = 0.15 + 0.85 * without_floor.mu / without_floor.mu0;
    assert!(
        (with_floor.mu / with_floor.mu0 - expected).abs() < 1e-9,
        "{with_floor:?}"
    );
    // Friction does not act back on the plate.
    assert_eq!(with_floor.gap_m, without_floor.gap_m);
    assert!((truth_after(&scenario, 0.0, &SLIDING, 0.04).mu - 0.8).abs() < 1e-6);
}

#[test]
fn friction_depends_on_speed_load_and_age_and_may_be_viscous() {
    let still =
        |scenario: &Scenario, finger: &FingerState| truth_after(scenario, 0.0, finger, 0.05);
    let mut scenario = ideal();
    scenario.friction.speed_exponent = -0.2;
    for (velocity_m_per_s, factor) in [(0.05, 1.0), (-0.1, 2f64.powf(-0.2)), (0.0, 50f64.powf(0.2))]
    {
        let truth = still(
            &scenario,
            &FingerState {
                velocity_m_per_s,
                ..SLIDING
            },
        );
        assert!((truth.mu / (0.8 * factor) - 1.0).abs() < 1e-6, "{truth:?}");
    }

    let mut scenario = ideal();
    scenario.friction.load_exponent = -0.3;
    let truth = still(
        &scenario,
        &FingerState {
            normal_n: 0.5,
            ..SLIDING
        },
    );
    assert!(
        (truth.mu / (0.8 * 0.5f64.powf(-0.3)) - 1.0).abs() < 1e-6,
        "{truth:?}"
    );

    let mut scenario = ideal();
    scenario.friction.viscous_n_s_per_m = 2.0;
    let (plain, viscous) = (still(&ideal(), &SLIDING), still(&scenario, &SLIDING));
    assert!((viscous.lateral_n - plain.lateral_n - 0.1).abs() < 1e-9);

    let mut scenario = ideal();
    scenario.friction.ageing = 0.5;
    scenario.friction.ageing_time_s = 0.5;
    let aged_truth = truth_after(&scenario, 0.0, &SLIDING, 0.5);
    let expected = 0.8 * (1.0 + 0.5 * (1.0 - (-1.0f64).exp()));
    assert!(
        (aged_truth.mu0 / expected - 1.0).abs() < 5e-3,
        "{aged_truth:?}"
    );
    let mut plant = Plant::new(&scenario, 1, 96e3);
    run(&mut plant, |_| 0.0, &SLIDING, 0.5, 480);
    run(&mut plant, |_| 0.0, &FingerState::default(), 2.5, 480);
    run(&mut plant, |_| 0.0, &SLIDING, 0.02, 480);
    let fresh = plant.truth().last().unwrap();
    assert!((fresh.mu0 / 0.8 - 1.0).abs() < 0.025, "{fresh:?}");
}

#[test]
fn asperities_and_tissue_grow_under_a_touch() {
    let mut scenario = ideal();
    scenario.participant.moisture.growth = 0.2;
    scenario.participant.moisture.growth_time_s = 0.5;
    let grown_truth = truth_after(&scenario, 0.0, &SLIDING, 0.5);
    let factor = 1.0 + 0.2 * (1.0 - (-1.0f64).exp());
    assert!(
        (grown_truth.sigma_t_m / (1.7e-6 * factor) - 1.0).abs() < 3e-3,
        "{grown_truth:?}"
    );
    let [re, im] = grown_truth.z_t_n_s_per_m;
    assert!(
        re == 0.47 && (im / (3.16 * factor) - 1.0).abs() < 3e-3,
        "{grown_truth:?}"
    );
}

#[test]
fn a_person_is_drawn_within_the_ranges_and_differs_in_everything_from_the_next() {
    let unkind = mock_world::scenario::built_in("population-unkind").unwrap();
    let pads: Vec<Pad> = (0..200).map(|seed| Pad::draw(&unkind, seed)).collect();
    let spread = &unkind.participant.spread;
    for (value, range) in [
        (
            (|p| p.contact_area_m2) as fn(&Pad) -> f64,
            spread.contact_area_m2,
        ),
        (|p| p.area_force_exponent, spread.area_force_exponent),
        (|p| p.q0_rad_per_m, spread.q0_rad_per_m),
        (|p| p.youngs_modulus_pa, spread.youngs_modulus_pa),
        (|p| p.loss_factor, spread.loss_factor),
        (|p| p.lag_s, spread.lag_s),
        (|p| p.lag_gap_exponent, spread.lag_gap_exponent),
        (|p| p.floor, spread.floor),
        (|p| p.speed_exponent, spread.speed_exponent),
        (|p| p.ageing, spread.ageing),
        (|p| p.ageing_time_s, spread.ageing_time_s),
        (|p| p.growth, spread.growth),
    ] {
        let [least, most] = range.unwrap();
        let width = most - least;
        let values = || pads.iter().map(value);
        assert!(values().all(|value| (least..=most).contains(&value)));
        assert!(values().any(|value| value < least + 0.1 * width));
        assert!(values().any(|value| value > most - 0.1 * width));
    }
    // The published constants of the skin are those of the same person in `population`.
    let kind = mock_world::scenario::built_in("population").unwrap();
    for seed in 0..5 {
        let (hard, soft) = (Fingertip::draw(&unkind, seed), Fingertip::draw(&kind, seed));
        assert_eq!(
            (hard.sigma_t_m, hard.z_t_n_s_per_m, hard.mu0),
            (soft.sigma_t_m, soft.z_t_n_s_per_m, soft.mu0)
        );
    }
}

#[test]
fn a_session_is_drawn_once_within_its_ranges() {
    let unkind = mock_world::scenario::built_in("population-unkind").unwrap();
    let ranges = &unkind.session;
    let (mut above_count, mut below_count) = (0, 0);
    for seed in 0..100 {
        let real = unkind.draw(seed);
        assert_eq!(real.draw(seed + 1), real, "a second call changes nothing");
        let (plate, sensor) = (&real.plate, &real.force_sensor);
        let off_hz = plate.second_mode.resonance_hz - plate.resonance_hz;
        if off_hz > 0.0 {
            above_count += 1
        } else {
            below_count += 1
        }
        for (value, range) in [
            (plate.drift.room_hz_per_min, ranges.room_hz_per_min),
            (
                plate.drift.room_damping_per_min,
                ranges.room_damping_per_min,
            ),
            (plate.drift.warmth_hz, ranges.warmth_hz),
            (plate.drift.warmth_damping, ranges.warmth_damping),
            (plate.drift.warmth_time_s, ranges.warmth_time_s),
            (plate.drift.warmth_spread, ranges.warmth_spread),
            (plate.drift.damping_time_ratio, ranges.damping_time_ratio),
            (plate.end_drop, ranges.end_drop),
            (plate.end_tilt, ranges.end_tilt),
            (off_hz.abs(), ranges.second_mode_off_hz),
            (plate.second_mode.half_waves, ranges.second_mode_half_waves),
            (
                sensor.lateral_resonance_hz.unwrap(),
                ranges.lateral_resonance_hz,
            ),
            (sensor.lateral_lag_s, ranges.lateral_lag_s),
        ] {
            let [least, most] = range.unwrap();
            assert!(
                (least..=most).contains(&value),
                "{value} of {least} to {most}"
            );
        }
    }
    assert!(
        above_count > 25 && below_count > 25,
        "{above_count} {below_count}"
    );
    let mut partial = unkind.clone();
    partial.session.warmth_hz = None;
    let (complete, partial) = (unkind.draw(3).plate, partial.draw(3).plate);
    assert_eq!(partial.drift.warmth_hz, 0.0);
    assert_eq!(
        (partial.end_drop, partial.second_mode),
        (complete.end_drop, complete.second_mode)
    );
}
