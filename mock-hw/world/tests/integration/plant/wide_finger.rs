//! A finger of a finite width across the plate's mode, against the sum of many independent strips.

use std::f64::consts::{PI, TAU};

use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthSample;
use mock_world::scenario::{AcrossTable, ContactWidthTable, Scenario};
use nalgebra::{Matrix3, Vector3};

use super::rig::{C, SLIDING, ideal, measured_impedance, run};

const CARRIER_HZ: f64 = 35_000.0;
const OMEGA: f64 = TAU * CARRIER_HZ;

fn wide(width_m: f64) -> Scenario {
    let mut scenario = ideal();
    scenario.plate.across = Some(AcrossTable {
        crest_m: 0.5e-3,
        ..AcrossTable::default()
    });
    scenario.film.contact_width = Some(ContactWidthTable {
        width_m,
        ..ContactWidthTable::default()
    });
    scenario
}

/// Strips of an elliptic contact: share of the area, and shape of the mode there.
fn strips(width_m: f64) -> Vec<(f64, f64)> {
    const COUNT: u32 = 4000;
    let strip = |i| {
        let y = 2.0 * (f64::from(i) + 0.5) / f64::from(COUNT) - 1.0;
        let share = 4.0 / PI * (1.0 - y * y).sqrt() / f64::from(COUNT);
        let across_m = 0.5 * width_m * y - 0.5e-3;
        (share, (TAU * across_m / 0.022).cos())
    };
    (0..COUNT).map(strip).collect()
}

/// Returns γU/ṽ at the pickup with a separate spring and damper under each strip, at a gap and an amplitude on the crest.
fn impedance_of_strips(s: &Scenario, strips: &[(f64, f64)], truth: &TruthSample) -> C {
    let film = &s.film;
    let modulus_pa = film.youngs_modulus_pa / (1.0 - film.poisson_ratio.powi(2));
    let asperity_pa =
        0.375 * film.q0_rad_per_m * 1.7e-6 * modulus_pa * (-truth.gap_m / 1.7e-6).exp();
    let mut sums = [C::from(0.0); 3];
    for (share, shape) in strips {
        let area_m2 = share * film.contact_area_m2;
        let local_m = shape * truth.amplitude_m;
        let squeeze_pa = 1.25 * film.ambient_pressure_pa * (local_m / truth.gap_m).powi(2);
        let k = area_m2 * (asperity_pa / 1.7e-6 + 2.0 * squeeze_pa / truth.gap_m);
        let z = C::new(0.3 * k / OMEGA, -k / OMEGA);
        for (sum, factor) in sums.iter_mut().zip([1.0, *shape, shape * shape]) {
            *sum += z * factor;
        }
    }
    let [z_c, coupling, plate] = sums;
    let second = &s.plate.second_mode;
    let mode = |mass: f64, f0: f64, damping: f64| {
        C::new(damping, OMEGA * mass - (TAU * f0).powi(2) * mass / OMEGA)
    };
    let z1 = mode(
        s.plate.modal_mass_kg,
        s.plate.resonance_hz,
        s.plate.damping_n_s_per_m,
    );
    let damping = TAU * second.resonance_hz * second.modal_mass_kg / second.quality;
    let z2 = mode(second.modal_mass_kg, second.resonance_hz, damping);
    let c = second.contact_ratio;
    let matrix = Matrix3::new(
        z1 + plate,
        plate * c,
        -coupling,
        plate * c,
        z2 + plate * c * c,
        -coupling * c,
        -coupling,
        -coupling * c,
        C::new(0.47, 3.16) + z_c,
    );
    let force = Vector3::new(C::from(1.0), C::from(second.actuator_ratio), C::from(0.0));
    let v = matrix.lu().solve(&force).unwrap();
    (v[0] + v[1] * second.pickup_ratio).inv()
}

/// Returns the plant and its impedance after 0.1 s of a constant carrier.
fn settled(scenario: &Scenario, level: f64, finger: &FingerState) -> (Plant, C) {
    let mut plant = Plant::new(scenario, 1, 192e3);
    let drive = |t: f64| level * (TAU * CARRIER_HZ * t).sin();
    let frames = run(&mut plant, drive, finger, 0.1, 1920);
    let measured = measured_impedance(&plant, &frames, CARRIER_HZ);
    (plant, measured)
}

#[test]
fn impedance_and_load_are_those_of_many_strips() {
    for (width_m, level) in [(4e-3, 0.3), (8e-3, 0.05), (8e-3, 0.3), (12e-3, 0.7)] {
        let scenario = wide(width_m);
        let (plant, measured) = settled(&scenario, level, &SLIDING);
        let truth = plant.truth().last().unwrap();
        let strips = strips(width_m);
        let expected = impedance_of_strips(&scenario, &strips, truth);
        let error = (measured - expected).norm() / expected.norm();
        assert!(error < 5e-4, "{width_m} m, {level}: {measured} {expected}");

        // Asperities and strips of the film carry the finger.
        let film = &scenario.film;
        let modulus_pa = film.youngs_modulus_pa / (1.0 - film.poisson_ratio.powi(2));
        let asperity_pa = 0.375 * film.q0_rad_per_m * 1.7e-6 * modulus_pa;
        let asperity_n = film.contact_area_m2 * asperity_pa * (-truth.gap_m / 1.7e-6).exp();
        let squeeze_n = strips.iter().map(|(share, shape)| {
            let pa =
                1.25 * film.ambient_pressure_pa * (shape * truth.amplitude_m / truth.gap_m).powi(2);
            share * film.contact_area_m2 * pa
        });
        let carried_n = asperity_n + squeeze_n.sum::<f64>();
        assert!((carried_n / 0.65 - 1.0).abs() < 2e-3, "{carried_n} N");
    }
}

#[test]
fn a_wider_finger_is_levitated_less_and_at_rest_loads_the_plate_less() {
    let gap_and_load = |scenario: &Scenario| {
        let (plant, _) = settled(scenario, 0.5, &SLIDING);
        let free = settled(scenario, 0.02, &FingerState::default()).1;
        let loaded = settled(scenario, 0.02, &SLIDING).1;
        (plant.truth().last().unwrap().gap_m, (loaded - free).norm())
    };
    let mut previous = gap_and_load(&ideal());
    for width_m in [4e-3, 8e-3, 12e-3] {
        let now = gap_and_load(&wide(width_m));
        assert!(
            now.0 < previous.0 && now.1 < previous.1,
            "{width_m} m: {now:?} {previous:?}"
        );
        previous = now;
    }
}

#[test]
fn width_without_a_mode_across_and_a_mode_without_width_change_nothing() {
    let reference = settled(&ideal(), 0.3, &SLIDING).1;
    for remove in [
        (|s: &mut Scenario| s.plate.across = None) as fn(&mut Scenario),
        |s| s.film.contact_width = None,
    ] {
        let mut scenario = wide(8e-3);
        remove(&mut scenario);
        assert_eq!(settled(&scenario, 0.3, &SLIDING).1, reference);
    }
}
