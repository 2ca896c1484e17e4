//! Record of a drill: `drill.toml` in a new folder.

use std::path::{Path, PathBuf};

use anyhow::Context;
use faults::{FaultKind, Required};
use jiff::Timestamp;
use recording::disk::replace_file;
use serde::{Deserialize, Serialize};

use crate::exercise::Exercise;
use crate::times::{ExerciseOutcome, Times};

/// Version of `drill.toml`.
const FORMAT: u32 = 1;
/// Name of the file.
const FILE: &str = "drill.toml";
/// Largest number of drills that begin within the same second.
const SAME_SECOND: u32 = 1000;

/// Record of a drill.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrillRecord {
    /// Version of the format.
    pub format: u32,
    /// Time of the beginning.
    pub began: Timestamp,
    /// Name of the operator.
    pub operator: String,
    /// Whether a script acted as operator.
    pub unattended: bool,
    /// Whether the hardware was simulated.
    pub simulated: bool,
    /// Seed of the order and the times.
    pub seed: u64,
    /// Program and version.
    pub software: String,
    /// Whether every exercise was met; false until the last one has ended.
    pub passed: bool,
    /// Number of exercises planned.
    pub planned: usize,
    /// Finished exercises.
    #[serde(default)]
    pub exercises: Vec<ExerciseRecord>,
}

/// Record of an exercise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExerciseRecord {
    /// The fault.
    pub fault: FaultKind,
    /// Row of the fault in FAULTS.md.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub row: Option<u8>,
    /// `stop` or `flag`.
    pub required: String,
    /// Longest time allowed until the drive is silent, or until the flag, s.
    pub within_s: f64,
    /// Whether it was met.
    pub met: bool,
    /// Reason why it was missed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missed: Option<String>,
    /// Stop or flag by which the bench showed the fault.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub shown: String,
    /// Times of the exercise.
    pub times: Times,
}

impl ExerciseRecord {
    /// Returns the record of an exercise; one that has not ended counts as left.
    pub(crate) fn from_exercise(exercise: &Exercise) -> Self {
        let fault = exercise.fault();
        let row = fault.row();
        let missed = match exercise.outcome() {
            Some(ExerciseOutcome::Met) => None,
            Some(ExerciseOutcome::Missed(reason)) => Some(reason.clone()),
            None => Some("left".to_owned()),
        };
        Self {
            fault,
            row: row.row,
            required: match row.required {
                Required::Flag => "flag",
                _ => "stop",
            }
            .to_owned(),
            within_s: exercise.within_s(),
            met: missed.is_none(),
            missed,
            shown: exercise.sign().to_owned(),
            times: exercise.times(),
        }
    }

    /// Returns the exercise and its result as a line of the log.
    #[must_use]
    pub fn log_line(&self) -> String {
        let verdict = if self.met { "met" } else { "MISSED" };
        format!("{}: {verdict}: {}", self.fault, self.words())
    }

    /// Returns the times, preceded by the reason if the exercise was missed.
    #[must_use]
    pub fn words(&self) -> String {
        let times = self.times.words();
        match &self.missed {
            None => times,
            Some(reason) if times.is_empty() => reason.clone(),
            Some(reason) => format!("{reason}; {times}"),
        }
    }
}

impl DrillRecord {
    /// Begins the record of a drill with this number of planned exercises.
    #[must_use]
    pub fn new(
        began: Timestamp,
        operator: &str,
        simulated: bool,
        seed: u64,
        planned: usize,
    ) -> Self {
        Self {
            format: FORMAT,
            began,
            operator: operator.to_owned(),
            unattended: false,
            simulated,
            seed,
            software: format!("friction-bench {}", env!("CARGO_PKG_VERSION")),
            passed: false,
            planned,
            exercises: Vec::new(),
        }
    }

    /// Adds a finished exercise.
    pub(crate) fn add(&mut self, exercise: &Exercise) {
        self.exercises.push(ExerciseRecord::from_exercise(exercise));
        let met_count = self
            .exercises
            .iter()
            .filter(|exercise| exercise.met)
            .count();
        self.passed = met_count == self.planned;
    }

    /// Returns the lines of the summary.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self
            .exercises
            .iter()
            .map(|exercise| {
                let verdict = if exercise.met { "met   " } else { "MISSED" };
                let row = exercise
                    .row
                    .map(|row| format!("row {row}"))
                    .unwrap_or_default();
                let name = exercise.fault.name();
                format!("{verdict}  {name:<18}  {row:<6}  {}", exercise.words())
            })
            .collect();
        let met_count = self
            .exercises
            .iter()
            .filter(|exercise| exercise.met)
            .count();
        let untried = self.planned - self.exercises.len();
        let remainder = match untried {
            0 => String::new(),
            _ => format!(", {untried} not tried"),
        };
        let missed = self.exercises.len() - met_count;
        lines.push(format!(
            "{met_count} of {} met, {missed} missed{remainder}",
            self.planned
        ));
        lines
    }
}

/// The folder of one drill.
#[derive(Debug)]
pub struct DrillFolder(PathBuf);

impl DrillFolder {
    /// Creates the folder of a drill that begins now, in `parent`; an existing folder is never used.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn create(parent: &Path, began: Timestamp) -> anyhow::Result<Self> {
        let cannot = |path: &Path| format!("cannot create {}", path.display());
        std::fs::create_dir_all(parent).with_context(|| cannot(parent))?;
        let name = calendar::folder_name(began);
        for number in 1..=SAME_SECOND {
            let path = match number {
                1 => parent.join(&name),
                _ => parent.join(format!("{name}-{number}")),
            };
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error).with_context(|| cannot(&path)),
            }
        }
        anyhow::bail!(
            "{} has {SAME_SECOND} drills of one second",
            parent.display()
        )
    }

    /// Returns the path of `drill.toml`.
    #[must_use]
    pub fn file(&self) -> PathBuf {
        self.0.join(FILE)
    }

    /// Writes the record, replacing an earlier one.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, record: &DrillRecord) -> anyhow::Result<()> {
        let text = toml::to_string(record).context("the record of the drill")?;
        Ok(replace_file(&self.file(), text.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> DrillRecord {
        let began = "2026-05-04T12:00:00Z".parse().unwrap();
        let mut record = DrillRecord::new(began, "A. Tester", true, 7, 3);
        let exercise = |fault, missed: Option<&str>| ExerciseRecord {
            fault,
            row: Some(17),
            required: "stop".to_owned(),
            within_s: 0.05,
            met: missed.is_none(),
            missed: missed.map(str::to_owned),
            shown: "e-stop pressed or its wire cut".to_owned(),
            times: Times {
                shown_s: Some(0.002),
                silent_s: Some(0.004),
                seen_s: Some(1.5),
                ..Times::default()
            },
        };
        record.exercises = vec![
            exercise(FaultKind::Estop, None),
            exercise(FaultKind::EstopCut, Some("nobody resumed")),
        ];
        record
    }

    #[test]
    fn a_drill_is_read_as_it_was_written_and_none_is_overwritten() {
        let temp = tempfile::tempdir().unwrap();
        let parent = temp.path().join("drills");
        let record = record();
        let folders: Vec<_> = (0..3)
            .map(|_| DrillFolder::create(&parent, record.began).unwrap())
            .collect();
        for folder in &folders {
            folder.write(&record).unwrap();
            let text = std::fs::read_to_string(folder.file()).unwrap();
            assert_eq!(toml::from_str::<DrillRecord>(&text).unwrap(), record);
        }
        let name = calendar::folder_name(record.began);
        assert!(folders[0].file().ends_with(format!("{name}/drill.toml")));
        assert!(folders[2].file().ends_with(format!("{name}-3/drill.toml")));
    }

    #[test]
    fn the_summary_names_met_missed_and_untried_exercises() {
        let lines = record().lines();
        assert_eq!(
            lines,
            [
                "met     estop               row 17  shown 2 ms, silent 4 ms, seen 1.5 s",
                "MISSED  estop-cut           row 17  nobody resumed; shown 2 ms, silent 4 ms, seen 1.5 s",
                "1 of 3 met, 1 missed, 1 not tried",
            ]
        );
    }
}
