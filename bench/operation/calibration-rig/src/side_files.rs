//! Files that a calibration writes next to the calibration file, whether it passes or ends early.

use std::path::{Path, PathBuf};

use anyhow::Context;
use plotting::Figure;

use crate::broken_off::EndedEarly;

/// Writes the points of `part`, and their figure if given, next to the calibration at `path`.
///
/// # Errors
/// If a file cannot be written.
pub fn write_files(
    path: &Path,
    part: &str,
    points: &str,
    figure: Option<&Figure>,
) -> anyhow::Result<Vec<PathBuf>> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let figure_path = path.with_file_name(format!("{stem}-{part}"));
    let table = path.with_file_name(format!("{stem}-{part}.csv"));
    std::fs::write(&table, points).with_context(|| format!("cannot write {}", table.display()))?;
    let mut written = vec![table];
    if let Some(figure) = figure {
        written.extend(plotting::write_figure(figure, &figure_path)?);
    }
    Ok(written)
}

/// Returns the suffix of the names of a calibration's files. It tells a rehearsal and a calibration that failed apart, so that neither
/// replaces the points of the calibration in force.
#[must_use]
pub fn file_stem(stem: &str, is_rehearsal: bool, is_failed: bool) -> String {
    let rehearsal = if is_rehearsal { "rehearsal-" } else { "" };
    let failed = if is_failed { "-failed" } else { "" };
    format!("{rehearsal}{stem}{failed}")
}

/// Returns the error of a calibration that ended early, with advice on how to continue; the points of an unattended calibration
/// are written to the table `part` next to the calibration at `path`.
#[must_use]
pub fn ended_early(error: anyhow::Error, path: &Path, part: &str) -> anyhow::Error {
    let Some(early) = error.downcast_ref::<EndedEarly>() else {
        return error;
    };
    let summary = match early.points.len() {
        0 => "nothing was measured yet".to_owned(),
        points => match early
            .table()
            .and_then(|table| write_files(path, part, &table, None))
        {
            Ok(written) => format!("points so far: {points}, saved in {}", written[0].display()),
            Err(why) => format!(
                "points so far: {points}, lost: {}",
                bounded_files::cause_line(why.as_ref())
            ),
        },
    };
    anyhow::anyhow!(
        "{early}; {summary}; nothing was put in force. Remove the cause and run the command again; unattended, it \
         measures from the beginning; on a terminal you can re-arm and continue from the stop"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::PointRead;

    fn ended_message(points: usize, path: &Path) -> String {
        let early = EndedEarly {
            why: anyhow::anyhow!("the safety watch stopped the calibration: it was pressed"),
            points: vec![PointRead::default(); points],
        };
        let error = anyhow::Error::from(early).context("the part `calibration`");
        ended_early(error, path, "pickup-unfinished").to_string()
    }

    #[test]
    fn only_a_calibration_in_force_has_the_plain_names() {
        let stem = |is_rehearsal, is_failed| file_stem("force", is_rehearsal, is_failed);
        assert_eq!(stem(false, false), "force");
        assert_eq!(stem(false, true), "force-failed");
        assert_eq!(stem(true, false), "rehearsal-force");
        assert_eq!(stem(true, true), "rehearsal-force-failed");
    }

    #[test]
    fn points_of_a_calibration_that_ended_early_are_kept_with_advice() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("mine.toml");
        let table = temp.path().join("mine-pickup-unfinished.csv");
        let message = ended_message(0, &path);
        assert!(
            message.contains("nothing was measured yet") && !table.exists(),
            "{message}"
        );
        let message = ended_message(2, &path);
        let summary = format!("points so far: 2, saved in {}", table.display());
        let phrases = ["it was pressed", &summary, "run the command again"];
        assert!(
            phrases.iter().all(|words| message.contains(words)),
            "{message}"
        );
        assert_eq!(std::fs::read_to_string(&table).unwrap().lines().count(), 3);
        let message = ended_message(2, &temp.path().join("gone/mine.toml"));
        assert!(message.contains("points so far: 2, lost"), "{message}");
        let unrelated = ended_early(anyhow::anyhow!("no card"), &path, "pickup-unfinished");
        assert_eq!(unrelated.to_string(), "no card");
    }
}
