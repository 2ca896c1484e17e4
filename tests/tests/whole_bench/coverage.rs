//! Coverage of stated intervals, compared with the truth that the estimator never sees, over virtual participants on an unkind
//! bench. The results are in docs/accuracy.md; `./dev campaign coverage` runs hundreds of participants.

use std::collections::BTreeMap;
use std::path::Path;

use analysis::estimate::{Estimated, InstanceAnalysis, Method};
use analysis::{Settings, analyse, find};
use bench_tests::campaign;
use bench_tests::session::{ALL_COMPLETED, VirtualParticipant, text};
use bench_tests::truth::{Course, recording_began_s};
use num_complex::Complex64;
use rayon::prelude::*;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::worlds::share_of;

/// Number of participants in every test run; `FRICTION_BENCH_COVERAGE` asks for more.
const PARTICIPANTS: usize = 4;
/// Number of participants that determines coverage to a per cent or two.
const MANY: usize = 400;
/// Amplitudes at which the friction is compared, m.
const AMPLITUDES_M: [f64; 3] = [0.5e-6, 1.5e-6, 3e-6];
/// Greatest allowed medians of relative errors over many people.
const MOST_SIGMA_T: f64 = 0.015;
const MOST_Z_T: f64 = 0.03;
const MOST_AREA: f64 = 0.05;
/// Quantities judged by their coverage, for the method without assumptions.
const JUDGED: [&str; 7] = ["sigma_t", "Re Z_t", "Im Z_t", "S", "tau", "mu0", "mu"];

/// An error and its stated standard error, both relative to the truth or to a scale of it.
#[derive(Clone, Copy)]
struct Stated {
    error: f64,
    std: f64,
}

impl Stated {
    /// Continuous ranked probability score of a normal distribution (Gneiting and Raftery 2007, Eq. 21).
    fn crps(&self) -> f64 {
        let (normal, z) = (Normal::standard(), self.error / self.std);
        let root = std::f64::consts::PI.sqrt();
        self.std * (z * (2.0 * normal.cdf(z) - 1.0) + 2.0 * normal.pdf(z) - 1.0 / root)
    }
}

/// Stated errors by method and quantity.
#[derive(Default)]
struct Found {
    stated: BTreeMap<(&'static str, &'static str), Vec<Stated>>,
    /// Relative distance between the estimated and true complex Z_t, by method.
    z_t: BTreeMap<&'static str, Vec<f64>>,
    trials: usize,
    flagged: usize,
}

impl Found {
    fn add(&mut self, method: &'static str, quantity: &'static str, error: f64, std: f64) {
        if error.is_finite() && std > 0.0 {
            let of = self.stated.entry((method, quantity)).or_default();
            of.push(Stated { error, std });
        }
    }

    fn merged(mut self, other: Self) -> Self {
        for (key, stated) in other.stated {
            self.stated.entry(key).or_default().extend(stated);
        }
        for (method, distances) in other.z_t {
            self.z_t.entry(method).or_default().extend(distances);
        }
        self.trials += other.trials;
        self.flagged += other.flagged;
        self
    }

    fn instance(&mut self, instance: &InstanceAnalysis, course: &Course, began_s: f64) {
        let (from_s, to_s) = (began_s + instance.start_s, began_s + instance.end_s);
        let mean = |column| course.mean(column, from_s, to_s);
        let methods = [Method::Dynamic, Method::Trial];
        for estimated in methods.map(|method| Some((method, instance.estimated(method)?))) {
            let Some((method, estimated)) = estimated else {
                continue;
            };
            let (name, sigma_t_m) = (method.name(), mean("sigma_t_m"));
            let [re, im] = ["re_z_t_n_s_per_m", "im_z_t_n_s_per_m"].map(mean);
            let (z_t, std) = (estimated.z_t_n_s_per_m, estimated.z_t_std_n_s_per_m);
            self.add(
                name,
                "sigma_t",
                estimated.sigma_t_m / sigma_t_m - 1.0,
                estimated.sigma_t_std_m / sigma_t_m,
            );
            self.add(name, "Re Z_t", z_t.re - re, std.re);
            self.add(name, "Im Z_t", z_t.im - im, std.im);
            let true_z_t = Complex64::new(re, im);
            let distance = (z_t - true_z_t).norm() / true_z_t.norm();
            self.z_t.entry(name).or_default().push(distance);
            self.add(name, "mu0", estimated.mu0 - mean("mu0"), estimated.mu0_std);
            self.friction(name, (instance, estimated), course, began_s);
        }
    }

    /// Adds the friction at each of the [`AMPLITUDES_M`] that the instance covers.
    fn friction(
        &mut self,
        method: &'static str,
        (instance, estimated): (&InstanceAnalysis, &Estimated),
        course: &Course,
        began_s: f64,
    ) {
        let amplitudes_m = instance.samples.amplitude_m(Method::Dynamic);
        for amplitude_m in AMPLITUDES_M {
            let crossing = amplitudes_m
                .windows(2)
                .position(|pair| (pair[0] < amplitude_m) != (pair[1] < amplitude_m));
            let Some(at) = crossing else { continue };
            let series = &estimated.series;
            let truth = course.value("mu", began_s + series.time_s[at]);
            self.add(method, "mu", series.mu[at] - truth, series.mu_std[at]);
        }
    }

    /// Returns the fraction of intervals of ± `stds` standard errors that contain the truth.
    fn holds(&self, key: (&str, &str), stds: f64) -> f64 {
        let stated = self.of(key);
        let held = stated.iter().filter(|of| of.error.abs() < stds * of.std);
        held.count() as f64 / stated.len() as f64
    }

    fn of(&self, (method, quantity): (&str, &str)) -> &[Stated] {
        let mut all = self.stated.iter();
        all.find(|(key, _)| **key == (method, quantity))
            .map_or(&[], |(_, stated)| stated)
    }

    fn mean(&self, key: (&str, &str), of: fn(&Stated) -> f64) -> f64 {
        let stated = self.of(key);
        stated.iter().map(of).sum::<f64>() / stated.len() as f64
    }

    /// Returns the RMS of error over standard error.
    fn rms_z(&self, key: (&str, &str)) -> f64 {
        self.mean(key, |of| (of.error / of.std).powi(2)).sqrt()
    }

    /// Returns the median of the absolute error.
    fn median(&self, key: (&str, &str)) -> f64 {
        share_of(self.of(key).iter().map(|of| of.error.abs()).collect(), 0.5)
    }

    fn median_z_t(&self, method: &str) -> f64 {
        share_of(self.z_t.get(method).cloned().unwrap_or_default(), 0.5)
    }

    fn line(&self, key: (&str, &str)) -> String {
        let rms = self.rms_z(key);
        format!(
            "{} {}: 95 % intervals hold {:.1} %, 68 % {:.1} %, RMS z {rms:.2}, CRPS {:.2e}, median error {:.2e}",
            key.0,
            key.1,
            100.0 * self.holds(key, 1.96),
            100.0 * self.holds(key, 0.9945),
            self.mean(key, Stated::crps),
            self.median(key),
        )
    }
}

/// Runs a session of one participant and compares its stated errors with the true ones.
fn participant(seed: u64, folder: &Path) -> Found {
    let VirtualParticipant {
        study,
        truth,
        output,
    } = VirtualParticipant::run("population-unkind", seed, folder);
    let mut found = Found::default();
    // A participant who never slides correctly leaves no data to analyse.
    let Ok(attempts) = find::attempts(std::slice::from_ref(&study), ALL_COMPLETED) else {
        assert!(study.exists(), "seed {seed}: {}", text(&output));
        return found;
    };
    let analysed = analyse(&attempts.recordings(), &Settings::default(), |_| {});
    let course = Course::read(&truth);
    for recording in analysed.findings() {
        let began_s = recording_began_s(&recording.path);
        let Some(shared) = recording.trial.as_ref().filter(|of| of.verdict.is_usable()) else {
            continue;
        };
        found.trials += 1;
        // No interval is claimed for a flagged trial.
        if !shared.misfit.is_empty() {
            found.flagged += 1;
            continue;
        }
        let n = recording.instances.len() as f64;
        let mean_of = |column: &str| {
            let each = recording.instances.iter();
            each.map(|of| course.mean(column, began_s + of.start_s, began_s + of.end_s))
                .sum::<f64>()
                / n
        };
        let (area, tau) = (&shared.contact_area_m2, &shared.tau_s);
        let (true_area, true_tau) = (mean_of("contact_area_m2"), mean_of("lag_s"));
        found.add("trial", "S", (area.value / true_area).ln(), area.ln_std);
        found.add("trial", "tau", (tau.value / true_tau).ln(), tau.ln_std);
        for instance in &recording.instances {
            found.instance(instance, &course, began_s);
        }
    }
    std::fs::remove_dir_all(&study).expect("the study goes");
    std::fs::remove_dir_all(&truth).expect("the truth goes");
    found
}

#[test]
fn intervals_are_of_the_right_size_and_those_of_400_people_hold_the_truth_to_the_per_cent() {
    let folder = tempfile::tempdir().expect("a folder");
    let participants = campaign::repeats("FRICTION_BENCH_COVERAGE", PARTICIPANTS);
    let found = (1..=participants as u64)
        .into_par_iter()
        .map(|seed| participant(seed, folder.path()))
        .reduce(Found::default, Found::merged);
    let counted = format!(
        "{} trials, {} instances, {} flagged",
        found.trials,
        found.of(("trial", "sigma_t")).len(),
        found.flagged
    );
    let keys = JUDGED.map(|quantity| ("trial", quantity));
    let before = ["sigma_t", "Re Z_t", "Im Z_t", "mu0", "mu"].map(|of| ("dynamic", of));
    let lines: Vec<String> = keys
        .iter()
        .chain(&before)
        .map(|key| found.line(*key))
        .collect();
    let z_t = ["trial", "dynamic"].map(|of| format!("{of} {:.2e}", found.median_z_t(of)));
    campaign::report(
        "intervals on an unkind bench",
        participants,
        &format!(
            "{counted}; {}; |Z_t - true|/|true|, medians: {}",
            lines.join("; "),
            z_t.join(", ")
        ),
    );

    assert!(found.trials * 10 >= participants * 8, "{counted}");
    assert!(found.flagged * 20 <= found.trials, "{counted}");
    for key in before {
        let (trial, dynamic) = (("trial", key.1), key);
        assert!(
            found.mean(trial, Stated::crps) < found.mean(dynamic, Stated::crps),
            "{}; {}",
            found.line(trial),
            found.line(dynamic)
        );
    }
    for key in keys {
        // A few people give few independent errors: all instances of one person share most of theirs.
        let rms = found.rms_z(key);
        assert!(rms < 2.5, "{}", found.line(key));
        if participants >= MANY {
            // Rounded to a per cent, the accuracy that so many people allow.
            let percent = |stds: f64| (100.0 * found.holds(key, stds)).round();
            assert!(
                (92.0..=98.0).contains(&percent(1.96))
                    && (62.0..=74.0).contains(&percent(0.9945))
                    && (0.85..=1.15).contains(&rms),
                "{}",
                found.line(key)
            );
        }
    }
    if participants >= MANY {
        let medians = [
            (found.median(("trial", "sigma_t")), MOST_SIGMA_T),
            (found.median_z_t("trial"), MOST_Z_T),
            (found.median(("trial", "S")), MOST_AREA),
        ];
        for (median, most) in medians {
            assert!(median <= most, "{medians:?}");
        }
    }
}
