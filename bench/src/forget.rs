//! `forget`: removes a participant from a study.

use std::io::{BufRead, IsTerminal, Write};

use anyhow::bail;
use protocols::ParticipantId;
use recording::study::{REMOVALS_FILE, Study, Traces};
use tasks::{Clock, SystemClock};

use crate::cli::Forget;

/// Runs the command; returns true if the participant was removed, false if the operator declined.
///
/// # Errors
/// The study or the participant does not exist, another instance uses the study, the operator cannot be asked, or the
/// system refuses.
pub fn run(options: &Forget) -> anyhow::Result<bool> {
    let participant: ParticipantId = options.participant.parse()?;
    let study = Study::open(&options.study)?;
    let traces = study.traces(&participant)?;
    let mut out = std::io::stdout();
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
    study.remove(&traces, &date)?;
    writeln!(
        out,
        "{participant} is removed; {REMOVALS_FILE} records the removal and its date\n\
         still to be removed by hand: results and figures that used these recordings, copies and backups, and the list \
         of names (docs/PRIVACY.md)"
    )?;
    Ok(true)
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
    if !traces.other_files.is_empty() {
        lines.push(format!(
            "these files name {participant} too, and would stay:"
        ));
        let files = traces.other_files.iter();
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
        answer("Remove all of this? It cannot be undone. (yes/no)")? == "yes"
            && answer("To confirm, type the participant's code:")? == participant.as_str(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
