//! Commands that print a text and use no bench: schemas, completions, manual pages, messages.

use std::fs;
use std::path::Path;

use anyhow::Context;
use clap::CommandFactory;
use friction_bench::cli::{Cli, Command};

/// Returns the text that `command` prints; empty for other commands, or if it wrote files instead.
///
/// # Errors
/// When no message has the words asked for, or a file cannot be written.
pub fn text(command: &Command) -> anyhow::Result<Vec<u8>> {
    let mut text = Vec::new();
    match command {
        Command::Schema { name } => {
            let schema = name.as_deref().and_then(help::schemas::schema_text);
            text = schema.unwrap_or_else(help::schemas::list).into();
        }
        // The generators panic if they cannot write.
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut Cli::command(), "friction-bench", &mut text);
        }
        Command::Manual { to: None } => clap_mangen::Man::new(Cli::command()).render(&mut text)?,
        Command::Manual { to: Some(folder) } => write_pages(folder)?,
        Command::Messages(options) => {
            let matches = help::messages::text(&options.words);
            let matches = matches.with_context(|| {
                format!(
                    "no message contains half of these words: {}; give fewer words, or none for the whole list",
                    options.words.join(" ")
                )
            })?;
            text = matches.into();
        }
        _ => {}
    }
    Ok(text)
}

fn write_pages(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    clap_mangen::generate_to(Cli::command(), folder)
        .with_context(|| format!("cannot write manual pages to {}", folder.display()))
}
