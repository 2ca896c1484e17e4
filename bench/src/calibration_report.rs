//! What a calibration says, and the files that it leaves beside the calibration file.

use std::path::{Path, PathBuf};

use crate::outcome::probe_folder_of;

use anyhow::Context;
use config::Quantity;
use serde::Serialize;

/// What was measured, for a person and for scripts.
#[derive(Debug, Serialize)]
pub struct Report {
    /// What was calibrated.
    pub calibrated: &'static str,
    /// Whether it holds and was written.
    pub passed: bool,
    /// The values, by name.
    pub values: Vec<(&'static str, Quantity)>,
    /// Further figures, a line each.
    pub remarks: Vec<String>,
    /// Why it does not pass.
    pub faults: Vec<String>,
    /// Files that were written.
    pub written: Vec<PathBuf>,
}

impl Report {
    /// For a person.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut lines = vec![format!("calibrate {}", self.calibrated)];
        for (name, quantity) in &self.values {
            lines.push(format!("  {name:<16} {quantity}  (95 %)"));
        }
        lines.extend(self.remarks.iter().map(|remark| format!("  {remark}")));
        lines.extend(self.faults.iter().map(|fault| format!("FAILED  {fault}")));
        let verdict = if self.passed {
            "passed"
        } else {
            "FAILED  nothing was put in force"
        };
        lines.push(verdict.to_owned());
        lines.extend(
            self.written
                .iter()
                .map(|path| format!("wrote {}", path.display())),
        );
        lines.join("\n") + "\n"
    }

    /// As JSON.
    ///
    /// # Errors
    /// Never for what was measured.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// What takes minutes to measure must have a place to go to.
pub(crate) fn require_writable(path: &Path) -> anyhow::Result<()> {
    probe_folder_of(path).with_context(|| {
        format!(
            "cannot write into {}: name a calibration file in a folder of yours with --calibration",
            path.parent().unwrap_or(path).display()
        )
    })
}
