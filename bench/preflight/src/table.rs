//! The preflight's table: for a person, and as JSON.

use std::fmt::Write;

use serde::Serialize;

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What was looked at.
    pub name: &'static str,
    /// Whether the bench may be used in spite of this row.
    pub passed: bool,
    /// The judgement in one word.
    pub verdict: Verdict,
    /// What was found, and what to do about it.
    pub found: String,
}

/// Judgement of a row. Only [`Verdict::Failed`] keeps the bench from being used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As it must be.
    Passed,
    /// Worth a look, no obstacle.
    Warning,
    /// Not required, because `[safety] waived` says so.
    Waived,
    /// The bench must not be used.
    Failed,
}

/// The whole preflight.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    /// Its lines in order.
    pub rows: Vec<Row>,
}

impl Table {
    pub(super) fn row(&mut self, name: &'static str, passed: bool, found: impl Into<String>) {
        let verdict = if passed {
            Verdict::Passed
        } else {
            Verdict::Failed
        };
        self.judged(name, verdict, found);
    }

    pub(super) fn judged(
        &mut self,
        name: &'static str,
        verdict: Verdict,
        found: impl Into<String>,
    ) {
        self.rows.push(Row {
            name,
            passed: verdict != Verdict::Failed,
            verdict,
            found: found.into(),
        });
    }

    /// Returns whether no row failed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(|row| row.passed)
    }

    /// Returns the table as JSON.
    ///
    /// # Errors
    /// Never for a table.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(&self)? + "\n")
    }

    /// Returns the table as text, a line for each row.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let verdict = match row.verdict {
                Verdict::Passed => "passed",
                Verdict::Warning => "warning",
                Verdict::Waived => "waived",
                Verdict::Failed => "FAILED",
            };
            let _ = writeln!(text, "{verdict:<7} {:<16} {}", row.name, row.found);
        }
        text
    }
}
