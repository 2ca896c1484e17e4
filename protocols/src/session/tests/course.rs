//! The course of a session: trials, steps and breaks.

use super::rig::*;
use crate::record::TrialOutcome;
use crate::session::commands::Refusal;
use crate::session::*;
use crate::trial::*;
use participant_texts::Instruction;

#[test]
fn a_whole_session_runs_as_the_protocol_says() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Finished);
    rig.check();
    assert_eq!(rig.begun_trials().len(), 5);
    assert!(rig.begun_trials()[0].practice && !rig.begun_trials()[1].practice);
    assert!(rig.trial_ends().iter().all(|e| *e == TrialEnd::Completed));
    let summary = rig.session.summary();
    assert_eq!(
        (summary.planned, summary.practice, summary.accepted),
        (4, 1, 4)
    );
    assert_eq!(summary.instances, 4 * 2 * 6);
    approx_eq(summary.mean_normal_n.unwrap(), 0.65);
    let cues = rig
        .actions()
        .filter(|a| matches!(a, SessionAction::Cue(_)))
        .count();
    assert_eq!(cues, 5 * 2 * 2);
    let rests = rig
        .events()
        .iter()
        .filter(|e| is_phase(e, Phase::Rest))
        .count();
    assert_eq!(rests, 1, "after two of four trials, and not after the last");
    assert_eq!(
        rig.actions()
            .filter(|a| matches!(a, SessionAction::Finished(_)))
            .count(),
        1
    );
}

/// While the operator is asked, neither time nor the participant begins the next trial; a command does.
#[test]
fn a_judged_trial_waits_for_the_operators_answer() {
    for is_answered in [true, false] {
        let mut rig = Rig::new(demo()).with_consent();
        rig.run_until(Phase::Verdict);
        for _ in 0..500 {
            rig.step(|o| {
                o.asking = true;
                o.button_pressed = true;
            });
            assert_eq!(rig.session.phase(), Phase::Verdict);
        }
        if is_answered {
            rig.run_until(Phase::Baseline);
        } else {
            let redo = rig.redo();
            rig.step(|o| {
                o.asking = true;
                o.command = Some(redo);
            });
            assert_eq!(rig.session.phase(), Phase::Baseline);
        }
        rig.check();
    }
}

#[test]
fn intervals_have_the_protocols_lengths_and_directions() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Analysing);
    let intervals: Vec<Interval> = rig
        .actions()
        .find_map(|a| match a {
            SessionAction::AnalyseTrial { intervals, .. } => Some(intervals.clone()),
            _ => None,
        })
        .unwrap();
    let kinds: Vec<IntervalKind> = intervals.iter().map(|i| i.kind).collect();
    assert_eq!(
        kinds,
        [
            IntervalKind::Unloaded,
            IntervalKind::Exploration {
                direction: Direction::LeftToRight
            },
            IntervalKind::Exploration {
                direction: Direction::RightToLeft
            },
        ]
    );
    let lengths: Vec<f64> = intervals.iter().map(|i| i.end_s - i.start_s).collect();
    for (length, expected) in lengths.iter().zip([0.8, 1.7, 1.7]) {
        approx_eq(*length, expected);
    }
}

#[test]
fn the_slider_is_a_function_of_time() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    let start_s = rig.t_s;
    let mut steps = 0;
    while rig.session.phase() == Phase::Exploration {
        let view = rig.view.clone().unwrap();
        approx_eq(view.slider_m.unwrap(), 0.010 + 0.050 * (rig.t_s - start_s));
        assert_eq!(view.direction, Some(Direction::LeftToRight));
        steps += 1;
        rig.step(|_| {});
    }
    assert!(steps > 80);
}

/// Hazard 10.
#[test]
fn the_participant_is_told_the_mean_force_of_the_exploration() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Feedback);
    let view = rig.view.clone().unwrap();
    assert_eq!(view.instruction, Instruction::Feedback);
    approx_eq(view.mean_force_n.unwrap(), 0.65);
}

/// At the ends of the slide the finger lands and leaves, and a finger off the plate does not press.
#[test]
fn the_told_force_is_that_of_the_contact_on_the_central_part() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Exploration);
    let start_s = rig.t_s;
    while rig.session.phase() == Phase::Exploration {
        let is_end = !(0.2..1.5).contains(&(rig.t_s - start_s));
        let is_off = (0.7..0.75).contains(&(rig.t_s - start_s));
        rig.step(|o| {
            o.normal_n = Some(if is_off {
                0.0
            } else if is_end {
                0.3
            } else {
                0.65
            })
        });
    }
    rig.run_until(Phase::Feedback);
    approx_eq(rig.view.unwrap().mean_force_n.unwrap(), 0.65);
}

/// Hazard 12.
#[test]
fn nothing_happens_before_the_consent() {
    let mut rig = Rig::new(demo());
    for command in [
        OperatorCommand::Continue,
        OperatorCommand::Pause,
        OperatorCommand::Redo {
            number: 1,
            attempt: 1,
        },
    ] {
        rig.tell(command);
    }
    rig.tell(OperatorCommand::ConsentGiven {
        by: "  ".to_owned(),
    });
    for _ in 0..100 {
        rig.step(|o| o.button_pressed = true);
    }
    assert_eq!(rig.session.phase(), Phase::Consent);
    assert!(rig.begun_trials().is_empty());
    let refusal_count = rig
        .events()
        .iter()
        .filter(|e| matches!(e, SessionEventKind::CommandRefused { .. }))
        .count();
    assert_eq!(refusal_count, 4);
}

#[test]
fn a_finger_on_the_plate_holds_the_baseline_up() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Baseline);
    rig.lifts = false;
    for _ in 0..200 {
        rig.step(|_| {});
    }
    assert_eq!(rig.session.phase(), Phase::Baseline);
    assert_eq!(
        rig.view.as_ref().unwrap().instruction,
        Instruction::LiftFinger
    );
    rig.lifts = true;
    let lifted_s = rig.t_s;
    rig.run_until(Phase::Ready);
    let baseline = rig.actions().find_map(|a| match a {
        SessionAction::Mark(interval) => Some(*interval),
        _ => None,
    });
    assert!(baseline.unwrap().start_s > lifted_s);
    rig.check();
}

#[test]
fn an_unknown_force_is_not_a_lifted_finger() {
    let mut rig = Rig::new(demo()).with_consent();
    for _ in 0..200 {
        rig.step(|o| o.normal_n = None);
    }
    assert_eq!(rig.session.phase(), Phase::Baseline);
}

#[test]
fn a_finger_lifted_during_the_countdown_goes_back_to_ready() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Countdown);
    rig.step(|o| o.normal_n = Some(0.0));
    assert_eq!(rig.session.phase(), Phase::Ready);
    assert!(rig.events().contains(&SessionEventKind::FingerLiftedEarly));
    rig.run_until(Phase::Finished);
    rig.check();
}

#[test]
fn the_button_counts_only_with_the_finger_on_the_plate() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Ready);
    rig.step(|o| {
        o.normal_n = Some(0.0);
        o.button_pressed = true;
        o.command = Some(OperatorCommand::Continue);
    });
    assert_eq!(rig.session.phase(), Phase::Ready);
    let event = SessionEventKind::CommandRefused {
        command: OperatorCommand::Continue,
        because: Refusal::NoFinger.to_string(),
    };
    assert!(rig.events().contains(&event));
}

#[test]
fn a_command_that_does_not_fit_the_phase_is_refused() {
    // All of these phases belong to the first attempt.
    let (number, attempt) = (1, 1);
    let redo = OperatorCommand::Redo { number, attempt };
    let accept = OperatorCommand::AcceptAnyway { number, attempt };
    let phases = [
        (OperatorCommand::Pause, Phase::Consent, Refusal::NotBegun),
        (consent(), Phase::Welcome, Refusal::ConsentNotAwaited),
        (redo, Phase::Welcome, Refusal::NoTrial),
        (OperatorCommand::Continue, Phase::Lift, Refusal::NotWaiting),
        (OperatorCommand::Resume, Phase::Lift, Refusal::NotPaused),
        (accept.clone(), Phase::Lift, Refusal::NotJudged),
        (accept, Phase::Verdict, Refusal::AlreadyAccepted),
        (OperatorCommand::Pause, Phase::Finished, Refusal::Over),
        (OperatorCommand::Abort, Phase::Finished, Refusal::Over),
    ];
    for (command, phase, refusal) in phases {
        let mut rig = Rig::new(demo());
        if phase != Phase::Consent {
            rig.tell(consent());
        }
        rig.run_until(phase);
        // The finger rests and the button is not pressed, so that only the command could act.
        rig.step(|o| {
            o.command = Some(command.clone());
            o.button_pressed = false;
            o.normal_n = Some(0.65);
        });
        assert_eq!(rig.session.phase(), phase, "{command:?}");
        let event = SessionEventKind::CommandRefused {
            command,
            because: refusal.to_string(),
        };
        assert_eq!(rig.events().last(), Some(&event));
    }
}

#[test]
fn the_operator_can_press_on_for_a_participant_without_button() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.presses = false;
    rig.tell(OperatorCommand::Continue);
    for _ in 0..2 {
        rig.run_until(Phase::Ready);
        rig.step(|_| {});
        rig.tell(OperatorCommand::Continue);
    }
    rig.run_until(Phase::Verdict);
    rig.check();
}

fn timed_out(set: impl FnOnce(&mut Rig), expected: Interruption) {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Baseline);
    set(&mut rig);
    rig.run_until(Phase::Paused);
    assert_eq!(
        rig.trial_ends(),
        [TrialEnd::Interrupted {
            interruption: expected
        }]
    );
    rig.lifts = true;
    rig.presses = true;
    rig.tell(OperatorCommand::Resume);
    rig.run_until(Phase::Finished);
    assert_eq!(
        (rig.begun_trials()[1].number, rig.begun_trials()[1].attempt),
        (1, 2)
    );
    rig.check();
}

#[test]
fn a_finger_that_stays_on_the_plate_pauses_the_session() {
    timed_out(|rig| rig.lifts = false, Interruption::FingerNotLifted);
}

/// Hazard 4.
#[test]
fn a_button_that_comes_too_late_pauses_the_session() {
    timed_out(|rig| rig.presses = false, Interruption::FingerNotPlaced);
}

#[test]
fn a_finger_that_stays_after_an_exploration_does_not_cost_the_trial() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Lift);
    rig.lifts = false;
    rig.run_until(Phase::Feedback);
    assert!(rig.events().contains(&SessionEventKind::FingerNotLifted));
    rig.lifts = true;
    rig.run_until(Phase::Rest);
    assert!(
        rig.trial_ends()
            .iter()
            .all(|end| *end == TrialEnd::Completed)
    );
    assert_eq!(rig.outcomes(), vec![TrialOutcome::Accepted; 3]);
    assert!(rig.begun_trials().iter().all(|key| key.attempt == 1));
    rig.check();
}

/// Hazard 11.
#[test]
fn a_break_is_as_long_as_the_protocol_says_or_as_the_operator_wants() {
    let mut rig = rig_in(Phase::Rest);
    let began_s = rig.t_s;
    while rig.session.phase() == Phase::Rest {
        rig.step(|o| o.button_pressed = true);
    }
    assert!(rig.t_s - began_s >= rig.protocol.rest.min_s);
    let mut rig = rig_in(Phase::Rest);
    rig.tell(OperatorCommand::Continue);
    assert_eq!(rig.session.phase(), Phase::Baseline);
}
