//! A session with a scripted participant, and the invariants of every session.

use crate::analysis::{ExplorationAnalysis, TrialAnalysis};
use crate::protocol::{Protocol, built_in};
use crate::record::TrialOutcome;
use crate::session::*;
use crate::stretch::{Instance, Stretch, StretchOutcome};
use crate::trial::*;
use participant_texts::Instruction;
use participants::ParticipantId;
use std::collections::HashSet;

pub(super) const STEP_S: f64 = 0.02;

/// Why a recording failed.
pub(super) const FULL: &str = "the disk is full";

pub(super) fn demo() -> Protocol {
    Protocol::parse(built_in("demo").unwrap(), "demo.toml").unwrap()
}

pub(super) fn sub(id: &str) -> ParticipantId {
    id.parse().unwrap()
}

pub(super) fn consent() -> OperatorCommand {
    OperatorCommand::ConsentGiven {
        by: "NH".to_owned(),
    }
}

/// Returns the analysis of a trial with each exploration pressed with `normal_n`.
pub(super) fn analysis(key: &TrialKey, protocol: &Protocol, normal_n: f64) -> TrialAnalysis {
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
        lifted_s: 0.0,
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

/// A session, a participant who follows the screen, and a bench that answers.
pub(super) struct Rig {
    pub(super) protocol: Protocol,
    pub(super) session: Session,
    pub(super) t_s: f64,
    pub(super) view: Option<ParticipantView>,
    pub(super) steps: Vec<Vec<SessionAction>>,
    pub(super) to_analyse: Option<TrialKey>,
    pub(super) safety: SafetyChain,
    pub(super) lifts: bool,
    pub(super) presses: bool,
    pub(super) analyses: bool,
    pub(super) normal_n: f64,
    /// Attempt with a recording that has ended but is not reported yet.
    pub(super) to_save: Option<TrialKey>,
    pub(super) saves: bool,
    /// Attempts with recordings reported as saved.
    pub(super) saved: HashSet<TrialKey>,
}

impl Rig {
    pub(super) fn new(protocol: Protocol) -> Self {
        let session = Session::new(protocol.clone(), sub("sub-01"), 7).unwrap();
        Self::from_session(protocol, session)
    }

    pub(super) fn from_session(protocol: Protocol, session: Session) -> Self {
        Self {
            protocol,
            session,
            t_s: 10.0,
            view: None,
            steps: Vec::new(),
            to_analyse: None,
            safety: SafetyChain::Ok,
            lifts: true,
            presses: true,
            analyses: true,
            normal_n: 0.65,
            to_save: None,
            saves: true,
            saved: HashSet::new(),
        }
    }

    pub(super) fn observation(&mut self) -> Observation {
        let instruction = self
            .view
            .as_ref()
            .map_or(Instruction::Wait, |v| v.instruction);
        let has_touch = matches!(
            instruction,
            Instruction::PlaceFinger | Instruction::GetReady | Instruction::FollowSlider
        );
        let button = self.view.as_ref().is_some_and(|v| v.button);
        let key = if self.analyses {
            self.to_analyse.take()
        } else {
            None
        };
        let save_key = if self.saves {
            self.to_save.take()
        } else {
            None
        };
        Observation {
            recording: save_key.map(|key| (key, RecordingOutcome::Saved)),
            t_s: self.t_s,
            normal_n: Some(if has_touch || !self.lifts {
                self.normal_n
            } else {
                0.0
            }),
            button_pressed: button && self.presses,
            command: None,
            safety: self.safety.clone(),
            analysis: key.map(|key| analysis(&key, &self.protocol, self.normal_n)),
            ..Observation::default()
        }
    }

    pub(super) fn step(&mut self, change: impl FnOnce(&mut Observation)) -> &[SessionAction] {
        self.t_s += STEP_S;
        let mut observation = self.observation();
        change(&mut observation);
        self.t_s = observation.t_s;
        if let Some((key, RecordingOutcome::Saved)) = &observation.recording {
            self.saved.insert(key.clone());
        }
        let actions = self.session.step(&observation);
        for action in &actions {
            match action {
                SessionAction::Show(view) => self.view = Some(view.clone()),
                SessionAction::AnalyseTrial { key, .. } => {
                    self.to_analyse = Some(key.clone());
                    self.to_save = Some(key.clone());
                }
                _ => {}
            }
        }
        self.steps.push(actions);
        self.steps.last().unwrap()
    }

    pub(super) fn tell(&mut self, command: OperatorCommand) -> &[SessionAction] {
        self.step(|o| o.command = Some(command))
    }

    /// Returns number and attempt of the trial for commands; those of the first trial if none runs.
    pub(super) fn current_attempt(&self) -> (u32, u32) {
        let key = self.session.current();
        key.map_or((1, 1), |key| (key.number, key.attempt))
    }

    pub(super) fn redo(&self) -> OperatorCommand {
        let (number, attempt) = self.current_attempt();
        OperatorCommand::Redo { number, attempt }
    }

    pub(super) fn accept_anyway(&self) -> OperatorCommand {
        let (number, attempt) = self.current_attempt();
        OperatorCommand::AcceptAnyway { number, attempt }
    }

    /// Pauses at once, in any state.
    pub(super) fn pause_now(&mut self) {
        let command = match self.session.current() {
            Some(key) => OperatorCommand::PauseNow {
                number: key.number,
                attempt: key.attempt,
            },
            None => OperatorCommand::Pause,
        };
        self.tell(command);
    }

    pub(super) fn with_consent(mut self) -> Self {
        self.tell(consent());
        self
    }

    /// Reports that the recording of an attempt failed.
    pub(super) fn fail(&mut self, key: &TrialKey) -> &[SessionAction] {
        let failure = RecordingOutcome::Failed(FULL.to_owned());
        self.step(|o| o.recording = Some((key.clone(), failure)))
    }

    /// Steps until `phase`, for at most ten minutes of session time.
    pub(super) fn run_until(&mut self, phase: Phase) -> &mut Self {
        for _ in 0..(600.0 / STEP_S) as usize {
            if self.session.phase() == phase {
                return self;
            }
            self.step(|_| {});
        }
        panic!("{phase:?} never came, now in {:?}", self.session.phase());
    }

    /// Like [`Self::run_until`], in the first trial that is not practice.
    pub(super) fn run_until_main(&mut self, phase: Phase) -> &mut Self {
        loop {
            self.run_until(phase);
            let practice = self.protocol.trials.practice;
            if self
                .begun_trials()
                .last()
                .is_some_and(|key| key.number > practice)
            {
                return self;
            }
            while self.session.phase() == phase {
                self.step(|_| {});
            }
        }
    }

    pub(super) fn actions(&self) -> impl Iterator<Item = &SessionAction> {
        self.steps.iter().flatten()
    }

    pub(super) fn begun_trials(&self) -> Vec<TrialKey> {
        self.actions()
            .filter_map(|a| match a {
                SessionAction::BeginTrial { key, .. } => Some(key.clone()),
                _ => None,
            })
            .collect()
    }

    pub(super) fn trial_ends(&self) -> Vec<TrialEnd> {
        self.actions()
            .filter_map(|a| match a {
                SessionAction::EndTrial { end, .. } => Some(end.clone()),
                _ => None,
            })
            .collect()
    }

    pub(super) fn events(&self) -> Vec<SessionEventKind> {
        self.actions()
            .filter_map(|a| match a {
                SessionAction::Log(event) => Some(event.kind.clone()),
                _ => None,
            })
            .collect()
    }

    pub(super) fn outcomes(&self) -> Vec<TrialOutcome> {
        self.session
            .records()
            .iter()
            .map(|r| r.outcome.clone())
            .collect()
    }

    pub(super) fn check(&self) {
        check_invariants(&self.steps, &self.protocol);
        for event in self.events() {
            if let SessionEventKind::TrialSettled { record } = event {
                let is_saved = self.saved.contains(&record.key);
                assert!(
                    is_saved || !record.outcome.settles(),
                    "{record:?}: not saved"
                );
            }
        }
    }
}

/// Checks the invariants, which hold for any observations.
pub(super) fn check_invariants(steps: &[Vec<SessionAction>], protocol: &Protocol) {
    let mut has_consented = false;
    let mut is_driven = false;
    let mut is_finished = false;
    let mut open: Option<(TrialKey, f64, Vec<Interval>)> = None;
    let mut keys = HashSet::new();
    let mut redone: Vec<u32> = Vec::new();
    for step in steps {
        assert!(matches!(step.last(), Some(SessionAction::Show(_))));
        assert_eq!(
            step.iter()
                .filter(|a| matches!(a, SessionAction::Show(_)))
                .count(),
            1
        );
        for action in step {
            match action {
                SessionAction::Log(SessionEvent {
                    kind: SessionEventKind::ConsentGiven { .. },
                    ..
                }) => {
                    has_consented = true;
                }
                SessionAction::Log(SessionEvent {
                    kind: SessionEventKind::TrialSettled { record },
                    ..
                }) if matches!(record.outcome, TrialOutcome::Redo { .. }) => {
                    redone.push(record.key.number);
                    let of_trial = redone.iter().filter(|n| **n == record.key.number).count();
                    assert!(of_trial <= protocol.redo.max_per_trial as usize);
                    assert!(redone.len() <= protocol.redo.max_total as usize);
                }
                SessionAction::BeginTrial { key, at_s, .. } => {
                    assert!(has_consented, "a trial before the consent");
                    assert!(!is_finished && !is_driven && open.is_none());
                    assert!(keys.insert((key.number, key.attempt)), "{key:?} twice");
                    open = Some((key.clone(), *at_s, Vec::new()));
                }
                SessionAction::Drive(DriveRequest::On(_)) => {
                    assert!(open.is_some(), "driven outside a trial");
                    is_driven = true;
                }
                SessionAction::Drive(DriveRequest::Off) => is_driven = false,
                SessionAction::Mark(interval) => {
                    let (_, begin_s, intervals) = open.as_mut().expect("marked outside a trial");
                    assert!(interval.start_s >= *begin_s && interval.end_s > interval.start_s);
                    if let Some(last) = intervals.last() {
                        assert!(interval.start_s >= last.end_s, "intervals overlap");
                    }
                    intervals.push(*interval);
                }
                SessionAction::EndTrial { key, end, at_s } => {
                    assert!(!is_driven, "a recording ended while driven");
                    let (begun_key, _, intervals) = open.take().expect("ended twice");
                    assert_eq!(begun_key, *key);
                    assert!(intervals.iter().all(|i| i.end_s <= *at_s));
                    if *end == TrialEnd::Completed {
                        let interval_count = 1 + protocol.exploration.directions.len();
                        assert_eq!(intervals.len(), interval_count);
                    }
                }
                SessionAction::Finished(_) => {
                    assert!(!is_finished && open.is_none());
                    is_finished = true;
                }
                _ => {}
            }
        }
    }
}

pub(super) fn is_phase(event: &SessionEventKind, expected: Phase) -> bool {
    matches!(event, SessionEventKind::Phase { phase } if *phase == expected)
}

pub(super) fn approx_eq(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

pub(super) const RUNNING: [Phase; 11] = [
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

pub(super) fn in_trial(phase: Phase) -> bool {
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

pub(super) fn rig_in(phase: Phase) -> Rig {
    let mut rig = Rig::new(demo()).with_consent();
    if phase == Phase::Paused {
        rig.run_until(Phase::Exploration);
        rig.pause_now();
    } else {
        rig.run_until(phase);
    }
    rig
}
