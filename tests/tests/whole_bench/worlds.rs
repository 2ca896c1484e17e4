//! Estimates of every method in each simulated world, compared with the truth that the estimator never sees: the tables of
//! docs/accuracy.md. `./dev campaign worlds` renews them.

use std::collections::BTreeMap;
use std::path::Path;

use analysis::estimate::{InstanceAnalysis, InstanceEstimate, Method};
use analysis::findings::RecordingFindings;
use analysis::within_laws::WithinLaws;
use analysis::{Settings, analyse};
use attempts::find;
use bench_tests::campaign;
use bench_tests::session::{ALL_COMPLETED, VirtualParticipant};
use bench_tests::truth::{Course, Skin, recording_began_s};
use mock_world::scenario::built_in_names;
use num_complex::Complex64;
use rayon::prelude::*;
use statistics::quantile;

/// Number of sessions of each world in every test run; `FRICTION_BENCH_WORLDS` asks for more.
const SESSIONS: usize = 1;
/// Number of sessions that shows how often a world is flagged.
const MANY: usize = 20;
/// RMS error of μ above which a method's friction is wrong.
const LIMIT_RMS_MU: f64 = 0.03;
/// Relative error of σ_t above which the estimate describes another finger.
const LIMIT_SIGMA_T: f64 = 0.1;

/// A person with randomly drawn skin and a contact area other than `dynamic` assumes.
const LARGE_AREA: &str =
    "purpose = \"A contact area of 220 mm2.\"\n[film]\ncontact_area_m2 = 220e-6\n";

/// `trial` with the published laws taken as true.
const WITHIN_LAWS: &str = "trial within laws";

/// Errors by method and quantity over the instances of a world, and its trials.
#[derive(Default)]
struct WorldErrors {
    errors: BTreeMap<(&'static str, &'static str), Vec<f64>>,
    /// Error over standard error.
    scores: BTreeMap<(&'static str, &'static str), Vec<f64>>,
    trials: Vec<TrialResult>,
}

impl WorldErrors {
    fn error(&mut self, method: &'static str, quantity: &'static str, error: f64) {
        if error.is_finite() {
            let errors = self.errors.entry((method, quantity)).or_default();
            errors.push(error.abs());
        }
    }

    fn score(&mut self, method: &'static str, quantity: &'static str, error: f64, std: f64) {
        if error.is_finite() && std > 0.0 {
            let scores = self.scores.entry((method, quantity)).or_default();
            scores.push(error / std);
        }
    }

    fn merge(mut self, other: Self) -> Self {
        for (all_values, new_values) in [
            (&mut self.errors, other.errors),
            (&mut self.scores, other.scores),
        ] {
            for (key, values) in new_values {
                all_values.entry(key).or_default().extend(values);
            }
        }
        self.trials.extend(other.trials);
        self
    }

    fn instance(&mut self, method: Method, estimate: &InstanceEstimate, truth: &TrueSkin) {
        let (name, sigma_t_m) = (method.name(), truth.sigma_t_m);
        let sigma_t = estimate.sigma_t_m() / sigma_t_m - 1.0;
        let z_t = estimate.z_t_n_s_per_m - truth.z_t;
        self.error(name, "sigma_t", sigma_t);
        self.error(name, "Z_t", z_t.norm() / truth.z_t.norm());
        self.error(name, "RMS of mu", estimate.agreement.rms_mu);
        let stds = estimate.z_t_std_n_s_per_m;
        self.score(
            name,
            "sigma_t",
            sigma_t,
            estimate.sigma_t_std_m() / sigma_t_m,
        );
        self.score(name, "Re Z_t", z_t.re, stds.re);
        self.score(name, "Im Z_t", z_t.im, stds.im);
        if let Some((tau_s, _)) = estimate.tau_s {
            self.error(name, "tau, ms", 1e3 * (tau_s - truth.lag_s));
        }
        if let Some(offset) = &estimate.plate_offset {
            let shift_hz = offset.resonance_shift_hz - truth.shift_hz;
            self.error(name, "shift, Hz", shift_hz);
        }
    }

    fn score_within_laws(&mut self, estimate: &WithinLaws, truth: &TrueSkin) {
        let (sigma_t, z_t) = (&estimate.sigma_t_m, estimate.z_t_n_s_per_m - truth.z_t);
        let stds = estimate.z_t_std_n_s_per_m;
        let ratio = sigma_t.value / truth.sigma_t_m;
        self.score(WITHIN_LAWS, "sigma_t", ratio - 1.0, ratio * sigma_t.ln_std);
        self.score(WITHIN_LAWS, "Re Z_t", z_t.re, stds.re);
        self.score(WITHIN_LAWS, "Im Z_t", z_t.im, stds.im);
    }

    fn recording(&mut self, recording: &RecordingFindings, truth: &Path) {
        let (course, recording_s) = (Course::read(truth), recording_began_s(&recording.path));
        let free_s = course.free_s(recording_s);
        let initial_shift_hz = course.mean("resonance_shift_hz", free_s.0, free_s.1);
        let (mut areas_m2, mut sigmas_t, mut rms_mu) = (Vec::new(), Vec::new(), Vec::new());
        for instance in &recording.instances {
            let mut skin = TrueSkin::mean_over(instance, &course, recording_s);
            skin.shift_hz -= initial_shift_hz;
            areas_m2.push(skin.contact_area_m2);
            for method in Method::ALL {
                if let Some(estimate) = instance.estimate(method) {
                    self.instance(method, estimate, &skin);
                }
            }
            if let Some(estimate) = &instance.within_laws {
                self.score_within_laws(estimate, &skin);
            }
            if let Some(estimate) = instance.estimate(Method::Trial) {
                sigmas_t.push((estimate.sigma_t_m() / skin.sigma_t_m - 1.0).abs());
                rms_mu.push(estimate.agreement.rms_mu);
            }
        }
        let Some(trial) = recording
            .trial
            .as_ref()
            .filter(|trial| trial.verdict.is_usable())
        else {
            return;
        };
        self.trials.push(TrialResult {
            sigma_t: quantile_of(sigmas_t, 0.5),
            rms_mu: quantile_of(rms_mu, 0.5),
            flagged: !trial.misfit.is_empty(),
        });
        let pad = Skin::read(truth).pad;
        let settings = Settings::default();
        let plane_modulus =
            |q0: f64, modulus: f64, ratio: f64| q0 * modulus / (1.0 - ratio * ratio);
        let q0 = plane_modulus(
            pad["q0_rad_per_m"],
            pad["youngs_modulus_pa"],
            pad["poisson_ratio"],
        ) / plane_modulus(1.0, settings.young_modulus_pa, settings.poisson_ratio);
        let area_m2 = areas_m2.iter().sum::<f64>() / areas_m2.len() as f64;
        let area = &trial.contact_area_m2;
        self.error("trial", "S", area.value / area_m2 - 1.0);
        self.score("trial", "S", (area.value / area_m2).ln(), area.ln_std);
        if let Some(within_laws) = recording.fit_within_laws() {
            let area = &within_laws.contact_area_m2;
            self.score(WITHIN_LAWS, "S", (area.value / area_m2).ln(), area.ln_std);
        }
        self.error("trial", "q0", trial.q0_rad_per_m.value / q0 - 1.0);
        let loss_factor = trial.loss_factor.value - pad["loss_factor"];
        self.error("trial", "eta", loss_factor);
    }

    /// Returns the median and 90th percentile of each error, and the coverage of intervals.
    fn lines(&self) -> String {
        let errors = self.errors.iter().map(|((method, quantity), values)| {
            let value_at = |share| quantile_of(values.clone(), share);
            let count = values.len();
            format!(
                "{method} {quantity} {:.2e}, {:.2e} ({count})",
                value_at(0.5),
                value_at(0.9)
            )
        });
        let scores = self.scores.iter().map(|((method, quantity), scores)| {
            let n = scores.len() as f64;
            let coverage_percent = |stds: f64| {
                let hits = scores.iter().filter(|score| score.abs() < stds).count();
                100.0 * hits as f64 / n
            };
            let rms = (scores.iter().map(|score| score * score).sum::<f64>() / n).sqrt();
            let (coverage_95, coverage_68) = (coverage_percent(1.96), coverage_percent(0.9945));
            format!("{method} {quantity}: intervals hold {coverage_95:.0}, {coverage_68:.0} %, RMS z {rms:.2}")
        });
        errors.chain(scores).collect::<Vec<_>>().join("; ")
    }

    fn flagged(&self) -> usize {
        self.trials.iter().filter(|trial| trial.flagged).count()
    }
}

/// Result of `trial` for one trial: medians over its instances.
struct TrialResult {
    sigma_t: f64,
    rms_mu: f64,
    flagged: bool,
}

impl TrialResult {
    fn is_wrong(&self) -> bool {
        self.sigma_t > LIMIT_SIGMA_T || self.rms_mu > LIMIT_RMS_MU
    }
}

/// True skin and plate during an instance.
struct TrueSkin {
    sigma_t_m: f64,
    z_t: Complex64,
    contact_area_m2: f64,
    lag_s: f64,
    shift_hz: f64,
}

impl TrueSkin {
    fn mean_over(instance: &InstanceAnalysis, course: &Course, recording_s: f64) -> Self {
        let (from_s, to_s) = (recording_s + instance.start_s, recording_s + instance.end_s);
        let mean = |column| course.mean(column, from_s, to_s);
        Self {
            sigma_t_m: mean("sigma_t_m"),
            z_t: Complex64::new(mean("re_z_t_n_s_per_m"), mean("im_z_t_n_s_per_m")),
            contact_area_m2: mean("contact_area_m2"),
            lag_s: mean("lag_s"),
            shift_hz: mean("resonance_shift_hz"),
        }
    }
}

/// Returns the quantile of the values at `share`.
pub(crate) fn quantile_of(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, share).unwrap_or(f64::NAN)
}

/// Runs and analyses a session in a world.
fn session(world: &str, seed: u64, folder: &Path) -> WorldErrors {
    let person = VirtualParticipant::run(world, seed, folder);
    let mut errors = WorldErrors::default();
    // A participant who never slides correctly leaves no data to analyse.
    if let Ok(attempts) = find::attempts(std::slice::from_ref(&person.study), ALL_COMPLETED) {
        let analysis = analyse(&attempts.recordings(), &Settings::default(), |_| {});
        for recording in analysis.findings() {
            errors.recording(recording, &person.truth);
        }
    }
    std::fs::remove_dir_all(&person.study).expect("the study goes");
    std::fs::remove_dir_all(&person.truth).expect("the truth goes");
    errors
}

#[test]
fn a_trial_of_each_world_is_right_or_flagged_and_false_alarms_of_20_are_few() {
    let folder = tempfile::tempdir().expect("a folder");
    let sessions = campaign::repeats("FRICTION_BENCH_WORLDS", SESSIONS);
    let large_area = folder.path().join("another-area.toml");
    std::fs::write(&large_area, LARGE_AREA).expect("a scenario");
    let populations = ["population", "population-unkind"].map(str::to_owned);
    let laws = built_in_names()
        .into_iter()
        .filter(|name| name.starts_with("laws/"));
    let worlds: Vec<String> = populations
        .into_iter()
        .chain([large_area.display().to_string()])
        .chain(laws.map(str::to_owned))
        .collect();
    assert!(worlds.len() >= 12, "{worlds:?}");
    let world_errors: Vec<WorldErrors> = worlds
        .par_iter()
        .enumerate()
        .map(|(index, world)| {
            let folder = folder.path().join(index.to_string());
            std::fs::create_dir(&folder).expect("a folder for the world");
            (1..=sessions as u64)
                .into_par_iter()
                .map(|seed| session(world, seed, &folder))
                .reduce(WorldErrors::default, WorldErrors::merge)
        })
        .collect();
    for (world, errors) in worlds.iter().zip(&world_errors) {
        let (trials, flagged) = (errors.trials.len(), errors.flagged());
        let name = world
            .rsplit_once("/another")
            .map_or(world.as_str(), |_| "population, S = 220 mm²");
        campaign::report(
            &format!("errors in {name}"),
            sessions,
            &format!("{trials} trials, {flagged} flagged; {}", errors.lines()),
        );
    }
    for (world, errors) in worlds.iter().zip(&world_errors) {
        let (trials, flagged) = (errors.trials.len(), errors.flagged());
        let unflagged = errors.trials.iter().filter(|trial| !trial.flagged);
        let wrong_count = unflagged.filter(|trial| trial.is_wrong()).count();
        assert!(
            wrong_count * 10 <= trials,
            "{world}: {wrong_count} of {trials} are wrong and not flagged"
        );
        if !world.starts_with("laws/") && sessions >= MANY {
            assert!(
                flagged * 20 <= trials,
                "{world}: {flagged} of {trials} flagged"
            );
        }
    }
}
