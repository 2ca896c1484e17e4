//! Pauses, safety trips, aborts and a wrong clock.

use super::rig::*;
use crate::session::*;
use crate::trial::*;
use participant_texts::Instruction;

/// Hazard 4.
#[test]
fn a_pause_in_any_phase_stops_the_drive_and_the_session_still_completes() {
    for phase in RUNNING {
        let mut rig = rig_in(phase);
        let trial_count = rig.begun_trials().len();
        rig.pause_now();
        assert_eq!(rig.session.phase(), Phase::Paused);
        assert_eq!(rig.view.as_ref().unwrap().instruction, Instruction::Paused);
        for _ in 0..500 {
            rig.step(|_| {});
        }
        assert_eq!(rig.begun_trials().len(), trial_count, "{phase:?}");
        rig.tell(OperatorCommand::Resume);
        if in_trial(phase) {
            assert_eq!(rig.session.phase(), Phase::Baseline, "{phase:?}");
            let keys = rig.begun_trials();
            assert_eq!(keys[trial_count].number, keys[trial_count - 1].number);
        } else if phase != Phase::Paused {
            assert_eq!(rig.session.phase(), phase);
        }
        rig.run_until(Phase::Finished);
        rig.check();
        assert_eq!(rig.session.summary().accepted, 4, "{phase:?}");
    }
}

#[test]
fn a_safety_trip_in_any_phase_stops_the_drive_until_the_operator_goes_on() {
    for phase in RUNNING {
        let mut rig = rig_in(phase);
        let trial_count = rig.begun_trials().len();
        rig.safety = SafetyChain::Tripped("e-stop".to_owned());
        let actions = rig.step(|_| {});
        let stop_index = actions
            .iter()
            .position(|a| *a == SessionAction::Drive(DriveRequest::Off));
        assert!(stop_index.is_some(), "{phase:?}");
        assert_eq!(rig.session.phase(), Phase::Fault);
        rig.tell(OperatorCommand::Resume);
        assert_eq!(rig.session.phase(), Phase::Fault, "resumed while tripped");
        rig.safety = SafetyChain::Ok;
        for _ in 0..500 {
            rig.step(|o| o.button_pressed = true);
        }
        assert_eq!(
            rig.session.phase(),
            Phase::Fault,
            "it must not go on by itself"
        );
        assert_eq!(rig.begun_trials().len(), trial_count);
        rig.tell(OperatorCommand::Resume);
        rig.run_until(Phase::Finished);
        rig.check();
        let trip_end = TrialEnd::Interrupted {
            interruption: Interruption::Safety {
                reason: "e-stop".to_owned(),
            },
        };
        assert_eq!(
            rig.trial_ends().contains(&trip_end),
            in_trial(phase),
            "{phase:?}"
        );
        assert_eq!(rig.session.summary().accepted, 4, "{phase:?}");
    }
}

#[test]
fn a_trip_before_the_consent_leads_back_to_the_consent() {
    let mut rig = Rig::new(demo());
    rig.safety = SafetyChain::Tripped("e-stop".to_owned());
    rig.tell(consent());
    assert_eq!(rig.session.phase(), Phase::Fault);
    assert!(
        rig.events()
            .iter()
            .any(|e| matches!(e, SessionEventKind::CommandRefused { .. }))
    );
    rig.safety = SafetyChain::Ok;
    rig.tell(OperatorCommand::Resume);
    assert_eq!(rig.session.phase(), Phase::Consent);
}

#[test]
fn an_abort_in_any_phase_ends_the_session_once() {
    for phase in RUNNING.into_iter().chain([Phase::Consent, Phase::Fault]) {
        let mut rig = match phase {
            Phase::Consent => Rig::new(demo()),
            Phase::Fault => {
                let mut rig = rig_in(Phase::Exploration);
                rig.step(|o| o.safety = SafetyChain::Tripped("e-stop".to_owned()));
                rig
            }
            _ => rig_in(phase),
        };
        rig.tell(OperatorCommand::Abort);
        assert_eq!(rig.session.phase(), Phase::Aborted);
        let trial_count = rig.begun_trials().len();
        for _ in 0..100 {
            rig.step(|o| o.button_pressed = true);
        }
        rig.tell(OperatorCommand::Resume);
        rig.tell(OperatorCommand::Abort);
        rig.check();
        assert_eq!(rig.begun_trials().len(), trial_count, "{phase:?}");
        assert_eq!(
            rig.session.records().len(),
            trial_count,
            "{phase:?}: every attempt is accounted for"
        );
        let finish_count = rig
            .actions()
            .filter(|a| matches!(a, SessionAction::Finished(_)))
            .count();
        assert_eq!(finish_count, 1, "{phase:?}");
    }
}

#[test]
fn an_analysis_that_arrives_during_a_pause_is_kept() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Analysing);
    rig.pause_now();
    rig.step(|_| {});
    rig.analyses = false;
    rig.tell(OperatorCommand::Resume);
    rig.step(|_| {});
    assert_eq!(rig.session.phase(), Phase::Verdict);
}

#[test]
fn a_clock_that_stands_or_goes_back_does_no_harm() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    let now_s = rig.t_s;
    let slider = rig.view.as_ref().unwrap().slider_m;
    for t_s in [now_s - 5.0, f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
        rig.step(|o| o.t_s = t_s);
        assert_eq!(rig.view.as_ref().unwrap().slider_m, slider);
    }
    rig.t_s = now_s;
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn a_pause_waits_for_the_attempt_and_loses_nothing() {
    for phase in [Phase::Baseline, Phase::Exploration, Phase::Feedback] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.run_until(phase);
        rig.tell(OperatorCommand::Pause);
        assert_eq!(rig.session.phase(), phase);
        assert!(rig.session.is_pausing());
        rig.run_until(Phase::Paused);
        assert_eq!(rig.trial_ends(), [TrialEnd::Completed], "{phase:?}");
        assert_eq!(
            rig.outcomes().len(),
            1,
            "{phase:?}: settled before the pause"
        );
        assert!(!rig.session.is_pausing());
        for _ in 0..500 {
            rig.step(|o| o.button_pressed = true);
        }
        assert_eq!(rig.session.phase(), Phase::Paused);
        rig.tell(OperatorCommand::Resume);
        rig.run_until(Phase::Finished);
        assert_eq!(rig.session.summary().interrupted, 0);
        rig.check();
    }
}

#[test]
fn a_pause_that_waits_is_withdrawn_hurried_and_outlives_a_repetition() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    rig.tell(OperatorCommand::Pause);
    rig.tell(OperatorCommand::Resume);
    assert!(!rig.session.is_pausing());
    rig.tell(OperatorCommand::Pause);
    rig.pause_now();
    assert_eq!(rig.session.phase(), Phase::Paused);
    rig.tell(OperatorCommand::Resume);
    rig.run_until(Phase::Exploration);
    rig.tell(OperatorCommand::Pause);
    let redo = rig.redo();
    rig.tell(redo);
    assert_eq!(rig.session.phase(), Phase::Paused);
    rig.tell(OperatorCommand::Resume);
    // After the last trial there is nothing left to pause.
    rig.run_until(Phase::Rest);
    while rig.session.trials_left() > 1 || rig.session.phase() != Phase::Exploration {
        rig.step(|_| {});
    }
    rig.tell(OperatorCommand::Pause);
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn a_lost_display_pauses_in_any_phase_until_it_is_back_and_the_operator_goes_on() {
    for phase in RUNNING {
        let mut rig = rig_in(phase);
        let trial_count = rig.begun_trials().len();
        let lose_display =
            |o: &mut Observation| o.display_lost = Some("the window has gone".to_owned());
        for _ in 0..200 {
            rig.step(lose_display);
        }
        assert_eq!(rig.session.phase(), Phase::Paused, "{phase:?}");
        assert_eq!(rig.begun_trials().len(), trial_count);
        rig.step(|o| {
            lose_display(o);
            o.command = Some(OperatorCommand::Resume);
        });
        assert_eq!(rig.session.phase(), Phase::Paused, "resumed unseen");
        for _ in 0..200 {
            rig.step(|o| o.button_pressed = true);
        }
        assert_eq!(
            rig.session.phase(),
            Phase::Paused,
            "it must not go on by itself"
        );
        rig.tell(OperatorCommand::Resume);
        rig.run_until(Phase::Finished);
        rig.check();
        let events = rig.events();
        let count = |is_counted: fn(&SessionEventKind) -> bool| {
            events.iter().filter(|e| is_counted(e)).count()
        };
        assert_eq!(
            count(|e| matches!(e, SessionEventKind::DisplayLost { .. })),
            1
        );
        assert_eq!(count(|e| matches!(e, SessionEventKind::DisplayBack)), 1);
        let cut = TrialEnd::Interrupted {
            interruption: Interruption::DisplayLost {
                reason: "the window has gone".to_owned(),
            },
        };
        assert_eq!(
            rig.trial_ends().contains(&cut),
            in_trial(phase),
            "{phase:?}"
        );
        assert_eq!(rig.session.summary().accepted, 4, "{phase:?}");
    }
}
