//! Tasks that an operator does with keys alone: overruled verdicts, repeated trials, pauses, stops, a lost display, a session
//! that was killed.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::Permissions;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::time::Duration;

use bench_tests::running::wait_until;
use bench_tests::session::{SessionFolder, write_demo_protocol};
use protocols::{Interruption, TrialOutcome, TrialRecord};
use recording::study::LOCK_FILE;
use rustix::process::{Pid, Signal, kill_process};

use participant_window::message::FromWindow;

use super::simulated_window::Window;
use super::terminal::Terminal;

const RUN: &str =
    "run --mock --study study --participant sub-01 --protocol protocol.toml --consent-by Tester";

/// Starts a session of two trials, as short as can be judged, with verdicts that wait for the operator.
fn session(min_instances: u32, options: &str) -> Terminal {
    let instances = format!("min_instances = {min_instances}");
    let prepare = |folder: &Path| {
        let changes = [
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 2"),
            (
                "[\"left_to_right\", \"right_to_left\"]",
                "[\"left_to_right\"]",
            ),
            ("baseline_s = 0.8", "baseline_s = 0.4"),
            ("countdown_s = 1.0", "countdown_s = 0.3"),
            ("feedback_s = 1.0", "feedback_s = 0.3"),
            ("verdict_s = 0.5", "verdict_s = 50.0"),
            ("every_trials = 2", "every_trials = 0"),
            ("min_instances = 5", instances.as_str()),
        ];
        write_demo_protocol(folder, &changes);
        // The session and the window meet only in a private folder.
        std::fs::set_permissions(folder, Permissions::from_mode(0o700)).unwrap();
        if options.contains("--participant-display") {
            std::fs::write(folder.join("wait"), "").unwrap();
        }
    };
    Terminal::open_prepared(120, 40, prepare, &format!("{RUN} {options}"))
}

fn outcomes(terminal: &Terminal) -> Vec<(u32, u32, TrialOutcome)> {
    let session = SessionFolder::read(&terminal.folder.path().join("study"), "sub-01").unwrap();
    let outcome_of = |record: TrialRecord| (record.key.number, record.key.attempt, record.outcome);
    session
        .history()
        .records
        .into_iter()
        .map(outcome_of)
        .collect()
}

fn quit(terminal: &Terminal) {
    terminal.press(&["q"]);
    terminal.expect_text(&["Quit?"]);
    terminal.press(&["y"]);
    terminal.expect_file("status");
}

#[test]
fn a_rejected_trial_is_kept_and_a_verdict_waits_through_a_pause() {
    let terminal = session(40, "");
    terminal.expect_text(&["now  REJECTED: ", "trial 1/2", "o keeps it", "r repeat"]);
    terminal.press(&["4"]);
    terminal.expect_text(&["wired, closed", "wired, beats", "wired, not pressed"]);
    terminal.press(&["1", "p"]);
    terminal.expect_text(&["PAUSED", "trial 1/2", "o keep anyway"]);
    terminal.press(&["o"]);
    terminal.expect_text(&["kept by the operator, although"]);
    terminal.press(&["p"]);
    terminal.expect_text(&["trial 2/2", "REJECTED"]);
    quit(&terminal);
    assert!(matches!(
        &outcomes(&terminal)[..],
        [(1, 1, TrialOutcome::AcceptedAnyway { reasons }), ..] if !reasons.is_empty()
    ));
}

#[test]
fn a_judged_trial_is_repeated_and_a_running_one_by_its_name() {
    let terminal = session(1, "");
    // On a busy computer the simulated finger may lag too much to be accepted.
    // `o keeps it` or `r repeats it`.
    let screen = terminal.expect_text(&["s it", "trial 1/2", "r repeat"]);
    let is_accepted = !screen.contains("keep anyway");
    terminal.press(&["r"]);
    terminal.expect_text(&["attempt 2", "DRIVING"]);
    terminal.press(&["r"]);
    terminal.expect_text(&["Discard trial 1, attempt 2, now running"]);
    terminal.press(&["y"]);
    terminal.expect_text(&["attempt 3", "DRIVING"]);
    // A pause waits for the attempt's end.
    terminal.press(&["p"]);
    terminal.expect_text(&["pauses after this attempt"]);
    terminal.expect_text(&[" in 5", "attempt 3"]);
    terminal.press(&["Space"]);
    terminal.expect_text(&["PAUSED"]);
    quit(&terminal);
    let [(1, 1, first_outcome), (1, 2, second_outcome), (1, 3, _)] = &outcomes(&terminal)[..]
    else {
        panic!("{:?}", outcomes(&terminal));
    };
    assert!(
        matches!(first_outcome, TrialOutcome::Redo { reasons } if reasons.is_empty() == is_accepted),
        "{first_outcome:?}"
    );
    let interruption = Interruption::Redo;
    assert_eq!(*second_outcome, TrialOutcome::Interrupted { interruption });
}

#[test]
fn a_stopped_session_goes_on_once_it_is_rearmed_and_a_killed_one_is_resumed() {
    let terminal = session(1, "");
    terminal.expect_text(&["DRIVING", "trial 1/2"]);
    terminal.press(&["e"]);
    terminal.expect_text(&["TRIPPED", "stopped by the operator", "x re-arm"]);
    terminal.press(&["x"]);
    terminal.expect_text(&["Re-arm?"]);
    terminal.press(&["y"]);
    terminal.expect_text(&["READY, drive off", "p resume"]);
    terminal.press(&["p"]);
    terminal.expect_text(&["DRIVING", "attempt 2"]);
    let pid = std::fs::read_to_string(terminal.folder.path().join("study").join(LOCK_FILE));
    let pid = Pid::from_raw(pid.unwrap().trim().parse().unwrap()).unwrap();
    kill_process(pid, Signal::KILL).unwrap();
    terminal.expect_file("status");
    // On a busy computer the quick check may need another try.
    let status = terminal.folder.path().join("status");
    let is_resumed = (0..4).any(|_| {
        terminal.rerun(&format!("{RUN} --resume"));
        let start_or_status = || {
            let is_shown = terminal.screen().contains("attempt 3");
            (is_shown || status.exists()).then_some(is_shown)
        };
        wait_until(Duration::from_secs(30), start_or_status).unwrap_or_default()
    });
    assert!(is_resumed, "{}", terminal.screen());
    terminal.expect_text(&["s it", "trial 1/2", "attempt 3"]);
    quit(&terminal);
    let attempts: Vec<_> = outcomes(&terminal)
        .into_iter()
        .map(|(number, attempt, _)| (number, attempt))
        .collect();
    assert_eq!(attempts, [(1, 1), (1, 2), (1, 3)]);
    terminal.rerun(&format!("{RUN} --resume"));
    // The verdict stood when the session was left: the attempt counts, unless a busy computer made it a rejected one.
    let is_next = || {
        let screen = terminal.screen();
        (screen.contains("trial 2/2") || screen.contains("attempt 4")).then_some(())
    };
    assert!(
        wait_until(Duration::from_secs(30), is_next).is_some(),
        "{}",
        terminal.screen()
    );
    terminal.press(&["3"]);
    // The newest attempt that has ended.
    terminal.expect_text(&["trial 1.3", "exploration 1 →"]);
}

#[test]
fn a_lost_participants_terminal_pauses_the_session_and_is_brought_back() {
    let terminal = session(1, "--participant-display participant");
    let open_pane = || {
        let size = [
            "split-window",
            "-d",
            "-P",
            "-F",
            "#{pane_id} #{pane_tty}",
            "sleep 60",
        ];
        let pane = terminal.tmux(&size);
        let (id, tty) = pane.trim().split_once(' ').unwrap();
        let link = terminal.folder.path().join("participant");
        let _ = std::fs::remove_file(&link);
        symlink(tty, link).unwrap();
        id.to_owned()
    };
    let first_pane = open_pane();
    std::fs::remove_file(terminal.folder.path().join("wait")).unwrap();
    terminal.expect_text(&["DRIVING", "trial 1/2"]);
    terminal.tmux(&["kill-pane", "-t", &first_pane]);
    let screen = terminal.expect_text(&["PARTICIPANT'S DISPLAY LOST", "PAUSED"]);
    assert!(!screen.contains("cursor"), "{screen}");
    let second_pane = open_pane();
    terminal.press(&["C-l", "p"]);
    terminal.expect_text(&["Show again on the participant's terminal"]);
    terminal.press(&["y"]);
    terminal.expect_text(&["DRIVING", "attempt 2"]);
    let pane = terminal.tmux(&["capture-pane", "-p", "-t", &second_pane]);
    assert!(!pane.is_empty());
    quit(&terminal);
    assert!(matches!(
        &outcomes(&terminal)[0],
        (
            1,
            1,
            TrialOutcome::Interrupted {
                interruption: Interruption::DisplayLost { .. }
            }
        )
    ));
}

/// A window that jerks or is on another monitor is as unusable as one that is gone.
///
/// Fault 43.
#[test]
fn a_window_that_is_unfit_or_gone_pauses_the_session_until_it_is_back() {
    let terminal = session(1, "--participant-window=meeting");
    let socket = || terminal.folder.path().join("meeting");
    let window = Window::connect(socket());
    terminal.expect_text(&["DRIVING", "trial 1/2"]);
    let report_fitness = |reason: Option<&str>| {
        let reason = reason.map(str::to_owned);
        window.say(FromWindow::Unfit { why: reason });
    };
    report_fitness(Some("it is on the monitor eDP-1, not on HDMI-1"));
    terminal.expect_text(&["PARTICIPANT'S DISPLAY LOST", "PAUSED"]);
    terminal.press(&["5"]);
    terminal.expect_text(&["on the monitor eDP-1"]);
    terminal.press(&["1", "p"]);
    terminal.expect_text(&["Show again on the participant's window"]);
    terminal.press(&["y"]);
    terminal.expect_text(&["not now: the participant's display", "PAUSED"]);
    report_fitness(None);
    terminal.press(&["5"]);
    terminal.expect_text(&["display is back"]);
    terminal.press(&["1", "p"]);
    terminal.expect_text(&["DRIVING", "attempt 2"]);
    window.close();
    terminal.expect_text(&["PARTICIPANT'S DISPLAY LOST", "PAUSED"]);
    let second_window = Window::connect(socket());
    terminal.press(&["5"]);
    terminal.expect_text(&["the participant's window is on monitor HDMI-1"]);
    terminal.press(&["1", "p"]);
    terminal.expect_text(&["DRIVING", "attempt 3"]);
    quit(&terminal);
    second_window.close();
    let attempts = outcomes(&terminal);
    assert_eq!(attempts.len(), 3, "{attempts:?}");
    for (index, word) in ["eDP-1", "closed"].into_iter().enumerate() {
        let TrialOutcome::Interrupted {
            interruption: Interruption::DisplayLost { reason },
        } = &attempts[index].2
        else {
            panic!("{attempts:?}");
        };
        assert!(reason.contains(word), "{reason}");
    }
}

#[test]
fn a_stopped_calibration_continues_with_its_points() {
    let terminal = Terminal::calibrate(100, 30, "pickup --levels-v 10,20,30");
    terminal.confirm_clear_plate();
    terminal.type_amplitude(10.0, 1.0);
    terminal.expect_text(&["10.00 V", "step 4 of 6"]);
    terminal.press(&["e"]);
    terminal.expect_text(&[
        "TRIPPED",
        "stopped by the operator",
        "Measured points are kept",
        "10.00 V",
    ]);
    // Too early: re-arming needs the operator's confirmation.
    terminal.press(&["Enter"]);
    terminal.expect_text(&["press x to re-arm it first"]);
    terminal.press(&["x"]);
    terminal.expect_text(&["Re-arm?"]);
    terminal.press(&["y"]);
    terminal.expect_text(&["DISARMED"]);
    terminal.press(&["Enter"]);
    terminal.type_amplitude(20.0, 1.0);
    terminal.type_amplitude(30.0, 1.0);
    terminal.expect_text(&["Keep them", "30.00 V"]);
    terminal.press(&["Enter"]);
    terminal.require_success();
    assert!(terminal.folder.path().join("calibration.toml").exists());
}

/// Fault 37.
/// Waiting for edge-triggered events wakes on the window's signal and may lose a key that arrived with it.
#[test]
fn a_key_pressed_while_the_window_changes_its_size_is_read() {
    let (terminal, pid) = super::terminal::start_first_trial();
    let help = "stop the drive at once, without confirmation";
    for turn in 0..10 {
        kill_process(pid, Signal::WINCH).unwrap();
        terminal.press(&["?"]);
        let is_shown = turn % 2 == 0;
        let key_effect = || (terminal.screen().contains(help) == is_shown).then_some(());
        wait_until(Duration::from_secs(10), key_effect)
            .unwrap_or_else(|| panic!("turn {turn}:\n{}", terminal.screen()));
    }
}
