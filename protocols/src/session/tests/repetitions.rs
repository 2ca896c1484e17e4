//! Verdicts and the repetitions that they cause.

use super::rig::*;
use crate::record::{TrialOutcome, TrialRecord};
use crate::redo_reason::RedoReason;
use crate::session::commands::Refusal;
use crate::session::*;
use crate::trial::*;
use crate::verdict::Verdict;
use participant_texts::RepeatCause;

#[test]
fn a_pause_keeps_the_open_verdict() {
    for (normal_n, repeats) in [(0.65, false), (1.2, true)] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.run_until_main(Phase::Baseline);
        rig.normal_n = normal_n;
        rig.run_until(Phase::Verdict);
        rig.tell(OperatorCommand::Pause);
        assert_eq!(rig.session.phase(), Phase::Paused);
        assert!(rig.session.is_judged());
        assert_eq!(rig.session.verdict_repeats(), repeats);
    }
}

#[test]
fn a_bad_trial_is_repeated_with_its_reasons_until_the_limit() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until_main(Phase::Baseline);
    rig.normal_n = 1.2;
    let limit = rig.protocol.redo.max_per_trial;
    let mut open = Vec::new();
    while rig.begun_trials().last().unwrap().number == 2 {
        rig.step(|_| {});
        if rig.session.phase() == Phase::Verdict {
            let repetitions = rig.session.repetitions_left().0;
            open.push((rig.session.verdict_repeats(), repetitions));
        }
    }
    open.dedup();
    let expected: Vec<_> = (0..=limit)
        .rev()
        .map(|repetitions| (repetitions > 0, repetitions))
        .collect();
    assert_eq!(open, expected);
    assert!(!rig.session.verdict_repeats());
    rig.normal_n = 0.65;
    rig.run_until(Phase::Finished);
    rig.check();
    let of_two: Vec<TrialRecord> = rig
        .session
        .records()
        .iter()
        .filter(|r| r.key.number == 2)
        .cloned()
        .collect();
    assert_eq!(of_two.len() as u32, limit + 1);
    for (i, record) in of_two.iter().enumerate() {
        assert_eq!(record.key.attempt as usize, i + 1);
        let reasons = match &record.outcome {
            TrialOutcome::Redo { reasons } => reasons,
            TrialOutcome::GivenUp { reasons } if i as u32 == limit => reasons,
            outcome => panic!("{outcome:?}"),
        };
        assert!(matches!(
            reasons[0],
            RedoReason::ForceOutOfBand { exploration: 1, .. }
        ));
    }
    let summary = rig.session.summary();
    assert_eq!(
        (summary.accepted, summary.redone, summary.given_up),
        (3, limit, 1)
    );
}

#[test]
fn the_participant_sees_the_cause_of_a_repetition_but_not_of_giving_up() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until_main(Phase::Baseline);
    rig.normal_n = 1.2;
    let mut causes = Vec::new();
    while rig.begun_trials().last().unwrap().number == 2 {
        rig.step(|_| {});
        if rig.session.phase() == Phase::Verdict {
            causes.push(rig.session.view().repeat);
        }
    }
    causes.dedup();
    assert_eq!(causes, [Some(RepeatCause::TooHard), None]);
}

#[test]
fn speed_is_named_before_force_and_causes_of_the_bench_are_not_named() {
    let slow = RedoReason::SpeedOutOfBand {
        exploration: 1,
        speed_m_per_s: 0.02,
        min_m_per_s: 0.0375,
        max_m_per_s: 0.0625,
    };
    let light = RedoReason::ForceOutOfBand {
        exploration: 1,
        mean_n: 0.2,
        min_n: 0.5,
        max_n: 0.8,
    };
    let cause = |reasons: &[RedoReason]| repeat_cause(reasons);
    let lifted = RedoReason::FingerLifted {
        exploration: 1,
        lifted_s: 0.2,
        limit_s: 0.06,
    };
    assert_eq!(
        cause(&[light.clone(), slow.clone(), lifted]),
        RepeatCause::Lifted
    );
    assert_eq!(cause(&[light.clone(), slow]), RepeatCause::TooSlow);
    assert_eq!(
        cause(&[RedoReason::NotAnalysed, light]),
        RepeatCause::TooLight
    );
    assert_eq!(cause(&[RedoReason::NotAnalysed]), RepeatCause::Other);
}

/// Hazard 11.
#[test]
fn the_sessions_limit_of_repetitions_holds_over_all_trials() {
    let mut protocol = demo();
    protocol.redo.max_total = 4;
    let mut rig = Rig::new(protocol).with_consent();
    rig.normal_n = 0.2;
    rig.run_until(Phase::Finished);
    rig.check();
    let summary = rig.session.summary();
    assert_eq!(
        (summary.redone, summary.given_up, summary.accepted),
        (4, 4, 0)
    );
}

#[test]
fn a_bad_practice_trial_is_not_repeated() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.normal_n = 1.2;
    rig.run_until_main(Phase::Baseline);
    assert!(matches!(
        rig.outcomes()[..],
        [TrialOutcome::AcceptedAnyway { .. }]
    ));
}

#[test]
fn the_operator_can_keep_a_bad_trial() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.normal_n = 1.2;
    rig.run_until_main(Phase::Verdict);
    let accept = rig.accept_anyway();
    rig.tell(accept);
    assert!(matches!(
        rig.outcomes().last(),
        Some(TrialOutcome::AcceptedAnyway { reasons }) if reasons.len() == 2
    ));
    assert_eq!(rig.begun_trials().last().unwrap().number, 3);
}

#[test]
fn the_operator_can_repeat_a_good_trial_and_a_running_one() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until_main(Phase::Verdict);
    let redo = rig.redo();
    rig.tell(redo);
    rig.run_until(Phase::Exploration);
    let redo = rig.redo();
    rig.tell(redo);
    assert_eq!(rig.session.phase(), Phase::Baseline);
    rig.run_until(Phase::Finished);
    rig.check();
    let of_two: Vec<TrialOutcome> = rig
        .session
        .records()
        .iter()
        .filter(|r| r.key.number == 2)
        .map(|r| r.outcome.clone())
        .collect();
    assert_eq!(
        of_two,
        [
            TrialOutcome::Redo { reasons: vec![] },
            TrialOutcome::Interrupted {
                interruption: Interruption::Redo
            },
            TrialOutcome::Accepted,
        ]
    );
}

#[test]
fn a_trial_that_is_never_analysed_is_repeated() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until_main(Phase::Lift);
    rig.analyses = false;
    rig.run_until(Phase::Verdict);
    rig.analyses = true;
    rig.to_analyse = None;
    rig.run_until(Phase::Finished);
    let redo_outcome = TrialOutcome::Redo {
        reasons: vec![RedoReason::NotAnalysed],
    };
    assert!(rig.outcomes().contains(&redo_outcome));
    assert_eq!(rig.session.summary().accepted, 4);
    rig.check();
}

#[test]
fn an_analysis_of_another_attempt_is_ignored() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Analysing);
    let mut key = rig.to_analyse.take().unwrap();
    key.attempt += 1;
    let foreign = analysis(&key, &rig.protocol, 0.65);
    rig.step(|o| o.analysis = Some(foreign));
    assert_eq!(rig.session.phase(), Phase::Analysing);
}

#[test]
fn a_verdict_is_announced_before_it_takes_hold() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Verdict);
    let announcement = rig.actions().find_map(|a| match a {
        SessionAction::Verdict { key, verdict } => Some((key.clone(), verdict.clone())),
        _ => None,
    });
    assert_eq!(
        announcement,
        Some((rig.begun_trials()[0].clone(), Verdict::Accepted))
    );
    assert!(rig.session.records().is_empty());
}

/// A command given in one trial and received in the next has no effect.
#[test]
fn a_command_about_another_attempt_is_refused() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    let stale = [rig.redo(), rig.accept_anyway()];
    let (number, attempt) = rig.current_attempt();
    rig.run_until(Phase::Verdict);
    rig.run_until(Phase::Exploration);
    let trial_count = rig.begun_trials().len();
    for command in stale
        .into_iter()
        .chain([OperatorCommand::PauseNow { number, attempt }])
    {
        rig.tell(command.clone());
        let event = SessionEventKind::CommandRefused {
            command,
            because: Refusal::OtherAttempt.to_string(),
        };
        assert_eq!(rig.events().last(), Some(&event));
        assert_eq!(rig.session.phase(), Phase::Exploration);
    }
    // The next attempt at the same trial counts as another one.
    let redo = rig.redo();
    rig.tell(redo.clone());
    rig.tell(redo);
    assert_eq!(rig.begun_trials().len(), trial_count + 1);
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn a_verdict_is_overruled_both_ways_during_a_pause() {
    for (normal_n, accepts) in [(1.2, true), (0.65, false)] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.normal_n = normal_n;
        rig.run_until_main(Phase::Verdict);
        rig.tell(OperatorCommand::Pause);
        for _ in 0..500 {
            rig.step(|_| {});
        }
        let number = rig.session.current().unwrap().number;
        let command = if accepts {
            rig.accept_anyway()
        } else {
            rig.redo()
        };
        rig.tell(command);
        assert_eq!(rig.session.phase(), Phase::Paused);
        assert_eq!(rig.session.current(), None);
        let outcome = rig.outcomes().last().cloned();
        assert!(
            if accepts {
                matches!(outcome, Some(TrialOutcome::AcceptedAnyway { .. }))
            } else {
                outcome == Some(TrialOutcome::Redo { reasons: vec![] })
            },
            "{outcome:?}"
        );
        rig.normal_n = 0.65;
        rig.tell(OperatorCommand::Resume);
        assert_eq!(
            rig.begun_trials().last().unwrap().number,
            number + u32::from(accepts)
        );
        rig.run_until(Phase::Finished);
        rig.check();
    }
}

#[test]
fn with_an_operator_a_verdict_is_open_long_enough_and_space_ends_it() {
    for (normal_n, attended, wanted_s) in [
        (0.65, false, 0.5),
        (1.2, false, 0.5),
        (0.65, true, 2.0),
        (1.2, true, 6.0),
    ] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.normal_n = normal_n;
        while rig.session.phase() != Phase::Verdict {
            rig.step(|o| o.attended = attended);
        }
        let left_s = rig.session.verdict_left_s().unwrap();
        assert!((left_s - wanted_s).abs() < 0.1, "{left_s} s");
        let began_s = rig.t_s;
        while rig.session.phase() == Phase::Verdict {
            rig.step(|o| o.attended = attended);
        }
        assert!((rig.t_s - began_s - wanted_s).abs() < 0.1);
        rig.run_until(Phase::Verdict);
        rig.step(|o| o.attended = attended);
        rig.tell(OperatorCommand::Continue);
        assert_ne!(rig.session.phase(), Phase::Verdict);
    }
}
