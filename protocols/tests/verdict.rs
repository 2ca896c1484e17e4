//! Trials with a known verdict.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use protocols::verdict::*;
use protocols::{
    Direction, Instance, Protocol, Rejection, Stretch, StretchOutcome, TrialKey, built_in,
};

fn rules() -> VerdictRules {
    Protocol::parse(built_in("huloux2021").unwrap(), "huloux2021.toml")
        .unwrap()
        .verdict_rules("am-6hz-95")
}

#[test]
fn a_trial_without_a_modulation_needs_no_instance() {
    let text = built_in("huloux2021").unwrap();
    let steady = text.replace("modulation_index = 0.95", "modulation_index = 0.0");
    assert_ne!(steady, text);
    let mut analysis = good_analysis();
    for exploration in &mut analysis.explorations {
        exploration.stretches.clear();
    }
    for (text, is_accepted) in [(text, false), (steady.as_str(), true)] {
        let protocol = Protocol::parse(text, "p.toml").unwrap();
        let verdict = judge(&analysis, &protocol.verdict_rules("am-6hz-95"));
        assert_eq!(verdict == Verdict::Accepted, is_accepted, "{verdict:?}");
    }
}

fn stretch(outcome: StretchOutcome) -> Stretch {
    Stretch {
        start_s: 1.0,
        end_s: 1.083,
        outcome,
    }
}

fn accepted_stretch() -> Stretch {
    stretch(StretchOutcome::Accepted(Instance {
        start_s: 1.01,
        end_s: 1.07,
    }))
}

fn good_analysis() -> TrialAnalysis {
    let exploration = |direction| ExplorationAnalysis {
        direction,
        mean_normal_n: Some(0.65),
        mean_speed_m_per_s: Some(0.051),
        lifted_s: 0.0,
        stretches: vec![accepted_stretch(); 6],
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

/// Returns the verdict's reasons for a good trial with one change.
fn reasons(change: impl FnOnce(&mut TrialAnalysis)) -> Vec<RedoReason> {
    let mut analysis = good_analysis();
    change(&mut analysis);
    match judge(&analysis, &rules()) {
        Verdict::Accepted => Vec::new(),
        Verdict::Redo { reasons } => {
            assert!(!reasons.is_empty());
            reasons
        }
    }
}

#[test]
fn a_good_trial_is_accepted() {
    assert_eq!(reasons(|_| {}), []);
}

#[test]
fn the_force_band_includes_its_ends() {
    for normal_n in [0.5, 0.8] {
        assert_eq!(
            reasons(|a| a.explorations[0].mean_normal_n = Some(normal_n)),
            []
        );
    }
    assert_eq!(
        reasons(|a| a.explorations[1].mean_normal_n = Some(0.81)),
        [RedoReason::ForceOutOfBand {
            exploration: 2,
            mean_n: 0.81,
            min_n: 0.5,
            max_n: 0.8
        }]
    );
}

#[test]
fn a_wrong_speed_is_given_with_its_limits() {
    let reasons = reasons(|a| a.explorations[0].mean_speed_m_per_s = Some(0.030));
    let [
        RedoReason::SpeedOutOfBand {
            exploration: 1,
            speed_m_per_s: 0.030,
            min_m_per_s,
            max_m_per_s,
        },
    ] = reasons[..]
    else {
        panic!("{reasons:?}")
    };
    assert!((min_m_per_s - 0.0375).abs() < 1e-12);
    assert!((max_m_per_s - 0.0625).abs() < 1e-12);
}

#[test]
fn an_exploration_that_was_not_measured_is_named_once() {
    assert_eq!(
        reasons(|a| {
            a.explorations[0].mean_normal_n = None;
            a.explorations[0].mean_speed_m_per_s = None;
        }),
        [RedoReason::NotMeasured { exploration: 1 }]
    );
}

#[test]
fn a_lifted_finger_is_named_and_a_short_bounce_is_not() {
    let lifted = |lifted_s| {
        reasons(|a| {
            a.explorations[1].mean_normal_n = None;
            a.explorations[1].mean_speed_m_per_s = None;
            a.explorations[1].lifted_s = lifted_s;
        })
    };
    let named = RedoReason::FingerLifted {
        exploration: 2,
        lifted_s: 0.26,
        limit_s: 0.06,
    };
    assert_eq!(lifted(0.26), [named]);
    assert_eq!(lifted(0.02), [RedoReason::NotMeasured { exploration: 2 }]);
    assert_eq!(reasons(|a| a.explorations[1].lifted_s = 0.02), []);
    assert_eq!(reasons(|a| a.explorations[1].lifted_s = 0.06).len(), 1);
}

#[test]
fn a_mean_that_is_no_number_was_not_measured() {
    let reasons_expected = [RedoReason::NotMeasured { exploration: 1 }];
    let nan = Some(f64::NAN);
    assert_eq!(
        reasons(|a| a.explorations[0].mean_normal_n = nan),
        reasons_expected
    );
    assert_eq!(
        reasons(|a| a.explorations[0].mean_speed_m_per_s = nan),
        reasons_expected
    );
    assert_eq!(
        reasons(|a| a.unloaded_mean_normal_n = nan),
        [RedoReason::BaselineNotMeasured]
    );
}

#[test]
fn drop_outs_are_counted_against_their_limits() {
    assert_eq!(
        reasons(|a| {
            a.clipped_frames = 3;
            a.lost_frames = 480;
            a.input_xruns = 1;
            a.output_xruns = 2;
        }),
        [
            RedoReason::Clipped {
                frames: 3,
                limit: 0
            },
            RedoReason::LostSamples {
                frames: 480,
                limit: 0
            },
            RedoReason::Xruns {
                input: 1,
                output: 2,
                limit: 0
            },
        ]
    );
}

#[test]
fn too_few_instances_name_the_commonest_rejection() {
    assert_eq!(reasons(|a| a.explorations[0].stretches.clear()), []);
    let slow = Rejection::Speed {
        speed_m_per_s: 0.02,
        min_m_per_s: 0.0375,
        max_m_per_s: 0.0625,
    };
    let no_contact = Rejection::NoContact { least_n: 0.0 };
    assert_eq!(
        reasons(|a| {
            a.explorations[0].stretches = vec![accepted_stretch(); 4];
            a.explorations[1].stretches = [no_contact, slow, slow]
                .map(|r| stretch(StretchOutcome::Rejected(r)))
                .to_vec();
        }),
        [RedoReason::TooFewInstances {
            found: 4,
            needed: 5,
            mostly: Some(slow.kind().to_owned())
        }]
    );
}

#[test]
fn a_finger_on_the_plate_during_the_baseline_is_noticed() {
    assert_eq!(
        reasons(|a| a.unloaded_mean_normal_n = Some(0.3)),
        [RedoReason::FingerOnPlate {
            mean_n: 0.3,
            limit_n: 0.1
        }]
    );
    assert_eq!(
        reasons(|a| a.unloaded_mean_normal_n = None),
        [RedoReason::BaselineNotMeasured]
    );
}

#[test]
fn all_reasons_are_given() {
    let reasons = reasons(|a| {
        a.unloaded_mean_normal_n = Some(0.3);
        a.explorations[0].mean_normal_n = Some(0.2);
        a.explorations[0].mean_speed_m_per_s = Some(0.2);
        a.lost_frames = 1;
    });
    assert!(
        matches!(
            reasons[..],
            [
                RedoReason::FingerOnPlate { .. },
                RedoReason::ForceOutOfBand { exploration: 1, .. },
                RedoReason::SpeedOutOfBand { exploration: 1, .. },
                RedoReason::LostSamples { frames: 1, .. },
            ]
        ),
        "{reasons:?}"
    );
}

#[test]
fn the_operator_reads_values_and_limits_in_handy_units() {
    let speed = RedoReason::SpeedOutOfBand {
        exploration: 1,
        speed_m_per_s: 0.030,
        min_m_per_s: 0.0375,
        max_m_per_s: 0.0625,
    };
    assert_eq!(
        speed.to_string(),
        "exploration 1: mean speed 30 mm/s, outside 38 to 62 mm/s"
    );
    let too_few = RedoReason::TooFewInstances {
        found: 4,
        needed: 5,
        mostly: Some("too short".to_owned()),
    };
    assert_eq!(
        too_few.to_string(),
        "4 instances, 5 needed; most other stretches: too short"
    );
}
