//! The operator's terminal is restored however the dashboard ends. Each case runs in a separate process, because a
//! terminal and a panic hook belong to a process: the test starts itself again, on a pseudo-terminal.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs::File;
use std::io::Write;
use std::process::{Child, Command};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use crate::pty::{PATIENCE, Screen};
use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
use tui::{Action, Event};

/// Environment variable set in the process started by a test.
const PART: &str = "TUI_TEST_PART";

/// The process started by a test; killed on drop.
struct Part(Child);

impl Part {
    fn wait_for_end(&mut self) {
        let deadline = Instant::now() + PATIENCE;
        while self.0.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "the dashboard never ended");
            thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Fails if it has already ended, as expected.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn on_a_terminal(test: &str) -> (Screen, Part) {
    let screen = Screen::new(80, 24);
    let terminal = || {
        let path = &screen.path;
        File::options().read(true).write(true).open(path).unwrap()
    };
    let child = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            &format!("operator_terminal::{test}"),
            "--nocapture",
        ])
        .env(PART, "")
        .stdin(terminal())
        .stdout(terminal())
        .stderr(terminal())
        .spawn()
        .unwrap();
    (screen, Part(child))
}

/// Returns whether the terminal is in raw mode; a new one is not, since it has echo and line editing.
fn is_raw(screen: &Screen) -> bool {
    let modes = tcgetattr(&screen.controller).unwrap().local_modes;
    !modes.intersects(LocalModes::ICANON | LocalModes::ECHO)
}

/// Shows the dashboard until it is interrupted; an emergency stop makes the bench's thread panic.
fn dashboard() {
    let (bench, events) = mpsc::channel();
    let (operator, actions) = mpsc::channel();
    thread::spawn(move || {
        for action in actions {
            match action {
                Action::Interrupt => bench.send(Event::Close).unwrap(),
                Action::EmergencyStop => panic!("out of paper"),
                _ => {}
            }
        }
    });
    tui::run_operator(&events, operator, |_| ()).unwrap();
}

#[test]
fn control_c_ends_it_and_the_terminal_is_as_before() {
    if std::env::var_os(PART).is_some() {
        dashboard();
        return;
    }
    let name = "control_c_ends_it_and_the_terminal_is_as_before";
    let (mut screen, mut part) = on_a_terminal(name);
    screen.wait_for("\x1b[?1049h");
    screen.wait_for("UNKNOWN");
    assert!(is_raw(&screen));
    screen.controller.write_all(b"\x03").unwrap();
    screen.wait_for("\x1b[?1049l");
    screen.wait_for("\x1b[?25h");
    part.wait_for_end();
    assert!(!is_raw(&screen));
}

/// Regression test: after SIGSTOP and the shell's `fg` the stop key waited for Enter.
#[test]
fn a_shell_that_set_the_terminal_to_lines_takes_no_key_from_it() {
    if std::env::var_os(PART).is_some() {
        dashboard();
        return;
    }
    let name = "a_shell_that_set_the_terminal_to_lines_takes_no_key_from_it";
    let (mut screen, mut part) = on_a_terminal(name);
    screen.wait_for("UNKNOWN");
    assert!(is_raw(&screen));
    let mut modes = tcgetattr(&screen.controller).unwrap();
    modes.local_modes |= LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG;
    tcsetattr(&screen.controller, OptionalActions::Now, &modes).unwrap();
    // The whole screen is drawn anew.
    screen.wait_for("UNKNOWN");
    assert!(is_raw(&screen));
    screen.controller.write_all(b"\x03").unwrap();
    screen.wait_for("\x1b[?1049l");
    part.wait_for_end();
}

/// Fault 30.
/// Hazard 15.
#[test]
fn a_panic_elsewhere_makes_safe_then_puts_back_then_speaks() {
    if std::env::var_os(PART).is_some() {
        tui::install_panic_hook(|info| info.to_string());
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            std::io::stderr().write_all(b"<made safe>").unwrap();
            report(info);
        }));
        dashboard();
        return;
    }
    let name = "a_panic_elsewhere_makes_safe_then_puts_back_then_speaks";
    let (mut screen, mut part) = on_a_terminal(name);
    screen.wait_for("UNKNOWN");
    assert!(is_raw(&screen));
    // The panic is in the thread that receives the actions: the dashboard ends with it.
    screen.controller.write_all(b"e").unwrap();
    screen.wait_for("<made safe>");
    screen.wait_for("\x1b[?1049l");
    screen.wait_for("out of paper");
    part.wait_for_end();
    assert!(!is_raw(&screen));
}

#[test]
fn it_ends_when_its_terminal_is_closed() {
    if std::env::var_os(PART).is_some() {
        dashboard();
        return;
    }
    let (mut screen, mut part) = on_a_terminal("it_ends_when_its_terminal_is_closed");
    screen.wait_for("UNKNOWN");
    drop(screen);
    part.wait_for_end();
}

#[test]
fn without_a_terminal_it_says_what_to_do() {
    if std::env::var_os(PART).is_some() {
        let (_bench, events) = mpsc::channel();
        let (operator, _actions) = mpsc::channel();
        let error = tui::run_operator(&events, operator, |_| ()).unwrap_err();
        std::io::stderr()
            .write_all(error.to_string().as_bytes())
            .unwrap();
        return;
    }
    let output = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "operator_terminal::without_a_terminal_it_says_what_to_do",
            "--nocapture",
        ])
        .env(PART, "")
        .stdin(std::process::Stdio::null())
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("--headless"), "{message}");
}
