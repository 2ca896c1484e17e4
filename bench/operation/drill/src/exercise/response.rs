//! The operator's part of an exercise: each key moves the exercise to its next stage, or is answered by a remark.

use faults::Remedy;
use tui::Action;

use super::{Exercise, Order, Stage};

const NOTHING_YET: &str = "Nothing has happened yet.";
const STOPPED_ALREADY: &str = "The drive is stopped already.";
const WRONG_KEY: &str = "This key does not help here.";

impl Exercise {
    /// Takes an action of the operator; returns the order to the bench.
    pub fn act(&mut self, action: Action, now_s: f64) -> Option<Order> {
        self.note = None;
        match (&self.stage, action) {
            (Stage::Settling { sounding_s, .. }, action) => {
                let sounding_s = *sounding_s;
                self.steer(action, sounding_s)
            }
            (Stage::Asked | Stage::Resuming { .. }, Action::EmergencyStop) => Some(Order::Stop),
            (Stage::Asked | Stage::Begun, _) => self.remark(NOTHING_YET),
            (Stage::Noticed, action) => self.acknowledge(action, now_s),
            (Stage::Acknowledged { .. }, action) => self.mend(action, now_s),
            (Stage::Rearmed, Action::Resume) => {
                self.enter(Stage::Resuming { sounding_s: None }, now_s);
                Some(Order::Drive)
            }
            (Stage::Rearmed, Action::EmergencyStop) => self.remark(STOPPED_ALREADY),
            (Stage::Rearmed, _) => self.remark(WRONG_KEY),
            (Stage::Resuming { .. } | Stage::Over(_), _) => None,
        }
    }

    /// Pauses, stops or resumes the drive before the fault.
    fn steer(&mut self, action: Action, sounding_s: Option<f64>) -> Option<Order> {
        let (paused, note, order) = match action {
            Action::EmergencyStop => (
                true,
                Some("You stopped the drive: re-arm with x."),
                Order::Stop,
            ),
            Action::Pause => (true, Some("Paused: resume with p."), Order::Pause),
            Action::Rearm => (true, Some("Re-armed: resume with p."), Order::Rearm),
            Action::Resume => (false, None, Order::Drive),
            _ => return self.remark(NOTHING_YET),
        };
        self.stage = Stage::Settling { sounding_s, paused };
        self.note = note;
        Some(order)
    }

    /// Takes the operator's first response to the fault: any key that acknowledges it.
    fn acknowledge(&mut self, action: Action, now_s: f64) -> Option<Order> {
        self.times.seen_s = self.since_fault_s(now_s);
        self.enter(Stage::Acknowledged { rearming_s: None }, now_s);
        match (self.fault.row().remedy, action) {
            (Remedy::Repeat, Action::Redo(_)) | (Remedy::Restart(_), Action::Quit) => {
                self.mend(action, now_s)
            }
            (Remedy::Rearm(_), Action::Rearm) if self.is_manual => self.mend(action, now_s),
            (Remedy::Rearm(_), Action::Rearm) => {
                self.note = Some("The cause was still there; it is removed now.");
                Some(Order::End)
            }
            (Remedy::Rearm(_), _) => (!self.is_manual).then_some(Order::End),
            _ => None,
        }
    }

    /// Takes a step of the remedy of an acknowledged fault.
    fn mend(&mut self, action: Action, now_s: f64) -> Option<Order> {
        match (self.fault.row().remedy, action) {
            (Remedy::Rearm(_), Action::Rearm) => {
                let rearming_s = Some(now_s);
                self.stage = Stage::Acknowledged { rearming_s };
                Some(Order::Rearm)
            }
            (Remedy::Repeat, Action::Redo(_)) | (Remedy::Restart(_), Action::Quit) => {
                self.complete(now_s);
                None
            }
            (_, Action::EmergencyStop) => self.remark(STOPPED_ALREADY),
            _ => self.remark(WRONG_KEY),
        }
    }

    /// Answers a key by a remark alone.
    fn remark(&mut self, note: &'static str) -> Option<Order> {
        self.note = Some(note);
        None
    }
}
