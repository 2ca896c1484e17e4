//! `exclude`: leaves trials out of a study's analysis, with a reason.

use std::io::Write;

use anyhow::bail;
use escaping::escaped_line;
use recording::storage::FileSystem;
use recording::study::Study;
use study::exclusions::{AllOrOne, EXCLUSIONS_FILE, Exclusion};

use crate::cli::Exclude;
use crate::dates;

/// Runs the command.
///
/// # Errors
/// The study, participant, session or trial does not exist; it is already excluded; another instance uses the study; or
/// the system refuses.
pub fn run(options: &Exclude) -> anyhow::Result<()> {
    for (flag, text) in [("--because", &options.because), ("--by", &options.by)] {
        if ["", "n/a"].contains(&text.trim()) {
            bail!("{flag} is empty: the results must state the reason and the person");
        }
    }
    let exclusion = Exclusion {
        participant: options.participant.parse()?,
        session: options.session.map_or(AllOrOne::All, AllOrOne::One),
        trial: options.trial.map_or(AllOrOne::All, AllOrOne::One),
        reason: options.because.trim().to_owned(),
        by: options.by.trim().to_owned(),
        date: Some(calendar::day(dates::now())),
    };
    let study = Study::open(&options.study)?;
    study::exclusions::add(&FileSystem, study.folder(), &exclusion)?;
    let line = format!("{exclusion}; {EXCLUSIONS_FILE} says so, and nothing was deleted");
    writeln!(
        standard_streams::stdout(),
        "excluded {}",
        escaped_line(&line)
    )?;
    Ok(())
}
