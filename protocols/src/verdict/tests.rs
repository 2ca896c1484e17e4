use super::*;
use crate::protocol::{Protocol, built_in};
use crate::stretch::{Instance, Rejection, Stretch, StretchOutcome};
use crate::trial::{Direction, TrialKey};

fn rules() -> VerdictRules {
    Protocol::parse(built_in("huloux2021").unwrap(), "huloux2021.toml")
        .unwrap()
        .verdict_rules()
}

fn stretch(outcome: StretchOutcome) -> Stretch {
    Stretch {
        start_s: 1.0,
        end_s: 1.083,
        outcome,
    }
}

fn accepted() -> Stretch {
    stretch(StretchOutcome::Accepted(Instance {
        start_s: 1.01,
        end_s: 1.07,
    }))
}

fn good() -> TrialAnalysis {
    let exploration = |direction| ExplorationAnalysis {
        direction,
        mean_normal_n: Some(0.65),
        mean_speed_m_per_s: Some(0.051),
        stretches: vec![accepted(); 6],
    };
    TrialAnalysis {
        key: TrialKey {
            number: 3,
            attempt: 1,
            practice: false,
            condition: "am".to_owned(),
        },
        explorations: vec![
            exploration(Direction::LeftToRight),
            exploration(Direction::RightToLeft),
        ],
        unloaded_mean_normal_n: Some(0.002),
        clipped_frames: 0,
        lost_frames: 0,
        input_xruns: 0,
        output_xruns: 0,
    }
}

/// The messages of the verdict on a good trial with a change.
fn messages(change: impl FnOnce(&mut TrialAnalysis)) -> Vec<String> {
    let mut analysis = good();
    change(&mut analysis);
    match judge(&analysis, &rules()) {
        Verdict::Accepted => Vec::new(),
        Verdict::Redo { reasons } => {
            assert!(!reasons.is_empty());
            reasons.iter().map(ToString::to_string).collect()
        }
    }
}

#[test]
fn a_good_trial_is_accepted() {
    assert_eq!(messages(|_| {}), [""; 0]);
}

#[test]
fn the_force_band_includes_its_ends() {
    for normal_n in [0.5, 0.8] {
        assert_eq!(
            messages(|a| a.explorations[0].mean_normal_n = Some(normal_n)),
            [""; 0]
        );
    }
    assert_eq!(
        messages(|a| a.explorations[1].mean_normal_n = Some(0.81)),
        ["exploration 2: mean normal force 0.81 N, outside 0.50 to 0.80 N"]
    );
}

#[test]
fn a_wrong_speed_is_said_in_mm_per_s() {
    assert_eq!(
        messages(|a| a.explorations[0].mean_speed_m_per_s = Some(0.030)),
        ["exploration 1: mean speed 30 mm/s, outside 38 to 62 mm/s"]
    );
}

#[test]
fn an_exploration_that_was_not_measured_is_named_once() {
    assert_eq!(
        messages(|a| {
            a.explorations[0].mean_normal_n = None;
            a.explorations[0].mean_speed_m_per_s = None;
        }),
        ["exploration 1: no valid force or position on the plate's central part"]
    );
}

#[test]
fn a_mean_that_is_no_number_was_not_measured() {
    let said = "exploration 1: no valid force or position on the plate's central part";
    let nan = Some(f64::NAN);
    assert_eq!(messages(|a| a.explorations[0].mean_normal_n = nan), [said]);
    assert_eq!(
        messages(|a| a.explorations[0].mean_speed_m_per_s = nan),
        [said]
    );
    assert_eq!(messages(|a| a.unloaded_mean_normal_n = nan).len(), 1);
}

#[test]
fn drop_outs_are_counted_against_their_limits() {
    assert_eq!(
        messages(|a| {
            a.clipped_frames = 3;
            a.lost_frames = 480;
            a.input_xruns = 1;
            a.output_xruns = 2;
        }),
        [
            "3 clipped frames, 0 allowed: lower the input gain or the amplitude",
            "480 lost frames, 0 allowed",
            "1 input and 2 output xruns, 0 allowed",
        ]
    );
}

#[test]
fn too_few_instances_name_the_commonest_rejection() {
    assert_eq!(messages(|a| a.explorations[0].stretches.clear()), [""; 0]);
    let slow = Rejection::Speed {
        speed_m_per_s: 0.02,
        min_m_per_s: 0.0375,
        max_m_per_s: 0.0625,
    };
    let other = Rejection::NoContact { least_n: 0.0 };
    assert_eq!(
        messages(|a| {
            a.explorations[0].stretches = vec![accepted(); 4];
            a.explorations[1].stretches = [other, slow, slow]
                .map(|r| stretch(StretchOutcome::Rejected(r)))
                .to_vec();
        }),
        ["4 instances, 5 needed; most other stretches: speed outside the tolerance"]
    );
}

#[test]
fn a_finger_on_the_plate_during_the_baseline_is_noticed() {
    assert_eq!(
        messages(|a| a.unloaded_mean_normal_n = Some(0.3)),
        [
            "finger on the plate during the baseline: mean normal force 0.30 N, less than 0.10 N needed"
        ]
    );
    assert_eq!(
        messages(|a| a.unloaded_mean_normal_n = None),
        ["the normal force of the baseline was not measured"]
    );
}

#[test]
fn all_reasons_are_given() {
    assert_eq!(
        messages(|a| {
            a.unloaded_mean_normal_n = Some(0.3);
            a.explorations[0].mean_normal_n = Some(0.2);
            a.explorations[0].mean_speed_m_per_s = Some(0.2);
            a.lost_frames = 1;
        })
        .len(),
        4
    );
}
