//! The independent implementation of the published laws (`independent/README.md`), and its drawn fingers.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::program::{Program, ProgramCache};
use crate::truth::World;

/// q0 of a world that does not state it, rad/m.
pub const Q0_RAD_PER_M: f64 = 1.4e4;

/// Program that makes recordings.
static WORLD: ProgramCache = ProgramCache::new(Program {
    name: "world",
    folder: concat!(env!("CARGO_MANIFEST_DIR"), "/independent"),
    sources: &["world.c"],
});

/// Compiles the program, so that worlds recorded side by side do not wait for each other.
///
/// # Panics
/// When the program cannot be compiled.
pub fn compile() {
    WORLD.path();
}

/// Writes a recording.
///
/// # Panics
/// When the program rejects the world.
pub fn record(folder: &Path, world: &World) {
    let output = WORLD.record(folder, world);
    assert!(output.status.success(), "{world:?}: {output:?}");
}

/// Draws a finger, a plate and sensors that differ from all assumptions and obey the published laws.
pub fn random_world(seed: u64) -> World {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |low: f64, high: f64| rng.random_range(low..high);
    vec![
        ("seed", seed as f64),
        ("sigma_t_m", uniform(1.1e-6, 2.3e-6)),
        ("re_z_t", uniform(0.2, 0.9)),
        ("im_z_t", uniform(2.4, 4.0)),
        ("growth", uniform(0.0, 0.2)),
        ("contact_area_m2", uniform(100e-6, 400e-6)),
        ("area_force_exponent", uniform(0.0, 0.6)),
        ("q0_rad_per_m", Q0_RAD_PER_M * uniform(-1.0, 1.0).exp2()),
        ("loss_factor", uniform(0.2, 0.5)),
        ("tau_s", uniform(0.5e-3, 2e-3)),
        ("film_mean_s", uniform(3e-5, 2e-4)),
        ("mu0", uniform(0.5, 1.0)),
        ("floor", uniform(0.0, 0.2)),
        ("lateral_lag_s", uniform(0.0, 2e-3)),
        ("normal_n", uniform(0.5, 0.8)),
        ("drift_hz", uniform(-10.0, 10.0)),
        ("pickup_phase_rad", uniform(-0.3, 0.3)),
    ]
}
