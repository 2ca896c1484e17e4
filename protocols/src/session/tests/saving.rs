//! Trials with recordings that are saved late or never.

use super::rig::*;
use crate::record::TrialOutcome;
use crate::session::*;
use crate::trial::*;

/// Returns a session in `phase` of its first trial, without a report from the recorder.
fn unsaved_in(phase: Phase) -> (Rig, TrialKey) {
    let mut rig = Rig::new(demo()).with_consent();
    rig.saves = false;
    rig.run_until(phase);
    let key = rig.session.current().unwrap().clone();
    (rig, key)
}

fn unsaved_outcome() -> TrialOutcome {
    let reason = FULL.to_owned();
    TrialOutcome::Interrupted {
        interruption: Interruption::NotSaved { reason },
    }
}

/// Resumes, saves from now on, and expects every trial to be accepted, the first at its second attempt.
fn completes(mut rig: Rig) {
    (rig.saves, rig.to_save) = (true, None);
    rig.safety = SafetyChain::Ok;
    rig.tell(OperatorCommand::Resume);
    rig.run_until(Phase::Finished);
    rig.check();
    assert_eq!(rig.session.summary().accepted, 4);
    let first: Vec<_> = rig
        .begun_trials()
        .iter()
        .map(|key| (key.number, key.attempt))
        .collect();
    assert_eq!(first[..2], [(1, 1), (1, 2)]);
}

/// Fault 27.
#[test]
fn a_trial_is_accepted_only_when_its_recording_is_saved() {
    let (mut rig, key) = unsaved_in(Phase::Saving);
    for _ in 0..100 {
        rig.step(|_| {});
    }
    assert_eq!(rig.session.phase(), Phase::Saving);
    assert_eq!(rig.outcomes(), []);
    assert_eq!(rig.session.current(), Some(&key));
    rig.saves = true;
    rig.step(|_| {});
    assert_eq!(rig.outcomes(), [TrialOutcome::Accepted]);
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn a_recording_that_is_saved_during_the_verdict_costs_no_time() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Finished);
    let is_saving = |event: &SessionEventKind| is_phase(event, Phase::Saving);
    assert!(!rig.events().iter().any(is_saving));
}

/// Fault 27.
#[test]
fn a_trial_whose_recording_fails_in_any_phase_is_interrupted_and_repeated() {
    for phase in [
        Phase::Baseline,
        Phase::Exploration,
        Phase::Feedback,
        Phase::Analysing,
        Phase::Verdict,
        Phase::Saving,
    ] {
        let (mut rig, key) = unsaved_in(phase);
        let stops = rig
            .fail(&key)
            .contains(&SessionAction::Drive(DriveRequest::Off));
        assert_eq!(stops, in_trial(phase), "{phase:?}");
        assert_eq!(rig.session.phase(), Phase::Paused, "{phase:?}");
        assert_eq!(rig.outcomes(), [unsaved_outcome()], "{phase:?}");
        // The bench trips the drive, too.
        rig.step(|o| o.safety = SafetyChain::Tripped("the recording failed".to_owned()));
        assert_eq!(rig.session.phase(), Phase::Fault, "{phase:?}");
        assert_eq!(rig.outcomes(), [unsaved_outcome()], "{phase:?}");
        completes(rig);
    }
}

/// Fault 27.
#[test]
fn a_recording_that_fails_while_the_session_is_halted_is_not_accepted_after_it() {
    for phase in [Phase::Analysing, Phase::Verdict, Phase::Saving] {
        let (mut rig, key) = unsaved_in(phase);
        rig.safety = SafetyChain::Tripped("the recording failed".to_owned());
        rig.step(|_| {});
        rig.fail(&key);
        assert_eq!(rig.session.phase(), Phase::Fault, "{phase:?}");
        assert_eq!(rig.outcomes(), [unsaved_outcome()], "{phase:?}");
        completes(rig);
    }
}

/// Fault 27.
#[test]
fn a_trial_of_which_nothing_is_heard_in_time_is_interrupted() {
    let (mut rig, _) = unsaved_in(Phase::Saving);
    let since_s = rig.t_s;
    rig.run_until(Phase::Paused);
    assert!((19.9..20.1).contains(&(rig.t_s - since_s)));
    assert!(matches!(
        rig.outcomes()[..],
        [TrialOutcome::Interrupted {
            interruption: Interruption::NotSaved { .. }
        }]
    ));
    completes(rig);
}

/// Fault 27.
#[test]
fn pauses_do_not_prolong_the_time_in_which_a_recording_is_to_be_saved() {
    let (mut rig, _) = unsaved_in(Phase::Saving);
    let since_s = rig.t_s;
    let mut pauses = 0;
    while rig.outcomes().is_empty() && pauses < 10 {
        while rig.session.phase() == Phase::Saving
            && rig.t_s < since_s + 9.0 * f64::from(pauses + 1)
        {
            rig.step(|_| {});
        }
        if rig.session.phase() == Phase::Saving {
            rig.tell(OperatorCommand::Pause);
            rig.tell(OperatorCommand::Resume);
            pauses += 1;
        }
    }
    let waited_s = rig.t_s - since_s;
    assert!((19.9..20.2).contains(&waited_s), "{waited_s} s");
    assert_eq!(rig.session.phase(), Phase::Paused);
    completes(rig);

    // A recording can be saved during the pause.
    let (mut rig, _) = unsaved_in(Phase::Saving);
    rig.tell(OperatorCommand::Pause);
    rig.saves = true;
    for _ in 0..1500 {
        rig.step(|_| {});
    }
    rig.tell(OperatorCommand::Resume);
    rig.step(|_| {});
    assert_eq!(rig.outcomes(), [TrialOutcome::Accepted]);
}

/// Fault 27.
#[test]
fn a_recording_that_fails_stays_failed() {
    let (mut rig, key) = unsaved_in(Phase::Verdict);
    rig.fail(&key);
    rig.step(|o| o.recording = Some((key, RecordingOutcome::Saved)));
    assert_eq!(rig.outcomes(), [unsaved_outcome()]);
    completes(rig);
}

/// Fault 27.
#[test]
fn an_overruled_trial_too_is_kept_only_when_it_is_saved() {
    for is_halted in [false, true] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.run_until_main(Phase::Baseline);
        let outcome_count = rig.outcomes().len();
        rig.normal_n = 1.2;
        rig.saves = false;
        rig.run_until(Phase::Verdict);
        let key = rig.session.current().unwrap().clone();
        if is_halted {
            rig.pause_now();
        }
        rig.tell(rig.accept_anyway());
        assert_eq!(rig.outcomes().len(), outcome_count);
        assert_eq!(rig.session.current(), Some(&key));
        rig.tell(rig.accept_anyway());
        rig.tell(rig.redo());
        assert_eq!(
            rig.outcomes().len(),
            outcome_count,
            "the word of the operator stands"
        );
        if is_halted {
            rig.tell(OperatorCommand::Resume);
            assert_eq!(rig.session.phase(), Phase::Saving);
        }
        let (mut failing, failed) = (rig.session.clone(), key.clone());
        rig.step(|o| o.recording = Some((key, RecordingOutcome::Saved)));
        assert!(matches!(
            rig.outcomes()[outcome_count],
            TrialOutcome::AcceptedAnyway { .. }
        ));
        failing.step(&Observation {
            t_s: rig.t_s,
            recording: Some((failed, RecordingOutcome::Failed(FULL.to_owned()))),
            ..Observation::default()
        });
        assert_eq!(failing.records()[outcome_count].outcome, unsaved_outcome());
    }
}

/// Fault 27.
#[test]
fn a_rejected_trial_is_repeated_whatever_becomes_of_its_recording() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until_main(Phase::Baseline);
    let outcome_count = rig.outcomes().len();
    rig.normal_n = 1.2;
    rig.saves = false;
    rig.run_until(Phase::Verdict);
    let key = rig.session.current().unwrap().clone();
    rig.run_until(Phase::Baseline);
    assert!(matches!(
        rig.outcomes()[outcome_count],
        TrialOutcome::Redo { .. }
    ));
    rig.fail(&key);
    assert_eq!(
        rig.session.phase(),
        Phase::Baseline,
        "it is another attempt's"
    );
    assert_eq!(rig.outcomes().len(), outcome_count + 1);
}

/// Fault 27.
#[test]
fn an_abort_before_the_recording_is_saved_leaves_the_trial_to_be_repeated() {
    for (phase, saved) in [
        (Phase::Verdict, false),
        (Phase::Verdict, true),
        (Phase::Saving, false),
    ] {
        let (mut rig, key) = unsaved_in(phase);
        if saved {
            rig.step(|o| o.recording = Some((key, RecordingOutcome::Saved)));
        }
        rig.tell(OperatorCommand::Abort);
        let outcome = if saved {
            TrialOutcome::Accepted
        } else {
            TrialOutcome::Interrupted {
                interruption: Interruption::Aborted,
            }
        };
        assert_eq!(rig.outcomes(), [outcome]);
        rig.check();
        let records = records_from_events(&rig.events());
        let session = Session::resume(demo(), sub("sub-01"), 7, &records).unwrap();
        let trials_left = rig.protocol.planned_trials() - u32::from(saved);
        assert_eq!(session.trials_left(), trials_left);
    }
}

/// Fault 27.
#[test]
fn the_session_ends_only_when_its_last_recording_is_saved() {
    let mut rig = Rig::new(demo()).with_consent();
    while rig.session.trials_left() > 1 {
        rig.step(|_| {});
    }
    rig.saves = false;
    rig.run_until(Phase::Saving);
    for _ in 0..100 {
        rig.step(|_| {});
    }
    assert_eq!(rig.session.phase(), Phase::Saving);
    rig.saves = true;
    rig.step(|_| {});
    assert_eq!(rig.session.phase(), Phase::Finished);
    rig.check();
}

/// Fault 27.
#[test]
fn a_pause_that_was_asked_for_comes_when_the_trial_is_saved() {
    let (mut rig, _) = unsaved_in(Phase::Feedback);
    rig.tell(OperatorCommand::Pause);
    rig.run_until(Phase::Saving);
    rig.saves = true;
    rig.run_until(Phase::Paused);
    assert_eq!(rig.outcomes(), [TrialOutcome::Accepted]);
}

/// Fault 27.
#[test]
fn no_trial_begins_while_the_recorder_lags_behind() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Verdict);
    rig.run_until(Phase::Baseline);
    let (trial_count, outcome_count) = (rig.begun_trials().len(), rig.outcomes().len());
    rig.step(|o| {
        o.command = Some(OperatorCommand::Redo {
            number: 2,
            attempt: 1,
        });
        o.recorder_lag_s = 2.1;
    });
    assert_eq!(rig.outcomes().len(), outcome_count + 1);
    let mut waited_s = 0.0;
    while rig.session.phase() == Phase::Saving {
        rig.step(|o| o.recorder_lag_s = 2.1);
        waited_s += STEP_S;
    }
    assert!((19.9..20.1).contains(&waited_s), "{waited_s}");
    assert_eq!(rig.session.phase(), Phase::Paused);
    rig.step(|o| {
        o.command = Some(OperatorCommand::Resume);
        o.recorder_lag_s = 2.1;
    });
    assert_eq!(rig.session.phase(), Phase::Saving);
    assert_eq!(rig.begun_trials().len(), trial_count);
    rig.step(|_| {});
    assert_eq!(rig.session.phase(), Phase::Baseline);
    let pauses: Vec<bool> = rig
        .events()
        .iter()
        .filter_map(|event| match event {
            SessionEventKind::RecorderBehind { paused, .. } => Some(*paused),
            _ => None,
        })
        .collect();
    assert_eq!(pauses, [false, true]);
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn a_session_that_is_left_counts_the_attempt_that_was_judged_and_saved() {
    for is_paused in [false, true] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.run_until(Phase::Verdict);
        let observation = Observation {
            t_s: rig.t_s,
            ..Observation::default()
        };
        if is_paused {
            rig.tell(OperatorCommand::Pause);
            for _ in 0..2000 {
                rig.step(|_| {});
            }
            assert_eq!(rig.session.phase(), Phase::Paused);
        }
        assert_eq!(rig.outcomes(), [], "{is_paused}");
        let actions = rig.session.close(&observation);
        let settled: Vec<&TrialOutcome> = actions
            .iter()
            .filter_map(|action| match action {
                SessionAction::Log(event) => match &event.kind {
                    SessionEventKind::TrialSettled { record } => Some(&record.outcome),
                    _ => None,
                },
                _ => None,
            })
            .collect();
        assert_eq!(
            settled,
            [&TrialOutcome::Accepted],
            "{is_paused}: {actions:?}"
        );
        assert_eq!(rig.session.close(&observation), [], "once");
    }
    let (mut rig, _) = unsaved_in(Phase::Verdict);
    let observation = rig.observation();
    assert_eq!(rig.session.close(&observation), []);
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    let observation = rig.observation();
    assert_eq!(rig.session.close(&observation), []);
    assert_eq!(rig.session.phase(), Phase::Exploration);
}
