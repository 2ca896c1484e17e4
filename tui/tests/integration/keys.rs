//! The effect of each key in each phase.

use crate::rig::{draw, key_event, press};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use tui::action::AttemptName;
use tui::calibration_page::Reply;
use tui::event::{
    AskedDetail, CarrierProposal, Event, PhaseKind, PhaseView, SafetyView, SessionHeader,
    TrialVerdict, ValueAndStd,
};
use tui::{Action, Page, State, Theme, Window, key};

const PHASES: [PhaseKind; 12] = [
    PhaseKind::Idle,
    PhaseKind::Consent,
    PhaseKind::Baseline,
    PhaseKind::Ready,
    PhaseKind::Countdown,
    PhaseKind::Exploration,
    PhaseKind::Feedback,
    PhaseKind::Verdict,
    PhaseKind::Rest,
    PhaseKind::Paused,
    PhaseKind::Monitoring,
    PhaseKind::Finished,
];

fn state(kind: PhaseKind, safety: SafetyView, trial: u32) -> State {
    let mut state = State::new(Theme::Colour);
    state.apply(&Event::Phase(PhaseView {
        trial,
        ..PhaseView::new(kind)
    }));
    state.apply(&Event::Safety {
        state: safety,
        reason: None,
    });
    state
}

/// Returns the attempt of the states here.
fn second() -> AttemptName {
    AttemptName {
        trial: 2,
        practice: false,
        attempt: 1,
    }
}

#[test]
fn a_question_about_the_participant_takes_digits_and_leaves_the_rest_to_the_dashboard() {
    let mut state = state(PhaseKind::Consent, SafetyView::Disarmed, 0);
    let question = |has_previous| Event::Asked {
        detail: Some(AskedDetail {
            has_previous,
            ..AskedDetail::default()
        }),
    };
    state.apply(&question(false));
    let answer = |reply| Some(Action::Answer(reply));
    let tap = |state: &mut State, code| {
        let reaction = key(state, key_event(code));
        state.ui = reaction.ui;
        reaction.action
    };
    assert_eq!(press(&mut state, "3x15"), []);
    assert_eq!(state.ui.typed, "315");
    assert_eq!(press(&mut state, "99"), []);
    tap(&mut state, KeyCode::Backspace);
    tap(&mut state, KeyCode::Backspace);
    assert_eq!(tap(&mut state, KeyCode::Enter), answer(Reply::Number(3.0)));
    assert_eq!(tap(&mut state, KeyCode::Enter), answer(Reply::Ready));
    assert_eq!(tap(&mut state, KeyCode::Up), None);
    assert!(
        state.ui.note.is_some(),
        "the first question has none before"
    );
    state.apply(&question(true));
    assert_eq!(press(&mut state, "4"), []);
    assert_eq!(tap(&mut state, KeyCode::Up), answer(Reply::Redo(0)));
    assert_eq!(state.ui.typed, "");
    // No session or trial can begin meanwhile; the session can still be stopped or ended.
    assert_eq!(press(&mut state, " sc"), []);
    assert!(state.ui.note.is_some());
    assert_eq!(press(&mut state, "e"), [Action::EmergencyStop]);
    assert_eq!(press(&mut state, "ay"), [Action::Abort]);
    state.apply(&Event::Asked { detail: None });
    assert_eq!(press(&mut state, "cy"), [Action::Consent]);
}

#[test]
fn a_new_carrier_is_taken_or_kept_while_it_is_proposed() {
    let mut state = state(PhaseKind::Feedback, SafetyView::Armed, 1);
    assert_eq!(press(&mut state, "tn"), []);
    assert!(state.ui.note.is_some());
    let proposal = CarrierProposal {
        from_hz: 35_000.0,
        to_hz: 35_004.0,
        drift_hz: ValueAndStd {
            value: 4.1,
            std: 0.3,
        },
    };
    state.apply(&Event::NewCarrier {
        proposal: Some(proposal),
    });
    assert_eq!(press(&mut state, "T"), [Action::TakeCarrier]);
    assert_eq!(press(&mut state, "n"), [Action::KeepCarrier]);
    // The stop key acts at once.
    assert_eq!(press(&mut state, "e"), [Action::EmergencyStop]);
    // The keys of the view send no request.
    assert_eq!(press(&mut state, "fjkzw12345"), []);
    state.apply(&Event::NewCarrier { proposal: None });
    assert_eq!(press(&mut state, "tn"), []);
}

#[test]
fn keys_by_phase() {
    use Action::{Abort, Consent, Pause, Quit, Ready, Resume, Start};
    let redo = &[Action::Redo(second())];
    use PhaseKind as P;
    let table: &[(P, &str, &[Action])] = &[
        (P::Idle, " ", &[Start]),
        (P::Idle, "s", &[Start]),
        (P::Idle, "S", &[Start]),
        (P::Idle, "p", &[]),
        (P::Idle, "ry", &[]),
        (P::Idle, "ay", &[]),
        (P::Idle, "q", &[Quit]),
        (P::Consent, " ", &[]),
        (P::Consent, "c", &[]),
        (P::Consent, "cy", &[Consent]),
        (P::Consent, "cn", &[]),
        (P::Consent, "cny", &[]),
        (P::Ready, " ", &[Ready]),
        (P::Ready, "cy", &[]),
        (P::Rest, "s", &[Ready]),
        (P::Exploration, " ", &[]),
        (P::Exploration, "p", &[Pause]),
        (P::Exploration, "r", &[]),
        (P::Exploration, "ry", redo),
        (P::Exploration, "r ", &[]),
        (P::Exploration, "ay", &[Abort]),
        (P::Exploration, "q", &[]),
        (P::Exploration, "qy", &[Quit]),
        (P::Paused, "p", &[Resume]),
        (P::Paused, " ", &[]),
        (P::Paused, "ry", &[]),
        (P::Monitoring, "p", &[Pause]),
        (P::Idle, "o", &[]),
        (P::Exploration, "o", &[]),
        (P::Finished, " ", &[]),
        (P::Finished, "ry", &[]),
        (P::Finished, "q", &[]),
        (P::Finished, "qy", &[Quit]),
    ];
    for (kind, keys, expected) in table {
        let mut state = state(*kind, SafetyView::Armed, 2);
        assert_eq!(press(&mut state, keys), *expected, "{kind:?} {keys:?}");
    }
}

#[test]
fn redo_needs_a_trial() {
    let mut state = state(PhaseKind::Baseline, SafetyView::Driving, 0);
    assert_eq!(press(&mut state, "ry"), []);
    assert_eq!(state.ui.confirm, None);
}

#[test]
fn nothing_starts_while_tripped_and_only_then_is_there_something_to_rearm() {
    for kind in PHASES {
        let mut tripped = state(kind, SafetyView::Tripped, 2);
        let actions = press(&mut tripped, " s");
        assert_eq!(actions, [], "{kind:?}");
        // After the end nothing drives the plate again.
        let rearms: &[Action] = match kind {
            PhaseKind::Finished => &[],
            _ => &[Action::Rearm],
        };
        assert_eq!(press(&mut tripped, "xy"), *rearms, "{kind:?}");
        let actions = press(&mut state(PhaseKind::Paused, SafetyView::Tripped, 2), "p");
        assert_eq!(actions, []);
        assert_eq!(press(&mut state(kind, SafetyView::Armed, 2), "xy"), []);
    }
}

#[test]
fn the_emergency_stop_works_everywhere_at_once() {
    for kind in PHASES {
        for opening in ["", "?", "a", "x", "c", "q"] {
            for stop in ["e", "E"] {
                let mut state = state(kind, SafetyView::Driving, 2);
                press(&mut state, opening);
                let actions = press(&mut state, stop);
                assert_eq!(actions, [Action::EmergencyStop], "{kind:?} {opening:?}");
                assert_eq!(state.ui.confirm, None, "a stop answers no question");
            }
        }
    }
}

#[test]
fn control_c_interrupts_and_other_chords_do_nothing() {
    for kind in PHASES {
        let mut state = state(kind, SafetyView::Driving, 2);
        press(&mut state, "a");
        let chord = |code| {
            key(
                &state,
                KeyEvent::new(KeyCode::Char(code), KeyModifiers::CONTROL),
            )
            .action
        };
        assert_eq!(chord('c'), Some(Action::Interrupt), "{kind:?}");
        assert_eq!(chord('s'), None);
        assert_eq!(chord('y'), None);
    }
}

#[test]
fn escape_closes_only_the_topmost_layer() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    for opening in ["", "?", "a"] {
        press(&mut state, opening);
        let reaction = key(&state, key_event(KeyCode::Esc));
        assert_eq!(reaction.action, None);
        assert!(!reaction.ui.help);
        assert_eq!(reaction.ui.confirm, None);
        state.ui = reaction.ui;
    }
}

#[test]
fn a_key_without_effect_says_why_until_the_next_one() {
    let mut state = state(PhaseKind::Idle, SafetyView::Armed, 0);
    press(&mut state, "p");
    assert!(state.ui.note.is_some());
    press(&mut state, "+");
    assert_eq!(state.ui.note, None);
}

#[test]
fn the_view_is_the_operators() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    state.ui = key(&state, key_event(KeyCode::Tab)).ui;
    assert_eq!(state.ui.page, Page::Participant);
    state.ui = key(&state, key_event(KeyCode::Tab)).ui;
    assert_eq!(state.ui.page, Page::Run);
    press(&mut state, "----");
    assert_eq!(state.ui.window, Window::Ten);
    press(&mut state, "++++");
    assert_eq!(state.ui.window, Window::One);
}

#[test]
fn a_drill_takes_the_keys_of_a_session_and_says_seen_with_space() {
    use Action::{EmergencyStop, Pause, Quit, Ready, Rearm, Redo, Resume};
    let first = AttemptName {
        trial: 1,
        ..second()
    };
    for (kind, safety, keys, expected) in [
        (
            PhaseKind::Monitoring,
            SafetyView::Driving,
            " ",
            &[Ready][..],
        ),
        (PhaseKind::Monitoring, SafetyView::Tripped, " ", &[Ready]),
        (PhaseKind::Monitoring, SafetyView::Tripped, "xy", &[Rearm]),
        (PhaseKind::Monitoring, SafetyView::Tripped, "xn", &[]),
        (PhaseKind::Monitoring, SafetyView::Driving, "x", &[]),
        (PhaseKind::Monitoring, SafetyView::Driving, "p", &[Pause]),
        (PhaseKind::Paused, SafetyView::Disarmed, "p", &[Resume]),
        (
            PhaseKind::Monitoring,
            SafetyView::Driving,
            "ry",
            &[Redo(first)],
        ),
        (PhaseKind::Monitoring, SafetyView::Tripped, "qy", &[Quit]),
        (PhaseKind::Monitoring, SafetyView::Tripped, "ay", &[]),
        (
            PhaseKind::Monitoring,
            SafetyView::Driving,
            "e",
            &[EmergencyStop],
        ),
        (PhaseKind::Finished, SafetyView::Disarmed, "qy", &[Quit]),
    ] {
        let mut state = state(kind, safety, 1);
        state.apply(&Event::Drill(tui::drill_view::DrillView::default()));
        assert_eq!(
            press(&mut state, keys),
            expected,
            "{kind:?} {safety:?} {keys:?}"
        );
    }
}

#[test]
fn an_open_verdict_is_overruled_both_ways_without_a_question_while_its_time_runs() {
    for (accepted, keys, expected) in [
        (true, "r", &[Action::Redo(second())][..]),
        (true, "o", &[]),
        (false, "r", &[Action::Redo(second())]),
        (false, "o", &[Action::AcceptAnyway(second())]),
        (false, " ", &[Action::Ready]),
    ] {
        for kind in [PhaseKind::Verdict, PhaseKind::Paused] {
            let mut state = state(kind, SafetyView::Armed, 2);
            state.phase.overrulable = true;
            state.apply(&Event::Verdict(TrialVerdict {
                trial: 2,
                attempt: 1,
                accepted,
                ..TrialVerdict::default()
            }));
            let expected = if kind == PhaseKind::Paused && keys == " " {
                &[]
            } else {
                expected
            };
            assert_eq!(
                press(&mut state, keys),
                expected,
                "{kind:?} {accepted} {keys:?}"
            );
            assert_eq!(state.ui.confirm, None);
        }
    }
}

/// The question belongs to the trial in which it was asked.
#[test]
fn a_question_about_a_trial_ends_with_it() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    press(&mut state, "r");
    state.apply(&Event::Phase(PhaseView {
        trial: 3,
        ..PhaseView::new(PhaseKind::Baseline)
    }));
    assert_eq!(press(&mut state, "y"), []);
}

#[test]
fn a_pause_waits_and_throws_nothing_away_before_it_is_confirmed() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    assert_eq!(press(&mut state, "p"), [Action::Pause]);
    state.phase.pausing = true;
    assert_eq!(press(&mut state, "p"), []);
    assert_eq!(press(&mut state, "n"), []);
    assert_eq!(press(&mut state, "py"), [Action::PauseNow(second())]);
}

/// The name may belong to another window by now.
#[test]
fn a_lost_terminal_is_opened_again_only_when_confirmed() {
    let mut state = state(PhaseKind::Paused, SafetyView::Armed, 0);
    state.apply(&Event::ParticipantDisplay {
        lost: Some("participant's terminal /dev/pts/7: it has gone".to_owned()),
    });
    assert_eq!(press(&mut state, "p"), []);
    assert_eq!(press(&mut state, "y"), [Action::Resume]);
    state.apply(&Event::ParticipantDisplay { lost: None });
    assert_eq!(press(&mut state, "p"), [Action::Resume]);
}

#[test]
fn a_replay_takes_the_keys_of_a_player_and_asks_nothing() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Disarmed, 0);
    state.apply(&Event::Session(SessionHeader {
        replayed: true,
        ..SessionHeader::default()
    }));
    assert_eq!(press(&mut state, "e"), []);
    assert_eq!(press(&mut state, "xrac"), []);
    assert_eq!(state.ui.confirm, None);
    assert_eq!(
        press(&mut state, "p q"),
        [Action::Pause, Action::Pause, Action::Quit]
    );
    for (code, by_s) in [(KeyCode::Left, -5.0), (KeyCode::Right, 5.0)] {
        let action = key(&state, key_event(code)).action;
        assert_eq!(action, Some(Action::Seek { by_s }));
    }
}

#[test]
fn control_l_redraws_everything() {
    let state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    let control_l = KeyEvent::new(KeyCode::Char('l'), KeyModifiers::CONTROL);
    let reaction = key(&state, control_l);
    assert!(reaction.redraw);
    assert_eq!((reaction.action, reaction.ui), (None, state.ui));
}

fn tap(state: &mut State, code: KeyCode) {
    state.ui = key(state, key_event(code)).ui;
}

#[test]
fn digits_turn_pages_unless_a_number_is_asked_for() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    for (digit, page) in [
        ("2", Page::Impedance),
        ("3", Page::Trials),
        ("4", Page::Bench),
        ("5", Page::Log),
        ("1", Page::Run),
    ] {
        press(&mut state, digit);
        assert_eq!(state.ui.page, page);
    }
    state.apply(&Event::Asked {
        detail: Some(AskedDetail::default()),
    });
    press(&mut state, "4");
    assert_eq!(state.ui.page, Page::Run);
}

#[test]
fn held_strips_stay_while_values_come_and_have_two_cursors() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    press(&mut state, "f");
    assert!(state.ui.frozen.is_none() && state.ui.note.is_some());
    let live = |t_s| {
        Event::Live(tui::event::Live {
            t_s,
            ..Default::default()
        })
    };
    (0..100).for_each(|i| state.apply(&live(f64::from(i) * 0.1)));
    press(&mut state, "f");
    let history = state.shown_history().clone();
    (100..300).for_each(|i| state.apply(&live(f64::from(i) * 0.1)));
    assert_eq!(state.shown_history(), &history);
    // On each of the five strips, also where their cursors have no room.
    for columns in [80, 120, 200] {
        let screen = draw(&state, columns, 24).backend().to_string();
        assert_eq!(screen.matches("HELD").count(), 5, "{screen}");
    }
    let cursors = state.ui.frozen.as_ref().unwrap().cursors;
    tap(&mut state, KeyCode::Left);
    press(&mut state, "]");
    let [a, b] = state.ui.frozen.as_ref().unwrap().cursors;
    assert!(a < cursors[0] && b > cursors[1]);
    (0..200).for_each(|_| tap(&mut state, KeyCode::Left));
    assert!(state.ui.frozen.as_ref().unwrap().cursors[0].abs() < 1e-9);
    press(&mut state, "f");
    assert_ne!(state.shown_history(), &history);
}

#[test]
fn arrows_choose_a_trial_and_follow_the_newest_after_the_last() {
    let mut state = State::new(Theme::Colour);
    for trial in 1..=3 {
        state.apply(&Event::Phase(PhaseView {
            trial,
            ..PhaseView::new(PhaseKind::Exploration)
        }));
    }
    press(&mut state, "3");
    let chosen_number = |state: &State| state.chosen_trial().unwrap().trial;
    assert_eq!(chosen_number(&state), 3);
    for _ in 0..5 {
        tap(&mut state, KeyCode::Left);
    }
    assert_eq!(chosen_number(&state), 1);
    tap(&mut state, KeyCode::Right);
    assert_eq!(chosen_number(&state), 2);
    tap(&mut state, KeyCode::Right);
    assert_eq!((chosen_number(&state), state.ui.trial), (3, None));
}

#[test]
fn panels_are_enlarged_one_after_the_other() {
    let mut state = state(PhaseKind::Exploration, SafetyView::Driving, 2);
    let panels = Page::Run.panels();
    for panel in (1..=panels).chain([0]) {
        press(&mut state, "z");
        assert_eq!(state.ui.zoom, panel);
    }
    press(&mut state, "z3");
    assert_eq!(state.ui.zoom, 0, "another page is whole");
}

#[test]
fn a_remark_goes_with_its_phase_and_after_seconds() {
    let mut state = state(PhaseKind::Feedback, SafetyView::Armed, 1);
    let remark = |state: &mut State| {
        assert_eq!(press(state, "t"), []);
        assert!(state.ui.note.is_some());
    };
    remark(&mut state);
    for now_s in [1.0, 4.0, 8.9] {
        state.apply(&Event::Tick { now_s });
        assert!(state.ui.note.is_some(), "{now_s}");
    }
    state.apply(&Event::Tick { now_s: 9.1 });
    assert_eq!(state.ui.note, None);
    remark(&mut state);
    state.apply(&Event::Phase(PhaseView::new(PhaseKind::Verdict)));
    assert_eq!(state.ui.note, None);
}
