//! A manual page for each command.

use std::process::ExitStatus;

use bench_tests::program::bench;
use clap::CommandFactory;
use friction_bench::cli::Cli;

/// Returns the page names of a command and all its subcommands.
fn pages(command: &clap::Command, name: &str) -> Vec<String> {
    let subcommands = command.get_subcommands().filter(|c| c.get_name() != "help");
    let mut names = vec![format!("{name}.1")];
    names.extend(subcommands.flat_map(|c| pages(c, &format!("{name}-{}", c.get_name()))));
    names
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("share/man/man1");
    let status: ExitStatus = bench()
        .args(["manual", "--to"])
        .arg(&target)
        .status()
        .unwrap();
    assert!(status.success());
    let names = pages(&Cli::command(), "friction-bench");
    assert!(names.contains(&"friction-bench-calibrate-pickup.1".to_owned()));
    for page in names {
        let text =
            std::fs::read_to_string(target.join(&page)).unwrap_or_else(|_| panic!("no {page}"));
        assert!(
            text.contains(".SH NAME") && text.contains(".SH SYNOPSIS"),
            "{page}"
        );
    }
}

#[test]
fn messages_are_looked_up_and_listed() {
    let run = |words: &[&str]| bench().args(words).output().unwrap();
    let explanation = run(&["messages", "drive reads back 3.1 V although disarmed"]);
    let explanation = String::from_utf8(explanation.stdout).unwrap();
    assert!(
        explanation.contains("mains") && !explanation.contains("e-stop pressed"),
        "{explanation}"
    );
    let help = String::from_utf8(run(&["messages", "--help"]).stdout).unwrap();
    assert!(help.lines().count() < 40, "{help}");
    let list = String::from_utf8(run(&["messages"]).stdout).unwrap();
    assert!(
        list.contains("e-stop pressed") && list.contains("participants.tsv lists"),
        "{list}"
    );
    let unknown = run(&["messages", "unheard-of"]);
    assert!(!unknown.status.success());
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("unheard-of"));
}
