//! Report of a calibration, and the files that it writes next to the calibration file.

use std::path::{Path, PathBuf};

use crate::outcome::probe_folder;

use anyhow::Context;
use config::Quantity;
use serde::Serialize;

/// Result of a calibration, for people and for scripts.
#[derive(Debug, Serialize)]
pub struct CalibrationReport {
    /// Name of the calibration.
    pub calibrated: &'static str,
    /// Whether the calibration passed and was written.
    pub passed: bool,
    /// Values by name.
    pub values: Vec<(&'static str, Quantity)>,
    /// Further results, a line each.
    pub remarks: Vec<String>,
    /// Reasons for not passing.
    pub faults: Vec<String>,
    /// Files that were written.
    pub written: Vec<PathBuf>,
}

impl CalibrationReport {
    /// Returns the report for a person.
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

    /// Returns the report as JSON.
    ///
    /// # Errors
    /// Never for measured values.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Checks that the result can be written before a measurement that takes minutes.
pub(crate) fn require_writable(path: &Path) -> anyhow::Result<()> {
    probe_folder(path).with_context(|| {
        format!(
            "cannot write into {}: name a calibration file in a folder of yours with --calibration",
            path.parent().unwrap_or(path).display()
        )
    })
}
