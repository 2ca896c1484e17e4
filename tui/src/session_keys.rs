//! Keys of the dashboard in a session, a drill, while monitoring and during a replay.

use ratatui::crossterm::event::KeyCode;

use crate::action::{Action, AttemptName};
use crate::event::{PhaseKind, SafetyView};
use crate::key_table::{Effect, KeyRow, Meaning, Press};
use crate::page::Page;
use crate::state::State;

/// Step of a replay per key press, s.
const SEEK_S: f64 = 5.0;

/// Keys that work on every page.
pub(crate) const ALL_PAGES: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::character('e')],
        label: "e",
        meaning: |state| {
            let stop = "stop the drive at once, without confirmation";
            if state.session.replayed {
                return Meaning::explanation("nothing is driven: this is a replay");
            }
            Meaning::new(Effect::Do(Action::EmergencyStop), stop, None)
        },
    },
    KeyRow {
        presses: &[Press::control('c')],
        label: "Ctrl-C",
        meaning: |state| {
            let help = match &state.drill {
                Some(_) => "leave the drill",
                None => "orderly stop, then quit",
            };
            Meaning::new(Effect::Do(Action::Interrupt), help, None)
        },
    },
    KeyRow {
        presses: &[Press::control('l')],
        label: "Ctrl-L",
        meaning: |_| Meaning::new(Effect::Redraw, "redraw the screen", None),
    },
];

/// Key of the help.
pub(crate) const HELP: &[KeyRow] = &[KeyRow {
    presses: &[Press::character('?'), Press::character('h')],
    label: "?",
    meaning: |_| {
        let open = |_: &State, ui: &mut crate::state::Ui, _| {
            ui.help = true;
            None
        };
        Meaning::view(open, "this help; any key closes it", Some("help"))
    },
}];

/// Keys of the dashboard, the most urgent first.
pub(crate) const DASHBOARD: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::character('t')],
        label: "t",
        meaning: |state| match state.new_carrier {
            Some(_) => Meaning::action(
                Action::TakeCarrier,
                "take the proposed carrier",
                "new carrier",
            ),
            None => Meaning::explanation("no new carrier is proposed"),
        },
    },
    KeyRow {
        presses: &[Press::character('n')],
        label: "n",
        meaning: |state| match state.new_carrier {
            Some(_) => Meaning::action(
                Action::KeepCarrier,
                "keep the present carrier",
                "keep carrier",
            ),
            None => Meaning::explanation("no new carrier is proposed"),
        },
    },
    KeyRow {
        presses: &[Press::character('o')],
        label: "o",
        meaning: accept_anyway,
    },
    KeyRow {
        presses: &[Press::character(' '), Press::character('s')],
        label: "space",
        meaning: go_on,
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        label: "enter",
        meaning: |state| match state.phase.kind {
            PhaseKind::Idle => go_on(state).map(|meaning| Meaning {
                hint: None,
                ..meaning
            }),
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::character('c')],
        label: "c",
        meaning: |state| match state.phase.kind {
            PhaseKind::Consent => Meaning::question(
                Action::Consent,
                "record the participant's consent",
                "consent",
            ),
            _ if state.in_session() => {
                Meaning::explanation("consent is recorded in a step of its own")
            }
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::character('x')],
        label: "x",
        meaning: |state| match state.safety {
            Some(SafetyView::Tripped) if !state.session.replayed => match state.phase.kind {
                PhaseKind::Finished => Meaning::explanation(ENDED),
                _ => rearm(state),
            },
            _ => Meaning::explanation("not tripped: nothing to re-arm"),
        },
    },
    KeyRow {
        presses: &[Press::character('p')],
        label: "p",
        meaning: pause,
    },
    KeyRow {
        presses: &[Press::character('r')],
        label: "r",
        meaning: repeat,
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Left), Press::key(KeyCode::Right)],
        label: "← →",
        meaning: |state| {
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
            let arrows_in_use = state.ui.frozen.is_some() || state.ui.page == Page::Trials;
            (state.session.replayed && !arrows_in_use)
                .then(|| Meaning::view(seek, help, Some("seek")))?
        },
    },
    KeyRow {
        presses: &[Press::character('a')],
        label: "a",
        meaning: |state| {
            if state.in_session() {
                Meaning::question(Action::Abort, "abort the session", "abort")
            } else {
                Meaning::explanation("no session to abort")
            }
        },
    },
    KeyRow {
        presses: &[Press::character('q')],
        label: "q",
        meaning: |state| {
            let help = match state.drill {
                Some(_) => "quit; leaves the drill unless the drill requests it",
                None => "quit",
            };
            let has_ended = state.phase.kind == PhaseKind::Finished;
            if (state.is_running() || has_ended) && !state.session.replayed {
                Meaning::question(Action::Quit, help, "quit")
            } else {
                Meaning::action(Action::Quit, help, "quit")
            }
        },
    },
];

/// Explanation after a session: nothing drives the plate any more.
const ENDED: &str = "the session has finished, and the drive stays off: q quits";

/// Explanation while a device is lost: the program does not open it again.
const LOST: &str = "device lost: q, y ends; plug it in, then start again (`run` with --resume)";

/// Returns the explanation of a key that the stop of the drive disables.
fn tripped(state: &State) -> Option<Meaning> {
    if state.is_device_lost() {
        return Meaning::explanation(LOST);
    }
    Meaning::explanation("tripped: remove the cause, then re-arm with x")
}

/// Returns the meaning of the key that re-arms.
pub(crate) fn rearm(state: &State) -> Option<Meaning> {
    if state.is_device_lost() {
        return Meaning::explanation(LOST);
    }
    Meaning::question(Action::Rearm, "re-arm after a trip", "re-arm")
}

/// Returns the attempt of the present phase.
fn attempt_name(state: &State) -> AttemptName {
    state.phase.name()
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
    let name = attempt_name(state);
    let verdict = state.verdict.as_ref();
    verdict.is_some_and(|verdict| verdict.name() == name && verdict.accepted)
}

fn go_on(state: &State) -> Option<Meaning> {
    let is_tripped = state.safety == Some(SafetyView::Tripped);
    let kind = state.phase.kind;
    if state.session.replayed {
        return match kind {
            PhaseKind::Paused => Meaning::action(Action::Resume, "go on", "go on"),
            PhaseKind::Finished => Meaning::explanation("the recording has ended"),
            _ => Meaning::action(Action::Pause, "pause", "pause"),
        };
    }
    if state.drill.is_some() && state.is_running() {
        return Meaning::action(
            Action::Ready,
            "confirm that you have seen the fault",
            "seen",
        );
    }
    match kind {
        PhaseKind::Finished => Meaning::explanation(ENDED),
        _ if is_tripped => tripped(state),
        PhaseKind::Idle => Meaning::action(Action::Start, "start", "start"),
        PhaseKind::Ready => Meaning::action(Action::Ready, "the participant is ready", "ready"),
        PhaseKind::Rest => Meaning::action(Action::Ready, "end the rest", "go on"),
        PhaseKind::Verdict => {
            Meaning::action(Action::Ready, "accept the verdict and go on", "go on")
        }
        PhaseKind::Consent => Meaning::explanation("record the consent first: c"),
        PhaseKind::Paused => Meaning::explanation("paused: resume with p"),
        _ => Meaning::explanation("already running"),
    }
}

fn pause(state: &State) -> Option<Meaning> {
    let is_tripped = state.safety == Some(SafetyView::Tripped);
    match state.phase.kind {
        PhaseKind::Paused if state.session.replayed => {
            Meaning::action(Action::Resume, "resume", "resume")
        }
        PhaseKind::Paused if is_tripped => tripped(state),
        PhaseKind::Paused if state.display_lost.is_some() => Meaning::question(
            Action::Resume,
            "show the participant's screen again, and resume",
            "resume",
        ),
        PhaseKind::Paused => Meaning::action(Action::Resume, "resume", "resume"),
        PhaseKind::Idle | PhaseKind::Consent | PhaseKind::Finished => {
            Meaning::explanation("nothing to pause")
        }
        _ if attempt_runs(state) && state.phase.pausing => Meaning::question(
            Action::PauseNow(attempt_name(state)),
            "pause at once; the running attempt is lost",
            "pause now",
        ),
        _ if attempt_runs(state) => {
            Meaning::action(Action::Pause, "pause after this attempt", "pause")
        }
        _ => Meaning::action(Action::Pause, "pause", "pause"),
    }
}

fn repeat(state: &State) -> Option<Meaning> {
    let redo = Action::Redo(attempt_name(state));
    if state.session.replayed {
        return None;
    }
    if state.phase.overrulable {
        // The time to overrule the verdict already serves as the question.
        let help = if is_accepted(state) {
            "repeat the accepted trial"
        } else {
            "repeat the rejected trial now"
        };
        return Meaning::action(redo, help, "repeat");
    }
    let runs = state.phase.trial > 0 && state.is_running();
    match state.phase.kind {
        PhaseKind::Paused if state.drill.is_none() => Meaning::explanation("no trial to repeat"),
        _ if runs => Meaning::question(redo, "repeat the running trial", "repeat"),
        _ => Meaning::explanation("no trial to repeat"),
    }
}

fn accept_anyway(state: &State) -> Option<Meaning> {
    if !state.phase.overrulable {
        let sessions = state.in_session();
        return sessions.then(|| Meaning::explanation("no verdict to overrule"))?;
    }
    if is_accepted(state) {
        return Meaning::explanation("the trial is accepted already");
    }
    if state.phase.practice {
        return Meaning::explanation("a practice is not counted: nothing to keep");
    }
    Meaning::action(
        Action::AcceptAnyway(attempt_name(state)),
        "keep the rejected trial",
        "keep anyway",
    )
}
