//! The program that makes recordings of the world, and its drawn fingers.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use crate::truth::World;

/// q0 of a world that does not state it, rad/m.
pub const Q0_RAD_PER_M: f64 = 1.4e4;

/// Returns the program, compiled once.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = PROGRAM.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("world");
        let source = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/integration/independent_world/world.c");
        let status = Command::new("cc")
            .args(["-std=c11", "-O3", "-Wall", "-Wextra", "-Werror", "-o"])
            .args([&path, &source])
            .arg("-lm")
            .status()
            .expect("the C compiler that the build needs too");
        assert!(status.success());
        (folder, path)
    });
    path
}

/// Writes a recording.
pub fn record(folder: &Path, world: &World) {
    let status = Command::new(program())
        .arg(folder)
        .args(world.iter().map(|(name, value)| format!("{name}={value}")))
        .status()
        .unwrap();
    assert!(status.success(), "{world:?}");
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
