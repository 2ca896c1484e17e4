//! Separation of scales and tables, compared with an integration through every cycle and with finer tables.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::process::Command;

use num_complex::Complex64;

use super::programs::STEADY;
use super::recorded_world::record;
use reference_worlds::truth::{Truth, World};

#[derive(Debug)]
struct SteadyState {
    gap_m: f64,
    film_pa: f64,
    asperity_pa: f64,
    z_pa_s_per_m: Complex64,
}

/// Returns the state by the tables and by integration.
fn steady_states(arguments: &str) -> [SteadyState; 2] {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(STEADY.compile(folder.path()))
        .args(arguments.split(' '))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let states: Vec<SteadyState> = text
        .lines()
        .map(|line| {
            let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
            SteadyState {
                gap_m: numbers[0],
                film_pa: numbers[1],
                asperity_pa: numbers[2],
                z_pa_s_per_m: Complex64::new(numbers[3], numbers[4]),
            }
        })
        .collect();
    states.try_into().unwrap()
}

/// The two share the skin's and the asperities' constants, and no method. The integration includes the higher harmonics of the
/// skin's motion, which the tables leave out.
#[test]
fn the_steady_state_is_that_of_an_integration_through_every_cycle() {
    // shape, half width, plate's amplitude, load, sigma_t, asperities, and mass, damping and stiffness of the skin; cells, cycles
    for (arguments, limit) in [
        (
            "0 5e-3 0.5e-6 3250 1.7e-6 240e3 .085 2350 6.35e8 48 500",
            0.005,
        ),
        (
            "0 5e-3 2.0e-6 3250 1.7e-6 240e3 .085 2350 6.35e8 48 500",
            0.02,
        ),
        (
            "1 5.64e-3 1.2e-6 5000 1.7e-6 240e3 .085 2350 6.35e8 48 500",
            0.01,
        ),
        (
            "0 0.6e-3 2.0e-6 3250 1.2e-6 120e3 .085 2350 6.35e8 16 400",
            0.02,
        ),
    ] {
        let [tables, integration] = steady_states(arguments);
        println!("{arguments}:\n  {tables:?}\n  {integration:?}");
        let z = (tables.z_pa_s_per_m / integration.z_pa_s_per_m - 1.0).norm();
        let gap = (tables.gap_m / integration.gap_m - 1.0).abs();
        // The film's share of the load, so that of friction.
        let load_pa = integration.film_pa + integration.asperity_pa;
        let film = (tables.film_pa - integration.film_pa).abs() / load_pa;
        assert!(
            z < limit && gap < limit && film < limit,
            "{arguments}: {z} {gap} {film}"
        );
    }
}

/// A strip, and in a campaign a disc in addition (`FRICTION_BENCH_TABLES=2`).
#[test]
fn finer_tables_give_the_same_recording() {
    let strip: World = vec![("half_width_m", 5e-3)];
    let disc: World = vec![("disc", 1.0), ("contact_area_m2", 1e-4)];
    let count = std::env::var("FRICTION_BENCH_TABLES").map_or(1, |count| count.parse().unwrap());
    for world in [strip, disc].into_iter().take(count) {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        record(folders[0].path(), &world).unwrap();
        let mut finer = world.clone();
        finer.extend([
            ("cells", 50.0),
            ("steps", 60.0),
            ("gaps", 50.0),
            ("ratios", 25.0),
        ]);
        record(folders[1].path(), &finer).unwrap();
        let [recorded, finer] = folders.each_ref().map(|folder| Truth::read(folder.path()));
        let is_touched = |time_s: &f64| *time_s > 1.3;
        let series = |truth: &Truth, column: &str| -> Vec<f64> {
            let times_s = truth.column("time_s");
            times_s
                .iter()
                .zip(truth.column(column))
                .filter(|(time_s, _)| is_touched(time_s))
                .map(|(_, value)| value)
                .collect()
        };
        let rms = |values: &[f64]| {
            (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
        };
        let difference = |column: &str| -> Vec<f64> {
            let pairs = series(&recorded, column)
                .into_iter()
                .zip(series(&finer, column));
            pairs.map(|(a, b)| a - b).collect()
        };
        let mu = rms(&difference("mu"));
        let (re, im) = ("re_contact_n_s_per_m", "im_contact_n_s_per_m");
        let z = rms(&difference(re)).hypot(rms(&difference(im)))
            / rms(&series(&finer, re)).hypot(rms(&series(&finer, im)));
        println!("{world:?}: RMS difference of mu {mu:.5}, of Z {z:.5}");
        assert!(mu < 1.5e-3 && z < 6e-3, "{world:?}: {mu} {z}");
    }
}
