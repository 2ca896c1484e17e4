//! The state is the fold of the events.

use crate::{rig, synthetic};
use ratatui::buffer::Buffer;
use tui::event::{
    ComplexImpedance, Event, FitView, Live, LogLevel, SafetyView, SessionHeader, TrialVerdict,
};
use tui::{HISTORY_S, State, Theme};

fn live(t_s: f64) -> Event {
    Event::Live(Live {
        t_s,
        ..Live::default()
    })
}

fn state_after(events: impl IntoIterator<Item = Event>) -> State {
    let mut state = State::new(Theme::Colour);
    for event in events {
        state.apply(&event);
    }
    state
}

fn draw(state: &State) -> Buffer {
    rig::draw(state, 140, 45).backend().buffer().clone()
}

/// A replay that is moved back and played again.
#[test]
fn a_trial_that_is_fitted_again_has_one_fit() {
    let fit = |trial, no_fit: &str| {
        Event::Fit(FitView {
            trial,
            no_fit: Some(no_fit.to_owned()),
            ..FitView::default()
        })
    };
    let state = state_after([
        fit(1, "too short"),
        fit(2, "too short"),
        fit(1, "too noisy"),
    ]);
    let fits: Vec<_> = state
        .fits
        .iter()
        .map(|fit| (fit.trial, fit.no_fit.as_deref().unwrap()))
        .collect();
    assert_eq!(fits, [(2, "too short"), (1, "too noisy")]);
}

#[test]
fn the_history_holds_ten_seconds_and_a_bounded_number() {
    let state = state_after((0..3000).map(|i| live(f64::from(i) * 0.01)));
    let span_s = 29.99 - state.history.front().unwrap().t_s;
    assert!((span_s - HISTORY_S).abs() < 0.011, "{span_s}");
    let state = state_after((0..50_000).map(|i| live(f64::from(i) * 1e-5)));
    assert!(state.history.len() <= 4000);
}

#[test]
fn time_that_starts_over_starts_a_new_curve() {
    let state = state_after([live(5.0), live(5.1), live(0.0)]);
    assert_eq!(state.history.len(), 1);
}

#[test]
fn values_that_are_not_finite_are_not_measured() {
    let state = state_after([Event::Live(Live {
        t_s: 1.0,
        normal_n: Some(f64::NAN),
        amplitude_m: Some(1e-6),
        z_m_n_s_per_m: Some(ComplexImpedance {
            re_n_s_per_m: 7.0,
            im_n_s_per_m: f64::INFINITY,
        }),
        ..Live::default()
    })]);
    let live = state.live().unwrap();
    assert_eq!((live.normal_n, live.amplitude_m), (None, Some(1e-6)));
    assert_eq!(live.z_m_n_s_per_m, None);
    assert!(state_after([self::live(f64::NAN)]).history.is_empty());
}

#[test]
fn values_grow_stale_by_the_screens_clock_not_by_their_own() {
    let tick = |now_s| Event::Tick { now_s };
    let fresh = state_after([tick(100.0), live(3.0), tick(100.9), live(9.0), tick(101.8)]);
    assert_eq!(fresh.live_stale_s(), None);
    let stale = state_after([tick(100.0), live(3.0), tick(102.5)]);
    assert_eq!(stale.live_stale_s(), Some(2.5));
    // The bench still sends events, only live values are missing.
    let mut state = stale;
    state.apply(&Event::Log {
        level: LogLevel::Warning,
        text: "no audio".to_owned(),
    });
    assert_eq!(state.silent_s(), None);
    assert_eq!(state.live_stale_s(), Some(2.5));
    // A bench that never sends an event counts as silent, too.
    assert_eq!(state_after([tick(7.0), tick(9.0)]).silent_s(), Some(2.0));
}

#[test]
fn attempts_and_practice_are_listed_apart() {
    let state = state_after(synthetic::session().into_iter().map(|(_, event)| event));
    let trials: Vec<_> = state
        .trials
        .iter()
        .map(|line| {
            let accepted = line.verdict.as_ref().map(|v| v.accepted);
            (line.trial, line.practice, line.attempt, accepted)
        })
        .collect();
    assert_eq!(
        trials,
        [
            (1, true, 1, Some(true)),
            (1, false, 1, Some(true)),
            (2, false, 1, Some(false)),
            (2, false, 2, Some(true)),
        ]
    );
}

#[test]
fn a_verdict_on_a_trial_that_was_never_announced_is_listed() {
    let verdict = TrialVerdict {
        trial: 9,
        attempt: 1,
        accepted: true,
        ..TrialVerdict::default()
    };
    let state = state_after([Event::Verdict(verdict.clone())]);
    assert_eq!(state.trials.len(), 1);
    assert_eq!(state.trials[0].verdict.as_ref(), Some(&verdict));
}

#[test]
fn a_repeated_line_is_counted_and_the_log_is_bounded() {
    let line = |text: &str| Event::Log {
        level: LogLevel::Info,
        text: text.to_owned(),
    };
    let state = state_after([line("a"), line("b"), line("b"), line("b")]);
    let counts: Vec<_> = state
        .log
        .iter()
        .map(|l| (l.text.as_str(), l.count))
        .collect();
    assert_eq!(counts, [("a", 1), ("b", 3)]);
    let state = state_after((0..10_000).map(|i| line(&i.to_string())));
    assert!(state.log.len() <= 2000);
    assert_eq!(state.log.back().unwrap().text, "9999");
}

#[test]
fn the_reason_of_a_trip_goes_when_it_is_rearmed() {
    let safety = |state, reason: Option<&str>| Event::Safety {
        state,
        reason: reason.map(str::to_owned),
    };
    let state = state_after([
        safety(SafetyView::Tripped, Some("e-stop")),
        safety(SafetyView::Armed, None),
    ]);
    assert_eq!(state.safety, Some(SafetyView::Armed));
    assert_eq!(state.safety_reason, None);
}

/// Fault 44.
#[test]
fn control_characters_reach_no_cell_and_the_log_shows_them() {
    const EVIL: &str = "\u{1b}[2J\u{9b}2J\u{202e}\n";
    let evil = || Some(format!("evil{EVIL}"));
    let evil_state = state_after([
        Event::Session(SessionHeader {
            participant: evil(),
            protocol: evil(),
            study: evil(),
            ..SessionHeader::default()
        }),
        Event::Safety {
            state: SafetyView::Tripped,
            reason: evil(),
        },
        Event::Log {
            level: LogLevel::Warning,
            text: format!("evil{EVIL}"),
        },
    ]);
    let end_event = Event::Finished {
        summary: vec![format!("evil{EVIL}")],
    };
    let mut finished = evil_state.clone();
    finished.apply(&end_event);
    for state in [&evil_state, &finished] {
        let screen = draw(state);
        let cells: Vec<&str> = screen.content.iter().map(|cell| cell.symbol()).collect();
        let is_obeyed = |c: char| c.is_control() || c == '\u{202e}';
        assert!(cells.iter().all(|symbol| !symbol.contains(is_obeyed)));
        assert!(cells.concat().contains("evil"));
    }
    assert!(
        draw(&evil_state)
            .content
            .iter()
            .map(|cell| cell.symbol())
            .collect::<String>()
            .contains(r"evil\u001b[2J\u009b2J\u202e\n")
    );
}
