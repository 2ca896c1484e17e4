//! The demonstration from start to end.

use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use escaping::quoted;

use crate::error::DemoError;
use crate::signals::Signals;
use crate::steps::{further_session, steps};
use crate::{folder, process};

/// Options of `demo`.
#[derive(Debug, Args)]
pub struct DemoOptions {
    /// Folder to create; if it exists, a numbered one is created instead, such as demo-2.
    #[arg(value_name = "FOLDER", default_value = "demo")]
    pub folder: PathBuf,
}

/// End of a demonstration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DemoEnd {
    /// All steps succeeded.
    Completed,
    /// A step failed and has reported the reason; its exit status.
    Failed(u8),
}

/// Exit status of a failed step that reports none.
const NO_STATUS: u8 = 2;
/// Offset added to the number of a signal that ended a program, as in shells.
const SIGNALLED: i32 = 128;

/// Runs all steps, each as a process of `program`, with the arguments `more` added. The last line names the program as
/// `called`. Titles and closing lines go to `out`, in bold if `bold`.
///
/// # Errors
/// [`DemoError`].
pub fn run(
    options: &DemoOptions,
    (program, called): (&Path, &Path),
    more: &[&str],
    mut out: impl Write,
    bold: bool,
) -> Result<DemoEnd, DemoError> {
    let folder = folder::make(&options.folder)?;
    let calibration = folder.join("calibration");
    fs::create_dir(&calibration).map_err(|source| DemoError::Folder {
        folder: calibration,
        source,
    })?;
    let mut signals = Signals::handle()?;
    for mut each in steps(&folder) {
        each.words.extend(more.iter().map(OsString::from));
        title(&mut out, each.title, bold)?;
        let status = process::run(&each, program, &mut signals).map_err(|source| {
            let program = program.to_owned();
            DemoError::Program { program, source }
        })?;
        if let Some(signal) = signals.came() {
            return Ok(DemoEnd::Failed(byte(SIGNALLED + signal)));
        }
        if !status.success() {
            return Ok(DemoEnd::Failed(status.code().map_or(NO_STATUS, byte)));
        }
    }
    title(&mut out, "Results", bold)?;
    for (name, holds) in RESULTS {
        let path = folder.join(name).display().to_string();
        let width = folder.display().to_string().chars().count() + 13;
        writeln!(out, "  {path:width$} {holds}")?;
    }
    let words = further_session(&folder);
    // An option is a word already.
    let words = words.iter().map(|word| match word.to_str() {
        Some(option) if option.starts_with('-') => option.to_owned(),
        _ => quoted(Path::new(word)),
    });
    writeln!(
        out,
        "\nA session of another participant at the same bench, with the dashboard and in real time:\n  {} {}",
        quoted(called),
        words.collect::<Vec<_>>().join(" ")
    )?;
    Ok(DemoEnd::Completed)
}

/// Files of the results with their descriptions.
const RESULTS: [(&str, &str); 4] = [
    ("calibration", "the calibration and its figures"),
    ("study", "the recordings and the session's log"),
    (
        "results.json",
        "the estimates of every instance by all three methods",
    ),
    ("figures", "the published figures from these data"),
];

fn title(out: &mut impl Write, title: &str, bold: bool) -> std::io::Result<()> {
    if bold {
        writeln!(out, "\n\x1b[1m{title}\x1b[0m")?;
    } else {
        writeln!(out, "\n{title}")?;
    }
    out.flush()
}

fn byte(status: i32) -> u8 {
    u8::try_from(status).unwrap_or(NO_STATUS)
}

#[cfg(all(test, unix))]
mod tests {
    #![expect(
        clippy::unwrap_used,
        reason = "what cannot be unwrapped fails the test"
    )]

    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// Runs a demonstration with a script as the program; returns its end, its output, and the file that the script wrote.
    fn demonstrated(script: &str) -> (Result<DemoEnd, DemoError>, String, String) {
        let room = tempfile::tempdir().unwrap();
        let program = room.path().join("program");
        fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let options = DemoOptions {
            folder: room.path().join("a demo"),
        };
        let mut shown = Vec::new();
        let programs = (program.as_path(), Path::new("friction-bench"));
        let ended = run(&options, programs, &["--quiet"], &mut shown, false);
        let kept = fs::read_to_string(options.folder.join("kept")).unwrap_or_default();
        (ended, String::from_utf8(shown).unwrap(), kept)
    }

    #[test]
    fn every_step_is_run_and_shown_in_turn() {
        let (ended, shown, kept) = demonstrated(r#"echo "$@" >>"$(dirname "$0")/a demo/kept""#);
        assert_eq!(ended.unwrap(), DemoEnd::Completed, "{shown}");
        let commands: Vec<&str> = kept.lines().collect();
        let titles: Vec<&str> = shown
            .lines()
            .filter(|line| line.contains("(friction-bench "))
            .collect();
        assert_eq!(commands.len(), 8, "{kept}");
        assert_eq!(titles.len(), 8, "{shown}");
        for (command, title) in commands.iter().zip(titles) {
            // The title names the command that runs.
            let named = title.split_once("(friction-bench ").unwrap().1;
            let named = named.trim_end_matches(')');
            assert!(command.starts_with(named), "{command}: {title}");
            assert!(command.ends_with("--quiet"), "{command}");
        }
        let last = shown.lines().last().unwrap();
        assert!(
            last.contains("--mock bench-unknown --seed 7 --calibration '")
                && last.contains("/a demo/study' --participant sub-02"),
            "{last}"
        );
    }

    #[test]
    fn a_step_that_fails_ends_the_demonstration_with_its_status() {
        let (ended, shown, _) = demonstrated("[ \"$2\" != plate ] || exit 3");
        assert_eq!(ended.unwrap(), DemoEnd::Failed(3));
        assert!(shown.contains("calibrate plate)"), "{shown}");
        assert!(!shown.contains("calibrate force)"), "{shown}");
    }

    #[test]
    fn a_program_that_is_gone_is_named() {
        let (ended, _, _) = demonstrated(r#"rm "$0""#);
        let said = ended.unwrap_err().to_string();
        assert!(said.contains("/program for the next step"), "{said}");
    }
}
