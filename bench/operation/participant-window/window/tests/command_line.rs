//! Answers of the program to command lines that open no window.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::process::{Command, Output};

fn window(arguments: &[&str]) -> Output {
    let home = tempfile::tempdir().unwrap();
    Command::new(env!("CARGO_BIN_EXE_friction-bench-participant"))
        .args(arguments)
        .env("XDG_CONFIG_HOME", home.path())
        .env("XDG_RUNTIME_DIR", home.path())
        .env_remove("DISPLAY")
        .output()
        .unwrap()
}

#[test]
fn the_program_prints_its_options_and_its_version() {
    let help = window(&["--help"]);
    assert!(help.status.success());
    let text = String::from_utf8_lossy(&help.stdout).into_owned();
    for option in ["--monitor", "--ruler", "--font", "--socket"] {
        assert!(text.contains(option), "{text}");
    }
    let version = window(&["--version"]).stdout;
    let version = String::from_utf8_lossy(&version).into_owned();
    assert!(version.contains(env!("CARGO_PKG_VERSION")), "{version}");
}

#[test]
fn a_font_that_is_not_there_is_named() {
    let output = window(&["--font", "absent\u{7}.ttf"]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        stderr.starts_with("friction-bench-participant: cannot read absent\\u0007.ttf: "),
        "{stderr}"
    );
}
