//! Progress and output of commands that process many recordings.

use std::fs;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::Path;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use recording::disk;
use recording::storage::FileSystem;
use study::result_files::{ResultFile, recorded_folder};

use crate::verbosity::Verbosity;

/// Returns a progress bar on standard error; hidden without a terminal.
pub(crate) fn progress_bar(recordings: u64, verbosity: Verbosity) -> ProgressBar {
    let target = if verbosity.shows_progress() && io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(recordings), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} recordings {eta}") {
        bar.set_style(if standard_streams::is_ascii() {
            style.progress_chars("#-")
        } else {
            style
        });
    }
    bar
}

/// Requires that a folder of results is not one of recordings, whose files results would replace or join.
///
/// # Errors
/// `folder` is a recording, a session or a study.
pub(crate) fn require_apart(folder: &Path) -> anyhow::Result<()> {
    match recorded_folder(folder) {
        Some(kind) => anyhow::bail!(
            "cannot write results into {}: it is {kind}; name another folder",
            folder.display()
        ),
        None => Ok(()),
    }
}

/// Fails at once if [`write_text`] could not write after a long computation, or would replace what is no earlier result.
///
/// # Errors
/// `path` is a folder, cannot be written, is in a recording or a session, or is a file that is not an earlier result.
pub(crate) fn require_writable(path: &Path, kind: ResultFile) -> anyhow::Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() || path.file_name().is_none() {
        anyhow::bail!(
            "cannot write {}: it is a folder; name a file",
            path.display()
        );
    }
    if is_stream(path) {
        return Ok(());
    }
    let folder = folder_of(path);
    if let Some(kind @ ("a recording" | "a session")) = recorded_folder(folder) {
        anyhow::bail!(
            "cannot write {}: {} is {kind}, whose files results must not change; name a file elsewhere",
            path.display(),
            folder.display()
        );
    }
    if path.exists() && !kind.is_earlier(path) {
        anyhow::bail!(
            "cannot write {}: it is there already and is no earlier result; name another file, or remove it",
            path.display()
        );
    }
    probe_folder(path).with_context(|| {
        format!(
            "cannot write {}: name a file in a folder of yours",
            path.display()
        )
    })
}

/// Tests whether a file could be created in the folder of `path`.
pub(crate) fn probe_folder(path: &Path) -> io::Result<()> {
    let probe = folder_of(path).join(format!(".friction-bench-{}", std::process::id()));
    fs::File::create_new(&probe).and_then(|_| fs::remove_file(&probe))
}

/// Returns the folder of `path`.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Returns whether `path` is a device or a pipe, which a file must not replace.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Writes `text` as [`write_lines`] does.
///
/// # Errors
/// When the system refuses.
pub(crate) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    write_lines(path, |out| out.write_all(text.as_bytes()))
}

/// Writes the lines that `write` writes to standard output for `-`, otherwise to a file that is complete or absent. Control
/// characters are escaped on the terminal, in a form that is valid in JSON too.
///
/// # Errors
/// When the system refuses.
pub(crate) fn write_lines(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> anyhow::Result<()> {
    if path == Path::new("-") {
        let mut lines = standard_streams::EscapedLines::new(standard_streams::data_out());
        write(&mut lines)?;
        lines.finish()?;
        return Ok(());
    }
    let buffered = |file: &mut dyn Write| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.flush()
    };
    if is_stream(path) {
        let mut stream = fs::OpenOptions::new().write(true).open(path)?;
        return buffered(&mut stream).with_context(|| format!("cannot write {}", path.display()));
    }
    disk::replace_file_by(&FileSystem, path, |mut file| buffered(&mut file))
        .context("cannot write the results")
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::io::Read;
    use std::os::fd::AsRawFd;

    use super::*;

    #[test]
    fn a_pipe_is_written_into_and_not_replaced() {
        let (mut reader, writer) = io::pipe().unwrap();
        let path = Path::new("/proc/self/fd").join(writer.as_raw_fd().to_string());
        require_writable(&path, ResultFile::Json).unwrap();
        write_text(&path, "results").unwrap();
        drop(writer);
        let mut read = String::new();
        reader.read_to_string(&mut read).unwrap();
        assert_eq!(read, "results");
    }

    #[test]
    fn a_file_is_replaced_and_a_folder_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.json");
        for text in ["{ \"format\": 1 }", "{ \"format\": 2 }"] {
            require_writable(&path, ResultFile::Json).unwrap();
            write_text(&path, text).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        for kind in [ResultFile::Json, ResultFile::Page] {
            assert!(require_writable(folder.path(), kind).is_err());
            assert!(require_writable(&folder.path().join("no/such"), kind).is_err());
        }
    }

    #[test]
    fn recorded_data_and_files_of_others_are_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, text).unwrap();
            path
        };
        let page = write("page.html", "<!DOCTYPE html><html>");
        let empty = write("empty", "");
        let study = write("study/dataset_description.json", "{ \"Name\": \"study\" }");
        let people = write("study/participants.tsv", "participant_id\n");
        let log = write("study/sub-01/ses-01/events.jsonl", "{}\n");
        let manifest = write(
            "study/sub-01/ses-01/trial-001/recording.toml",
            "format = 1\n",
        );
        let neighbour = manifest.with_file_name("results.json");
        for kind in [ResultFile::Json, ResultFile::Page] {
            for path in [&study, &people, &log, &manifest, &neighbour] {
                let error = require_writable(path, kind).unwrap_err().to_string();
                assert!(error.contains("name a"), "{error}");
            }
            require_writable(&empty, kind).unwrap();
            require_writable(&study.with_file_name("results"), kind).unwrap();
        }
        assert!(require_writable(&page, ResultFile::Json).is_err());
        require_writable(&page, ResultFile::Page).unwrap();
        for file in [&study, &log, &manifest] {
            assert!(require_apart(file.parent().unwrap()).is_err());
        }
        require_apart(folder.path()).unwrap();
    }
}
