//! A calibration's page: its contents at two sizes and in every kind of state, and its keys.

use crate::rig::{draw, press};
use proptest::prelude::*;
use tui::calibration_page::{
    CalibrationPage, CalibrationReadings, Chart, MainReading, PointLine, Question, Reply,
};
use tui::event::{LogLevel, SafetyView, SessionHeader, SystemHealth};
use tui::{Action, Event, Page, State, Theme};

/// Levels, V, known amplitudes, μm, and their residuals from the fitted line, nm, of a ladder of six.
const LADDER: [(f64, f64, f64); 6] = [
    (5.07, 0.3372, 0.12),
    (12.66, 0.8430, -0.31),
    (20.26, 1.3488, 0.22),
    (27.86, 1.8547, -4.18),
    (35.46, 2.3604, 0.35),
    (43.06, 2.8664, 0.28),
];

fn points(count: usize) -> Vec<PointLine> {
    LADDER[..count]
        .iter()
        .map(|(drive_v, known_um, residual_nm)| PointLine {
            at: format!("{drive_v:.2} V"),
            value: format!("{known_um:.4} μm"),
            residual: (count > 2).then(|| format!("{residual_nm:+.1} nm").replace('-', "−")),
            worst: count > 2 && residual_nm.abs() > 1.0,
        })
        .collect()
}

fn typing_page() -> CalibrationPage {
    CalibrationPage {
        title: "calibrate pickup".to_owned(),
        step: 5,
        steps: 10,
        instruction: "Read the plate's peak amplitude on your instrument and type it.".to_owned(),
        asked: Some(Question::Number {
            unit: "μm".to_owned(),
            expected: Some(1.3488),
            optional: false,
        }),
        points: points(2),
        curve: Some(Chart {
            x: "drive, V".to_owned(),
            y: "known, μm".to_owned(),
            points: LADDER[..2].iter().map(|point| (point.0, point.1)).collect(),
            fit: Vec::new(),
        }),
        ..CalibrationPage::default()
    }
}

fn naming_page() -> CalibrationPage {
    let point = |setting: &str, value: &str| PointLine {
        at: setting.to_owned(),
        value: value.to_owned(),
        ..PointLine::default()
    };
    CalibrationPage {
        title: "calibrate force".to_owned(),
        instruction: "Type the masses that you will put on the plate, one at a time; Enter alone when these are all, \
            r takes the chosen one out."
            .to_owned(),
        note: Some("400 g weigh 3.92 N, more than safety.max_normal_n = 3 N allows on the sensor: \
            use masses up to 305 g"
            .to_owned()),
        asked: Some(Question::Number {
            unit: "g".to_owned(),
            expected: None,
            optional: true,
        }),
        watched: MainReading::NormalForce,
        points: vec![point("20 g normal", "0.196 N"), point("50 g normal", "0.490 N")],
        ..CalibrationPage::default()
    }
}

fn review() -> CalibrationPage {
    CalibrationPage {
        step: 9,
        instruction: "Look at the results and the points. Keep them, or measure one of the points again.".to_owned(),
        note: Some(
            "the points depart from a line by 0.15 % of the largest amplitude: repeat the worst one"
                .to_owned(),
        ),
        asked: Some(Question::Review),
        points: points(6),
        curve: Some(Chart {
            x: "drive, V".to_owned(),
            y: "off the line, nm".to_owned(),
            points: LADDER.iter().map(|point| (point.0, point.2)).collect(),
            fit: vec![(0.0, 0.0), (43.06, 0.0)],
        }),
        findings: [
            "sensitivity (4.9963 ± 0.0055)e-6 m",
            "offset (0.1 ± 1.2)e-9 m",
            "nonlinearity 0.146 % of the largest amplitude",
            "points 6 at 35012.4 Hz",
        ]
        .map(str::to_owned)
        .to_vec(),
        rejected: true,
        ..typing_page()
    }
}

fn state(calibration: CalibrationPage) -> State {
    let mut state = State::new(Theme::Colour);
    let is_driven = matches!(
        calibration.asked,
        Some(Question::Number {
            optional: false,
            ..
        })
    );
    for event in [
        Event::Tick { now_s: 0.0 },
        Event::Session(SessionHeader {
            simulated: true,
            ..SessionHeader::default()
        }),
        Event::Calibration(calibration),
        Event::CalibrationReadings(CalibrationReadings {
            normal_n: Some(0.002),
            lateral_n: Some(-0.0011),
            drive_v: Some(if is_driven { 20.26 } else { 0.0 }),
            amplitude_m: Some(if is_driven { 1.3491e-6 } else { 1e-10 }),
            known_m: Some(1.34877e-6),
            known_v: None,
            level: Some(0.338),
        }),
        Event::Safety {
            state: if is_driven {
                SafetyView::Driving
            } else {
                SafetyView::Armed
            },
            reason: None,
        },
    ] {
        state.apply(&event);
    }
    state
}

fn states() -> Vec<(&'static str, State)> {
    let mut typed = state(typing_page());
    press(&mut typed, "1.3");
    let mut stale = state(typing_page());
    stale.apply(&Event::Tick { now_s: 4.2 });
    let mut empty = State::new(Theme::Colour);
    empty.apply(&Event::Calibration(CalibrationPage {
        title: "calibrate plate".to_owned(),
        instruction: "Waiting until the force is steady.".to_owned(),
        ..CalibrationPage::default()
    }));
    let mut failed = state(CalibrationPage {
        instruction: "the safety watch stopped the calibration: normal force 5.30 N over the limit of 3.00 N. \
            Nothing was written."
            .to_owned(),
        asked: None,
        failed: true,
        ..typing_page()
    });
    failed.apply(&Event::Safety {
        state: SafetyView::Tripped,
        reason: Some("normal force 5.30 N over the limit of 3.00 N".to_owned()),
    });
    let mut leaving = state(review());
    press(&mut leaving, "q");
    let load = state(CalibrationPage {
        title: "calibrate force".to_owned(),
        instruction: "Put 200 g on the middle of the plate, and nothing else.".to_owned(),
        asked: Some(Question::Done),
        watched: MainReading::NormalForce,
        points: Vec::new(),
        curve: None,
        ..typing_page()
    });
    let mut help = state(review());
    press(&mut help, "?");
    let mut bench = state(review());
    bench.apply(&Event::Health(SystemHealth {
        speed: 1.0,
        force_rate_hz: Some(500.0),
        ..SystemHealth::default()
    }));
    press(&mut bench, "4");
    let mut log = state(CalibrationPage {
        asked: None,
        instruction: "Driving 20.26 V.".to_owned(),
        ..typing_page()
    });
    log.apply(&Event::Log {
        level: LogLevel::Warning,
        text: "the volts were never checked".to_owned(),
    });
    press(&mut log, "5");
    vec![
        ("empty", empty),
        ("typing", typed),
        ("review", state(review())),
        ("load", load),
        ("naming", state(naming_page())),
        ("stale", stale),
        ("failed", failed),
        ("leaving", leaving),
        ("help", help),
        ("bench", bench),
        ("log", log),
    ]
}

fn row(state: &State, columns: u16, rows: u16, y: u16) -> String {
    let terminal = draw(state, columns, rows);
    let buffer = terminal.backend().buffer();
    (0..columns).map(|x| buffer[(x, y)].symbol()).collect()
}

#[test]
fn every_state_at_two_sizes() {
    for (name, state) in states() {
        for (columns, rows) in [(80, 24), (120, 40)] {
            let screen = draw(&state, columns, rows);
            insta::assert_snapshot!(format!("{name}_{columns}x{rows}"), screen.backend());
        }
    }
}

#[test]
fn small_terminals_keep_the_instruction_and_the_answer() {
    for (columns, rows) in [(40, 10), (20, 5)] {
        let (_, typed) = states().swap_remove(1);
        let screen = draw(&typed, columns, rows);
        insta::assert_snapshot!(format!("typing_{columns}x{rows}"), screen.backend());
    }
}

#[test]
fn every_small_size_in_every_state_is_drawn_with_the_instruction() {
    let states = states();
    // States in the inner loop, because a solved layout is cached.
    for (columns, rows) in (0..=60).flat_map(|c| (0..=30).map(move |r| (c, r))) {
        for (name, state) in &states {
            let screen = draw(state, columns, rows);
            // The help covers the instruction on a small screen.
            if columns < 15 || rows < 8 || state.ui.help {
                continue;
            }
            let page = state.calibration.as_ref().unwrap();
            let first_word = page.instruction.split(' ').next().unwrap();
            let buffer = screen.backend().buffer();
            let is_shown = (0..rows).any(|y| {
                let row: String = (0..columns).map(|x| buffer[(x, y)].symbol()).collect();
                row.starts_with(first_word)
            });
            assert!(is_shown, "{name} {columns}x{rows}: no {first_word:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Fault 37.
    #[test]
    fn any_size_in_any_state_shows_the_safety_word(
        columns in 0..=200u16,
        rows in 0..=60u16,
        which in 0..11usize,
    ) {
        let state = STATES.with(|states| states[which].1.clone());
        let terminal = draw(&state, columns, rows);
        if columns >= 10 && rows >= 1 {
            let word = match state.safety {
                None => "UNKNOWN",
                Some(SafetyView::Disarmed) => "DISARMED",
                Some(SafetyView::Armed) => "ARMED",
                Some(SafetyView::Driving) => "DRIVING",
                Some(SafetyView::Tripped) => "TRIPPED",
            };
            let buffer = terminal.backend().buffer();
            let first: String = (0..columns).map(|x| buffer[(x, 0)].symbol()).collect();
            prop_assert!(first.contains(word), "{first:?}");
        }
    }

    #[test]
    fn any_values_are_drawn_without_panic(
        values in proptest::collection::vec(
            prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-f64::MAX), Just(0.0), -1e9..1e9f64],
            8,
        ),
        columns in 0..=160u16,
        rows in 0..=50u16,
        watched in prop_oneof![Just(MainReading::Amplitude), Just(MainReading::Level), Just(MainReading::LateralForce)],
    ) {
        let pairs: Vec<(f64, f64)> = values.windows(2).map(|pair| (pair[0], pair[1])).collect();
        let mut state = state(CalibrationPage {
            watched,
            curve: Some(Chart {
                points: pairs.clone(),
                fit: pairs,
                ..Chart::default()
            }),
            ..review()
        });
        state.apply(&Event::CalibrationReadings(CalibrationReadings {
            normal_n: Some(values[0]),
            lateral_n: Some(values[1]),
            drive_v: Some(values[2]),
            amplitude_m: Some(values[3]),
            known_m: Some(values[4]),
            known_v: Some(values[4]),
            level: Some(values[5]),
        }));
        let _ = draw(&state, columns, rows);
    }
}

thread_local! {
    static STATES: Vec<(&'static str, State)> = states();
}

#[test]
fn keys_by_question() {
    let number = |value| Action::Answer(Reply::Number(value));
    let redo = |point| Action::Answer(Reply::Redo(point));
    let ready = Action::Answer(Reply::Ready);
    let working = CalibrationPage {
        asked: None,
        ..typing_page()
    };
    let done = CalibrationPage {
        asked: Some(Question::Done),
        ..typing_page()
    };
    let naming = naming_page();
    let failed = CalibrationPage {
        failed: true,
        ..working.clone()
    };
    let table: &[(&CalibrationPage, &str, &[Action])] = &[
        (&typing_page(), "1.25\n", &[number(1.25)]),
        (&typing_page(), "1,25\n", &[number(1.25)]),
        (&typing_page(), "1.255\u{8}\n", &[number(1.25)]),
        (&typing_page(), "\n", &[]),
        (&typing_page(), "1.2.5\n", &[]),
        (&typing_page(), "1.2\n1.2\n", &[number(1.2), number(1.2)]),
        (&naming, "\n", &[ready]),
        (&naming, "50\n\n", &[number(50.0), ready]),
        (&naming, ".\n", &[]),
        (&typing_page(), "r", &[redo(1)]),
        (&typing_page(), "↑r", &[redo(0)]),
        (&typing_page(), "e", &[Action::EmergencyStop]),
        (&typing_page(), "q", &[]),
        (&typing_page(), "qn", &[]),
        (&typing_page(), "qy", &[Action::Quit]),
        (&typing_page(), "pac ", &[]),
        (&review(), "\n", &[ready]),
        (&review(), "r", &[redo(3)]),
        (&review(), "↓↓↓↓r", &[redo(5)]),
        (&review(), "↑↑↑↑↑↑r", &[redo(0)]),
        (&review(), "12", &[]),
        (&done, "\n", &[ready]),
        (&done, "r", &[]),
        (&working, "\n", &[]),
        (&working, "5\n", &[]),
        (&working, "r", &[]),
        (&working, "e", &[Action::EmergencyStop]),
        (&failed, "q", &[Action::Quit]),
        (&failed, "\n", &[Action::Quit]),
    ];
    for (calibration, keys, expected) in table {
        let mut state = state((*calibration).clone());
        let actions = press(&mut state, keys);
        assert_eq!(actions, *expected, "{keys:?} at {:?}", calibration.asked);
    }
}

#[test]
fn typed_text_is_shown_and_a_typing_error_explained() {
    let mut state = state(typing_page());
    press(&mut state, "1.2.");
    assert!(row(&state, 80, 24, 3).contains("1.2.▏ μm"));
    press(&mut state, "\n");
    assert!(row(&state, 80, 24, 23).contains("1.2. is not a number"));
    press(&mut state, "\u{8}5\n");
    assert_eq!(state.ui.typed, "");
}

#[test]
fn the_chosen_point_is_marked_and_the_worst_is_named() {
    let mut state = state(review());
    let screen: String = (0..24).map(|y| row(&state, 80, 24, y) + "\n").collect();
    let worst = screen
        .lines()
        .find(|line| line.contains("nm worst"))
        .unwrap();
    assert!(worst.starts_with("▸ 4"), "{worst}");
    press(&mut state, "↑");
    let screen: String = (0..24).map(|y| row(&state, 80, 24, y) + "\n").collect();
    let selected_line = screen
        .lines()
        .find(|line| line.starts_with('▸') && line.contains(" V "))
        .unwrap();
    assert!(selected_line.starts_with("▸ 3"), "{selected_line}");
}

#[test]
fn the_bench_and_the_log_are_looked_at_and_nothing_is_answered_there() {
    let done = CalibrationPage {
        asked: Some(Question::Done),
        ..typing_page()
    };
    for calibration in [done, review(), typing_page()] {
        let mut state = state(calibration);
        for (key, page) in [
            ("\t", Page::Bench),
            ("\t", Page::Log),
            ("\t", Page::Run),
            ("\t5", Page::Log),
            ("4", Page::Bench),
        ] {
            assert_eq!(press(&mut state, key), []);
            assert_eq!(state.ui.page, page);
        }
        let screen: String = (0..24).map(|y| row(&state, 80, 24, y)).collect();
        assert!(screen.contains("press 1 to return"), "{screen}");
        // The points and the typed text are not shown here.
        assert_eq!(press(&mut state, "\n"), []);
        assert!(row(&state, 80, 24, 23).contains("return to the calibration"));
        assert_eq!(press(&mut state, "r.\n7\n"), []);
        assert_eq!((state.ui.page, state.ui.typed.as_str()), (Page::Bench, ""));
        assert_eq!(
            press(&mut state, "eqy"),
            [Action::EmergencyStop, Action::Quit]
        );
        press(&mut state, "1");
        assert_eq!(state.ui.page, Page::Run);
    }
}

#[test]
fn a_number_that_is_half_typed_is_still_there_after_a_look_at_the_bench() {
    let mut state = state(typing_page());
    assert_eq!(
        press(&mut state, "1.4\t5\t5\n"),
        [Action::Answer(Reply::Number(1.45))]
    );
}

#[test]
fn a_calibration_that_calls_for_its_operator_brings_its_page_back() {
    let working = CalibrationPage {
        asked: None,
        ..typing_page()
    };
    let looking_state = || {
        let mut state = state(working.clone());
        press(&mut state, "4?");
        state
    };
    let is_called = |events: &[Event]| {
        let mut state = looking_state();
        events.iter().for_each(|event| state.apply(event));
        assert_eq!(state.ui.page == Page::Run, !state.ui.help);
        state.ui.page == Page::Run
    };
    let page = Event::Calibration;
    assert!(is_called(&[page(typing_page())]));
    assert!(is_called(&[page(CalibrationPage {
        failed: true,
        ..working.clone()
    })]));
    let safety = |state| Event::Safety {
        state,
        reason: None,
    };
    assert!(is_called(&[safety(SafetyView::Tripped)]));
    for state in [SafetyView::Disarmed, SafetyView::Armed, SafetyView::Driving] {
        assert!(!is_called(&[safety(state)]));
    }
    let next = CalibrationPage {
        step: 6,
        instruction: "Driving 27.86 V.".to_owned(),
        ..working.clone()
    };
    assert!(!is_called(&[page(next)]), "it works on");
    // An operator who turns away from a question may stay on another page until the next question.
    let mut state = looking_state();
    state.apply(&page(typing_page()));
    press(&mut state, "\t");
    state.apply(&page(CalibrationPage {
        findings: vec!["off a line by 0.1 %".to_owned()],
        ..typing_page()
    }));
    state.apply(&safety(SafetyView::Tripped));
    press(&mut state, "\t\t\t\t");
    state.apply(&safety(SafetyView::Tripped));
    assert_eq!(state.ui.page, Page::Bench);
    state.apply(&page(CalibrationPage {
        note: Some("again, please".to_owned()),
        ..typing_page()
    }));
    assert_eq!(state.ui.page, Page::Run);
}

/// Regression test: a stopped calibration asked for Enter, which does nothing before the bench is re-armed.
#[test]
fn a_stopped_calibration_asks_for_x_and_not_for_enter() {
    let mut state = state(CalibrationPage {
        asked: Some(Question::Done),
        ..typing_page()
    });
    let screen = |state: &State| (0..24).map(|y| row(state, 80, 24, y)).collect::<String>();
    assert!(screen(&state).contains("press Enter when done"));
    state.apply(&Event::Safety {
        state: SafetyView::Tripped,
        reason: None,
    });
    let stopped = screen(&state);
    assert!(!stopped.contains("press Enter when done"), "{stopped}");
    assert!(stopped.contains("x re-arms"), "{stopped}");
}
