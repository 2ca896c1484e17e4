//! A manual page for each command.

use std::process::ExitStatus;

use bench_tests::program::bench;
use clap::CommandFactory;
use friction_bench::cli::Cli;

/// Returns the page names of a command and all its subcommands.
fn pages(command: &clap::Command, name: &str) -> Vec<String> {
    let below = command.get_subcommands().filter(|c| c.get_name() != "help");
    let mut names = vec![format!("{name}.1")];
    names.extend(below.flat_map(|c| pages(c, &format!("{name}-{}", c.get_name()))));
    names
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("share/man/man1");
    let wrote: ExitStatus = bench().args(["manual", "--to"]).arg(&to).status().unwrap();
    assert!(wrote.success());
    let all = pages(&Cli::command(), "friction-bench");
    assert!(all.contains(&"friction-bench-calibrate-pickup.1".to_owned()));
    for page in all {
        let text = std::fs::read_to_string(to.join(&page)).unwrap_or_else(|_| panic!("no {page}"));
        assert!(
            text.contains(".SH NAME") && text.contains(".SH SYNOPSIS"),
            "{page}"
        );
    }
}

#[test]
fn messages_are_looked_up_and_listed() {
    let said = |words: &[&str]| bench().args(words).output().unwrap();
    let one = said(&["messages", "drive reads back 3.1 V although disarmed"]);
    let one = String::from_utf8(one.stdout).unwrap();
    assert!(
        one.contains("mains") && !one.contains("e-stop pressed"),
        "{one}"
    );
    let all = String::from_utf8(said(&["help", "messages"]).stdout).unwrap();
    assert!(
        all.contains("e-stop pressed") && all.contains("participants.tsv lists"),
        "{all}"
    );
    let none = said(&["messages", "unheard-of"]);
    assert!(!none.status.success());
    assert!(String::from_utf8_lossy(&none.stderr).contains("unheard-of"));
}
