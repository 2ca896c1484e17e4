//! Virtual participants, one session each: both methods compared with the truth that the estimator never sees. The results are
//! in docs/accuracy.md.

use std::path::Path;

use analysis::estimate::{InstanceEstimate, Method};
use analysis::{Analysis, Settings, analyse};
use attempts::find;
use bench_tests::campaign;
use bench_tests::session::{ALL_COMPLETED, VirtualParticipant, text};
use bench_tests::truth::Skin;
use rayon::prelude::*;
use statistics::quantile;

/// Number of participants in every test run; `FRICTION_BENCH_PARTICIPANTS` asks for more.
const PARTICIPANTS: usize = 10;
/// Levitation lag of the simulated film at rest, s (`film.lag_s` of the scenario).
const TAU_S: f64 = 1e-3;

/// Errors of one instance.
#[derive(Clone, Copy)]
struct Errors {
    /// |σ_t/true − 1|
    sigma_t: f64,
    /// |Z_t − true|/|true|
    z_t: f64,
    /// |τ − true|, s
    tau_s: f64,
    /// RMS of estimated minus measured friction.
    mu: f64,
}

impl Errors {
    fn new(estimate: &InstanceEstimate, truth: &Skin) -> Self {
        Self {
            sigma_t: (estimate.sigma_t_m() / truth.sigma_t_m - 1.0).abs(),
            z_t: (estimate.z_t_n_s_per_m - truth.z_t).norm() / truth.z_t.norm(),
            tau_s: estimate
                .tau_s
                .map_or(f64::NAN, |(tau, _)| (tau - TAU_S).abs()),
            mu: estimate.agreement.rms_mu,
        }
    }
}

/// Runs and analyses a session of one participant in a built-in scenario.
fn session(scenario: &str, seed: u64, folder: &Path) -> (Analysis, Skin) {
    let person = VirtualParticipant::run(scenario, seed, folder);
    // A participant who never presses correctly gets no accepted trial, and exit status 1; the attempts are recorded all the
    // same.
    let recordings = find::attempts(&[person.study], ALL_COMPLETED)
        .map(|attempts| attempts.recordings())
        .unwrap_or_else(|error| panic!("seed {seed}: {error}\n{}", text(&person.output)));
    let analysis = analyse(&recordings, &Settings::default(), |_| {});
    (analysis, Skin::read(&person.truth))
}

/// Returns the errors of `paper`, `dynamic` and `trial` over the instances of one participant.
fn participant(seed: u64, folder: &Path) -> [Vec<Errors>; 3] {
    let (analysis, true_skin) = session("population", seed, folder);
    Method::ALL.map(|method| {
        let estimates = analysis.instances().filter_map(|(_, i)| i.estimate(method));
        estimates
            .map(|estimate| Errors::new(estimate, &true_skin))
            .collect()
    })
}

/// Returns the median and the 90th percentile.
fn quantiles(errors: &[Errors], value: impl Fn(&Errors) -> f64) -> (f64, f64) {
    let mut values: Vec<f64> = errors.iter().map(value).filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let quantile_at = |share| quantile(&values, share).unwrap_or(f64::NAN);
    (quantile_at(0.5), quantile_at(0.9))
}

#[test]
fn both_methods_meet_their_error_quantiles_over_many_participants() {
    let folder = tempfile::tempdir().expect("a folder");
    let participants = campaign::repeats("FRICTION_BENCH_PARTICIPANTS", PARTICIPANTS);
    let participant_errors: Vec<_> = (1..=participants as u64)
        .into_par_iter()
        .map(|seed| participant(seed, folder.path()))
        .collect();
    let count = participant_errors
        .iter()
        .filter(|[paper, ..]| !paper.is_empty())
        .count();
    let [paper, dynamic, trial] = [0, 1, 2].map(|method| -> Vec<Errors> {
        participant_errors
            .iter()
            .flat_map(|errors| errors[method].clone())
            .collect()
    });

    println!("{count} participants, {} instances", dynamic.len());
    for (name, errors) in [("paper", &paper), ("dynamic", &dynamic), ("trial", &trial)] {
        println!(
            "{name}: sigma_t {:.3?}, Z_t {:.3?}, tau {:.5?} s, mu {:.4?} (median, 90th percentile)",
            quantiles(errors, |e| e.sigma_t),
            quantiles(errors, |e| e.z_t),
            quantiles(errors, |e| e.tau_s),
            quantiles(errors, |e| e.mu),
        );
    }

    let text = |name: &str, value: fn(&Errors) -> f64| {
        let (median, p90) = quantiles(&dynamic, value);
        format!("{name} {median:.2e}, {p90:.2e}")
    };
    campaign::report(
        "virtual participants",
        participants,
        &format!(
            "{count} with instances, {} instances; errors of `dynamic`, median and 90th percentile: {}; {}; {}; {}",
            dynamic.len(),
            text("sigma_t", |e| e.sigma_t),
            text("Z_t", |e| e.z_t),
            text("tau (s)", |e| e.tau_s),
            text("mu", |e| e.mu),
        ),
    );
    assert!(count >= participants, "{count} participants");
    assert!(dynamic.len() >= 5 * count, "{} instances", dynamic.len());
    let require_limits = |name: &str, (median, p90): (f64, f64), limits: (f64, f64)| {
        assert!(
            median <= limits.0 && p90 <= limits.1,
            "{name}: median {median}, 90th percentile {p90}, limits {limits:?}"
        );
    };
    require_limits("sigma_t", quantiles(&dynamic, |e| e.sigma_t), (0.02, 0.05));
    require_limits("Z_t", quantiles(&dynamic, |e| e.z_t), (0.04, 0.08));
    require_limits("tau", quantiles(&dynamic, |e| e.tau_s), (0.35e-3, 0.8e-3));
    require_limits("mu", quantiles(&dynamic, |e| e.mu), (0.006, 0.015));
    assert!(trial.len() * 20 >= dynamic.len() * 19, "{}", trial.len());
    require_limits(
        "trial, sigma_t",
        quantiles(&trial, |e| e.sigma_t),
        (0.01, 0.04),
    );
    require_limits("trial, Z_t", quantiles(&trial, |e| e.z_t), (0.015, 0.06));
    require_limits("trial, mu", quantiles(&trial, |e| e.mu), (0.003, 0.006));
    // The bias is inherent in the published method: it must neither grow nor shrink.
    for (name, (median, _), (from, to)) in [
        ("sigma_t", quantiles(&paper, |e| e.sigma_t), (0.5, 1.0)),
        ("Z_t", quantiles(&paper, |e| e.z_t), (0.5, 0.75)),
        ("mu", quantiles(&paper, |e| e.mu), (0.10, 0.20)),
    ] {
        assert!(
            (from..=to).contains(&median),
            "paper, {name}: median {median}"
        );
    }
}

#[test]
fn an_unkind_world_is_recorded_to_the_end_and_its_truth_is_not_what_dynamic_assumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (analysis, truth) = session("population-unkind", 4, folder.path());
    let errors: Vec<Errors> = analysis
        .instances()
        .map(|(_, instance)| Errors::new(&instance.dynamic, &truth))
        .collect();
    assert!(errors.len() >= 5, "{} instances", errors.len());
    let (sigma_t, _) = quantiles(&errors, |e| e.sigma_t);
    let area = truth.contact_area_m2 / Settings::default().contact_area_m2;
    println!("area {area:.2} of the assumed one, error of sigma_t {sigma_t:.2}");
    assert!(area < 0.8 && sigma_t > 0.2, "{area} {sigma_t}");
    let shift_hz = truth.resonance_shift_hz;
    assert!(shift_hz.abs() > 0.5, "{shift_hz} Hz");
    // S under the mean force, which is less than 1 N
    assert!(truth.contact_area_m2 < truth.pad["contact_area_m2"]);
}
