//! Orders of trials, and sessions resumed from their log.

use super::rig::*;
use crate::protocol::{Protocol, built_in};
use crate::record::{TrialOutcome, TrialRecord};
use crate::session::*;
use crate::trial::*;

fn many_conditions(order: &str) -> Protocol {
    let base = built_in("demo").unwrap();
    let text = base
        .replace(
            "[[conditions]]",
            "[[conditions]]\nname = \"slow\"\nmodulation_hz = 2.0\n\
             [[conditions]]\nname = \"weak\"\nmean_amplitude_v = 5.0\n[[conditions]]",
        )
        .replace("order = \"fixed\"", &format!("order = \"{order}\""));
    Protocol::parse(&text, "many.toml").unwrap()
}

fn order_of(protocol: &Protocol, id: &str, seed: u64) -> Vec<String> {
    let mut session = Session::new(protocol.clone(), sub(id), seed).unwrap();
    let actions = session.step(&Observation::default());
    let SessionAction::Log(SessionEvent {
        kind: SessionEventKind::SessionStarted { order, .. },
        ..
    }) = &actions[0]
    else {
        panic!("{actions:?}")
    };
    order.clone()
}

#[test]
fn a_randomised_order_is_reproducible_and_balanced() {
    let protocol = many_conditions("randomised");
    let order = order_of(&protocol, "sub-01", 3);
    assert_eq!(order, order_of(&protocol, "sub-01", 3));
    assert_ne!(order, order_of(&protocol, "sub-01", 4));
    assert_ne!(order, order_of(&protocol, "sub-02", 3));
    for name in ["slow", "weak", "am-6hz-95"] {
        assert_eq!(order[1..].iter().filter(|n| *n == name).count(), 4);
    }
}

#[test]
fn a_counterbalanced_order_depends_on_the_participants_number_alone() {
    let protocol = many_conditions("counterbalanced");
    assert_eq!(
        order_of(&protocol, "sub-01", 3),
        order_of(&protocol, "sub-A1", 9)
    );
    assert_ne!(
        order_of(&protocol, "sub-01", 3),
        order_of(&protocol, "sub-02", 3)
    );
    assert_eq!(
        Session::new(protocol, sub("sub-anna"), 3).unwrap_err(),
        SessionError::NoParticipantNumber {
            participant: sub("sub-anna")
        }
    );
}

/// Fault 35.
#[test]
fn a_session_resumed_from_its_log_keeps_its_order_and_counts() {
    let protocol = many_conditions("randomised");
    let all_trials = {
        let mut rig = Rig::new(protocol.clone()).with_consent();
        rig.run_until(Phase::Finished);
        rig.begun_trials()
    };
    // Killed in the middle of the fifth trial.
    let mut rig = Rig::new(protocol.clone()).with_consent();
    while rig.begun_trials().len() < 5 {
        rig.step(|_| {});
    }
    rig.run_until(Phase::Exploration);
    let text: Vec<String> = rig
        .events()
        .iter()
        .map(|e| serde_json::to_string(e).unwrap())
        .collect();
    let events: Vec<SessionEventKind> = text
        .iter()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let records = records_from_events(&events);
    assert_eq!(records.len(), 5);
    assert_eq!(
        records[4].outcome,
        TrialOutcome::Interrupted {
            interruption: Interruption::Crash
        }
    );
    let session = Session::resume(protocol.clone(), sub("sub-01"), 7, &records).unwrap();
    let mut rig = Rig::from_session(protocol.clone(), session).with_consent();
    rig.run_until(Phase::Finished);
    rig.check();
    let trials = rig.begun_trials();
    assert_eq!((trials[0].number, trials[0].attempt), (5, 2));
    let names = |keys: &[TrialKey]| keys.iter().map(|k| k.condition.clone()).collect::<Vec<_>>();
    assert_eq!(names(&trials), names(&all_trials[4..]));
    assert_eq!(rig.session.summary().accepted, 12);

    let SessionError::ForeignRecord { because, .. } =
        Session::resume(protocol, sub("sub-01"), 8, &records).unwrap_err()
    else {
        panic!("another error")
    };
    assert!(
        matches!(because, RecordMismatch::Condition { .. }),
        "{because}"
    );
}

#[test]
fn repetitions_before_a_crash_still_count() {
    let protocol = demo();
    let mut rig = Rig::new(protocol.clone()).with_consent();
    rig.run_until_main(Phase::Baseline);
    rig.normal_n = 1.2;
    while rig.session.summary().redone < 2 {
        rig.step(|_| {});
    }
    let session = Session::resume(
        protocol.clone(),
        sub("sub-01"),
        7,
        &records_from_events(&rig.events()),
    )
    .unwrap();
    let mut rig = Rig::from_session(protocol, session).with_consent();
    rig.normal_n = 1.2;
    while rig.session.summary().given_up == 0 {
        rig.step(|_| {});
    }
    assert_eq!(rig.session.summary().redone, 3);
}

#[test]
fn attempts_that_are_left_out_are_not_made() {
    let protocol = demo();
    let mut session = Session::new(protocol.clone(), sub("sub-01"), 7).unwrap();
    session.leave_out(2, 3);
    session.leave_out(2, 1);
    let mut rig = Rig::from_session(protocol, session).with_consent();
    rig.run_until(Phase::Finished);
    let attempts: Vec<_> = rig
        .begun_trials()
        .iter()
        .map(|key| (key.number, key.attempt))
        .collect();
    assert_eq!(attempts[..3], [(1, 1), (2, 4), (3, 1)]);
    assert_eq!(rig.session.summary().redone, 0);
}

#[test]
fn a_finished_session_cannot_be_gone_beyond() {
    let protocol = demo();
    let mut rig = Rig::new(protocol.clone()).with_consent();
    rig.run_until(Phase::Finished);
    let records = records_from_events(&rig.events());
    let mut rig = Rig::from_session(
        protocol.clone(),
        Session::resume(protocol.clone(), sub("sub-01"), 7, &records).unwrap(),
    )
    .with_consent();
    rig.run_until(Phase::Finished);
    assert!(rig.begun_trials().is_empty());
    let mismatch = |records: &[TrialRecord]| match Session::resume(
        protocol.clone(),
        sub("sub-01"),
        7,
        records,
    )
    .unwrap_err()
    {
        SessionError::ForeignRecord { because, .. } => because,
        error => panic!("{error}"),
    };
    assert_eq!(
        mismatch(&[records.clone(), records.clone()].concat()),
        RecordMismatch::AllSettled { trials: 5 }
    );
    assert_eq!(mismatch(&records[1..]), RecordMismatch::Trial { number: 1 });
    let mut repetition = records[0].clone();
    repetition.outcome = TrialOutcome::Redo { reasons: vec![] };
    assert_eq!(
        mismatch(&[repetition.clone(), repetition]),
        RecordMismatch::Attempt { next: 2 }
    );
}

/// Returns a resumed session after the log withdrew the acceptance of these trials.
fn without_trials(rig: &Rig, numbers: &[u32]) -> (Session, Vec<SessionEventKind>) {
    let mut events = rig.events();
    let records = records_from_events(&events);
    let mut session = Session::resume(demo(), sub("sub-01"), 7, &records).unwrap();
    let reason = || "its folder is missing".to_owned();
    for &number in numbers {
        let record = session.withdraw(number, 1, reason()).unwrap();
        assert!(matches!(
            record.outcome,
            TrialOutcome::Interrupted {
                interruption: Interruption::NotSaved { .. }
            }
        ));
        assert_eq!(session.withdraw(number, 1, reason()), None, "once");
        events.push(SessionEventKind::TrialSettled { record });
    }
    (session, events)
}

/// Fault 27.
#[test]
fn a_trial_whose_recording_is_lost_is_repeated_and_the_log_keeps_that() {
    let mut rig = Rig::new(demo()).with_consent();
    while rig.session.trials_left() > 2 {
        rig.step(|_| {});
    }
    // The attempt after it has begun and is cut off.
    rig.run_until(Phase::Exploration);
    let (session, events) = without_trials(&rig, &[3]);
    assert_eq!(session.trials_left(), 3);
    assert_eq!(session.summary().accepted, 1);
    assert_eq!(session.next_numbers(), (3, 4));
    let mut rig = Rig::from_session(demo(), session).with_consent();
    rig.run_until(Phase::Verdict);
    let killed_events = [events, rig.events()].concat();
    rig.run_until(Phase::Finished);
    rig.check();
    let keys = |rig: &Rig| -> Vec<_> {
        let trials = rig.begun_trials();
        trials.iter().map(|key| (key.number, key.attempt)).collect()
    };
    assert_eq!(keys(&rig), [(3, 2), (4, 2), (5, 1)]);
    assert_eq!(rig.session.summary().accepted, 4);

    // The program was killed in that part, too.
    let records = records_from_events(&killed_events);
    let session = Session::resume(demo(), sub("sub-01"), 7, &records).unwrap();
    let mut rig = Rig::from_session(demo(), session).with_consent();
    rig.run_until(Phase::Finished);
    assert_eq!(keys(&rig), [(3, 3), (4, 2), (5, 1)]);
    assert_eq!(rig.session.summary().accepted, 4);
}

/// Fault 27.
#[test]
fn trials_amid_others_are_repeated_before_the_session_goes_on() {
    let mut rig = Rig::new(demo()).with_consent();
    while rig.session.trials_left() > 1 {
        rig.step(|_| {});
    }
    let (session, _) = without_trials(&rig, &[2, 4]);
    assert_eq!(session.trials_left(), 3);
    assert_eq!(session.next_numbers(), (2, 4));
    let mut rig = Rig::from_session(demo(), session).with_consent();
    rig.run_until(Phase::Finished);
    rig.check();
    let attempts: Vec<_> = rig
        .begun_trials()
        .iter()
        .map(|key| (key.number, key.attempt))
        .collect();
    assert_eq!(attempts, [(2, 2), (4, 2), (5, 2)]);
    assert_eq!(rig.session.next_numbers(), (6, 6));
}

#[test]
fn an_attempt_that_did_not_settle_its_trial_is_not_taken_back() {
    let mut session = Session::new(demo(), sub("sub-01"), 7).unwrap();
    assert_eq!(session.withdraw(1, 1, String::new()), None);
}
