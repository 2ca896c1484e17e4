//! The preflight's table, as text or JSON.

use std::fmt::Write;

use serde::Serialize;

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Item that was checked.
    pub name: &'static str,
    /// Whether the bench may be used in spite of this row.
    pub passed: bool,
    /// Verdict in one word.
    pub verdict: RowVerdict,
    /// Finding and remedy.
    pub found: String,
}

/// Verdict of a row. Only [`RowVerdict::Failed`] prevents the use of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RowVerdict {
    /// Requirement met.
    Passed,
    /// Worth attention, but no obstacle.
    Warning,
    /// Not required, because `[safety] waived` says so.
    Waived,
    /// The bench must not be used.
    Failed,
}

/// The whole preflight.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    /// Rows in order.
    pub rows: Vec<Row>,
}

impl Table {
    pub(super) fn row(&mut self, name: &'static str, passed: bool, finding: impl Into<String>) {
        let verdict = if passed {
            RowVerdict::Passed
        } else {
            RowVerdict::Failed
        };
        self.verdict_row(name, verdict, finding);
    }

    pub(super) fn verdict_row(
        &mut self,
        name: &'static str,
        verdict: RowVerdict,
        finding: impl Into<String>,
    ) {
        self.rows.push(Row {
            name,
            passed: verdict != RowVerdict::Failed,
            verdict,
            found: finding.into(),
        });
    }

    /// Returns whether no row failed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(|row| row.passed)
    }

    /// Returns the failed row from which the others may follow; `None` if no row failed.
    #[must_use]
    pub fn root_cause(&self) -> Option<&Row> {
        let rank = |row: &&Row| {
            let place = CAUSES.iter().position(|name| *name == row.name);
            place.unwrap_or(CAUSES.len())
        };
        self.rows.iter().filter(|row| !row.passed).min_by_key(rank)
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
                RowVerdict::Passed => "passed",
                RowVerdict::Warning => "warning",
                RowVerdict::Waived => "waived",
                RowVerdict::Failed => "FAILED",
            };
            let _ = writeln!(text, "{verdict:<7} {:<16} {}", row.name, row.found);
        }
        let failed = self.rows.iter().filter(|row| !row.passed).count();
        if let (2.., Some(cause)) = (failed, self.root_cause()) {
            let _ = writeln!(
                text,
                "begin with the row `{}`: the other {} that FAILED may follow from it",
                cause.name,
                failed - 1
            );
        }
        text
    }
}

/// Rows on which others depend, a cause before its consequences.
const CAUSES: [&str; 11] = [
    "limits",
    "hardware",
    "sound card",
    "rate",
    "drop-outs",
    "field box",
    "e-stop",
    "safety",
    "relay",
    "loop delay",
    "carrier",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_is_named_wherever_its_row_stands() {
        let mut table = Table::default();
        table.row("sound card", true, "it is there");
        assert_eq!(table.root_cause(), None);
        table.row("encoder", false, "no counts");
        assert!(!table.to_text().contains("begin with"));
        table.row("carrier", false, "the tone was not played");
        table.row("field box", false, "no answer");
        assert_eq!(table.root_cause().map(|row| row.name), Some("field box"));
        let text = table.to_text();
        assert!(
            text.ends_with("the row `field box`: the other 2 that FAILED may follow from it\n"),
            "{text}"
        );
    }
}
