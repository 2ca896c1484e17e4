use approx::assert_relative_eq;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

const STD: f64 = 0.01;

fn condition(drive_v: f64, modulation_hz: f64) -> Condition {
    Condition {
        drive_v,
        modulation_hz,
        carrier_hz: 35_000.0,
    }
}

/// Returns a trial with these values, each with a standard error of 0.01.
fn trial(condition: Condition, values: [f64; 5]) -> CheckedTrial {
    CheckedTrial {
        condition,
        estimates: Quantities::from_fn(|quantity| Estimate::new(values[quantity], STD)),
    }
}

/// Returns the trials of two drive levels and two modulation frequencies, five of each, that scatter by `scatter`; `shift` moves
/// each value by the condition.
fn balanced_trials(
    rng: &mut impl Rng,
    scatter: f64,
    shift: impl Fn(&Condition) -> [f64; 5],
) -> Vec<CheckedTrial> {
    let mut trials = Vec::new();
    for _ in 0..5 {
        for (drive_v, modulation_hz) in [(12.0, 3.0), (12.1, 6.0), (24.2, 3.0), (24.0, 6.0)] {
            let condition = condition(drive_v, modulation_hz);
            let values = shift(&condition).map(|shift| {
                let deviation: f64 = StandardNormal.sample(rng);
                1.0 + shift + scatter * deviation
            });
            trials.push(trial(condition, values));
        }
    }
    trials
}

fn find(check: &LawCheck, setting: Setting) -> &Comparison {
    let mut comparisons = check.comparisons.iter();
    comparisons
        .find(|comparison| comparison.setting == setting)
        .unwrap()
}

fn agreements(comparison: &Comparison) -> [bool; 5] {
    comparison
        .differences
        .as_array()
        .map(|difference| difference.unwrap().agrees)
}

#[test]
fn equal_conditions_agree() {
    let mut rng = ChaCha8Rng::seed_from_u64(30);
    let check = check("sub-01", &balanced_trials(&mut rng, STD, |_| [0.0; 5]), 1).unwrap();
    let conditions: Vec<_> = check.conditions.iter().map(|row| row.n_trials).collect();
    assert_eq!(conditions, [5; 4]);
    let settings: Vec<_> = check
        .comparisons
        .iter()
        .map(|comparison| comparison.setting)
        .collect();
    assert_eq!(settings, [Setting::DriveV, Setting::ModulationHz]);
    for comparison in &check.comparisons {
        assert_eq!(agreements(comparison), [true; 5], "{comparison:?}");
    }
    let drive = find(&check, Setting::DriveV);
    assert_relative_eq!(drive.lower, 12.05);
    assert_relative_eq!(drive.upper, 24.1);
    let lines = check.lines();
    assert_eq!(
        lines[0],
        "law check of sub-01, 20 trials under 4 conditions, 1 left out: the estimates agree"
    );
    assert!(
        lines[1].starts_with("  drive 12.1 and 24.1 V: σ_t agrees ("),
        "{}",
        lines[1]
    );
    assert_eq!(lines.len(), 3);
}

#[test]
fn a_quantity_that_follows_a_setting_differs_by_its_size() {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let shift = |condition: &Condition| {
        let growth = if condition.drive_v > 20.0 { 0.1 } else { 0.0 };
        [0.0, growth, 0.0, 0.0, 0.0]
    };
    let check = check("sub-01", &balanced_trials(&mut rng, STD, shift), 0).unwrap();
    let drive = find(&check, Setting::DriveV);
    assert_eq!(agreements(drive), [true, false, true, true, true]);
    assert_eq!(agreements(find(&check, Setting::ModulationHz)), [true; 5]);
    let difference = drive.differences.ln_contact_area.unwrap();
    let [low, high] = difference.interval95;
    assert!(
        (low..high).contains(&0.1) && difference.p_adjusted < 1e-6,
        "{difference:?}"
    );
    // Two strata of 2 × 5 trials: (σ²/5 + σ²/5)/2, if the scatter is that of the errors.
    assert_relative_eq!(difference.std, STD * 0.2_f64.sqrt(), max_relative = 0.3);
    assert_eq!(check.verdict(), "1 of 10 differences exceed their errors");
    let [_, (symbol, words), ..] = drive.words();
    assert_eq!(symbol, "S");
    assert!(
        words.starts_with("differs by +1") && words.ends_with(" % (p < 0.001)"),
        "{words}"
    );
}

/// The scatter between trials is five times their stated errors, as that of a finger that changes.
#[test]
fn scatter_between_trials_is_part_of_the_error() {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    let mut disagreements = 0;
    let people = 1000;
    for _ in 0..people {
        let check = check(
            "sub-01",
            &balanced_trials(&mut rng, 5.0 * STD, |_| [0.0; 5]),
            0,
        )
        .unwrap();
        disagreements += usize::from(
            check
                .comparisons
                .iter()
                .flat_map(agreements)
                .any(|agrees| !agrees),
        );
    }
    assert!(
        (20..=80).contains(&disagreements),
        "{disagreements} of {people}, nominally 50"
    );
}

#[test]
fn two_conditions_of_equal_errors_are_compared_by_welchs_test() {
    // Far beyond the stated errors, all weights are equal.
    let low = [1.0, 1.3, 0.8, 1.1];
    let high = [1.6, 1.2, 2.0];
    let values = |values: &[f64], drive_v| -> Vec<_> {
        values
            .iter()
            .map(|value| trial(condition(drive_v, 6.0), [*value; 5]))
            .collect()
    };
    let trials = [values(&low, 12.0), values(&high, 24.0)].concat();
    let difference = check("sub-01", &trials, 0).unwrap().comparisons[0]
        .differences
        .ln_tau
        .unwrap();
    let (mean_low, mean_high) = (4.2 / 4.0, 4.8 / 3.0);
    let (variance_low, variance_high) = (0.13 / 3.0 / 4.0, 0.32 / 2.0 / 3.0);
    let variance: f64 = variance_low + variance_high;
    let freedom = variance * variance
        / (variance_low * variance_low / 3.0 + variance_high * variance_high / 2.0);
    assert_relative_eq!(difference.value, mean_high - mean_low, max_relative = 1e-9);
    assert_relative_eq!(difference.std, variance.sqrt(), max_relative = 1e-9);
    assert_relative_eq!(difference.freedom, freedom, max_relative = 1e-9);
}

#[test]
fn p_values_are_adjusted_by_holm() {
    let mut rng = ChaCha8Rng::seed_from_u64(33);
    let check = check("sub-01", &balanced_trials(&mut rng, STD, |_| [0.0; 5]), 0).unwrap();
    let differences = check
        .comparisons
        .iter()
        .flat_map(|comparison| comparison.differences.as_array());
    let mut differences: Vec<Difference> =
        differences.map(|difference| difference.unwrap()).collect();
    differences.sort_by(|a, b| a.p.total_cmp(&b.p));
    assert_eq!(differences.len(), 10);
    assert_relative_eq!(
        differences[0].p_adjusted,
        (10.0 * differences[0].p).min(1.0)
    );
    assert!(
        differences
            .iter()
            .all(|difference| difference.p_adjusted >= difference.p)
    );
    assert!(differences.is_sorted_by(|a, b| a.p_adjusted <= b.p_adjusted));
}

#[test]
fn one_condition_is_not_checked() {
    let trials: Vec<_> = [11.8, 12.0, 12.3, 12.9]
        .map(|drive_v| trial(condition(drive_v, 6.0), [1.0; 5]))
        .into();
    assert_eq!(check("sub-01", &trials, 0), None);
    assert_eq!(check("sub-01", &[], 3), None);
}

#[test]
fn a_condition_with_one_trial_is_not_compared() {
    let trials = [12.0, 12.0, 24.0].map(|drive_v| trial(condition(drive_v, 6.0), [1.0; 5]));
    let check = check("sub-01", &trials, 0).unwrap();
    assert_eq!(check.comparisons.len(), 1);
    assert_eq!(check.comparisons[0].differences, Quantities::default());
    assert_eq!(
        check.verdict(),
        "not compared, because each condition needs two trials"
    );
    assert!(check.lines()[1].contains("τ not compared: too few trials"));
}

#[test]
fn an_unknown_estimate_leaves_out_its_quantity_alone() {
    let mut trials: Vec<_> = [12.0, 12.0, 24.0, 24.0]
        .map(|drive_v| trial(condition(drive_v, 6.0), [1.0; 5]))
        .into();
    trials[0].estimates.ln_tau = Estimate::new(1.0, f64::INFINITY);
    let differences = check("sub-01", &trials, 0).unwrap().comparisons[0].differences;
    assert!(differences.ln_tau.is_none() && differences.ln_sigma_t.is_some());
}

#[test]
fn conditions_that_differ_in_several_settings_are_not_compared() {
    let conditions = [condition(12.0, 3.0), condition(24.0, 6.0)];
    let trials: Vec<_> = conditions
        .iter()
        .flat_map(|condition| [trial(*condition, [1.0; 5]); 3])
        .collect();
    let check = check("sub-01", &trials, 0).unwrap();
    assert_eq!((check.conditions.len(), check.comparisons.len()), (2, 0));
    assert!(
        check
            .verdict()
            .starts_with("not compared, because the conditions differ")
    );
}

/// A second carrier has another calibration, with an error that all of its trials share.
#[test]
fn errors_between_carriers_do_not_shrink_with_the_number_of_trials() {
    let carriers = [28_000.0, 28_020.0, 35_000.0, 35_030.0];
    let trials: Vec<_> = carriers
        .iter()
        .flat_map(|carrier_hz| {
            let condition = Condition {
                carrier_hz: *carrier_hz,
                ..condition(12.0, 6.0)
            };
            [trial(condition, [1.0; 5]); 8]
        })
        .collect();
    let check = check("sub-01", &trials, 0).unwrap();
    assert_eq!(check.conditions.len(), 2);
    let carrier = find(&check, Setting::CarrierHz);
    assert_relative_eq!(
        carrier.differences.ln_sigma_t.unwrap().std,
        STD * 2.0_f64.sqrt(),
        max_relative = 1e-9
    );
}
