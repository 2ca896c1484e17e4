//! Every page in every kind of state at the three sizes of its layouts, and any events at any size.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use crate::rig::{draw, key_event, play_until};
use crate::synthetic;
use proptest::prelude::*;
use ratatui::crossterm::event::KeyCode;
use tui::event::{BenchLine, LineStates, Live, PhaseKind, SafetyView, TrialVerdict, ValueAndStd};
use tui::{Event, Page, State, Theme, key};

const PAGES: [(Page, &str); 5] = [
    (Page::Run, "run"),
    (Page::Impedance, "impedance"),
    (Page::Trials, "trials"),
    (Page::Bench, "bench"),
    (Page::Log, "log"),
];
const SIZES: [(u16, u16); 3] = [(80, 24), (120, 40), (200, 60)];

/// Returns the second exploration of a trial that was rejected once.
fn normal() -> State {
    play_until(|state| {
        let phase = &state.phase;
        (phase.trial, phase.attempt, phase.exploration) == (2, 2, 2)
            && phase.kind == PhaseKind::Exploration
            && state.live().and_then(|live| live.slider_m) > Some(0.06)
    })
}

fn states() -> Vec<(&'static str, State)> {
    let mut stale = normal();
    stale.apply(&Event::Tick {
        now_s: stale.now_s + 3.2,
    });
    let mut fault = normal();
    synthetic::trip()
        .iter()
        .for_each(|event| fault.apply(event));
    let mut stop = normal();
    stop.apply(&Event::Safety {
        state: SafetyView::Tripped,
        reason: Some("emergency stop pressed".to_owned()),
    });
    let mut health = stop.health.unwrap();
    health.lines.estop_open = Some(true);
    stop.apply(&Event::Health(health));
    let mut uncalibrated = normal();
    uncalibrated.session.uncalibrated = true;
    uncalibrated.session.calibration_label = None;
    let mut facts = uncalibrated.bench.take().unwrap();
    for fact in &mut facts.calibrations {
        fact.date = None;
    }
    uncalibrated.bench = Some(facts);
    let mut finished = play_until(|state| state.phase.kind == PhaseKind::Rest);
    synthetic::finish()
        .iter()
        .for_each(|event| finished.apply(event));
    vec![
        ("normal", normal()),
        ("empty", State::new(Theme::Colour)),
        ("stale", stale),
        ("fault", fault),
        ("uncalibrated", uncalibrated),
        ("estop", stop),
        ("finished", finished),
    ]
}

fn lines(state: &State, columns: u16, rows: u16) -> String {
    let screen = draw(state, columns, rows);
    tui::picture::text(screen.backend().buffer())
}

#[test]
fn every_page_in_every_state_at_three_sizes() {
    for (state_name, mut state) in states() {
        for (page, page_name) in PAGES {
            state.ui.page = page;
            for (columns, rows) in SIZES {
                let name = format!("{page_name}_{state_name}_{columns}x{rows}");
                insta::assert_snapshot!(name, lines(&state, columns, rows));
            }
        }
    }
}

#[test]
fn a_stop_is_to_be_re_armed_first_until_it_is() {
    let mut state = normal();
    synthetic::trip()
        .iter()
        .for_each(|event| state.apply(event));
    let first = |state: &State| lines(state, 120, 40).contains("find the cause, then x re-arms");
    assert!(first(&state));
    state.apply(&Event::Safety {
        state: SafetyView::Disarmed,
        reason: None,
    });
    assert!(!first(&state));
}

#[test]
fn an_attempt_that_was_broken_off_is_neither_accepted_nor_rejected() {
    let verdict = |attempt: u32, interrupted: bool| {
        Event::Verdict(TrialVerdict {
            trial: 7,
            attempt,
            interrupted,
            settled: interrupted.then(|| "paused by the operator".to_owned()),
            ..TrialVerdict::default()
        })
    };
    let mut state = State::new(Theme::Mono);
    state.ui.page = Page::Trials;
    state.apply(&verdict(1, true));
    assert_eq!(state.verdict, None, "there is nothing to overrule");
    let screen = lines(&state, 120, 40);
    assert!(screen.contains("– paused by the operator"), "{screen}");
    assert!(
        screen.contains("0 accepted") && !screen.contains("rejected"),
        "{screen}"
    );
    state.apply(&verdict(2, false));
    let screen = lines(&state, 120, 40);
    assert!(screen.contains("0 accepted, 1 rejected"), "{screen}");
}

#[test]
fn a_panel_is_enlarged_and_held_strips_have_their_values() {
    let mut state = normal();
    let press = |state: &mut State, code| {
        state.ui = key(state, key_event(code)).ui;
    };
    for _ in 0..4 {
        press(&mut state, KeyCode::Char('z'));
    }
    press(&mut state, KeyCode::Char('f'));
    insta::assert_snapshot!("enlarged_held_120x40", lines(&state, 120, 40));
}

#[test]
fn an_estimate_that_is_missing_says_why() {
    let mut state = normal();
    let last_s = state.live().unwrap().t_s;
    for i in 1..100 {
        state.apply(&Event::Live(Live {
            t_s: last_s + f64::from(i) * 0.01,
            no_estimate: Some(tui::event::NoEstimate::NoFit),
            ..Live::default()
        }));
    }
    assert!(lines(&state, 120, 40).contains("after the first fit"));
}

#[test]
fn without_utf8_the_screen_is_ascii() {
    for (name, mut state) in states() {
        state.ui.ascii = true;
        for (page, _) in PAGES {
            state.ui.page = page;
            for (columns, rows) in SIZES {
                let screen = lines(&state, columns, rows);
                assert!(screen.is_ascii(), "{name} {page:?}");
                assert!(
                    !screen.contains('?') || screen.contains("? help"),
                    "{name} {page:?}"
                );
            }
        }
    }
}

#[test]
fn one_sign_for_mu_and_one_for_minus() {
    for (name, mut state) in states() {
        for (page, _) in PAGES {
            state.ui.page = page;
            let screen = lines(&state, 200, 60);
            assert!(!screen.contains('\u{b5}'), "{name} {page:?}");
            // A hyphen before a digit would be a wrong minus sign; dates and names have hyphens within a word.
            let hyphens = screen.split_whitespace().filter(|word| {
                word.starts_with('-') && word[1..].starts_with(|c: char| c.is_ascii_digit())
            });
            assert_eq!(hyphens.count(), 0, "{name} {page:?}");
        }
    }
}

fn value() -> impl Strategy<Value = Option<f64>> {
    prop_oneof![
        2 => Just(None),
        1 => Just(Some(f64::NAN)),
        1 => Just(Some(f64::MAX)),
        1 => Just(Some(-f64::MAX)),
        1 => Just(Some(0.0)),
        4 => (-1e-5..1e3f64).prop_map(Some),
    ]
}

fn estimate() -> impl Strategy<Value = Option<ValueAndStd>> {
    (value(), value()).prop_map(|(value, std)| {
        Some(ValueAndStd {
            value: value?,
            std: std?,
        })
    })
}

fn event() -> impl Strategy<Value = Event> {
    let made_up: Vec<Event> = EVENTS.with(Clone::clone);
    let live = (
        value(),
        value(),
        value(),
        value(),
        value(),
        estimate(),
        estimate(),
    )
        .prop_map(
            |(t_s, amplitude_m, normal_n, measured_mu, position_m, mu, gap_m)| {
                Event::Live(Live {
                    t_s: t_s.unwrap_or(1.0),
                    amplitude_m,
                    normal_n,
                    measured_mu,
                    position_m,
                    mu,
                    gap_m,
                    ..Live::default()
                })
            },
        );
    let tick = (0.0..1e6f64).prop_map(|now_s| Event::Tick { now_s });
    prop_oneof![6 => proptest::sample::select(made_up), 3 => live, 1 => tick]
}

fn press() -> impl Strategy<Value = KeyCode> {
    let keys = "12345zfjkwatnrpxs?+-[]y ".chars().map(KeyCode::Char);
    let named_keys = [KeyCode::Left, KeyCode::Right, KeyCode::Tab, KeyCode::PageUp];
    proptest::sample::select(keys.chain(named_keys).collect::<Vec<_>>())
}

thread_local! {
    /// One event of every kind, few of the frequent ones.
    static EVENTS: Vec<Event> = {
        let events = synthetic::session().into_iter().map(|(_, event)| event);
        let rare = events.enumerate().filter(|(i, event)| {
            !matches!(event, Event::Live(_) | Event::Participant(_) | Event::Period(_)) || i % 97 == 0
        });
        let last_events = synthetic::trip().into_iter().chain(synthetic::finish());
        rare.map(|(_, event)| event).chain(last_events).collect()
    };
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn any_events_and_keys_are_drawn_at_any_size(
        steps in proptest::collection::vec((event(), press()), 1..40),
        sizes in proptest::collection::vec((0..=200u16, 0..=60u16), 3),
        ascii in any::<bool>(),
    ) {
        let mut state = State::new(Theme::HighContrast);
        state.ui.ascii = ascii;
        for (event, code) in steps {
            state.apply(&event);
            state.ui = key(&state, key_event(code)).ui;
        }
        for (columns, rows) in sizes {
            let _ = draw(&state, columns, rows);
        }
    }
}

#[test]
fn a_line_says_how_it_is_and_how_it_was_last() {
    let levels = |open: bool, presses, ago_s| LineStates {
        estop_open: Some(open),
        button_pressed: Some(false),
        button_presses: presses,
        estop_open_ago_s: Some(ago_s),
        button_press_ago_s: (presses > 0).then_some(ago_s),
        heartbeat_beats: Some(true),
    };
    for (state, line, words, well) in [
        (
            levels(true, 0, 0.0),
            BenchLine::Estop,
            "PRESSED OR CUT",
            false,
        ),
        (
            levels(false, 0, 0.4),
            BenchLine::Estop,
            "closed; open just now",
            true,
        ),
        (
            levels(false, 0, 0.4),
            BenchLine::Button,
            "not pressed",
            true,
        ),
        (
            levels(false, 1, 3.2),
            BenchLine::Button,
            "not pressed; pressed 3 s ago",
            true,
        ),
        (
            levels(false, 3, 150.0),
            BenchLine::Button,
            "not pressed; pressed ×3, 2 min ago",
            true,
        ),
        (levels(false, 3, 0.0), BenchLine::Heartbeat, "beats", true),
    ] {
        assert_eq!(state.describe(line), Some((words.to_owned(), well)));
    }
    // The text appears on the page and is not cut off.
    let mut state = normal();
    let mut health = state.health.unwrap();
    health.lines = levels(false, 3, 150.0);
    state.apply(&Event::Health(health));
    state.ui.page = Page::Bench;
    let screen = lines(&state, 80, 24);
    assert!(screen.contains("pressed ×3, 2 min ago"), "{screen}");
}

/// Regression test: on a small terminal the last rows of the bench's page were out of reach.
#[test]
fn a_table_of_health_that_is_cut_begins_with_bad_values_and_scrolls() {
    let mut state = normal();
    state.ui.page = Page::Bench;
    let screen = lines(&state, 80, 24);
    assert!(!screen.contains("all well"), "{screen}");
    state.ui.scroll = 20;
    let screen = lines(&state, 80, 24);
    assert!(
        screen.contains("processor") && screen.contains("all well"),
        "{screen}"
    );
    state.ui.scroll = 0;
    let mut health = state.health.unwrap();
    health.disk_free_bytes = Some(1_000_000_000);
    state.apply(&Event::Health(health));
    let screen = lines(&state, 80, 24);
    assert!(screen.contains("no: disk free"), "{screen}");
}
