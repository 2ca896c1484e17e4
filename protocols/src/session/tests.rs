//! Whole sessions with a scripted participant, and invariants over arbitrary observations.

use super::*;
use crate::participant::ParticipantId;
use crate::protocol::{Protocol, built_in};
use crate::selection::{Instance, Stretch, StretchOutcome};
use crate::trial::*;
use crate::verdict::{ExplorationAnalysis, RedoReason, TrialAnalysis, Verdict};
use proptest::prelude::*;
use std::collections::HashSet;

const STEP_S: f64 = 0.02;

fn demo() -> Protocol {
    Protocol::parse(built_in("demo").unwrap(), "demo.toml").unwrap()
}

fn sub(id: &str) -> ParticipantId {
    id.parse().unwrap()
}

fn consent() -> OperatorCommand {
    OperatorCommand::ConsentGiven {
        by: "NH".to_owned(),
    }
}

/// What the bench would find in a trial where each exploration was pressed with `normal_n`.
fn analysis(key: &TrialKey, protocol: &Protocol, normal_n: f64) -> TrialAnalysis {
    let instance = Instance {
        start_s: 1.0,
        end_s: 1.06,
    };
    let stretch = Stretch {
        start_s: 0.99,
        end_s: 1.07,
        outcome: StretchOutcome::Accepted(instance),
    };
    let exploration = |&direction: &Direction| ExplorationAnalysis {
        direction,
        mean_normal_n: Some(normal_n),
        mean_speed_m_per_s: Some(0.05),
        stretches: vec![stretch; 6],
    };
    TrialAnalysis {
        key: key.clone(),
        explorations: protocol
            .exploration
            .directions
            .iter()
            .map(exploration)
            .collect(),
        unloaded_mean_normal_n: Some(0.0),
        clipped_frames: 0,
        lost_frames: 0,
        input_xruns: 0,
        output_xruns: 0,
    }
}

/// A session, a participant who does as the screen says, and a bench that answers.
struct Rig {
    protocol: Protocol,
    session: Session,
    t_s: f64,
    view: Option<ParticipantView>,
    steps: Vec<Vec<Action>>,
    to_analyse: Option<TrialKey>,
    safety: Safety,
    lifts: bool,
    presses: bool,
    analyses: bool,
    normal_n: f64,
}

impl Rig {
    fn new(protocol: Protocol) -> Self {
        let session = Session::new(protocol.clone(), sub("sub-01"), 7).unwrap();
        Self::with(protocol, session)
    }

    fn with(protocol: Protocol, session: Session) -> Self {
        Self {
            protocol,
            session,
            t_s: 10.0,
            view: None,
            steps: Vec::new(),
            to_analyse: None,
            safety: Safety::Ok,
            lifts: true,
            presses: true,
            analyses: true,
            normal_n: 0.65,
        }
    }

    fn observation(&mut self) -> Observation {
        let instruction = self
            .view
            .as_ref()
            .map_or(Instruction::Wait, |v| v.instruction);
        let on = matches!(
            instruction,
            Instruction::PlaceFinger | Instruction::GetReady | Instruction::FollowSlider
        );
        let button = self.view.as_ref().is_some_and(|v| v.button);
        let key = if self.analyses {
            self.to_analyse.take()
        } else {
            None
        };
        Observation {
            t_s: self.t_s,
            normal_n: Some(if on || !self.lifts {
                self.normal_n
            } else {
                0.0
            }),
            button_pressed: button && self.presses,
            command: None,
            safety: self.safety.clone(),
            analysis: key.map(|key| analysis(&key, &self.protocol, self.normal_n)),
        }
    }

    fn step(&mut self, change: impl FnOnce(&mut Observation)) -> &[Action] {
        self.t_s += STEP_S;
        let mut observation = self.observation();
        change(&mut observation);
        self.t_s = observation.t_s;
        let actions = self.session.step(&observation);
        for action in &actions {
            match action {
                Action::Show(view) => self.view = Some(view.clone()),
                Action::AnalyseTrial { key, .. } => self.to_analyse = Some(key.clone()),
                _ => {}
            }
        }
        self.steps.push(actions);
        self.steps.last().unwrap()
    }

    fn tell(&mut self, command: OperatorCommand) -> &[Action] {
        self.step(|o| o.command = Some(command))
    }

    fn consented(mut self) -> Self {
        self.tell(consent());
        self
    }

    /// Steps until `phase`, for at most ten minutes of session.
    fn until(&mut self, phase: Phase) -> &mut Self {
        for _ in 0..(600.0 / STEP_S) as usize {
            if self.session.phase() == phase {
                return self;
            }
            self.step(|_| {});
        }
        panic!("{phase:?} never came, now in {:?}", self.session.phase());
    }

    /// Like [`Self::until`], in the first trial that is not practice.
    fn until_main(&mut self, phase: Phase) -> &mut Self {
        loop {
            self.until(phase);
            let practice = self.protocol.trials.practice;
            if self.begun().last().is_some_and(|key| key.number > practice) {
                return self;
            }
            while self.session.phase() == phase {
                self.step(|_| {});
            }
        }
    }

    fn actions(&self) -> impl Iterator<Item = &Action> {
        self.steps.iter().flatten()
    }

    fn begun(&self) -> Vec<TrialKey> {
        self.actions()
            .filter_map(|a| match a {
                Action::BeginTrial { key, .. } => Some(key.clone()),
                _ => None,
            })
            .collect()
    }

    fn ends(&self) -> Vec<TrialEnd> {
        self.actions()
            .filter_map(|a| match a {
                Action::EndTrial { end, .. } => Some(end.clone()),
                _ => None,
            })
            .collect()
    }

    fn events(&self) -> Vec<SessionEventKind> {
        self.actions()
            .filter_map(|a| match a {
                Action::Log(event) => Some(event.kind.clone()),
                _ => None,
            })
            .collect()
    }

    fn outcomes(&self) -> Vec<TrialOutcome> {
        self.session
            .records()
            .iter()
            .map(|r| r.outcome.clone())
            .collect()
    }

    fn check(&self) {
        check_invariants(&self.steps, &self.protocol);
    }
}

/// Everything that must hold whatever is observed.
fn check_invariants(steps: &[Vec<Action>], protocol: &Protocol) {
    let mut consented = false;
    let mut driven = false;
    let mut finished = false;
    let mut open: Option<(TrialKey, f64, Vec<Interval>)> = None;
    let mut keys = HashSet::new();
    let mut redone: Vec<u32> = Vec::new();
    for step in steps {
        assert!(matches!(step.last(), Some(Action::Show(_))));
        assert_eq!(
            step.iter().filter(|a| matches!(a, Action::Show(_))).count(),
            1
        );
        for action in step {
            match action {
                Action::Log(SessionEvent {
                    kind: SessionEventKind::ConsentGiven { .. },
                    ..
                }) => {
                    consented = true;
                }
                Action::Log(SessionEvent {
                    kind: SessionEventKind::TrialSettled { record },
                    ..
                }) if matches!(record.outcome, TrialOutcome::Redo { .. }) => {
                    redone.push(record.key.number);
                    let of_trial = redone.iter().filter(|n| **n == record.key.number).count();
                    assert!(of_trial <= protocol.redo.max_per_trial as usize);
                    assert!(redone.len() <= protocol.redo.max_total as usize);
                }
                Action::BeginTrial { key, at_s, .. } => {
                    assert!(consented, "a trial before the consent");
                    assert!(!finished && !driven && open.is_none());
                    assert!(keys.insert((key.number, key.attempt)), "{key:?} twice");
                    open = Some((key.clone(), *at_s, Vec::new()));
                }
                Action::Drive(DriveRequest::On(_)) => {
                    assert!(open.is_some(), "driven outside a trial");
                    driven = true;
                }
                Action::Drive(DriveRequest::Off) => driven = false,
                Action::Mark(interval) => {
                    let (_, begin_s, intervals) = open.as_mut().expect("marked outside a trial");
                    assert!(interval.start_s >= *begin_s && interval.end_s > interval.start_s);
                    if let Some(last) = intervals.last() {
                        assert!(interval.start_s >= last.end_s, "intervals overlap");
                    }
                    intervals.push(*interval);
                }
                Action::EndTrial { key, end, at_s } => {
                    assert!(!driven, "a recording ended while driven");
                    let (begun, _, intervals) = open.take().expect("ended twice");
                    assert_eq!(begun, *key);
                    assert!(intervals.iter().all(|i| i.end_s <= *at_s));
                    if *end == TrialEnd::Completed {
                        let all = 1 + protocol.exploration.directions.len();
                        assert_eq!(intervals.len(), all);
                    }
                }
                Action::Finished(_) => {
                    assert!(!finished && open.is_none());
                    finished = true;
                }
                _ => {}
            }
        }
    }
}

#[test]
fn a_whole_session_runs_as_the_protocol_says() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Finished);
    rig.check();
    assert_eq!(rig.begun().len(), 5);
    assert!(rig.begun()[0].practice && !rig.begun()[1].practice);
    assert!(rig.ends().iter().all(|e| *e == TrialEnd::Completed));
    let summary = rig.session.summary();
    assert_eq!(
        (summary.planned, summary.practice, summary.accepted),
        (4, 1, 4)
    );
    assert_eq!(summary.instances, 4 * 2 * 6);
    approx_eq(summary.mean_normal_n.unwrap(), 0.65);
    let cues = rig
        .actions()
        .filter(|a| matches!(a, Action::Cue(_)))
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
            .filter(|a| matches!(a, Action::Finished(_)))
            .count(),
        1
    );
}

fn is_phase(event: &SessionEventKind, wanted: Phase) -> bool {
    matches!(event, SessionEventKind::Phase { phase } if *phase == wanted)
}

fn approx_eq(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

#[test]
fn intervals_have_the_protocols_lengths_and_directions() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Analysing);
    let intervals: Vec<Interval> = rig
        .actions()
        .find_map(|a| match a {
            Action::AnalyseTrial { intervals, .. } => Some(intervals.clone()),
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
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Exploration);
    let start_s = rig.t_s;
    let mut seen = 0;
    while rig.session.phase() == Phase::Exploration {
        let view = rig.view.clone().unwrap();
        approx_eq(view.slider_m.unwrap(), 0.010 + 0.050 * (rig.t_s - start_s));
        assert_eq!(view.direction, Some(Direction::LeftToRight));
        seen += 1;
        rig.step(|_| {});
    }
    assert!(seen > 80);
}

#[test]
fn the_participant_is_told_the_mean_force_of_the_exploration() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Feedback);
    let view = rig.view.clone().unwrap();
    assert_eq!(view.instruction, Instruction::Feedback);
    approx_eq(view.mean_force_n.unwrap(), 0.65);
}

#[test]
fn nothing_happens_before_the_consent() {
    let mut rig = Rig::new(demo());
    for command in [
        OperatorCommand::Continue,
        OperatorCommand::Pause,
        OperatorCommand::Redo,
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
    assert!(rig.begun().is_empty());
    let refused = rig
        .events()
        .iter()
        .filter(|e| matches!(e, SessionEventKind::CommandRefused { .. }))
        .count();
    assert_eq!(refused, 4);
}

#[test]
fn a_finger_on_the_plate_holds_the_baseline_up() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Baseline);
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
    rig.until(Phase::Ready);
    let baseline = rig.actions().find_map(|a| match a {
        Action::Mark(interval) => Some(*interval),
        _ => None,
    });
    assert!(baseline.unwrap().start_s > lifted_s);
    rig.check();
}

#[test]
fn an_unknown_force_is_not_a_lifted_finger() {
    let mut rig = Rig::new(demo()).consented();
    for _ in 0..200 {
        rig.step(|o| o.normal_n = None);
    }
    assert_eq!(rig.session.phase(), Phase::Baseline);
}

#[test]
fn a_finger_lifted_during_the_countdown_goes_back_to_ready() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Countdown);
    rig.step(|o| o.normal_n = Some(0.0));
    assert_eq!(rig.session.phase(), Phase::Ready);
    assert!(rig.events().contains(&SessionEventKind::FingerLiftedEarly));
    rig.until(Phase::Finished);
    rig.check();
}

#[test]
fn the_button_counts_only_with_the_finger_on_the_plate() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Ready);
    rig.step(|o| {
        o.normal_n = Some(0.0);
        o.button_pressed = true;
        o.command = Some(OperatorCommand::Continue);
    });
    assert_eq!(rig.session.phase(), Phase::Ready);
    let refused = rig.events().iter().any(
        |e| matches!(e, SessionEventKind::CommandRefused { because, .. } if because.contains("finger")),
    );
    assert!(refused);
}

#[test]
fn the_operator_can_press_on_for_a_participant_without_button() {
    let mut rig = Rig::new(demo()).consented();
    rig.presses = false;
    rig.tell(OperatorCommand::Continue);
    for _ in 0..2 {
        rig.until(Phase::Ready);
        rig.step(|_| {});
        rig.tell(OperatorCommand::Continue);
    }
    rig.until(Phase::Verdict);
    rig.check();
}

fn timed_out(set: impl FnOnce(&mut Rig), expected: Interruption) {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Baseline);
    set(&mut rig);
    rig.until(Phase::Paused);
    assert_eq!(
        rig.ends(),
        [TrialEnd::Interrupted {
            interruption: expected
        }]
    );
    rig.lifts = true;
    rig.presses = true;
    rig.tell(OperatorCommand::Resume);
    rig.until(Phase::Finished);
    assert_eq!((rig.begun()[1].number, rig.begun()[1].attempt), (1, 2));
    rig.check();
}

#[test]
fn a_finger_that_stays_on_the_plate_pauses_the_session() {
    timed_out(|rig| rig.lifts = false, Interruption::FingerNotLifted);
}

#[test]
fn a_button_that_comes_too_late_pauses_the_session() {
    timed_out(|rig| rig.presses = false, Interruption::FingerNotPlaced);
}

#[test]
fn a_finger_that_stays_after_an_exploration_does_not_cost_the_trial() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Lift);
    rig.lifts = false;
    rig.until(Phase::Feedback);
    assert!(rig.events().contains(&SessionEventKind::FingerNotLifted));
}

#[test]
fn a_bad_trial_is_repeated_with_its_reasons_until_the_limit() {
    let mut rig = Rig::new(demo()).consented();
    rig.until_main(Phase::Baseline);
    rig.normal_n = 1.2;
    let limit = rig.protocol.redo.max_per_trial;
    while rig.begun().last().unwrap().number == 2 {
        rig.step(|_| {});
    }
    rig.normal_n = 0.65;
    rig.until(Phase::Finished);
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
            other => panic!("{other:?}"),
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
fn the_sessions_limit_of_repetitions_holds_over_all_trials() {
    let mut protocol = demo();
    protocol.redo.max_total = 4;
    let mut rig = Rig::new(protocol).consented();
    rig.normal_n = 0.2;
    rig.until(Phase::Finished);
    rig.check();
    let summary = rig.session.summary();
    assert_eq!(
        (summary.redone, summary.given_up, summary.accepted),
        (4, 4, 0)
    );
}

#[test]
fn a_bad_practice_trial_is_not_repeated() {
    let mut rig = Rig::new(demo()).consented();
    rig.normal_n = 1.2;
    rig.until_main(Phase::Baseline);
    assert!(matches!(
        rig.outcomes()[..],
        [TrialOutcome::AcceptedAnyway { .. }]
    ));
}

#[test]
fn the_operator_can_keep_a_bad_trial() {
    let mut rig = Rig::new(demo()).consented();
    rig.normal_n = 1.2;
    rig.until_main(Phase::Verdict);
    rig.tell(OperatorCommand::AcceptAnyway);
    assert!(matches!(
        rig.outcomes().last(),
        Some(TrialOutcome::AcceptedAnyway { reasons }) if reasons.len() == 2
    ));
    assert_eq!(rig.begun().last().unwrap().number, 3);
}

#[test]
fn the_operator_can_repeat_a_good_trial_and_a_running_one() {
    let mut rig = Rig::new(demo()).consented();
    rig.until_main(Phase::Verdict);
    rig.tell(OperatorCommand::Redo);
    rig.until(Phase::Exploration);
    rig.tell(OperatorCommand::Redo);
    assert_eq!(rig.session.phase(), Phase::Baseline);
    rig.until(Phase::Finished);
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
    let mut rig = Rig::new(demo()).consented();
    rig.until_main(Phase::Lift);
    rig.analyses = false;
    rig.until(Phase::Verdict);
    rig.analyses = true;
    rig.to_analyse = None;
    rig.until(Phase::Finished);
    let not_analysed = TrialOutcome::Redo {
        reasons: vec![RedoReason::NotAnalysed],
    };
    assert!(rig.outcomes().contains(&not_analysed));
    assert_eq!(rig.session.summary().accepted, 4);
    rig.check();
}

#[test]
fn an_analysis_of_another_attempt_is_ignored() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Analysing);
    let mut key = rig.to_analyse.take().unwrap();
    key.attempt += 1;
    let foreign = analysis(&key, &rig.protocol, 0.65);
    rig.step(|o| o.analysis = Some(foreign));
    assert_eq!(rig.session.phase(), Phase::Analysing);
}

const RUNNING: [Phase; 11] = [
    Phase::Welcome,
    Phase::Baseline,
    Phase::Ready,
    Phase::Countdown,
    Phase::Exploration,
    Phase::Lift,
    Phase::Feedback,
    Phase::Analysing,
    Phase::Verdict,
    Phase::Rest,
    Phase::Paused,
];

fn in_trial(phase: Phase) -> bool {
    matches!(
        phase,
        Phase::Baseline
            | Phase::Ready
            | Phase::Countdown
            | Phase::Exploration
            | Phase::Lift
            | Phase::Feedback
    )
}

fn rig_in(phase: Phase) -> Rig {
    let mut rig = Rig::new(demo()).consented();
    if phase == Phase::Paused {
        rig.until(Phase::Exploration);
        rig.tell(OperatorCommand::Pause);
    } else {
        rig.until(phase);
    }
    rig
}

#[test]
fn a_pause_in_any_phase_stops_the_drive_and_the_session_still_completes() {
    for phase in RUNNING {
        let mut rig = rig_in(phase);
        let begun = rig.begun().len();
        rig.tell(OperatorCommand::Pause);
        assert_eq!(rig.session.phase(), Phase::Paused);
        assert_eq!(rig.view.as_ref().unwrap().instruction, Instruction::Paused);
        for _ in 0..500 {
            rig.step(|_| {});
        }
        assert_eq!(rig.begun().len(), begun, "{phase:?}");
        rig.tell(OperatorCommand::Resume);
        if in_trial(phase) {
            assert_eq!(rig.session.phase(), Phase::Baseline, "{phase:?}");
            let keys = rig.begun();
            assert_eq!(keys[begun].number, keys[begun - 1].number);
        } else if phase != Phase::Paused {
            assert_eq!(rig.session.phase(), phase);
        }
        rig.until(Phase::Finished);
        rig.check();
        assert_eq!(rig.session.summary().accepted, 4, "{phase:?}");
    }
}

#[test]
fn a_safety_trip_in_any_phase_stops_the_drive_until_the_operator_goes_on() {
    for phase in RUNNING {
        let mut rig = rig_in(phase);
        let begun = rig.begun().len();
        rig.safety = Safety::Tripped("e-stop".to_owned());
        let actions = rig.step(|_| {});
        let stopped = actions
            .iter()
            .position(|a| *a == Action::Drive(DriveRequest::Off));
        assert!(stopped.is_some(), "{phase:?}");
        assert_eq!(rig.session.phase(), Phase::Fault);
        rig.tell(OperatorCommand::Resume);
        assert_eq!(rig.session.phase(), Phase::Fault, "resumed while tripped");
        rig.safety = Safety::Ok;
        for _ in 0..500 {
            rig.step(|o| o.button_pressed = true);
        }
        assert_eq!(
            rig.session.phase(),
            Phase::Fault,
            "it must not go on by itself"
        );
        assert_eq!(rig.begun().len(), begun);
        rig.tell(OperatorCommand::Resume);
        rig.until(Phase::Finished);
        rig.check();
        let tripped = TrialEnd::Interrupted {
            interruption: Interruption::Safety {
                reason: "e-stop".to_owned(),
            },
        };
        assert_eq!(rig.ends().contains(&tripped), in_trial(phase), "{phase:?}");
        assert_eq!(rig.session.summary().accepted, 4, "{phase:?}");
    }
}

#[test]
fn a_trip_before_the_consent_leads_back_to_the_consent() {
    let mut rig = Rig::new(demo());
    rig.safety = Safety::Tripped("e-stop".to_owned());
    rig.tell(consent());
    assert_eq!(rig.session.phase(), Phase::Fault);
    assert!(
        rig.events()
            .iter()
            .any(|e| matches!(e, SessionEventKind::CommandRefused { .. }))
    );
    rig.safety = Safety::Ok;
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
                rig.step(|o| o.safety = Safety::Tripped("e-stop".to_owned()));
                rig
            }
            _ => rig_in(phase),
        };
        rig.tell(OperatorCommand::Abort);
        assert_eq!(rig.session.phase(), Phase::Aborted);
        let begun = rig.begun().len();
        for _ in 0..100 {
            rig.step(|o| o.button_pressed = true);
        }
        rig.tell(OperatorCommand::Resume);
        rig.tell(OperatorCommand::Abort);
        rig.check();
        assert_eq!(rig.begun().len(), begun, "{phase:?}");
        assert_eq!(
            rig.session.records().len(),
            begun,
            "{phase:?}: every attempt is accounted for"
        );
        let finished = rig
            .actions()
            .filter(|a| matches!(a, Action::Finished(_)))
            .count();
        assert_eq!(finished, 1, "{phase:?}");
    }
}

#[test]
fn an_analysis_that_arrives_during_a_pause_is_kept() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Analysing);
    rig.tell(OperatorCommand::Pause);
    rig.step(|_| {});
    rig.analyses = false;
    rig.tell(OperatorCommand::Resume);
    rig.step(|_| {});
    assert_eq!(rig.session.phase(), Phase::Verdict);
}

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

fn many_conditions(order: &str) -> Protocol {
    let base = built_in("demo").unwrap();
    let text = base
        .replace(
            "[[conditions]]",
            "[[conditions]]\nname = \"slow\"\nmodulation_hz = 2.0\n[[conditions]]\nname = \"weak\"\nmean_amplitude_v = 5.0\n[[conditions]]",
        )
        .replace("order = \"fixed\"", &format!("order = \"{order}\""));
    Protocol::parse(&text, "many.toml").unwrap()
}

fn order_of(protocol: &Protocol, id: &str, seed: u64) -> Vec<String> {
    let mut session = Session::new(protocol.clone(), sub(id), seed).unwrap();
    let actions = session.step(&Observation::default());
    let Action::Log(SessionEvent {
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
    let error = Session::new(protocol, sub("sub-anna"), 3).unwrap_err();
    assert!(error.to_string().contains("sub-anna"), "{error}");
}

#[test]
fn a_session_resumed_from_its_log_keeps_its_order_and_counts() {
    let protocol = many_conditions("randomised");
    let whole = {
        let mut rig = Rig::new(protocol.clone()).consented();
        rig.until(Phase::Finished);
        rig.begun()
    };
    // Killed in the middle of the fifth trial.
    let mut rig = Rig::new(protocol.clone()).consented();
    while rig.begun().len() < 5 {
        rig.step(|_| {});
    }
    rig.until(Phase::Exploration);
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
    let resumed = Session::resume(protocol.clone(), sub("sub-01"), 7, &records).unwrap();
    let mut rig = Rig::with(protocol.clone(), resumed).consented();
    rig.until(Phase::Finished);
    rig.check();
    let begun = rig.begun();
    assert_eq!((begun[0].number, begun[0].attempt), (5, 2));
    let names = |keys: &[TrialKey]| keys.iter().map(|k| k.condition.clone()).collect::<Vec<_>>();
    assert_eq!(names(&begun), names(&whole[4..]));
    assert_eq!(rig.session.summary().accepted, 12);

    let error = Session::resume(protocol, sub("sub-01"), 8, &records).unwrap_err();
    assert!(
        matches!(error, SessionError::ForeignRecord { .. }),
        "{error}"
    );
}

#[test]
fn repetitions_before_a_crash_still_count() {
    let protocol = demo();
    let mut rig = Rig::new(protocol.clone()).consented();
    rig.until_main(Phase::Baseline);
    rig.normal_n = 1.2;
    while rig.session.summary().redone < 2 {
        rig.step(|_| {});
    }
    let resumed = Session::resume(
        protocol.clone(),
        sub("sub-01"),
        7,
        &records_from_events(&rig.events()),
    )
    .unwrap();
    let mut rig = Rig::with(protocol, resumed).consented();
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
    let mut rig = Rig::with(protocol, session).consented();
    rig.until(Phase::Finished);
    let attempts: Vec<_> = rig
        .begun()
        .iter()
        .map(|key| (key.number, key.attempt))
        .collect();
    assert_eq!(attempts[..3], [(1, 1), (2, 4), (3, 1)]);
    assert_eq!(rig.session.summary().redone, 0);
}

#[test]
fn a_finished_session_cannot_be_gone_beyond() {
    let protocol = demo();
    let mut rig = Rig::new(protocol.clone()).consented();
    rig.until(Phase::Finished);
    let records = records_from_events(&rig.events());
    let mut resumed = Rig::with(
        protocol.clone(),
        Session::resume(protocol.clone(), sub("sub-01"), 7, &records).unwrap(),
    )
    .consented();
    resumed.until(Phase::Finished);
    assert!(resumed.begun().is_empty());
    let twice = [records.clone(), records].concat();
    Session::resume(protocol, sub("sub-01"), 7, &twice).unwrap_err();
}

#[test]
fn a_clock_that_stands_or_goes_back_does_no_harm() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Exploration);
    let before = rig.t_s;
    let slider = rig.view.as_ref().unwrap().slider_m;
    for t_s in [before - 5.0, f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
        rig.step(|o| o.t_s = t_s);
        assert_eq!(rig.view.as_ref().unwrap().slider_m, slider);
    }
    rig.t_s = before;
    rig.until(Phase::Finished);
    rig.check();
}

#[test]
fn every_action_survives_json() {
    let mut rig = Rig::new(demo()).consented();
    rig.until_main(Phase::Exploration);
    rig.step(|o| o.safety = Safety::Tripped("e-stop".to_owned()));
    rig.tell(OperatorCommand::Resume);
    rig.normal_n = 1.2;
    rig.until(Phase::Verdict);
    rig.tell(OperatorCommand::Abort);
    for action in rig.actions() {
        let text = serde_json::to_string(action).unwrap();
        let back: Action = serde_json::from_str(&text).unwrap();
        assert_eq!(back, *action, "{text}");
    }
}

/// One step of a participant, operator and bench who do anything.
#[derive(Clone, Debug)]
enum Move {
    /// Do as the screen says, for a while, under an operator who ends a pause or does not.
    Follow {
        steps: u8,
        resume: bool,
    },
    Anything {
        dt_s: f64,
        normal_n: Option<f64>,
        button: bool,
        command: Option<OperatorCommand>,
    },
    Trip,
    Analyse {
        normal_n: f64,
    },
}

fn a_move() -> impl Strategy<Value = Move> {
    let command = prop_oneof![
        Just(consent()),
        Just(OperatorCommand::Continue),
        Just(OperatorCommand::Pause),
        Just(OperatorCommand::Resume),
        Just(OperatorCommand::Redo),
        Just(OperatorCommand::AcceptAnyway),
    ];
    // Rare, or few sessions would get far.
    let command = prop_oneof![100 => command, 1 => Just(OperatorCommand::Abort)];
    let dt_s = prop_oneof![Just(0.0), -1.0..3.0, Just(40.0), Just(f64::NAN)];
    let normal_n = prop::option::of(prop_oneof![Just(0.0), -0.1..1.5, Just(f64::NAN)]);
    prop_oneof![
        12 => (1u8..200, any::<bool>()).prop_map(|(steps, resume)| Move::Follow { steps, resume }),
        4 => (dt_s, normal_n, any::<bool>(), prop::option::of(command))
            .prop_map(|(dt_s, normal_n, button, command)| Move::Anything { dt_s, normal_n, button, command }),
        1 => Just(Move::Trip),
        2 => (0.1..1.5).prop_map(|normal_n| Move::Analyse { normal_n }),
    ]
}

proptest! {
    #[test]
    fn invariants_hold_whatever_is_observed(
        consented: bool, moves in prop::collection::vec(a_move(), 1..150),
    ) {
        let mut rig = Rig::new(demo());
        if consented {
            rig.tell(consent());
        }
        for a_move in moves {
            match a_move {
                Move::Follow { steps, resume } => {
                    if resume {
                        rig.tell(OperatorCommand::Resume);
                    }
                    for _ in 0..steps {
                        rig.step(|_| {});
                    }
                }
                Move::Anything { dt_s, normal_n, button, command } => {
                    rig.step(|o| {
                        o.t_s += dt_s;
                        o.normal_n = normal_n;
                        o.button_pressed = button;
                        o.command = command;
                    });
                    if rig.t_s.is_nan() {
                        rig.t_s = 1e3;
                    }
                }
                Move::Trip => {
                    rig.step(|o| o.safety = Safety::Tripped("any".to_owned()));
                }
                Move::Analyse { normal_n } => rig.normal_n = normal_n,
            }
        }
        rig.check();
        let records = records_from_events(&rig.events());
        let known = rig.session.records();
        prop_assert_eq!(&records[..known.len()], known);
        let resumed = Session::resume(demo(), sub("sub-01"), 7, &records);
        prop_assert!(resumed.is_ok(), "{:?}", resumed);
    }
}

#[test]
fn a_verdict_is_announced_before_it_takes_hold() {
    let mut rig = Rig::new(demo()).consented();
    rig.until(Phase::Verdict);
    let announced = rig.actions().find_map(|a| match a {
        Action::Verdict { key, verdict } => Some((key.clone(), verdict.clone())),
        _ => None,
    });
    assert_eq!(announced, Some((rig.begun()[0].clone(), Verdict::Accepted)));
    assert!(rig.session.records().is_empty());
}
