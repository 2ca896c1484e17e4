//! The help lists exactly the keys that work.

use ratatui::crossterm::event::{KeyEvent, KeyModifiers};

use super::*;
use crate::calibration_page::{CalibrationPage, PointLine, Question};
use crate::event::{AskedDetail, Event, PhaseKind, PhaseView, SafetyView, SessionHeader};
use crate::page::Page;
use drawing::theme::Theme;

/// Returns every key press that the table could contain.
fn presses() -> impl Iterator<Item = Press> {
    let letters = ('a'..='z').chain('0'..='9').chain(" .,-+=?/;[]".chars());
    let named_keys = [
        KeyCode::Enter,
        KeyCode::Tab,
        KeyCode::Backspace,
        KeyCode::Esc,
        KeyCode::Up,
        KeyCode::Down,
        KeyCode::Left,
        KeyCode::Right,
    ];
    let controls = ('a'..='z').map(Press::control);
    let plain = letters
        .map(Press::character)
        .chain(named_keys.map(Press::key));
    plain.chain(controls)
}

fn states() -> Vec<State> {
    let mut states = Vec::new();
    let kinds = [
        PhaseKind::Idle,
        PhaseKind::Consent,
        PhaseKind::Baseline,
        PhaseKind::Exploration,
        PhaseKind::Verdict,
        PhaseKind::Rest,
        PhaseKind::Paused,
        PhaseKind::Monitoring,
        PhaseKind::Finished,
    ];
    let (mut trial, mut flag) = (0, false);
    for kind in kinds {
        for safety in [SafetyView::Disarmed, SafetyView::Tripped] {
            for replayed in [false, true] {
                (trial, flag) = (2 - trial, !flag);
                let mut state = State::new(Theme::Mono);
                state.apply(&Event::Session(SessionHeader {
                    participant: (!replayed).then(|| "sub-01".to_owned()),
                    replayed,
                    ..SessionHeader::default()
                }));
                state.apply(&Event::Phase(PhaseView {
                    trial,
                    pausing: flag,
                    overrulable: kind == PhaseKind::Verdict,
                    ..PhaseView::new(kind)
                }));
                state.apply(&Event::Safety {
                    state: safety,
                    reason: None,
                });
                if flag {
                    state.apply(&Event::ParticipantDisplay {
                        lost: Some("terminal: gone".to_owned()),
                    });
                }
                states.push(state);
            }
        }
    }
    let mut question = State::new(Theme::Mono);
    question.apply(&Event::Asked {
        detail: Some(AskedDetail::default()),
    });
    states.push(question);
    let questions = [
        None,
        Some(Question::Done),
        Some(Question::Review),
        Some(Question::Number {
            unit: "V".to_owned(),
            expected: None,
            optional: true,
        }),
    ];
    for question in questions {
        for failed in [false, true] {
            let mut state = State::new(Theme::Mono);
            state.apply(&Event::Calibration(CalibrationPage {
                asked: question.clone().filter(|_| !failed),
                failed,
                points: vec![PointLine::default(); 3],
                ..CalibrationPage::default()
            }));
            for page in [Page::Run, Page::Bench, Page::Log] {
                state.ui.page = page;
                states.push(state.clone());
            }
        }
    }
    states
}

#[test]
fn the_help_lists_each_key_that_works_and_no_other() {
    for state in states() {
        let listed: Vec<Press> = active_rows(&state)
            .flat_map(|(row, _)| row.presses.iter().copied())
            .collect();
        for press in presses() {
            let modifiers = if press.control {
                KeyModifiers::CONTROL
            } else {
                KeyModifiers::NONE
            };
            let mut reaction = key(&state, KeyEvent::new(press.code, modifiers));
            let note = reaction.ui.note.take();
            let has_effect =
                reaction.action.is_some() || reaction.redraw || reaction.ui != state.ui;
            let is_listed = listed.contains(&press);
            let kind = state.phase.kind;
            assert!(
                !has_effect || is_listed,
                "{press:?} works and is not listed: {kind:?}"
            );
            // A key without effect at the end of its range still works, like the key of the shown page.
            let may_do_nothing = matches!(
                press.code,
                KeyCode::Up
                    | KeyCode::Down
                    | KeyCode::Backspace
                    | KeyCode::Enter
                    | KeyCode::Char('1' | '4' | '5' | 'j' | 'k')
            );
            assert!(
                has_effect || !is_listed || may_do_nothing,
                "{press:?} is listed and does nothing ({note:?}): {kind:?}"
            );
        }
        for (row, meaning) in active_rows(&state) {
            assert!(!meaning.help.is_empty(), "{} has no words", row.label);
        }
    }
}

#[test]
fn every_page_can_be_written() {
    let press = KeyEvent::new(KeyCode::Char('w'), KeyModifiers::NONE);
    for state in states() {
        assert!(key(&state, press).ui.write, "{:?}", state.calibration);
    }
}

/// A letter has one meaning: a second row in the table would never be reached.
#[test]
fn no_two_rows_of_a_page_share_a_key() {
    for page in [
        DASHBOARD,
        CALIBRATION,
        CALIBRATION_PAGES,
        ANSWER,
        VIEW,
        SCROLL,
        PAGES,
    ] {
        let page_presses: Vec<Press> = ALL_PAGES
            .iter()
            .chain(HELP)
            .chain(WRITE)
            .chain(page)
            .flat_map(|row| row.presses.iter().copied())
            .collect();
        for (i, press) in page_presses.iter().enumerate() {
            assert!(!page_presses[..i].contains(press), "{press:?} twice");
        }
    }
}

/// Fault 49.
#[test]
fn a_key_that_acts_at_once_means_the_same_on_every_screen() {
    let stop = KeyEvent::new(KeyCode::Char('e'), KeyModifiers::NONE);
    let end = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(at_once(stop), Some(Action::EmergencyStop));
    assert_eq!(at_once(end), Some(Action::Interrupt));
    for state in states().into_iter().filter(|state| !state.session.replayed) {
        for press in ALL_PAGES.iter().flat_map(|row| row.presses) {
            let modifiers = match press.control {
                true => KeyModifiers::CONTROL,
                false => KeyModifiers::NONE,
            };
            let event = KeyEvent::new(press.code, modifiers);
            assert_eq!(at_once(event), key(&state, event).action, "{press:?}");
        }
    }
}
