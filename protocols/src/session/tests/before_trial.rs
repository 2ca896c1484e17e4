//! Conditions before a trial: the hour's driving time, and the dead-man switch.

use super::rig::*;
use crate::session::*;
use participant_texts::Instruction;

fn hold_for(rig: &mut Rig, hold: DeadManAction, steps: usize) {
    for _ in 0..steps {
        rig.step(|o| o.hold = Some(hold));
    }
}

fn instruction(rig: &Rig) -> Instruction {
    rig.view.as_ref().unwrap().instruction
}

/// Fault 42.
/// Hazard 15.
#[test]
fn each_trial_waits_until_the_switch_was_released_and_is_held() {
    let mut rig = Rig::new(demo()).with_consent();
    hold_for(&mut rig, DeadManAction::Release, 300);
    assert_eq!(rig.session.phase(), Phase::Hold);
    assert_eq!(instruction(&rig), Instruction::ReleaseSwitch);
    hold_for(&mut rig, DeadManAction::Press, 300);
    assert_eq!(instruction(&rig), Instruction::HoldSwitch);
    assert_eq!(rig.begun_trials().len(), 0, "nothing is driven meanwhile");
    hold_for(&mut rig, DeadManAction::Held, 1);
    assert_eq!(rig.session.phase(), Phase::Baseline);
    for _ in 0..100_000 {
        if rig.session.phase() == Phase::Hold {
            break;
        }
        // After its drive the switch must be released again.
        let has_trial_ended = matches!(rig.session.phase(), Phase::Analysing | Phase::Verdict);
        let hold = if has_trial_ended {
            DeadManAction::Release
        } else {
            DeadManAction::Held
        };
        hold_for(&mut rig, hold, 1);
    }
    assert_eq!(rig.session.phase(), Phase::Hold);
    assert_eq!(rig.begun_trials().len(), 1);
    rig.check();
}

/// Hazard 15.
#[test]
fn a_switch_that_nobody_holds_pauses_the_session() {
    let mut rig = Rig::new(demo()).with_consent();
    let longest_s = rig.protocol.timeouts.place_finger_s;
    let steps = (longest_s / STEP_S) as usize;
    hold_for(&mut rig, DeadManAction::Press, steps - 100);
    assert_eq!(rig.session.phase(), Phase::Hold);
    hold_for(&mut rig, DeadManAction::Press, 300);
    assert_eq!(rig.session.phase(), Phase::Paused);
    assert!(rig.events().contains(&SessionEventKind::DeadManNotHeld));
    assert_eq!(rig.begun_trials().len(), 0);
    // The operator continues, and the session waits again.
    rig.step(|o| {
        o.hold = Some(DeadManAction::Press);
        o.command = Some(OperatorCommand::Resume);
    });
    assert_eq!(rig.session.phase(), Phase::Hold);
}

/// Hazard 15.
#[test]
fn a_participant_who_let_go_is_told_so() {
    let mut rig = Rig::new(demo()).with_consent();
    while rig.session.phase() != Phase::Exploration {
        hold_for(&mut rig, DeadManAction::Held, 1);
    }
    rig.safety = SafetyChain::Tripped("the dead-man switch was released".to_owned());
    hold_for(&mut rig, DeadManAction::Press, 1);
    assert_eq!(instruction(&rig), Instruction::SwitchReleased);
    rig.safety = SafetyChain::Ok;
    hold_for(&mut rig, DeadManAction::Held, 500);
    assert_eq!(
        rig.session.phase(),
        Phase::Fault,
        "it must not go on by itself"
    );
    rig.step(|o| {
        o.hold = Some(DeadManAction::Release);
        o.command = Some(OperatorCommand::Resume);
    });
    assert_eq!(rig.session.phase(), Phase::Hold);
}

/// Fault 42.
/// Hazards 4, 5.
#[test]
fn no_trial_begins_in_an_hour_that_is_used_up() {
    let mut rig = Rig::new(demo()).with_consent();
    rig.run_until(Phase::Verdict);
    let trial_count = rig.begun_trials().len();
    let wait = |o: &mut Observation| o.drive_wait_s = 700.0;
    while rig.session.phase() != Phase::Paused {
        rig.step(wait);
    }
    assert_eq!(rig.begun_trials().len(), trial_count);
    let event = SessionEventKind::DrivingTimeSpent { wait_s: 700.0 };
    assert!(rig.events().contains(&event));
    rig.step(|o| {
        wait(o);
        o.command = Some(OperatorCommand::Resume);
    });
    assert_eq!(rig.session.phase(), Phase::Paused);
    let is_refusal = |event: &SessionEventKind| matches!(event, SessionEventKind::CommandRefused { because, .. } if because.contains("driving time"));
    assert!(rig.events().iter().any(is_refusal));
    rig.tell(OperatorCommand::Resume);
    assert_eq!(rig.session.phase(), Phase::Baseline);
    assert_eq!(rig.begun_trials().len(), trial_count + 1);
    rig.run_until(Phase::Finished);
    rig.check();
}
