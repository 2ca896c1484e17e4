//! Recordings of an independent implementation of the same laws (world.c), in which skin and plate differ from all assumptions,
//! compared with their true values. docs/accuracy.md quotes the numbers from here.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(
    clippy::print_stdout,
    reason = "docs/accuracy.md has the numbers from here"
)]

use analysis::Settings;
use analysis::findings::RecordingFindings;
use analysis::method::Method;
use analysis::recording_analysis::analyse;
use contact::uncertain::{LogUncertain, Uncertain};
use num_complex::Complex64;
use rayon::prelude::*;
use reference_worlds::campaign;
use reference_worlds::independent::{Q0_RAD_PER_M, compile, random_world, record};
use reference_worlds::truth::{Truth, World, parameter};

/// Largest errors of `trial` over all instances.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    sigma_t: f64,
    z_t: f64,
    shift_hz: f64,
    mu: f64,
    area: f64,
    q0: f64,
    loss_factor: f64,
    tau_s: f64,
    floor: f64,
    lateral_lag_s: f64,
    /// Number of stated 95 % intervals that include the true value, and number of all intervals.
    coverage: (usize, usize),
}

impl Errors {
    fn new(
        findings: &RecordingFindings,
        truth: &Truth,
        true_value: impl Fn(&str, f64) -> f64,
    ) -> Self {
        let shared = findings.trial.as_ref().unwrap();
        assert!(shared.verdict.is_usable(), "{:?}", shared.verdict);
        assert!(shared.misfit.is_empty(), "{:?}", shared.misfit);
        let instance_at = |index: usize| &findings.instances[index];
        let (first_s, last_s) = (
            instance_at(0).start_s,
            instance_at(findings.instances.len() - 1).end_s,
        );
        let area_m2 = truth.mean("contact_area_m2", first_s, last_s);
        let (q0, loss_factor, tau_s) = (
            true_value("q0_rad_per_m", Q0_RAD_PER_M),
            true_value("loss_factor", 0.3),
            true_value("tau_s", 1e-3),
        );
        let mut errors = Self {
            area: (shared.contact_area_m2.value / area_m2 - 1.0).abs(),
            q0: (shared.q0_rad_per_m.value / q0 - 1.0).abs(),
            loss_factor: (shared.loss_factor.value - loss_factor).abs(),
            tau_s: (shared.tau_s.value - tau_s).abs(),
            floor: (shared.friction_floor.unwrap().value - true_value("floor", 0.0)).abs(),
            lateral_lag_s: (shared.lateral_lag_s.unwrap().value - true_value("lateral_lag_s", 0.0))
                .abs(),
            ..Self::default()
        };
        let log_interval = |value: &LogUncertain, truth: f64| (value.interval95(), truth);
        let mut intervals = vec![
            log_interval(&shared.contact_area_m2, area_m2),
            log_interval(&shared.q0_rad_per_m, q0),
            log_interval(&shared.loss_factor, loss_factor),
        ];
        let unloaded_hz = truth.mean("resonance_hz", 0.2, 1.0);
        for instance in &findings.instances {
            let estimate = instance.trial.as_ref().unwrap();
            let mean = |column| truth.mean(column, instance.start_s, instance.end_s);
            let sigma_t_m = mean("sigma_t_m");
            let z_t = Complex64::new(mean("re_z_t_n_s_per_m"), mean("im_z_t_n_s_per_m"));
            let shift_hz = estimate.plate_offset.unwrap().resonance_shift_hz;
            let shifted_hz = mean("resonance_hz") - unloaded_hz;
            let mut worst = |field: fn(&mut Self) -> &mut f64, error: f64| {
                let worst = field(&mut errors);
                *worst = worst.max(error);
            };
            worst(
                |errors| &mut errors.sigma_t,
                (estimate.sigma_t_m() / sigma_t_m - 1.0).abs(),
            );
            worst(
                |errors| &mut errors.z_t,
                (estimate.z_t_n_s_per_m - z_t).norm() / z_t.norm(),
            );
            worst(|errors| &mut errors.shift_hz, (shift_hz - shifted_hz).abs());
            worst(|errors| &mut errors.mu, estimate.agreement.rms_mu);
            let interval = |value, std| Uncertain { value, std }.interval95();
            intervals.extend([
                (
                    interval(estimate.sigma_t_m(), estimate.sigma_t_std_m()),
                    sigma_t_m,
                ),
                (
                    interval(estimate.z_t_n_s_per_m.re, estimate.z_t_std_n_s_per_m.re),
                    z_t.re,
                ),
                (
                    interval(estimate.z_t_n_s_per_m.im, estimate.z_t_std_n_s_per_m.im),
                    z_t.im,
                ),
                (
                    interval(estimate.mu0, estimate.mu0_std),
                    true_value("mu0", 0.8),
                ),
            ]);
        }
        let covered_intervals = intervals
            .iter()
            .filter(|([low, high], truth)| (low..=high).contains(&truth));
        errors.coverage = (covered_intervals.count(), intervals.len());
        errors
    }

    /// Asserts the accuracy promised for a recording of seven instances at 80 dB.
    fn assert_within(&self, name: &str) {
        println!("{name}: {self:?}");
        for (quantity, error, limit) in [
            ("sigma_t", self.sigma_t, 0.03),
            ("Z_t", self.z_t, 0.05),
            ("shift, Hz", self.shift_hz, 0.05),
            ("RMS of mu", self.mu, 0.02),
            ("S", self.area, 0.06),
            ("q0", self.q0, 0.3),
            ("eta", self.loss_factor, 0.03),
            ("tau, s", self.tau_s, 0.5e-3),
            ("floor", self.floor, 0.01),
            ("lateral lag, s", self.lateral_lag_s, 0.3e-3),
        ] {
            assert!(error <= limit, "{name}: {quantity} {error} > {limit}");
        }
        let (covered, all) = self.coverage;
        assert!(covered * 10 >= all * 9, "{name}: {covered} of {all}");
    }
}

/// Makes a recording and analyses it.
fn record_and_analyse(world: &World) -> (RecordingFindings, Truth) {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), world);
    let findings = analyse(folder.path(), &Settings::default())
        .findings
        .unwrap();
    assert_eq!(findings.instances.len(), 7, "{:?}", findings.rejected);
    (findings, Truth::read(folder.path()))
}

fn errors(world: &World) -> Errors {
    let (findings, truth) = record_and_analyse(world);
    let true_value = |name: &str, default: f64| parameter(world, name).unwrap_or(default);
    Errors::new(&findings, &truth, true_value)
}

fn assert_recovered(worlds: Vec<(String, World)>) {
    compile();
    let world_errors: Vec<(String, Errors)> = worlds
        .into_par_iter()
        .map(|(name, world)| (name, errors(&world)))
        .collect();
    for (name, errors) in &world_errors {
        errors.assert_within(name);
    }
}

#[test]
fn each_single_deviation_from_the_assumptions_is_recovered() {
    let world_with =
        |name: &'static str, value: f64| (format!("{name} = {value}"), vec![(name, value)]);
    let mut worlds = vec![
        world_with("growth", 0.2),
        world_with("floor", 0.15),
        world_with("lateral_lag_s", 2e-3),
    ];
    worlds.extend([-10.0, 0.0, 10.0].map(|hz| world_with("drift_hz", hz)));
    worlds.extend([100e-6, 200e-6, 400e-6].map(|m2| world_with("contact_area_m2", m2)));
    worlds.extend([0.5, 2.0].map(|factor| world_with("q0_rad_per_m", factor * Q0_RAD_PER_M)));
    worlds.extend([0.2, 0.5].map(|eta| world_with("loss_factor", eta)));
    worlds.extend([0.5e-3, 2e-3].map(|tau_s| world_with("tau_s", tau_s)));
    worlds.extend([0.3, 0.6].map(|exponent| world_with("area_force_exponent", exponent)));
    worlds.extend([3e-5, 2e-4].map(|mean_s| world_with("film_mean_s", mean_s)));
    worlds.push(world_with("pickup_phase_rad", -0.3));
    assert_recovered(worlds);
}

/// The skin is as `dynamic` assumes it.
#[test]
fn dynamic_tolerates_a_drifting_plate() {
    for drift_hz in [-10.0, 10.0] {
        let (findings, truth) = record_and_analyse(&vec![("drift_hz", drift_hz)]);
        for instance in &findings.instances {
            let estimate = instance.estimate(Method::Dynamic).unwrap();
            let sigma_t_m = truth.mean("sigma_t_m", instance.start_s, instance.end_s);
            let error = (estimate.sigma_t_m() / sigma_t_m - 1.0).abs();
            assert!(
                error < 0.02,
                "{drift_hz} Hz, {} s: {error}",
                instance.start_s
            );
        }
    }
}

#[test]
fn all_deviations_at_once_are_recovered() {
    // docs/accuracy.md has the first 16.
    let count = campaign::repeats("FRICTION_BENCH_DEVIATIONS", 8) as u64;
    let worlds = (1..=count).map(|seed| (format!("seed {seed}"), random_world(seed)));
    assert_recovered(worlds.collect());
}
