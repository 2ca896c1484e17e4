//! Worlds drawn from three kinds of finger, each analysed by every method: three in every test run, as many as
//! `FRICTION_BENCH_REYNOLDS` says in a campaign (`./dev campaign reynolds`).

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use analysis::Settings;
use analysis::method::Method;
use analysis::recording_analysis::analyse_with_series;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use reference_worlds::campaign;
use reference_worlds::truth::{Truth, World, parameter};

use super::programs::WORLD;
use super::recorded_world::record;
use crate::verdict::{Outcome, Verdict};

/// Number of worlds in every test run: one of each kind.
const WORLDS: usize = 3;
/// Variable with the number of worlds of a campaign.
const COUNT: &str = "FRICTION_BENCH_REYNOLDS";

/// Worlds of every test run: strips without grooves, ridges with grooves under the plate's mode, a disc under the mode.
fn usual_worlds() -> Vec<(String, World)> {
    let common = [
        ("mu0", 0.8),
        ("normal_n", 0.65),
        ("contact_area_m2", 150e-6),
    ];
    let named = |name: &str, parameters: &[(&'static str, f64)]| {
        (name.to_owned(), [common.as_slice(), parameters].concat())
    };
    vec![
        named(
            "strips",
            &[
                ("half_width_m", 0.5e-3),
                ("sigma_t_m", 1.7e-6),
                ("asperity_pa", 120e3),
            ],
        ),
        named(
            "ridges",
            &[
                ("half_width_m", 0.2e-3),
                ("groove_half_width_m", 60e-6),
                ("groove_length_m", 5e-3),
                ("sigma_t_m", 1.2e-6),
                ("asperity_pa", 60e3),
                ("half_length_m", 6e-3),
                ("wavelength_m", 22e-3),
            ],
        ),
        named(
            "disc",
            &[("disc", 1.0), ("sigma_t_m", 2e-6), ("wavelength_m", 22e-3)],
        ),
    ]
}

/// Draws a world; its kind follows from its number.
fn drawn_world(number: u64) -> (String, World) {
    let mut rng = ChaCha8Rng::seed_from_u64(number);
    let mut uniform = |low: f64, high: f64| rng.random_range(low..high);
    let omega = std::f64::consts::TAU * 35e3;
    // Mass above the resonance of a skin whose stiffness takes a third off its reactance.
    let reactance = uniform(2.4, 4.0);
    let is_moded = uniform(0.0, 1.0) < 0.5;
    let mut world: World = vec![
        ("seed", number as f64),
        ("sigma_t_m", 1e-6 * uniform(0.8, 2.2)),
        ("asperity_pa", 1e3 * uniform(3.7, 5.7).exp()),
        ("gaussian", f64::from(u8::from(uniform(0.0, 1.0) < 0.3))),
        ("loss_factor", uniform(0.15, 0.5)),
        ("skin_damping", uniform(0.2, 0.9)),
        ("skin_kg", 1.5 * reactance / omega),
        ("skin_n_per_m", 0.5 * reactance * omega),
        ("tau_s", uniform(0.5e-3, 2e-3)),
        ("mu0", uniform(0.5, 1.0)),
        ("normal_n", uniform(0.5, 0.8)),
        ("drift_hz", uniform(-5.0, 5.0)),
        ("contact_area_m2", 1e-6 * uniform(80.0, 250.0)),
        ("wavelength_m", if is_moded { 22e-3 } else { 0.0 }),
        ("half_length_m", uniform(3e-3, 7e-3)),
    ];
    let name = match number % 3 {
        0 => {
            world.push(("half_width_m", 1e-3 * uniform(-1.6, 1.8).exp()));
            "strips"
        }
        1 => {
            let is_open = uniform(0.0, 1.0) < 0.5;
            world.extend([
                ("half_width_m", uniform(0.15e-3, 0.225e-3)),
                ("groove_half_width_m", uniform(0.04e-3, 0.1e-3)),
                ("groove_depth_m", uniform(40e-6, 100e-6)),
                (
                    "groove_length_m",
                    if is_open { 0.0 } else { uniform(3e-3, 6e-3) },
                ),
            ]);
            "ridges"
        }
        _ => {
            world.push(("disc", 1.0));
            "disc"
        }
    };
    (format!("{name} {number}"), world)
}

fn worlds() -> (usize, Vec<(String, World)>) {
    let count = campaign::size(COUNT, WORLDS).unwrap_or(WORLDS);
    let mut worlds = usual_worlds();
    worlds.extend((1..=(count - WORLDS) as u64).map(drawn_world));
    (count, worlds)
}

/// Returns the verdict of each method on a world, or the program's message if the world is impossible.
fn verdicts(world: &World) -> Result<Vec<Verdict>, String> {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), world)?;
    let (analysis, series) = analyse_with_series(folder.path(), &Settings::default());
    let findings = analysis.findings.unwrap();
    let truth = Truth::read(folder.path());
    let verdicts =
        Method::ALL.map(|method| Verdict::new(method, (&findings, &series), &truth, world));
    Ok(verdicts.into())
}

/// Number of verdicts of each outcome.
fn counted(verdicts: &[&Verdict]) -> String {
    let count = |is: fn(&Outcome) -> bool| verdicts.iter().filter(|v| is(&v.outcome)).count();
    format!(
        "{} refused, {} flagged, {} right, {} covered, {} wrong in silence; {} unflagged within 20 % of sigma_t and \
         certain to 60 %",
        count(|outcome| *outcome == Outcome::Refused),
        count(|outcome| matches!(outcome, Outcome::Flagged(_))),
        count(|outcome| *outcome == Outcome::Right),
        count(|outcome| *outcome == Outcome::Covered),
        count(|outcome| matches!(outcome, Outcome::WrongInSilence(_))),
        verdicts
            .iter()
            .filter(|verdict| verdict.is_useful())
            .count(),
    )
}

#[test]
fn a_finger_on_a_reynolds_film_is_right_or_flagged() {
    WORLD.path();
    let (count, worlds) = worlds();
    let results: Vec<(String, f64, Result<Vec<Verdict>, String>)> = worlds
        .into_par_iter()
        .map(|(name, world)| {
            let sigma_t_m = parameter(&world, "sigma_t_m").unwrap_or(1.7e-6);
            let verdicts = verdicts(&world);
            (name, sigma_t_m, verdicts)
        })
        .collect();
    let mut all: Vec<Verdict> = Vec::new();
    let mut recorded = 0;
    for (name, sigma_t_m, verdicts) in results {
        println!("{name}: sigma_t {:.2} um", 1e6 * sigma_t_m);
        match verdicts {
            Err(message) => println!("    impossible: {}", message.trim()),
            Ok(verdicts) => {
                recorded += 1;
                for verdict in &verdicts {
                    println!("    {verdict}");
                }
                all.extend(verdicts);
            }
        }
    }
    for method in Method::ALL {
        let of_method: Vec<&Verdict> = all.iter().filter(|v| v.method == method).collect();
        let text = format!("{} of {recorded}: {}", method.name(), counted(&of_method));
        campaign::report("a finger on a Reynolds film", count, &text);
    }
    assert!(recorded * 10 >= count * 8, "{recorded} of {count} recorded");
    let wrong: Vec<String> = all
        .iter()
        .filter(|verdict| matches!(verdict.outcome, Outcome::WrongInSilence(_)))
        .map(ToString::to_string)
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
