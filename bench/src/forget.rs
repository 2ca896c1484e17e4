//! `forget`: removes a participant from a study.

use std::io::{BufRead, IsTerminal, Write};
use std::path::Path;

use anyhow::bail;
use protocols::ParticipantId;
use recording::study::Study;
use study::removal::{REMOVALS_FILE, Traces};
use tasks::{Clock, SystemClock};

use crate::cli::Forget;

/// Runs the command; returns true if the participant was removed, false if the operator declined.
///
/// # Errors
/// The study or the participant does not exist, another instance uses the study, the operator cannot be asked, or the
/// system refuses.
pub fn run(options: &Forget) -> anyhow::Result<bool> {
    let (folder, named) = options.target();
    let participant = participant(named)?;
    let study = Study::open(folder)?;
    let traces = Traces::find(&study, &participant)?;
    let mut out = standard_streams::stdout();
    describe(&traces, &participant, &mut out)?;
    let agreed = match &options.confirm {
        Some(confirmed) if *confirmed == participant.as_str() => true,
        Some(confirmed) => {
            bail!("--confirm names {confirmed}, not {participant}: nothing was removed")
        }
        None if std::io::stdin().is_terminal() => {
            ask(&participant, std::io::stdin().lock(), &mut out)?
        }
        None => bail!(
            "nothing was removed: there is no terminal for the two questions; --confirm {participant} answers both"
        ),
    };
    if !agreed {
        writeln!(out, "nothing was removed")?;
        return Ok(false);
    }
    let date = SystemClock::start().day();
    traces.remove(&study, &date)?;
    writeln!(
        out,
        "{participant} is removed; {REMOVALS_FILE} records the removal and its date\n\
         still to be removed by hand: results and figures that used these recordings, copies and backups, and the list \
         of names (docs/PRIVACY.md)"
    )?;
    Ok(true)
}

/// Returns the participant of a command line; a folder in their place leads to the right form.
fn participant(named: &Path) -> anyhow::Result<ParticipantId> {
    let participant = named.to_string_lossy().parse::<ParticipantId>();
    if participant.is_err() && named.is_dir() {
        bail!(
            "{} is a folder, and no participant is named: friction-bench forget ID --study {}",
            named.display(),
            escaping::quoted(named)
        );
    }
    Ok(participant?)
}

/// Prints the data that would be removed, and other places that name the participant.
fn describe(
    traces: &Traces,
    participant: &ParticipantId,
    mut out: impl Write,
) -> std::io::Result<()> {
    let mut lines = vec![format!("of {participant} would be removed, for good:")];
    if let Some(folder) = &traces.folder {
        let Traces {
            folders,
            files,
            bytes,
            links,
            ..
        } = traces;
        let folder = folder.display();
        lines.push(format!(
            "  {folder}: {files} files in {folders} folders, {bytes} bytes ({:.1} MB)",
            *bytes as f64 / 1e6
        ));
        if *links > 0 {
            lines.push(format!(
                "  {links} symbolic links in it; their targets stay"
            ));
        }
    }
    if traces.is_listed {
        lines.push("  the line in participants.tsv".to_owned());
    }
    match traces.exclusions {
        0 => {}
        1 => lines.push("  a line in exclusions.tsv".to_owned()),
        count => lines.push(format!("  {count} lines in exclusions.tsv")),
    }
    if !traces.others.is_empty() {
        lines.push(format!(
            "these files and folders name {participant} too, and would stay:"
        ));
        let files = traces.others.iter();
        lines.extend(files.map(|file| format!("  {}", file.display())));
    }
    for line in lines {
        writeln!(out, "{}", escaping::escaped_line(&line))?;
    }
    Ok(())
}

/// Asks twice, the second time for the participant's identifier.
fn ask(
    participant: &ParticipantId,
    mut input: impl BufRead,
    mut out: impl Write,
) -> std::io::Result<bool> {
    let mut answer = |question: &str| -> std::io::Result<String> {
        write!(out, "{question} ")?;
        out.flush()?;
        let mut line = String::new();
        input.read_line(&mut line)?;
        Ok(line.trim().to_owned())
    };
    Ok(
        answer("Remove all of this? It cannot be undone. (type yes in full, or no)")? == "yes"
            && answer("To confirm, type the participant's code:")? == participant.as_str(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_form_names_the_study_and_the_participant() {
        use clap::Parser;
        let target = |words: &[&str]| {
            let words = ["friction-bench", "forget"].iter().chain(words);
            let cli = crate::cli::Cli::try_parse_from(words).unwrap();
            let crate::cli::Command::Forget(options) = cli.command else {
                panic!("another command");
            };
            let (study, participant) = options.target();
            (study.to_owned(), participant.to_owned())
        };
        let expected = |study: &str| (study.into(), "sub-07".into());
        assert_eq!(target(&["sub-07", "--study", "mine"]), expected("mine"));
        assert_eq!(target(&["mine", "sub-07"]), expected("mine"));
        assert_eq!(target(&["sub-07"]), expected("study"));
    }

    #[test]
    fn a_folder_in_place_of_the_participant_leads_to_the_right_form() {
        let folder = tempfile::tempdir().unwrap();
        let error = participant(folder.path()).unwrap_err().to_string();
        assert!(error.contains("forget ID --study"), "{error}");
        assert_eq!(participant(Path::new("sub-07")).unwrap().as_str(), "sub-07");
    }

    #[test]
    fn both_questions_want_their_answer() {
        let participant: ParticipantId = "sub-07".parse().unwrap();
        let reply = |answers: &str| {
            let mut out = Vec::new();
            let agreed = ask(&participant, answers.as_bytes(), &mut out).unwrap();
            (
                agreed,
                String::from_utf8(out).unwrap().matches(['?', ':']).count(),
            )
        };
        assert_eq!(reply("yes\nsub-07\n"), (true, 2));
        assert_eq!(reply("yes\nsub-08\n"), (false, 2));
        assert_eq!(reply("yes\nyes\n"), (false, 2));
        assert_eq!(reply("yes\n"), (false, 2));
        for refusal in [
            "no\nsub-07\n",
            "y\nsub-07\n",
            "\nsub-07\n",
            "sub-07\nsub-07\n",
            "",
        ] {
            assert_eq!(reply(refusal), (false, 1), "{refusal:?}");
        }
    }
}
