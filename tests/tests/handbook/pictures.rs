//! The handbook's screenshots, drawn by the program from a made-up session and made-up calibrations.

#[path = "../../../tui/examples/dashboard/synthetic.rs"]
#[allow(dead_code, reason = "the example and other tests use the rest")]
mod synthetic;

use bench_tests::handbook::folder;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use tui::calibration_page::{
    CalibrationPage, CalibrationReadings, Chart, MainReading, PointLine, Question,
};
use tui::event::{PhaseKind, SafetyState, SessionHeader};
use tui::picture::{Paper, svg};
use tui::{Event, Instruction, State, Theme, participant_screen, view};

/// Columns and rows of the dashboard, and of a calibration's page.
const DASHBOARD: (u16, u16) = (110, 36);
const CALIBRATION: (u16, u16) = (92, 26);

fn kept(name: &str, screen: &Buffer, title: &str) {
    let path = folder().join("src/pictures").join(name);
    super::same(&path, svg(screen, title, Paper::Dark));
}

fn drawn(state: &State, (columns, rows): (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    terminal.draw(|frame| view(state, frame)).unwrap();
    terminal.backend().buffer().clone()
}

/// The made-up session, played until `wanted` holds for the first time.
fn played_until(wanted: impl Fn(&State) -> bool) -> State {
    let mut state = State::new(Theme::Colour);
    for (at_s, event) in synthetic::session() {
        state.apply(&Event::Tick { now_s: at_s });
        state.apply(&event);
        if wanted(&state) {
            return state;
        }
    }
    panic!("the session never gets there");
}

fn exploring() -> State {
    played_until(|state| {
        state.phase.kind == PhaseKind::Exploration
            && (state.phase.trial, state.phase.practice) == (2, false)
            && state.live().and_then(|live| live.slider_m) > Some(0.06)
    })
}

#[test]
fn the_dashboard_in_a_trial() {
    let title = "The operator's dashboard in the middle of a trial";
    kept("screen-trial.svg", &drawn(&exploring(), DASHBOARD), title);
}

#[test]
fn the_dashboard_after_a_rejected_trial() {
    let state = played_until(|state| state.verdict.as_ref().is_some_and(|v| !v.accepted));
    let title = "The dashboard after a trial that must be repeated, with the reasons";
    kept("screen-rejected.svg", &drawn(&state, DASHBOARD), title);
}

#[test]
fn the_dashboard_after_a_stop() {
    let mut state = exploring();
    for event in synthetic::trip() {
        state.apply(&event);
    }
    let title = "The dashboard after the force limit has stopped the drive";
    kept("screen-stopped.svg", &drawn(&state, DASHBOARD), title);
}

#[test]
fn what_the_participant_sees() {
    let state = played_until(|state| {
        let shown = state.participant.as_ref();
        shown.is_some_and(|shown| {
            shown.instruction == Instruction::FollowSlider && shown.slider_m > Some(0.04)
        })
    });
    let shown = state.participant.unwrap();
    let area = Rect::new(0, 0, 80, 22);
    let mut screen = Buffer::empty(area);
    participant_screen::view(&shown, Theme::Colour, area, &mut screen);
    let title = "The participant's screen while the finger follows the slider";
    kept("screen-participant.svg", &screen, title);
}

/// Levels, V, known amplitudes, µm, and what they depart from their line by, nm.
const LADDER: [(f64, f64, f64); 6] = [
    (5.07, 0.3372, 0.12),
    (12.66, 0.8430, -0.31),
    (20.26, 1.3488, 0.22),
    (27.86, 1.8547, -4.18),
    (35.46, 2.3604, 0.35),
    (43.06, 2.8664, 0.28),
];

fn calibrating(page: CalibrationPage, driven: bool, normal_n: f64) -> Buffer {
    let mut state = State::new(Theme::Colour);
    let readings = CalibrationReadings {
        normal_n: Some(normal_n),
        lateral_n: Some(-0.001),
        drive_v: Some(if driven { 20.26 } else { 0.0 }),
        amplitude_m: Some(if driven { 1.3491e-6 } else { 1e-10 }),
        known_m: None,
        level: Some(0.338),
    };
    let safety = if driven {
        SafetyState::Driving
    } else {
        SafetyState::Armed
    };
    for event in [
        Event::Tick { now_s: 0.0 },
        Event::Session(SessionHeader {
            simulated: true,
            ..SessionHeader::default()
        }),
        Event::Calibration(page),
        Event::CalibrationReadings(readings),
        Event::Safety {
            state: safety,
            reason: None,
        },
    ] {
        state.apply(&event);
    }
    drawn(&state, CALIBRATION)
}

#[test]
fn the_page_of_calibrate_pickup() {
    let point = |(drive_v, known_um, residual_nm): &(f64, f64, f64)| PointLine {
        at: format!("{drive_v:.2} V"),
        value: format!("{known_um:.4} µm"),
        residual: Some(format!("{residual_nm:+.1} nm").replace('-', "−")),
        worst: residual_nm.abs() > 1.0,
    };
    let page = CalibrationPage {
        title: "calibrate pickup".to_owned(),
        step: 9,
        steps: 10,
        instruction: "Look at the points. Keep them, or measure one of them again.".to_owned(),
        note: Some(
            "the points depart from a line by 0.15 % of the largest amplitude: repeat the worst one"
                .to_owned(),
        ),
        asked: Some(Question::Review),
        points: LADDER.iter().map(point).collect(),
        curve: Some(Chart {
            x: "drive, V".to_owned(),
            y: "off the line, nm".to_owned(),
            points: LADDER.iter().map(|at| (at.0, at.2)).collect(),
            fit: vec![(0.0, 0.0), (43.06, 0.0)],
        }),
        findings: vec![
            "sensitivity 4.9963 µm/unit ± 0.11 %".to_owned(),
            "off a line by 0.146 % at most".to_owned(),
        ],
        ..CalibrationPage::default()
    };
    let title = "calibrate pickup: the points are reviewed before anything is written";
    kept("screen-pickup.svg", &calibrating(page, false, 0.0), title);
}

#[test]
fn the_page_of_calibrate_plate() {
    // A resonance of Q 250 at 35 kHz.
    let response = |hz: f64| {
        let detuning: f64 = 2.0 * 250.0 * (hz - 35_000.0) / 35_000.0;
        2.8 / (1.0 + detuning * detuning).sqrt()
    };
    let tones: Vec<(f64, f64)> = (0..60)
        .map(|i| 34_700.0 + 10.0 * f64::from(i))
        .map(|hz| (hz / 1e3, response(hz)))
        .collect();
    let page = CalibrationPage {
        title: "calibrate plate".to_owned(),
        step: 3,
        steps: 4,
        instruction: "Sweeping: keep everything off the plate.".to_owned(),
        curve: Some(Chart {
            x: "frequency, kHz".to_owned(),
            y: "amplitude, µm".to_owned(),
            points: tones.clone(),
            fit: tones,
        }),
        findings: vec![
            "resonance 35.000 kHz ± 0.2 Hz, Q 250".to_owned(),
            "force factor 0.112 N/V ± 0.4 %".to_owned(),
        ],
        ..CalibrationPage::default()
    };
    let title = "calibrate plate: the resonance as it is swept";
    kept("screen-plate.svg", &calibrating(page, true, 0.0), title);
}

#[test]
fn the_page_of_calibrate_force() {
    let point = |at: &str, value: &str| PointLine {
        at: at.to_owned(),
        value: value.to_owned(),
        ..PointLine::default()
    };
    let page = CalibrationPage {
        title: "calibrate force".to_owned(),
        step: 4,
        steps: 9,
        instruction: "Put 100 g on the middle of the plate, and nothing else.".to_owned(),
        asked: Some(Question::Done),
        watched: MainReading::NormalForce,
        points: vec![
            point("20 g normal", "0.196 N"),
            point("50 g normal", "0.490 N"),
        ],
        ..CalibrationPage::default()
    };
    let title = "calibrate force: a known mass is asked for, and its weight shown live";
    kept("screen-force.svg", &calibrating(page, false, 0.972), title);
}
