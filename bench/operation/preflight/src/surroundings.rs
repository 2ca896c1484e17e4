//! Surroundings of a session: the computer's date and disk space, and the terminal's size for a dashboard.

use std::path::Path;

use jiff::Timestamp;

use crate::table::{RowVerdict, Table};
use recording::study::free_bytes;

/// Judges the date of the computer's clock.
pub(super) fn judge_date(table: &mut Table, now: Timestamp) {
    let complaint = calendar::complaint(now);
    let finding = || now.strftime("%Y-%m-%d").to_string();
    table.row(
        "date",
        complaint.is_none(),
        complaint.unwrap_or_else(finding),
    );
}

/// Judges the free space on the disk of `study`.
pub(super) fn judge_disk(table: &mut Table, study: &Path, session_bytes: u64) {
    let gigabytes = |bytes: u64| bytes as f64 * 1e-9;
    // The first session creates the study's folder; until then its nearest existing parent is judged.
    let existing = study
        .ancestors()
        .map(|folder| {
            if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            }
        })
        .find(|folder| folder.is_dir())
        .unwrap_or(study);
    match free_bytes(existing) {
        Ok(free) => {
            let enough = free >= session_bytes;
            let remedy = if enough {
                ""
            } else {
                ": make room, or choose another folder with --study"
            };
            let finding = format!(
                "{:.1} GB free at {}, {:.1} GB for a session{remedy}",
                gigabytes(free),
                existing.display(),
                gigabytes(session_bytes),
            );
            table.row("disk", enough, finding);
        }
        Err(error) => table.row("disk", false, error.to_string()),
    }
}

/// Warns of a terminal too small for the dashboard. A window can be enlarged at any time, so this never fails.
pub(super) fn judge_terminal(table: &mut Table, size: Option<(u16, u16)>) {
    let (columns, rows) = tui::TWO_COLUMNS;
    let (verdict, finding) = match size {
        // Containers and `script` open terminals without a size.
        None | Some((0, _) | (_, 0)) => (
            RowVerdict::Warning,
            "its size is unknown: run with --headless if no dashboard appears".to_owned(),
        ),
        Some((width, height)) if width >= columns && height >= rows => {
            (RowVerdict::Passed, format!("{width} × {height}"))
        }
        Some((width, height)) => (
            RowVerdict::Warning,
            format!(
                "{width} × {height}: the whole dashboard needs {columns} × {rows}; enlarge the window before `run`"
            ),
        ),
    };
    table.verdict_row("terminal", verdict, finding);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_study_is_judged_by_its_parent_folder() {
        let folder = tempfile::tempdir().unwrap();
        for (bytes, enough) in [(1, true), (u64::MAX, false)] {
            let mut table = Table::default();
            judge_disk(&mut table, &folder.path().join("not/yet"), bytes);
            assert_eq!(table.rows[0].passed, enough, "{:?}", table.rows[0]);
            assert!(table.rows[0].found.contains("GB free"));
        }
    }

    #[test]
    fn a_clock_that_was_never_set_fails() {
        for (second, passed, finding) in [
            (0, false, "1970-01-01: set it"),
            (1_780_000_000, true, "2026-05-28"),
        ] {
            let mut table = Table::default();
            judge_date(&mut table, Timestamp::from_second(second).unwrap());
            assert_eq!(table.rows[0].passed, passed, "{:?}", table.rows[0]);
            assert!(table.rows[0].found.contains(finding));
        }
    }

    #[test]
    fn a_small_terminal_is_a_warning_and_never_a_failure() {
        for (size, verdict) in [
            (None, RowVerdict::Warning),
            (Some((0, 0)), RowVerdict::Warning),
            (Some((80, 24)), RowVerdict::Passed),
            (Some((60, 24)), RowVerdict::Warning),
            (Some((80, 12)), RowVerdict::Warning),
        ] {
            let mut table = Table::default();
            judge_terminal(&mut table, size);
            assert_eq!(table.rows[0].verdict, verdict, "{size:?}");
            assert!(table.passed(), "{size:?}");
        }
    }
}
