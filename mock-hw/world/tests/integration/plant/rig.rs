//! A bench without noise, and its impedance from samples and in closed form.

use std::f64::consts::TAU;

use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthConstants;
use mock_world::scenario::{ParticipantTable, Scenario};
use nalgebra::{Complex, Matrix3, Vector3};

pub type C = Complex<f64>;

include!("../fixture/ideal.rs");

/// Runs `seconds` with `drive(t)`; returns the last `keep` frames of drive read-back, pickup and line loop.
pub fn run(
    plant: &mut Plant,
    drive: impl Fn(f64) -> f64,
    finger: &FingerState,
    seconds: f64,
    keep: usize,
) -> Vec<[f64; 3]> {
    const PERIOD: usize = 480;
    let channels = plant.channels();
    let interval_s = 1.0 / plant.constants().frames_per_s;
    let total = (seconds / interval_s) as usize;
    let mut frames = Vec::new();
    let (mut out, mut inputs) = (vec![0.0; PERIOD], vec![0.0; PERIOD * channels]);
    let mut n = 0;
    while n < total {
        for (i, sample) in out.iter_mut().enumerate() {
            *sample = drive((n + i) as f64 * interval_s) as f32;
        }
        plant.step(&out, true, finger, &mut inputs);
        n += PERIOD;
        if n + keep + PERIOD > total {
            frames.extend(
                inputs
                    .chunks(channels)
                    .map(|f| [0, 1, 2].map(|c| f64::from(f[c]))),
            );
        }
    }
    frames.split_off(frames.len() - keep)
}

/// Returns the complex amplitude at `cycles` per frame, over frames with a whole number of cycles.
pub fn envelope(values: impl Iterator<Item = f64>, cycles: f64) -> C {
    let (sum, n) = values
        .enumerate()
        .fold((C::new(0.0, 0.0), 0), |(sum, _), (i, v)| {
            (
                sum + C::from_polar(2.0 * v, -TAU * cycles * i as f64),
                i + 1,
            )
        });
    sum / f64::from(n as u32)
}

/// Returns f̃/ṽ as computed by a bench with perfect constants.
pub fn measured_impedance(plant: &Plant, frames: &[[f64; 3]], carrier_hz: f64) -> C {
    let TruthConstants {
        scenario: s,
        frames_per_s,
        ..
    } = plant.constants();
    let cycles = carrier_hz / frames_per_s;
    let omega = TAU * carrier_hz;
    let volts = envelope(frames.iter().map(|k| k[0]), cycles) * s.converter.readback_volts_per_unit;
    let phase = s.pickup.phase_rad * omega / s.plate.omega_rad_per_s();
    let displacement = envelope(frames.iter().map(|k| k[1]), cycles)
        * C::from_polar(s.pickup.metres_per_unit, phase);
    volts * s.plate.force_factor_n_per_v / (displacement * C::new(0.0, omega))
}

/// Returns γU/ṽ at the pickup from the harmonic equations of two modes and a skin mass, independently of the integrator.
pub fn harmonic_impedance(s: &Scenario, omega: f64, z_c: C, z_t: C) -> C {
    let second = &s.plate.second_mode;
    let z = |mass: f64, f0: f64, damping: f64| {
        C::new(damping, omega * mass - (TAU * f0).powi(2) * mass / omega)
    };
    let z1 = z(
        s.plate.modal_mass_kg,
        s.plate.resonance_hz,
        s.plate.damping_n_s_per_m,
    );
    let damping2 = TAU * second.resonance_hz * second.modal_mass_kg / second.quality;
    let z2 = z(second.modal_mass_kg, second.resonance_hz, damping2);
    let c = second.contact_ratio;
    let matrix = Matrix3::new(
        z1 + z_c,
        z_c * c,
        -z_c,
        z_c * c,
        z2 + z_c * c * c,
        -z_c * c,
        -z_c,
        -z_c * c,
        z_t + z_c,
    );
    let force = Vector3::new(C::from(1.0), C::from(second.actuator_ratio), C::from(0.0));
    let v = matrix.lu().solve(&force).unwrap();
    (v[0] + v[1] * second.pickup_ratio).inv()
}
