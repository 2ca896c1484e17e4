//! The preflight's table: for a person, and as JSON.

use std::fmt::Write;

use serde::Serialize;

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What was looked at.
    pub name: &'static str,
    /// Whether it is as it must be.
    pub passed: bool,
    /// What was found, and what to do when it failed.
    pub found: String,
}

/// The whole preflight.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    /// Its lines in order.
    pub rows: Vec<Row>,
}

impl Table {
    pub(super) fn row(&mut self, name: &'static str, passed: bool, found: impl Into<String>) {
        self.rows.push(Row {
            name,
            passed,
            found: found.into(),
        });
    }

    /// Nothing failed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(|row| row.passed)
    }

    /// As JSON.
    ///
    /// # Errors
    /// Never for a table.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(&self)? + "\n")
    }

    /// For a person.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let verdict = if row.passed { "passed" } else { "FAILED" };
            let _ = writeln!(text, "{verdict}  {:<16} {}", row.name, row.found);
        }
        text
    }
}
