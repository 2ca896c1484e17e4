//! Steps of a trial: baseline, then ready, countdown, exploration, lift and feedback for each exploration.

use super::action::{Cue, DriveRequest, SessionAction, StepActions};
use super::event::SessionEventKind;
use super::machine::Session;
use super::observation::DeadManAction;
use super::settling::LONGEST_SAVE_S;
use super::state::{AfterHalt, Mean, OpenTrial, State, TrialStep};
use crate::analysis::TrialAnalysis;
use crate::record::{TrialOutcome, TrialRecord};
use crate::trial::{Interruption, Interval, IntervalKind, TrialEnd, TrialKey};

/// Largest lag of the recorder at which a trial may begin, s. It syncs every 0.4 s, and its queue is 10 s long.
const MAX_RECORDER_LAG_S: f64 = 2.0;

/// Time after which the operator is informed that a trial waits for the recorder, s; long enough to leave out the end
/// of a recording that was just interrupted.
const TELL_BEHIND_S: f64 = 0.5;

/// Continuation after a step of a trial.
enum Next {
    /// The same step goes on.
    Stay(TrialStep),
    /// The next step begins.
    Step(TrialStep),
    /// The trial is interrupted.
    TimeOut(Interruption),
    /// All explorations are done.
    Complete,
}

impl Session {
    /// Begins the next attempt if the hour's driving time allows it, the recorder has caught up and the dead-man switch
    /// is held.
    pub(super) fn enter_trial(&mut self, out: &mut StepActions) -> State {
        self.let_go = false;
        if self.drive_wait_s > 0.0 {
            let wait_s = self.drive_wait_s;
            out.log(SessionEventKind::DrivingTimeSpent { wait_s });
            return self.paused_before_trial();
        }
        if self.recorder_lag_s > MAX_RECORDER_LAG_S {
            return State::Behind {
                since_s: self.now_s,
                is_reported: false,
            };
        }
        if self.hold.is_some_and(|hold| hold != DeadManAction::Held) {
            return State::Hold {
                since_s: self.now_s,
            };
        }
        self.begin_trial(out)
    }

    /// Waits for the dead-man switch, with the timeout of the finger.
    pub(super) fn advance_hold(&mut self, since_s: f64, out: &mut StepActions) -> State {
        if self.hold.is_none_or(|hold| hold == DeadManAction::Held) {
            return self.enter_trial(out);
        }
        if self.elapsed_s(since_s) > self.protocol.timeouts.place_finger_s {
            out.log(SessionEventKind::DeadManNotHeld);
            return self.paused_before_trial();
        }
        State::Hold { since_s }
    }

    /// Waits for the recorder, with the timeout of a recording to be saved.
    pub(super) fn advance_behind(
        &mut self,
        since_s: f64,
        mut is_reported: bool,
        out: &mut StepActions,
    ) -> State {
        if self.recorder_lag_s <= MAX_RECORDER_LAG_S {
            return self.enter_trial(out);
        }
        if self.elapsed_s(since_s) > LONGEST_SAVE_S {
            self.recorder_behind(true, out);
            return self.paused_before_trial();
        }
        if !is_reported && self.elapsed_s(since_s) > TELL_BEHIND_S {
            is_reported = true;
            self.recorder_behind(false, out);
        }
        State::Behind {
            since_s,
            is_reported,
        }
    }

    fn recorder_behind(&self, paused: bool, out: &mut StepActions) {
        let lag_s = self.recorder_lag_s;
        out.log(SessionEventKind::RecorderBehind { lag_s, paused });
    }

    pub(super) fn paused_before_trial(&self) -> State {
        State::Halted {
            fault: false,
            sequel: AfterHalt::Trial,
        }
    }

    /// Opens the recording of the next attempt and starts its drive.
    fn begin_trial(&mut self, out: &mut StepActions) -> State {
        let key = self.attempts.next_key();
        let drive = self.attempts.condition().drive;
        self.recording_outcome = None;
        out.push(SessionAction::BeginTrial {
            key: key.clone(),
            drive,
            at_s: self.now_s,
        });
        out.log(SessionEventKind::TrialBegan { key: key.clone() });
        out.push(SessionAction::Drive(DriveRequest::On(drive)));
        State::Trial {
            open: OpenTrial {
                key,
                intervals: Vec::new(),
            },
            step: TrialStep::Baseline { off_since_s: None },
            since_s: self.now_s,
        }
    }

    /// Advances a trial by time, finger and button. `go_on` is the button or the operator's command to continue.
    pub(super) fn advance_trial(
        &mut self,
        mut open: OpenTrial,
        step: TrialStep,
        since_s: f64,
        go_on: bool,
        normal_n: Option<f64>,
        out: &mut StepActions,
    ) -> State {
        match self.next_step(&mut open, step, since_s, go_on, normal_n, out) {
            Next::Stay(step) => State::Trial {
                open,
                step,
                since_s,
            },
            Next::Step(step) => State::Trial {
                open,
                step,
                since_s: self.now_s,
            },
            Next::TimeOut(interruption) => self.time_out(open, interruption, out),
            Next::Complete => self.complete(open, out),
        }
    }

    fn next_step(
        &self,
        open: &mut OpenTrial,
        step: TrialStep,
        since_s: f64,
        go_on: bool,
        normal_n: Option<f64>,
        out: &mut StepActions,
    ) -> Next {
        let timing = self.protocol.timing;
        let timeouts = self.protocol.timeouts;
        let elapsed_s = self.elapsed_s(since_s);
        let is_touching = self.finger == Some(true);
        let is_lifted = self.finger == Some(false);
        match step {
            TrialStep::Baseline { off_since_s } => self.baseline(open, off_since_s, since_s, out),
            TrialStep::Ready { exploration } if is_touching && go_on => {
                Next::Step(TrialStep::Countdown { exploration })
            }
            TrialStep::Ready { .. } if elapsed_s > timeouts.place_finger_s => {
                Next::TimeOut(Interruption::FingerNotPlaced)
            }
            TrialStep::Countdown { exploration } if is_lifted => {
                out.log(SessionEventKind::FingerLiftedEarly);
                Next::Step(TrialStep::Ready { exploration })
            }
            TrialStep::Countdown { exploration } if elapsed_s >= timing.countdown_s => {
                self.cue(Cue::Start, out);
                Next::Step(TrialStep::Exploration {
                    exploration,
                    force: Mean::default(),
                })
            }
            TrialStep::Exploration {
                exploration,
                mut force,
            } => {
                // As in the verdict: of the contact on the plate's central part.
                let is_central = self
                    .slider(exploration)
                    .is_central(elapsed_s, self.protocol.selection.central_m);
                if let (true, true, Some(normal_n)) = (is_touching, is_central, normal_n) {
                    force.push(normal_n);
                }
                self.exploration(open, exploration, force, since_s, out)
            }
            TrialStep::Lift {
                exploration,
                mean_n,
            } if is_lifted => Next::Step(TrialStep::Feedback {
                exploration,
                mean_n,
            }),
            TrialStep::Lift {
                exploration,
                mean_n,
            } if elapsed_s > timeouts.lift_finger_s => {
                out.log(SessionEventKind::FingerNotLifted);
                Next::Step(TrialStep::Feedback {
                    exploration,
                    mean_n,
                })
            }
            TrialStep::Feedback { exploration, .. } if elapsed_s >= timing.feedback_s => {
                let next = exploration + 1;
                if next == self.protocol.exploration.directions.len() {
                    return Next::Complete;
                }
                Next::Step(TrialStep::Ready { exploration: next })
            }
            step => Next::Stay(step),
        }
    }

    /// Waits until the drive has settled and the finger has been off for the length of the baseline.
    fn baseline(
        &self,
        open: &mut OpenTrial,
        off_since_s: Option<f64>,
        since_s: f64,
        out: &mut StepActions,
    ) -> Next {
        let timing = self.protocol.timing;
        let longest_s = timing.settle_s + timing.baseline_s + self.protocol.timeouts.lift_finger_s;
        let settled_s = since_s + timing.settle_s;
        let is_lifted = self.finger == Some(false);
        let off_since_s = is_lifted.then(|| off_since_s.unwrap_or(self.now_s.max(settled_s)));
        match off_since_s {
            Some(start_s) if self.elapsed_s(start_s) >= timing.baseline_s => {
                let end_s = start_s + timing.baseline_s;
                self.mark(open, IntervalKind::Unloaded, start_s, end_s, out);
                Next::Step(TrialStep::Ready { exploration: 0 })
            }
            _ if self.elapsed_s(since_s) > longest_s => {
                Next::TimeOut(Interruption::FingerNotLifted)
            }
            _ => Next::Stay(TrialStep::Baseline { off_since_s }),
        }
    }

    /// Marks the exploration after the slider has stopped.
    fn exploration(
        &self,
        open: &mut OpenTrial,
        exploration: usize,
        force: Mean,
        since_s: f64,
        out: &mut StepActions,
    ) -> Next {
        let duration_s = self.slider(exploration).duration_s();
        if self.elapsed_s(since_s) < duration_s {
            return Next::Stay(TrialStep::Exploration { exploration, force });
        }
        self.cue(Cue::End, out);
        let direction = self.direction(exploration);
        let kind = IntervalKind::Exploration { direction };
        self.mark(open, kind, since_s, since_s + duration_s, out);
        Next::Step(TrialStep::Lift {
            exploration,
            mean_n: force.value(),
        })
    }

    /// Interrupts an attempt: stops the drive, closes the recording, records the attempt.
    pub(super) fn interrupt(
        &mut self,
        open: OpenTrial,
        interruption: Interruption,
        out: &mut StepActions,
    ) {
        let end = TrialEnd::Interrupted {
            interruption: interruption.clone(),
        };
        self.end_trial(&open.key, end, out);
        self.record(
            open.key,
            None,
            TrialOutcome::Interrupted { interruption },
            out,
        );
    }

    /// Records the outcome of an attempt.
    pub(super) fn record(
        &mut self,
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        out: &mut StepActions,
    ) {
        let record = TrialRecord {
            key,
            outcome,
            analysis,
        };
        self.attempts.add(record.clone());
        out.log(SessionEventKind::TrialSettled { record });
    }

    /// Interrupts an attempt and pauses the session.
    fn time_out(
        &mut self,
        open: OpenTrial,
        interruption: Interruption,
        out: &mut StepActions,
    ) -> State {
        self.interrupt(open, interruption, out);
        self.is_pause_due = false;
        self.paused_before_trial()
    }

    fn complete(&mut self, open: OpenTrial, out: &mut StepActions) -> State {
        self.end_trial(&open.key, TrialEnd::Completed, out);
        out.push(SessionAction::AnalyseTrial {
            key: open.key.clone(),
            intervals: open.intervals,
        });
        self.analysis_key = Some(open.key.clone());
        State::Analysing {
            key: open.key,
            since_s: self.now_s,
        }
    }

    fn end_trial(&self, key: &TrialKey, end: TrialEnd, out: &mut StepActions) {
        out.push(SessionAction::Drive(DriveRequest::Off));
        out.push(SessionAction::EndTrial {
            key: key.clone(),
            end,
            at_s: self.now_s,
        });
    }

    fn mark(
        &self,
        open: &mut OpenTrial,
        kind: IntervalKind,
        start_s: f64,
        end_s: f64,
        out: &mut StepActions,
    ) {
        // `start + (now − start)` may round to just after now, where the recording ends.
        let interval = Interval {
            kind,
            start_s,
            end_s: end_s.min(self.now_s),
        };
        open.intervals.push(interval);
        out.push(SessionAction::Mark(interval));
        out.log(SessionEventKind::Marked { interval });
    }

    fn cue(&self, cue: Cue, out: &mut StepActions) {
        if self.protocol.exploration.cues {
            out.push(SessionAction::Cue(cue));
        }
    }
}
