//! Keys of the dashboard in a session, a drill, while monitoring and during a replay.

use ratatui::crossterm::event::KeyCode;

use crate::action::{Action, AttemptName};
use crate::event::{PhaseKind, SafetyState};
use crate::key_table::{Effect, KeyRow, Meaning, Press};
use crate::page::Page;
use crate::state::State;

/// Step of a replay per key press, s.
const SEEK_S: f64 = 5.0;

/// Keys that work on every page.
pub(crate) const EVERYWHERE: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::of('e')],
        shown: "e",
        here: |state| {
            let stop = "stop the drive at once, without confirmation";
            if state.session.replayed {
                return Meaning::explaining("nothing is driven: this is a replay");
            }
            Meaning::with(Effect::Do(Action::EmergencyStop), stop, None)
        },
    },
    KeyRow {
        presses: &[Press::control('c')],
        shown: "Ctrl-C",
        here: |state| {
            let help = match &state.drill {
                Some(_) => "leave the drill",
                None => "orderly stop, then quit",
            };
            Meaning::with(Effect::Do(Action::Interrupt), help, None)
        },
    },
    KeyRow {
        presses: &[Press::control('l')],
        shown: "Ctrl-L",
        here: |_| Meaning::with(Effect::Redraw, "draw the screen anew", None),
    },
];

/// Key of the help.
pub(crate) const HELP: &[KeyRow] = &[KeyRow {
    presses: &[Press::of('?'), Press::of('h')],
    shown: "?",
    here: |_| {
        let open = |_: &State, ui: &mut crate::state::Ui, _| {
            ui.help = true;
            None
        };
        Meaning::viewing(open, "this help; any key closes it", Some("help"))
    },
}];

/// Keys of the dashboard, the most urgent first.
pub(crate) const DASHBOARD: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::of('t')],
        shown: "t",
        here: |state| match state.new_carrier {
            Some(_) => Meaning::doing(
                Action::TakeCarrier,
                "take the proposed carrier",
                "new carrier",
            ),
            None => Meaning::explaining("no new carrier is proposed"),
        },
    },
    KeyRow {
        presses: &[Press::of('n')],
        shown: "n",
        here: |state| match state.new_carrier {
            Some(_) => Meaning::doing(
                Action::KeepCarrier,
                "keep the present carrier",
                "keep carrier",
            ),
            None => Meaning::explaining("no new carrier is proposed"),
        },
    },
    KeyRow {
        presses: &[Press::of('o')],
        shown: "o",
        here: accept_anyway,
    },
    KeyRow {
        presses: &[Press::of(' '), Press::of('s')],
        shown: "space",
        here: go_on,
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        shown: "enter",
        here: |state| match state.phase.kind {
            PhaseKind::Idle => go_on(state).map(|meaning| Meaning {
                hint: None,
                ..meaning
            }),
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::of('c')],
        shown: "c",
        here: |state| match state.phase.kind {
            PhaseKind::Consent => Meaning::asking(
                Action::Consent,
                "record the participant's consent",
                "consent",
            ),
            _ if state.in_session() => Meaning::explaining("consent is not needed now"),
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::of('x')],
        shown: "x",
        here: |state| match state.safety {
            Some(SafetyState::Tripped) if !state.session.replayed => rearm(),
            _ => Meaning::explaining("not tripped: nothing to re-arm"),
        },
    },
    KeyRow {
        presses: &[Press::of('p')],
        shown: "p",
        here: pause,
    },
    KeyRow {
        presses: &[Press::of('r')],
        shown: "r",
        here: repeat,
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Left), Press::key(KeyCode::Right)],
        shown: "← →",
        here: |state| {
            let seek = |_: &State, _: &mut crate::state::Ui, code| {
                let by_s = if code == KeyCode::Left {
                    -SEEK_S
                } else {
                    SEEK_S
                };
                Some(Action::Seek { by_s })
            };
            let help = "back or forward by five seconds";
            // The same keys have another meaning there.
            let taken = state.ui.frozen.is_some() || state.ui.page == Page::Trials;
            (state.session.replayed && !taken)
                .then(|| Meaning::viewing(seek, help, Some("seek")))?
        },
    },
    KeyRow {
        presses: &[Press::of('a')],
        shown: "a",
        here: |state| {
            if state.in_session() {
                Meaning::asking(Action::Abort, "abort the session", "abort")
            } else {
                Meaning::explaining("no session to abort")
            }
        },
    },
    KeyRow {
        presses: &[Press::of('q')],
        shown: "q",
        here: |state| {
            let help = match state.drill {
                Some(_) => "end the program; leaves the drill if not asked for",
                None => "quit",
            };
            if state.is_running() && !state.session.replayed {
                Meaning::asking(Action::Quit, help, "quit")
            } else {
                Meaning::doing(Action::Quit, help, "quit")
            }
        },
    },
];

/// Returns the meaning of the key that re-arms.
pub(crate) fn rearm() -> Option<Meaning> {
    Meaning::asking(Action::Rearm, "re-arm after a trip", "re-arm")
}

/// Returns the attempt of the present phase.
fn named(state: &State) -> AttemptName {
    let phase = &state.phase;
    AttemptName {
        trial: phase.trial,
        practice: phase.practice,
        attempt: phase.attempt,
    }
}

/// Whether an attempt runs that a pause would discard.
fn attempt_runs(state: &State) -> bool {
    let runs = matches!(
        state.phase.kind,
        PhaseKind::Baseline
            | PhaseKind::Ready
            | PhaseKind::Countdown
            | PhaseKind::Exploration
            | PhaseKind::Feedback
    );
    runs && state.phase.trial > 0 && state.in_session()
}

/// Whether the open verdict accepts its attempt.
fn is_accepted(state: &State) -> bool {
    let name = named(state);
    state.verdict.as_ref().is_some_and(|verdict| {
        (verdict.trial, verdict.practice, verdict.attempt)
            == (name.trial, name.practice, name.attempt)
            && verdict.accepted
    })
}

fn go_on(state: &State) -> Option<Meaning> {
    let tripped = state.safety == Some(SafetyState::Tripped);
    let kind = state.phase.kind;
    if state.session.replayed {
        return match kind {
            PhaseKind::Paused => Meaning::doing(Action::Resume, "go on", "go on"),
            PhaseKind::Finished => Meaning::explaining("the recording is at its end"),
            _ => Meaning::doing(Action::Pause, "pause", "pause"),
        };
    }
    if state.drill.is_some() && state.is_running() {
        return Meaning::doing(Action::Ready, "you have seen the fault", "seen");
    }
    match kind {
        _ if tripped => Meaning::explaining("tripped: remove the cause, then re-arm with x"),
        PhaseKind::Idle => Meaning::doing(Action::Start, "start", "start"),
        PhaseKind::Ready => Meaning::doing(Action::Ready, "the participant is ready", "ready"),
        PhaseKind::Rest => Meaning::doing(Action::Ready, "end the rest", "go on"),
        PhaseKind::Verdict => {
            Meaning::doing(Action::Ready, "let the verdict stand and go on", "go on")
        }
        PhaseKind::Consent => Meaning::explaining("record the consent first: c"),
        PhaseKind::Paused => Meaning::explaining("paused: resume with p"),
        PhaseKind::Finished => Meaning::explaining("the session has finished"),
        _ => Meaning::explaining("already running"),
    }
}

fn pause(state: &State) -> Option<Meaning> {
    let tripped = state.safety == Some(SafetyState::Tripped);
    match state.phase.kind {
        PhaseKind::Paused if state.session.replayed => {
            Meaning::doing(Action::Resume, "resume", "resume")
        }
        PhaseKind::Paused if tripped => {
            Meaning::explaining("tripped: remove the cause, then re-arm with x")
        }
        PhaseKind::Paused if state.display_lost.is_some() => Meaning::asking(
            Action::Resume,
            "show the participant's screen again, and resume",
            "resume",
        ),
        PhaseKind::Paused => Meaning::doing(Action::Resume, "resume", "resume"),
        PhaseKind::Idle | PhaseKind::Consent | PhaseKind::Finished => {
            Meaning::explaining("nothing to pause")
        }
        _ if attempt_runs(state) && state.phase.pausing => Meaning::asking(
            Action::PauseNow(named(state)),
            "pause at once; the running attempt is lost",
            "pause now",
        ),
        _ if attempt_runs(state) => {
            Meaning::doing(Action::Pause, "pause after this attempt", "pause")
        }
        _ => Meaning::doing(Action::Pause, "pause", "pause"),
    }
}

fn repeat(state: &State) -> Option<Meaning> {
    let redo = Action::Redo(named(state));
    if state.session.replayed {
        return None;
    }
    if state.phase.overrulable {
        // The time to overrule the verdict already serves as the question.
        let help = if is_accepted(state) {
            "repeat the trial although it is accepted"
        } else {
            "repeat the rejected trial now"
        };
        return Meaning::doing(redo, help, "repeat");
    }
    let runs = state.phase.trial > 0 && state.is_running();
    match state.phase.kind {
        PhaseKind::Paused if state.drill.is_none() => Meaning::explaining("no trial to repeat"),
        _ if runs => Meaning::asking(redo, "repeat the trial that runs", "repeat"),
        _ => Meaning::explaining("no trial to repeat"),
    }
}

fn accept_anyway(state: &State) -> Option<Meaning> {
    if !state.phase.overrulable {
        let sessions = state.in_session();
        return sessions.then(|| Meaning::explaining("no verdict to overrule"))?;
    }
    if is_accepted(state) {
        return Meaning::explaining("the trial is accepted already");
    }
    Meaning::doing(
        Action::AcceptAnyway(named(state)),
        "keep the trial although it is rejected",
        "keep anyway",
    )
}
