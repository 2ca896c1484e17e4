//! The operator's screen at two sizes and in every kind of state; colours are asserted on the buffer.

use crate::rig::{draw, play_until, press};
use crate::synthetic;
use participant_texts::{Instruction, Language, Texts};
use proptest::prelude::*;
use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};
use std::sync::Arc;
use tui::drill_view::{DrillResult, DrillStep, DrillView};
use tui::event::{
    AskedDetail, CarrierProposal, Live, PhaseKind, PhaseView, SafetyView, TrialVerdict, ValueAndStd,
};
use tui::{Action, Event, Page, State, Theme};

fn exploring_state() -> State {
    play_until(|state| {
        let trial = &state.phase;
        trial.kind == PhaseKind::Exploration
            && (trial.trial, trial.practice) == (2, false)
            && state.live().and_then(|live| live.slider_m) > Some(0.06)
    })
}

fn press_key(mut state: State, keys: &str) -> State {
    press(&mut state, keys);
    state
}

fn states() -> Vec<(&'static str, State)> {
    let mut stale = exploring_state();
    stale.apply(&Event::Tick {
        now_s: stale.now_s + 3.2,
    });
    let mut tripped = exploring_state();
    for event in synthetic::trip() {
        tripped.apply(&event);
    }
    let mut on_pause = exploring_state();
    on_pause.phase.kind = PhaseKind::Paused;
    let mut finished = play_until(|state| state.phase.kind == PhaseKind::Rest);
    for event in synthetic::finish() {
        finished.apply(&event);
    }
    vec![
        ("empty", State::new(Theme::Colour)),
        ("running", exploring_state()),
        (
            "countdown",
            play_until(|state| state.phase.countdown == Some(2)),
        ),
        (
            "rejected",
            play_until(|state| state.verdict.as_ref().is_some_and(|v| !v.accepted)),
        ),
        ("stale", stale),
        ("tripped", tripped),
        ("paused", on_pause),
        ("help", press_key(exploring_state(), "?")),
        ("confirm", press_key(exploring_state(), "a")),
        ("finished", finished),
    ]
}

fn buffer(state: &State, columns: u16, rows: u16) -> Buffer {
    draw(state, columns, rows).backend().buffer().clone()
}

fn row(buffer: &Buffer, y: u16) -> String {
    (0..buffer.area.width)
        .map(|x| buffer[(x, y)].symbol())
        .collect()
}

/// Returns the cells that contain `words`.
fn cells<'a>(buffer: &'a Buffer, words: &str) -> Vec<&'a Cell> {
    for y in 0..buffer.area.height {
        let symbols: Vec<&str> = (0..buffer.area.width)
            .map(|x| buffer[(x, y)].symbol())
            .collect();
        let letters: Vec<String> = words.chars().map(String::from).collect();
        if let Some(x) = symbols.windows(letters.len()).position(|w| w == letters) {
            return (x..x + letters.len())
                .map(|x| &buffer[(x as u16, y)])
                .collect();
        }
    }
    panic!("{words:?} is not on the screen");
}

#[test]
fn words_that_are_no_alarm_give_way_to_the_flags() {
    let mut state = State::new(Theme::Mono);
    state.session.simulated = true;
    state.session.uncalibrated = true;
    state.apply(&Event::Safety {
        state: SafetyView::Driving,
        reason: Some("11 min of driving left this hour".to_owned()),
    });
    let line = |columns| row(&buffer(&state, columns, 24), 0);
    let wide_row = line(80);
    assert!(
        wide_row.contains("11 min of driving left") && wide_row.contains("UNCALIBRATED"),
        "{wide_row}"
    );
    let narrow_row = line(60);
    assert!(
        !narrow_row.contains("11 min") && narrow_row.contains("UNCALIBRATED"),
        "{narrow_row}"
    );
}

#[test]
fn every_state_of_the_run_page() {
    for (name, state) in states() {
        for (columns, rows) in [(80, 24), (120, 40)] {
            let screen = draw(&state, columns, rows);
            insta::assert_snapshot!(format!("{name}_{columns}x{rows}"), screen.backend());
        }
    }
}

#[test]
fn small_terminals_keep_the_essentials() {
    for (columns, rows) in [(40, 10), (20, 5)] {
        let screen = draw(&exploring_state(), columns, rows);
        insta::assert_snapshot!(format!("running_{columns}x{rows}"), screen.backend());
    }
}

/// Returns the open verdict that rejects a trial because of its force.
fn rejecting_state() -> State {
    let mut state = play_until(|state| state.verdict.as_ref().is_some_and(|v| !v.accepted));
    state.phase = PhaseView {
        kind: PhaseKind::Verdict,
        countdown: Some(6),
        overrulable: true,
        repeats: true,
        exploration: 0,
        ..state.phase
    };
    state
}

#[test]
fn a_rejection_states_its_reason_at_every_size_and_on_every_page() {
    for (columns, rows) in [(200, 60), (120, 40), (80, 24), (60, 16), (40, 8)] {
        for page in ["1", "2", "3", "4"] {
            let mut state = rejecting_state();
            press(&mut state, page);
            let screen = lines(&state, columns, rows);
            let line = if columns >= 80 {
                "REJECTED: force 0.93 N, band 0.50–0.80 · repeats in 6 s · o keeps it"
            } else {
                "REJECTED: force 0.93 N"
            };
            assert!(
                screen.contains(line),
                "{columns}x{rows}, page {page}:\n{screen}"
            );
        }
    }
    let list = lines(&rejecting_state(), 200, 60);
    assert!(list.contains("2 ✗ force 0.93 N, band 0.50–0.80"), "{list}");
    for (columns, rows) in [(200, 60), (120, 40), (80, 24)] {
        let screen = draw(&rejecting_state(), columns, rows);
        insta::assert_snapshot!(format!("verdict_{columns}x{rows}"), screen.backend());
    }
}

#[test]
fn an_interrupted_trial_is_named_so_where_its_reason_does_not_fit() {
    let mut state = rejecting_state();
    let verdict = TrialVerdict {
        interrupted: true,
        settled: Some("drive stopped: stopped by the operator".to_owned()),
        ..state.verdict.clone().unwrap()
    };
    state.apply(&Event::Verdict(verdict));
    let narrow = lines(&state, 80, 24);
    assert!(narrow.contains("2 – interrupted"), "{narrow}");
    let wide = lines(&state, 200, 60);
    assert!(
        wide.contains("2 – drive stopped: stopped by the operator"),
        "{wide}"
    );
}

#[test]
fn a_key_without_effect_is_answered_on_every_page_until_the_next_key() {
    for page in ["1", "2", "3", "4"] {
        let mut state = exploring_state();
        press(&mut state, page);
        state.apply(&Event::Answer("not re-armed".to_owned()));
        assert!(
            lines(&state, 80, 24).contains("not re-armed"),
            "page {page}"
        );
        press(&mut state, page);
        assert!(
            !lines(&state, 80, 24).contains("not re-armed"),
            "page {page}"
        );
    }
}

#[test]
fn a_question_about_an_attempt_and_one_about_the_participant_end_with_it() {
    let mut state = exploring_state();
    press(&mut state, "r");
    let screen = lines(&state, 80, 24);
    assert!(screen.contains("now running, and repeat it?"), "{screen}");
    let verdict = PhaseView {
        kind: PhaseKind::Verdict,
        ..state.phase.clone()
    };
    state.apply(&Event::Phase(verdict));
    assert_eq!(state.ui.confirm, None);
    let detail = || AskedDetail {
        question: "age in whole years".to_owned(),
        ..AskedDetail::default()
    };
    state.apply(&Event::Asked {
        detail: Some(detail()),
    });
    assert!(lines(&state, 80, 24).contains("age in whole years"));
    let finished = PhaseView::new(PhaseKind::Finished);
    state.apply(&Event::Phase(finished));
    state.apply(&Event::Asked {
        detail: Some(detail()),
    });
    let screen = lines(&state, 80, 24);
    assert!(!screen.contains("age in whole years"), "{screen}");
}

#[test]
fn an_accepted_trial_and_the_last_rejection_state_their_outcome() {
    let mut state = rejecting_state();
    state.participant.as_mut().unwrap().instruction = Instruction::Wait;
    assert!(lines(&state, 80, 24).contains("“We do this one once more, please.”"));
    state.phase.repeats = false;
    let screen = lines(&state, 80, 24);
    assert!(
        screen.contains("given up in 6 s · o keeps it") && screen.contains("“One moment, please.”"),
        "{screen}"
    );
    let verdict = state.verdict.as_mut().unwrap();
    verdict.accepted = true;
    assert!(
        lines(&state, 80, 24).contains("ACCEPTED: force 0.93 N · goes on in 6 s · r repeats it")
    );
    state.phase.overrulable = false;
    assert!(lines(&state, 80, 24).contains("now  saving the recording"));
}

#[test]
fn an_aborted_session_is_called_so() {
    let mut state = exploring_state();
    state.phase = PhaseView {
        aborted: true,
        ..PhaseView::new(PhaseKind::Finished)
    };
    let screen = lines(&state, 80, 24);
    assert!(screen.contains("aborted"), "{screen}");
    assert!(!screen.contains("now  finished"), "{screen}");
}

#[test]
fn a_practice_is_not_kept() {
    let mut state = rejecting_state();
    state.phase.practice = true;
    state = press_key(state, "o");
    let note = state.ui.note.clone().unwrap();
    assert!(note.contains("practice"), "{note}");
}

#[test]
fn a_stopped_session_is_ready_once_it_is_rearmed() {
    let mut state = exploring_state();
    state.phase.kind = PhaseKind::Paused;
    state.phase.stopped = true;
    state.safety = Some(SafetyView::Tripped);
    let screen = lines(&state, 80, 24);
    assert!(
        screen.contains("STOPPED · find the cause, then x re-arms"),
        "{screen}"
    );
    state.safety = Some(SafetyView::Disarmed);
    let screen = lines(&state, 80, 24);
    assert!(screen.contains("READY, drive off · p goes on"), "{screen}");
    assert!(
        !screen.contains("DISARMED") && !screen.contains("find the cause"),
        "{screen}"
    );
    state.phase.stopped = false;
    assert!(lines(&state, 80, 24).contains("PAUSED, drive off · p goes on"));
}

#[test]
fn the_operators_words_are_in_the_protocols_language() {
    let mut state = exploring_state();
    let german = Texts::in_language(Language::De);
    let mut view = state.participant.clone().unwrap();
    view.texts = Arc::new(german.clone());
    view.instruction = Instruction::PlaceFinger;
    state.participant = Some(view);
    let words = "“Legen Sie den Finger an der Marke auf die Platte, dann drücken Sie den";
    // The words are wrapped, never cut off.
    let screen = lines(&state, 80, 24);
    assert!(
        screen.contains(words) && screen.contains("     Knopf.”"),
        "{screen}"
    );
    state.phase.kind = PhaseKind::Finished;
    assert!(lines(&state, 120, 40).contains("say  “Das war alles. Vielen Dank!”"));
    state.phase.aborted = true;
    assert!(lines(&state, 120, 40).contains(&*german.say_aborted));
}

/// The display may come back between the question and its answer.
#[test]
fn a_question_about_a_lost_display_keeps_its_sense_when_the_display_is_back() {
    let mut state = exploring_state();
    state.phase.kind = PhaseKind::Paused;
    state.display_lost = Some("participant's window: it was closed".to_owned());
    press(&mut state, "p");
    assert!(lines(&state, 80, 24).contains("Show again on the participant's window and resume?"));
    state.display_lost = None;
    assert!(lines(&state, 80, 24).contains("The participant's display is back. Resume?"));
}

#[test]
fn quitting_has_its_hint_and_its_question_at_the_end_too() {
    let mut state = play_until(|state| state.phase.kind == PhaseKind::Rest);
    for event in synthetic::finish() {
        state.apply(&event);
    }
    assert_eq!(press(&mut state, "q"), []);
    assert_eq!(press(&mut state, "y"), [Action::Quit]);
    for columns in [40, 60, 80] {
        let last = row(&buffer(&exploring_state(), columns, 24), 23);
        assert!(last.contains("q quit"), "{columns}: {last}");
    }
}

fn lines(state: &State, columns: u16, rows: u16) -> String {
    let buffer = buffer(state, columns, rows);
    let rows: Vec<String> = (0..rows).map(|y| row(&buffer, y)).collect();
    rows.join("\n")
}

/// Returns a drill in which the third fault was just shown.
fn drill_state(step: DrillStep, instruction: &str) -> State {
    let mut state = State::new(Theme::Colour);
    let result = |fault: &str, met, words: &str| DrillResult {
        fault: fault.to_owned(),
        met,
        words: words.to_owned(),
    };
    for event in [
        Event::Phase(PhaseView {
            trial: 3,
            trials: 20,
            ..PhaseView::new(PhaseKind::Monitoring)
        }),
        Event::Safety {
            state: SafetyView::Tripped,
            reason: Some("drive reads back 0.0 V, commanded 1.0 to 39.0 V".to_owned()),
        },
        Event::Live(Live {
            t_s: 1.0,
            normal_n: Some(0.01),
            ..Live::default()
        }),
        Event::Drill(DrillView {
            exercise: 3,
            exercises: 20,
            instruction: instruction.to_owned(),
            note: Some("The cause is still there.".to_owned()),
            asked: step,
            results: vec![
                result("estop", true, "shown 2 ms, silent 4 ms, seen 1.2 s"),
                result("xrun", false, "nobody acknowledged it"),
            ],
        }),
    ] {
        state.apply(&event);
    }
    state
}

#[test]
fn a_drill_states_the_requested_step_at_every_size() {
    let words = "It was: the amplifier is switched off. The cause is removed. Re-arm: x, then y.";
    let state = drill_state(DrillStep::Rearm, words);
    for (columns, rows) in [(200, 60), (80, 24), (40, 10), (20, 5)] {
        let screen = draw(&state, columns, rows);
        insta::assert_snapshot!(format!("drill_{columns}x{rows}"), screen.backend());
    }
}

#[test]
fn a_question_about_the_participant_is_read_at_every_size_and_on_every_page() {
    let mut state = State::new(Theme::Colour);
    state.apply(&Event::Tick { now_s: 1.0 });
    state.apply(&Event::Phase(PhaseView::new(PhaseKind::Consent)));
    state.apply(&Event::Asked {
        detail: Some(AskedDetail {
            question: "writing hand".to_owned(),
            choices: ["right", "left", "ambidextrous"]
                .map(str::to_owned)
                .to_vec(),
            note: Some("a number from 1 to 3".to_owned()),
            has_previous: true,
        }),
    });
    let mut state = press_key(state, "2h");
    state.ui.help = false;
    for (columns, rows) in [(120, 40), (80, 24), (40, 10), (20, 5)] {
        let screen = draw(&state, columns, rows);
        insta::assert_snapshot!(format!("asked_{columns}x{rows}"), screen.backend());
        let mut participant_page = state.clone();
        participant_page.ui.page = Page::Participant;
        let (operator_screen, participant_screen) = (
            screen.backend().buffer(),
            buffer(&participant_page, columns, rows),
        );
        for y in 1..4 {
            assert_eq!(
                row(operator_screen, y),
                row(&participant_screen, y),
                "{columns}x{rows}"
            );
        }
    }
}

#[test]
fn a_proposed_carrier_is_read_at_every_size() {
    let mut state = exploring_state();
    state.apply(&Event::NewCarrier {
        proposal: Some(CarrierProposal {
            from_hz: 35_000.0,
            to_hz: 34_994.0,
            drift_hz: ValueAndStd {
                value: -5.8,
                std: 0.4,
            },
        }),
    });
    for (columns, rows) in [(200, 60), (100, 30), (80, 24), (40, 10), (20, 5)] {
        let screen = draw(&state, columns, rows);
        insta::assert_snapshot!(format!("new_carrier_{columns}x{rows}"), screen.backend());
        let mut participant_page = state.clone();
        participant_page.ui.page = Page::Participant;
        let screen = buffer(&participant_page, columns, rows);
        assert!((0..rows).any(|y| row(&screen, y).contains("new carrier")));
    }
}

#[test]
fn the_safety_line_has_its_colours() {
    let (_, tripped) = states().swap_remove(5);
    let screen = buffer(&tripped, 80, 24);
    for cell in cells(&screen, "TRIPPED") {
        assert_eq!(cell.fg, Color::Red);
        assert!(cell.modifier.contains(Modifier::REVERSED | Modifier::BOLD));
    }
    let screen = buffer(&exploring_state(), 80, 24);
    for cell in cells(&screen, "DRIVING") {
        assert_eq!(cell.fg, Color::Cyan);
        assert!(cell.modifier.contains(Modifier::REVERSED));
    }
}

#[test]
fn kept_and_rejected_stretches_differ_in_colour_and_in_symbol() {
    let state = play_until(|state| state.verdict.is_some());
    let screen = buffer(&state, 120, 40);
    for cell in cells(&screen, "▒▒") {
        assert_eq!(cell.fg, Color::Green);
    }
    for cell in cells(&screen, "╱╱") {
        assert_eq!(cell.fg, Color::Red);
    }
}

#[test]
fn the_corrected_curve_is_bold_and_the_plain_one_faint() {
    let screen = buffer(&exploring_state(), 120, 40);
    let curve: Vec<&Cell> = (13..17)
        .flat_map(|y| (7..66).map(move |x| (x, y)))
        .map(|position| &screen[position])
        .filter(|cell| ("\u{2801}"..="\u{28ff}").contains(&cell.symbol()))
        .collect();
    let bold = |cell: &&&Cell| cell.fg == Color::Cyan && cell.modifier == Modifier::BOLD;
    let faint = |cell: &&&Cell| cell.fg == Color::Reset && cell.modifier == Modifier::DIM;
    assert!(curve.iter().filter(bold).count() > 50);
    assert!(curve.iter().filter(faint).count() > 5);
    assert!(curve.iter().all(|cell| bold(&cell) || faint(&cell)));
}

#[test]
fn stale_values_are_grey_and_say_their_age() {
    let (_, stale) = states().swap_remove(4);
    let screen = buffer(&stale, 120, 40);
    assert!(
        cells(&screen, "stale 3 s")
            .iter()
            .all(|cell| cell.fg == Color::Magenta)
    );
    assert!(row(&screen, 0).contains("no data from the bench for 3 s"));
    let little = buffer(&stale, 80, 24);
    assert!((0..24).any(|y| row(&little, y).contains("stale 3 s")));
    // The live panels are on the left; the safety word above them keeps its colour, and so does the last trial.
    for y in 7..39 {
        for x in 0..66 {
            assert_ne!(screen[(x, y)].fg, Color::Cyan, "{x} {y}");
        }
    }
}

/// Fault 37.
#[test]
fn without_colours_only_modifiers_are_used() {
    for (name, mut state) in states() {
        state.ui.theme = Theme::Mono;
        for cell in buffer(&state, 120, 40).content() {
            assert_eq!((cell.fg, cell.bg), (Color::Reset, Color::Reset), "{name}");
        }
    }
}

/// Fault 37.
#[test]
fn the_background_is_the_terminals_own() {
    for (name, state) in states() {
        for cell in buffer(&state, 120, 40).content() {
            assert_eq!(cell.bg, Color::Reset, "{name}");
            let unreadable = [Color::White, Color::Black, Color::Gray, Color::Yellow];
            assert!(!unreadable.contains(&cell.fg), "{name}");
        }
    }
}

#[test]
fn no_cell_is_bold_and_faint_at_once() {
    for (name, state) in states() {
        let screen = buffer(&state, 120, 40);
        for (i, cell) in screen.content().iter().enumerate() {
            let bold_and_faint = Modifier::BOLD | Modifier::DIM;
            assert!(
                !cell.modifier.contains(bold_and_faint),
                "{name} {:?} {}",
                screen.pos_of(i),
                cell.symbol()
            );
        }
    }
}

#[test]
fn the_participants_page_keeps_the_safety_line() {
    let mut state = exploring_state();
    state.ui.page = Page::Participant;
    let screen = draw(&state, 80, 24);
    assert!(row(screen.backend().buffer(), 0).contains("DRIVING"));
    insta::assert_snapshot!("page_participant_80x24", screen.backend());
}

/// Fault 37.
#[test]
fn every_small_size_in_every_state_is_drawn_with_the_safety_word_first() {
    let mut preview = exploring_state();
    preview.ui.page = Page::Participant;
    let mut states = states();
    states.push(("preview", preview));
    for (_, state) in &mut states {
        // One second of curves: ten seconds take much longer to draw and prove nothing else.
        let old = state.history.len().saturating_sub(100);
        state.history.drain(..old);
    }
    // States in the inner loop, because a solved layout is cached.
    for (columns, rows) in (0..=60).flat_map(|c| (0..=30).map(move |r| (c, r))) {
        for (name, state) in &states {
            let screen = draw(state, columns, rows);
            let screen = screen.backend().buffer();
            let case = format!("{name} {columns}x{rows}");
            let word = match state.safety {
                None => " UNKNOWN",
                Some(SafetyView::Disarmed) => " DISARMED",
                Some(SafetyView::Armed) => " ARMED",
                Some(SafetyView::Driving) => " DRIVING",
                Some(SafetyView::Tripped) => " TRIPPED",
            };
            if let Some(text_columns) = columns.checked_sub(1).filter(|_| rows > 0) {
                let visible_word = &word[..word.len().min(text_columns.into())];
                let first = row(screen, 0);
                assert!(first.starts_with(visible_word), "{case}: {first:?}");
            }
            if columns >= 6 && rows >= 4 {
                let last = row(screen, rows - 1);
                let keys: &[&str] = match state.ui.confirm {
                    Some(_) => &[" y/n:", " Abort the session?  y yes · n no "],
                    None => &["e STOP"],
                };
                let has_keys = keys.iter().any(|keys| last.starts_with(keys));
                assert!(has_keys, "{case}: {last:?}");
            }
        }
    }
}

fn value() -> impl Strategy<Value = Option<f64>> {
    prop_oneof![
        Just(None),
        Just(Some(f64::NAN)),
        Just(Some(f64::INFINITY)),
        Just(Some(f64::MAX)),
        Just(Some(-f64::MAX)),
        Just(Some(0.0)),
        (-1e-5..1e3f64).prop_map(Some),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    /// Fault 37.
    #[test]
    fn any_size_in_any_state_shows_the_safety_word(
        columns in 0..=200u16,
        rows in 0..=60u16,
        state_index in 0..10usize,
        safety in proptest::option::of(0..4usize),
        confirms in any::<bool>(),
        help in any::<bool>(),
        page in any::<bool>(),
    ) {
        let safety_states = [SafetyView::Disarmed, SafetyView::Armed, SafetyView::Driving, SafetyView::Tripped];
        let words = ["DISARMED", "ARMED", "DRIVING", "TRIPPED"];
        let mut state = STATES.with(|states| states[state_index].1.clone());
        state.safety = safety.map(|i| safety_states[i]);
        state.ui.confirm = confirms.then_some(Action::Abort);
        state.ui.help = help;
        state.ui.page = if page { Page::Participant } else { Page::Run };
        let screen = buffer(&state, columns, rows);
        if columns >= 10 && rows >= 1 {
            let word = safety.map_or("UNKNOWN", |i| words[i]);
            prop_assert!(row(&screen, 0).contains(word), "{:?}", row(&screen, 0));
        }
    }

    #[test]
    fn any_values_are_drawn_without_panic(
        t_s in prop_oneof![Just(f64::NAN), Just(1e300), 0.0..100.0f64],
        values in proptest::collection::vec(value(), 8),
        columns in 0..=160u16,
        rows in 0..=50u16,
    ) {
        let mut state = exploring_once();
        let last_s = state.live().map_or(0.0, |live| live.t_s);
        for (i, t_s) in [t_s, last_s + 0.01, last_s + 0.02].into_iter().enumerate() {
            state.apply(&Event::Live(Live {
                t_s,
                amplitude_m: values[i],
                normal_n: values[i + 1],
                lateral_n: values[i + 2],
                position_m: values[i + 3],
                slider_m: values[i + 4],
                drive_v: values[i + 5],
                ..Live::default()
            }));
        }
        state.session.plate_length_m = values[0].unwrap_or(0.1);
        let _ = buffer(&state, columns, rows);
    }
}

thread_local! {
    static STATES: Vec<(&'static str, State)> = states();
}

fn exploring_once() -> State {
    STATES.with(|states| states[1].1.clone())
}
