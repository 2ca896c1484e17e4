//! Instructions to the operator.

use faults::{Remedy, Required};
use tui::drill_view::DrillStep;

use super::{Exercise, Stage};
use crate::times::ExerciseOutcome;

impl Exercise {
    /// Whether the operator is shown a paused bench.
    pub fn is_paused(&self) -> bool {
        matches!(
            self.stage,
            Stage::Rearmed | Stage::Settling { paused: true, .. }
        )
    }

    /// Whether the bench is re-armed and waits for the operator to resume.
    pub fn is_rearmed(&self) -> bool {
        matches!(self.stage, Stage::Rearmed)
    }

    /// Returns the step requested of the operator.
    pub fn current_step(&self) -> DrillStep {
        match (&self.stage, self.fault.row().remedy) {
            (Stage::Asked, _) => DrillStep::Act,
            (Stage::Noticed, _) => DrillStep::Acknowledge,
            (Stage::Acknowledged { .. }, Remedy::Rearm(_)) => DrillStep::Rearm,
            (Stage::Acknowledged { .. }, Remedy::Repeat) => DrillStep::Repeat,
            (Stage::Acknowledged { .. }, Remedy::Restart(_)) => DrillStep::Quit,
            (Stage::Rearmed, _) => DrillStep::Resume,
            _ => DrillStep::Watch,
        }
    }

    /// Returns the instruction to the operator.
    pub fn instruction(&self) -> String {
        let row = self.fault.row();
        match (&self.stage, row.remedy) {
            (Stage::Settling { .. } | Stage::Begun, _) if self.is_manual => {
                "The faint tone sounds. Nothing is to be done yet.".to_owned()
            }
            (Stage::Settling { .. } | Stage::Begun, _) => {
                "Watch the bench: a fault will come.".to_owned()
            }
            (Stage::Asked, _) => row.real.map_or("", |real| real.words).to_owned(),
            (Stage::Noticed, _) if row.required == Required::Flag => {
                format!("Flagged: {}. Space when you have seen it.", self.sign)
            }
            (Stage::Noticed, _) => {
                format!("Stopped: {}. Space when you have seen it.", self.sign)
            }
            (Stage::Acknowledged { .. }, Remedy::Rearm(removed)) if self.is_manual => {
                format!("{removed} Then re-arm: x, y.")
            }
            (Stage::Acknowledged { .. }, Remedy::Rearm(_)) => {
                format!("Re-arm: x, y. The cause is removed; it was: {}.", row.words)
            }
            (Stage::Acknowledged { .. }, Remedy::Repeat) => {
                format!("Repeat the trial: r, y. It was: {}.", row.words)
            }
            (Stage::Acknowledged { .. }, Remedy::Restart(mended)) => format!(
                "End the program: q, y; nothing can be re-armed. It was: {}. {mended} A session is resumed with \
                 --resume.",
                row.words
            ),
            (Stage::Rearmed, _) => "Resume: p.".to_owned(),
            (Stage::Resuming { .. }, _) => "The drive resumes.".to_owned(),
            (Stage::Over(ExerciseOutcome::Met), _) => "Met.".to_owned(),
            (Stage::Over(ExerciseOutcome::Missed(reason)), _) => format!("Missed: {reason}."),
        }
    }
}
