//! Checks that the program accepts every command that README and handbook print.

use std::path::PathBuf;

use bench_tests::handbook::folder;
use bench_tests::program::workspace;
use clap::{CommandFactory, Parser};
use config::CalibrationKind;
use friction_bench::cli::Cli;

fn texts() -> Vec<(PathBuf, String)> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder().join("src"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    paths.push(workspace().join("README.md"));
    paths.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// Returns the words of a command without their quotes; `None` if a quote is not closed.
fn split(line: &str) -> Option<Vec<String>> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for character in line.chars() {
        match (quote, character) {
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            (None, ' ') => words.push(String::new()),
            _ => words.last_mut()?.push(character),
        }
    }
    words.retain(|word| !word.is_empty());
    quote.is_none().then_some(words)
}

/// Returns the commands in blocks marked `sh`, without comments and with continued lines joined.
fn commands(text: &str) -> Vec<String> {
    let mut list = Vec::new();
    let mut is_shell_block = false;
    let script = text.replace("\\\n", " ");
    for line in script.lines() {
        match line.trim() {
            "```sh" => is_shell_block = true,
            line if line.starts_with("```") => is_shell_block = false,
            line if is_shell_block => {
                list.push(line.split(" #").next().unwrap_or(line).trim().to_owned())
            }
            _ => {}
        }
    }
    list
}

#[test]
fn each_command_of_readme_and_handbook_is_understood() {
    let mut problems = Vec::new();
    let mut count = 0;
    for (path, text) in texts() {
        for line in commands(&text) {
            // Cut off a redirection or a second command, and replace the shell function for the simulated bench.
            let line = line.split(" > ").next().unwrap_or(&line);
            let line = line.split(" | ").next().unwrap_or(line).to_owned();
            let line = line.replace("unknown calibrate", "friction-bench calibrate");
            if !line.starts_with("friction-bench ") {
                continue;
            }
            count += 1;
            match split(&line).map(Cli::try_parse_from) {
                Some(Ok(_)) => {}
                Some(Err(error)) if !error.use_stderr() => {}
                Some(Err(error)) => problems.push(format!("{}: {line}\n{error}", path.display())),
                None => problems.push(format!("{}: an open quote: {line}", path.display())),
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(count > 20, "only {count} commands were found");
}

/// Returns the names of the calibrations in these texts, each where it first occurs.
fn first_calibrations(texts: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut names = Vec::new();
    for text in texts {
        for rest in text.split("calibrate ").skip(1) {
            let name = rest.split(|c: char| !c.is_ascii_lowercase()).next();
            let name = name.unwrap_or_default().to_owned();
            let is_kind = CalibrationKind::ORDER
                .iter()
                .any(|kind| kind.name() == name);
            if is_kind && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

#[test]
fn the_calibrations_have_one_order_everywhere() {
    let order = CalibrationKind::ORDER.map(CalibrationKind::name);
    let mut command = Cli::command();
    let calibrate = command.find_subcommand_mut("calibrate").unwrap();
    let help: Vec<&str> = calibrate
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    assert_eq!(help, order, "--help");
    let chapters = texts()
        .into_iter()
        .filter(|(path, _)| path.ends_with("calibrating.md") || path.ends_with("unboxing.md"));
    for (path, text) in chapters {
        assert_eq!(first_calibrations([text]), order, "{}", path.display());
    }
    let design = std::fs::read_to_string(workspace().join("docs/DESIGN.md")).unwrap();
    assert!(design.contains(&format!("calibrate {}`", order.join("\\|"))));
}
