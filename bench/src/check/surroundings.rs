//! What the computer has for a session: room on the disk, and on the screen.

use std::path::Path;

use super::table::Table;
use recording::study::free_bytes;

pub(super) fn judge(table: &mut Table, study: &Path, session_bytes: u64) {
    let gigabytes = |bytes: u64| bytes as f64 * 1e-9;
    // A study is made by its first session: until then the folder that will hold it tells.
    let there = study
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
    match free_bytes(there) {
        Ok(free) => {
            let enough = free >= session_bytes;
            let remedy = if enough {
                ""
            } else {
                ": make room, or choose another folder with --study"
            };
            let found = format!(
                "{:.1} GB free at {}, {:.1} GB for a session{remedy}",
                gigabytes(free),
                there.display(),
                gigabytes(session_bytes),
            );
            table.row("disk", enough, found);
        }
        Err(error) => table.row("disk", false, error.to_string()),
    }
    judge_terminal(table, tui::shell::size());
}

fn judge_terminal(table: &mut Table, size: Option<(u16, u16)>) {
    let (columns, rows) = tui::TWO_COLUMNS;
    match size {
        None => table.row("terminal", true, "none: run with --headless"),
        Some((width, height)) => {
            let enough = width >= columns && height >= rows;
            let remedy = if enough {
                String::new()
            } else {
                format!(": the whole dashboard needs {columns} × {rows}; enlarge the window")
            };
            table.row("terminal", enough, format!("{width} × {height}{remedy}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_that_is_not_there_yet_is_judged_by_the_folder_that_will_hold_it() {
        let folder = tempfile::tempdir().unwrap();
        for (bytes, enough) in [(1, true), (u64::MAX, false)] {
            let mut table = Table::default();
            judge(&mut table, &folder.path().join("not/yet"), bytes);
            assert_eq!(table.rows[0].passed, enough, "{:?}", table.rows[0]);
            assert!(table.rows[0].found.contains("GB free"));
        }
    }

    #[test]
    fn a_small_terminal_is_named_and_none_is_no_fault() {
        for (size, passed) in [
            (None, true),
            (Some((80, 24)), true),
            (Some((60, 24)), false),
            (Some((80, 12)), false),
        ] {
            let mut table = Table::default();
            judge_terminal(&mut table, size);
            assert_eq!(table.rows[0].passed, passed, "{size:?}");
        }
    }
}
