//! Estimates of every method in each simulated world, compared with the truth that the estimator never sees: the tables of
//! docs/accuracy.md. `./dev campaign worlds` renews them.

use std::collections::BTreeMap;
use std::path::Path;

use analysis::analysed::RecordingFindings;
use analysis::estimate::{Estimated, InstanceAnalysis, Method};
use analysis::model_check::quantile;
use analysis::{Settings, analyse, find};
use bench_tests::campaign;
use bench_tests::session::{ALL_COMPLETED, VirtualParticipant};
use bench_tests::truth::{Course, Skin, recording_began_s};
use mock_world::scenario::built_in_names;
use num_complex::Complex64;
use rayon::prelude::*;

/// Number of sessions of each world in every test run; `FRICTION_BENCH_WORLDS` asks for more.
const SESSIONS: usize = 1;
/// Number of sessions that shows how often a world is flagged.
const MANY: usize = 20;
/// RMS error of μ above which a method's friction is wrong.
const MOST_RMS_MU: f64 = 0.03;
/// Relative error of σ_t above which the estimate describes another finger.
const MOST_SIGMA_T: f64 = 0.1;

/// A person with randomly drawn skin and a contact area other than `dynamic` assumes.
const ANOTHER_AREA: &str =
    "purpose = \"A contact area of 220 mm2.\"\n[film]\ncontact_area_m2 = 220e-6\n";

/// Errors by method and quantity over the instances of a world, and its trials.
#[derive(Default)]
struct Found {
    errors: BTreeMap<(&'static str, &'static str), Vec<f64>>,
    /// Error over standard error.
    scores: BTreeMap<(&'static str, &'static str), Vec<f64>>,
    trials: Vec<OfTrial>,
}

impl Found {
    fn error(&mut self, method: &'static str, quantity: &'static str, error: f64) {
        if error.is_finite() {
            let of = self.errors.entry((method, quantity)).or_default();
            of.push(error.abs());
        }
    }

    fn score(&mut self, method: &'static str, quantity: &'static str, error: f64, std: f64) {
        if error.is_finite() && std > 0.0 {
            let of = self.scores.entry((method, quantity)).or_default();
            of.push(error / std);
        }
    }

    fn merged(mut self, other: Self) -> Self {
        for (of_all, of_other) in [
            (&mut self.errors, other.errors),
            (&mut self.scores, other.scores),
        ] {
            for (key, values) in of_other {
                of_all.entry(key).or_default().extend(values);
            }
        }
        self.trials.extend(other.trials);
        self
    }

    fn instance(&mut self, method: Method, estimated: &Estimated, true_skin: &TrueSkin) {
        let (name, sigma_t_m) = (method.name(), true_skin.sigma_t_m);
        let sigma_t = estimated.sigma_t_m / sigma_t_m - 1.0;
        let z_t = estimated.z_t_n_s_per_m - true_skin.z_t;
        self.error(name, "sigma_t", sigma_t);
        self.error(name, "Z_t", z_t.norm() / true_skin.z_t.norm());
        self.error(name, "RMS of mu", estimated.agreement.rms_mu);
        let stds = estimated.z_t_std_n_s_per_m;
        self.score(
            name,
            "sigma_t",
            sigma_t,
            estimated.sigma_t_std_m / sigma_t_m,
        );
        self.score(name, "Re Z_t", z_t.re, stds.re);
        self.score(name, "Im Z_t", z_t.im, stds.im);
        if let Some((tau_s, _)) = estimated.tau_s {
            self.error(name, "tau, ms", 1e3 * (tau_s - true_skin.lag_s));
        }
        if let Some(offset) = &estimated.plate_offset {
            let shift_hz = offset.resonance_shift_hz - true_skin.shift_hz;
            self.error(name, "shift, Hz", shift_hz);
        }
    }

    fn recording(&mut self, recording: &RecordingFindings, truth: &Path) {
        let (course, began_s) = (Course::read(truth), recording_began_s(&recording.path));
        let free_s = course.free_s(began_s);
        let at_first_hz = course.mean("resonance_shift_hz", free_s.0, free_s.1);
        let (mut areas_m2, mut sigmas_t, mut rms_mu) = (Vec::new(), Vec::new(), Vec::new());
        for instance in &recording.instances {
            let mut skin = TrueSkin::of(instance, &course, began_s);
            skin.shift_hz -= at_first_hz;
            areas_m2.push(skin.contact_area_m2);
            for method in Method::ALL {
                if let Some(estimated) = instance.estimated(method) {
                    self.instance(method, estimated, &skin);
                }
            }
            if let Some(estimated) = instance.estimated(Method::Trial) {
                sigmas_t.push((estimated.sigma_t_m / skin.sigma_t_m - 1.0).abs());
                rms_mu.push(estimated.agreement.rms_mu);
            }
        }
        let Some(shared) = recording.trial.as_ref().filter(|of| of.verdict.is_usable()) else {
            return;
        };
        self.trials.push(OfTrial {
            sigma_t: share_of(sigmas_t, 0.5),
            rms_mu: share_of(rms_mu, 0.5),
            flagged: !shared.misfit.is_empty(),
        });
        let pad = Skin::read(truth).pad;
        let assumed = Settings::default();
        let stiff = |q0: f64, modulus: f64, ratio: f64| q0 * modulus / (1.0 - ratio * ratio);
        let q0 = stiff(
            pad["q0_rad_per_m"],
            pad["youngs_modulus_pa"],
            pad["poisson_ratio"],
        ) / stiff(1.0, assumed.young_modulus_pa, assumed.poisson_ratio);
        let area_m2 = areas_m2.iter().sum::<f64>() / areas_m2.len() as f64;
        let area = &shared.contact_area_m2;
        self.error("trial", "S", area.value / area_m2 - 1.0);
        self.score("trial", "S", (area.value / area_m2).ln(), area.ln_std);
        self.error("trial", "q0", shared.q0_rad_per_m.value / q0 - 1.0);
        let loss_factor = shared.loss_factor.value - pad["loss_factor"];
        self.error("trial", "eta", loss_factor);
    }

    /// Returns the median and 90th percentile of each error, and the coverage of intervals.
    fn lines(&self) -> String {
        let errors = self.errors.iter().map(|((method, quantity), values)| {
            let at = |share| share_of(values.clone(), share);
            let count = values.len();
            format!(
                "{method} {quantity} {:.2e}, {:.2e} ({count})",
                at(0.5),
                at(0.9)
            )
        });
        let scores = self.scores.iter().map(|((method, quantity), scores)| {
            let n = scores.len() as f64;
            let within = |stds: f64| {
                let held = scores.iter().filter(|of| of.abs() < stds).count();
                100.0 * held as f64 / n
            };
            let rms = (scores.iter().map(|of| of * of).sum::<f64>() / n).sqrt();
            let (most, half) = (within(1.96), within(0.9945));
            format!("{method} {quantity}: intervals hold {most:.0}, {half:.0} %, RMS z {rms:.2}")
        });
        errors.chain(scores).collect::<Vec<_>>().join("; ")
    }

    fn flagged(&self) -> usize {
        self.trials.iter().filter(|of| of.flagged).count()
    }
}

/// Result of `trial` for one trial: medians over its instances.
struct OfTrial {
    sigma_t: f64,
    rms_mu: f64,
    flagged: bool,
}

impl OfTrial {
    fn is_wrong(&self) -> bool {
        self.sigma_t > MOST_SIGMA_T || self.rms_mu > MOST_RMS_MU
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
    fn of(instance: &InstanceAnalysis, course: &Course, began_s: f64) -> Self {
        let (from_s, to_s) = (began_s + instance.start_s, began_s + instance.end_s);
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
pub(crate) fn share_of(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, share).unwrap_or(f64::NAN)
}

/// Runs and analyses a session in a world.
fn session(world: &str, seed: u64, folder: &Path) -> Found {
    let person = VirtualParticipant::run(world, seed, folder);
    let mut found = Found::default();
    // A participant who never slides correctly leaves no data to analyse.
    if let Ok(found_there) = find::attempts(std::slice::from_ref(&person.study), ALL_COMPLETED) {
        let analysed = analyse(&found_there.recordings(), &Settings::default(), |_| {});
        for recording in analysed.findings() {
            found.recording(recording, &person.truth);
        }
    }
    std::fs::remove_dir_all(&person.study).expect("the study goes");
    std::fs::remove_dir_all(&person.truth).expect("the truth goes");
    found
}

#[test]
fn a_trial_of_each_world_is_right_or_flagged_and_false_alarms_of_20_are_few() {
    let folder = tempfile::tempdir().expect("a folder");
    let sessions = campaign::repeats("FRICTION_BENCH_WORLDS", SESSIONS);
    let another_area = folder.path().join("another-area.toml");
    std::fs::write(&another_area, ANOTHER_AREA).expect("a scenario");
    let populations = ["population", "population-unkind"].map(str::to_owned);
    let laws = built_in_names()
        .into_iter()
        .filter(|name| name.starts_with("laws/"));
    let worlds: Vec<String> = populations
        .into_iter()
        .chain([another_area.display().to_string()])
        .chain(laws.map(str::to_owned))
        .collect();
    assert!(worlds.len() >= 12, "{worlds:?}");
    let found: Vec<Found> = worlds
        .par_iter()
        .enumerate()
        .map(|(place, world)| {
            let folder = folder.path().join(place.to_string());
            std::fs::create_dir(&folder).expect("a folder for the world");
            (1..=sessions as u64)
                .into_par_iter()
                .map(|seed| session(world, seed, &folder))
                .reduce(Found::default, Found::merged)
        })
        .collect();
    for (world, found) in worlds.iter().zip(&found) {
        let (trials, flagged) = (found.trials.len(), found.flagged());
        let name = world
            .rsplit_once("/another")
            .map_or(world.as_str(), |_| "population, S = 220 mm²");
        campaign::report(
            &format!("errors in {name}"),
            sessions,
            &format!("{trials} trials, {flagged} flagged; {}", found.lines()),
        );
    }
    for (world, found) in worlds.iter().zip(&found) {
        let (trials, flagged) = (found.trials.len(), found.flagged());
        let trusted = found.trials.iter().filter(|of| !of.flagged);
        let wrong = trusted.filter(|of| of.is_wrong()).count();
        assert!(
            wrong * 10 <= trials,
            "{world}: {wrong} of {trials} are wrong and not flagged"
        );
        if !world.starts_with("laws/") && sessions >= MANY {
            assert!(
                flagged * 20 <= trials,
                "{world}: {flagged} of {trials} flagged"
            );
        }
    }
}
