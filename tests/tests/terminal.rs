//! The dashboard on a real terminal, in real time: it shows what matters, and gives the terminal back as it was.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use bench_tests::program::{friction_bench, installed};
use bench_tests::running::until;
use bench_tests::session::{SessionFolder, config_with, finish, text};
use friction_bench::study::event_log::ExitStatus;
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(30);

/// A terminal of its own; it ends with the test.
struct Terminal {
    tmux: PathBuf,
    folder: TempDir,
}

impl Terminal {
    fn open(columns: u16, rows: u16, command: &str) -> Self {
        let terminal = Self {
            tmux: installed("tmux"),
            folder: tempfile::tempdir().unwrap(),
        };
        let config = config_with(
            terminal.folder.path(),
            &[
                ("loop_latency_s =", "loop_latency_s = 1.0 # not"),
                ("silence_s =", "silence_s = 1.0 # not"),
            ],
        );
        let script = format!(
            "cd '{}'; stty -g > before; '{}' {command} --config '{}'; echo $? > status; stty -g > after; sleep 60",
            terminal.folder.path().display(),
            friction_bench().display(),
            config.display(),
        );
        let size = [columns.to_string(), rows.to_string()];
        terminal.tmux(&["new-session", "-d", "-x", &size[0], "-y", &size[1], &script]);
        terminal
    }

    fn tmux(&self, arguments: &[&str]) -> String {
        let output = finish(
            Command::new(&self.tmux)
                .args(["-f", "/dev/null", "-S"])
                .arg(self.folder.path().join("socket"))
                .args(arguments),
        );
        assert!(
            output.status.success(),
            "tmux {arguments:?}: {}",
            text(&output)
        );
        String::from_utf8(output.stdout).unwrap()
    }

    fn screen(&self) -> String {
        self.tmux(&["capture-pane", "-p"])
    }

    fn shows(&self, what: &[&str]) -> String {
        let mut last = String::new();
        until(PATIENCE, || {
            last = self.screen();
            what.iter().all(|word| last.contains(word)).then_some(())
        })
        .unwrap_or_else(|| panic!("no {what:?} in {PATIENCE:?} on:\n{last}"));
        last
    }

    /// What the script wrote into `file`, once it has.
    fn wrote(&self, file: &str) -> String {
        let path = self.folder.path().join(file);
        until(PATIENCE, || {
            std::fs::read_to_string(&path)
                .ok()
                .filter(|text| !text.is_empty())
        })
        .unwrap_or_else(|| panic!("no {file}; the screen is:\n{}", self.screen()))
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = Command::new(&self.tmux)
            .arg("-S")
            .arg(self.folder.path().join("socket"))
            .arg("kill-server")
            .status();
    }
}

fn shows_the_session_and_restores_the_terminal(columns: u16, rows: u16) {
    let command =
        "run --mock --study study --participant sub-01 --protocol demo --consent-by Tester";
    let terminal = Terminal::open(columns, rows, command);
    let screen = terminal.shows(&[
        "DRIVING",
        "simulated",
        "UNCALIBRATED",
        "sub-01",
        "practice 1/1",
        "Re Z_m",
        "Im Z_m",
        "quit",
    ]);
    assert!(
        screen.lines().next().unwrap().contains("DRIVING"),
        "the safety line comes first:\n{screen}"
    );
    // A number, not a placeholder: the bare plate's 7 N·s/m, or more under the finger.
    until(PATIENCE, || {
        let screen = terminal.screen();
        let value = screen.split_once("Re Z_m")?.1.split_whitespace().next()?;
        value
            .replace('−', "-")
            .parse::<f64>()
            .ok()
            .filter(|re| (6.5..40.0).contains(re))
    })
    .unwrap_or_else(|| panic!("no impedance on:\n{}", terminal.screen()));
    assert_eq!(
        terminal
            .tmux(&["display-message", "-p", "#{alternate_on}"])
            .trim(),
        "1"
    );

    terminal.tmux(&["send-keys", "q"]);
    terminal.shows(&["Quit?"]);
    terminal.tmux(&["send-keys", "y"]);
    assert_eq!(
        terminal.wrote("status").trim(),
        "1",
        "a session that is not over"
    );
    assert_eq!(terminal.wrote("after"), terminal.wrote("before"));
    let restored = terminal.tmux(&[
        "display-message",
        "-p",
        "#{alternate_on} #{cursor_flag} #{mouse_any_flag}",
    ]);
    assert_eq!(restored.trim(), "0 1 0", "main screen, cursor, no mouse");
    let screen = terminal.screen();
    assert!(
        screen.contains("ended early"),
        "the summary stays on the terminal:\n{screen}"
    );
    assert!(!screen.contains("panicked"), "{screen}");
    let session = SessionFolder::read(&terminal.folder.path().join("study"), "sub-01").unwrap();
    assert_eq!(session.stops()[0].exit_status, ExitStatus::Abort);
}

#[test]
fn on_a_terminal_of_80_by_24() {
    shows_the_session_and_restores_the_terminal(80, 24);
}

#[test]
fn on_a_terminal_of_120_by_40() {
    shows_the_session_and_restores_the_terminal(120, 40);
}
