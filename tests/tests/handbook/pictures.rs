//! The handbook's screenshots, drawn by the program from calibrations and a session on a simulated bench.

use bench_tests::handbook::folder;
use protocols::Instruction;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use tui::calibration_page::Question;
use tui::event::{PhaseKind, SafetyView};
use tui::picture::{Paper, svg};
use tui::{Page, State, Theme, participant_screen};

use super::simulated::{Captures, Deed, Shot, calibrate_bench, draw, session};
use super::window_pictures;

/// Columns and rows of the dashboard and of a calibration page.
const DASHBOARD: (u16, u16) = (110, 36);
const CALIBRATION: (u16, u16) = (92, 26);
/// Number of readings, at 20 or 30 per second, for which a screen settles before the shot.
const SETTLING: u32 = 12;

fn is_reviewed(state: &State) -> bool {
    let page = state.calibration.as_ref();
    page.is_some_and(|page| page.asked == Some(Question::Review))
}

/// Whether a mass of 100 g is requested and on the plate.
fn is_weighed(state: &State) -> bool {
    let page = state.calibration.as_ref();
    let shown_n = state.readings.and_then(|readings| readings.normal_n);
    page.is_some_and(|page| page.instruction.starts_with("Put 100 g")) && shown_n > Some(0.9)
}

/// Whether the second exploration of a second attempt is running, with the slider coming back and past `to_m`.
fn is_coming_back(state: &State, to_m: f64) -> bool {
    let phase = &state.phase;
    (phase.kind, phase.attempt, phase.exploration) == (PhaseKind::Exploration, 2, 2)
        && state
            .live()
            .is_some_and(|live| live.slider_m < Some(to_m) && live.mu.is_some())
}

/// A state of the screen for each picture, by name.
struct States(Vec<(&'static str, State)>);

impl States {
    fn state(&self, name: &str) -> &State {
        let capture = self
            .0
            .iter()
            .find(|(capture_name, _)| *capture_name == name);
        &capture.unwrap_or_else(|| panic!("{name} never came")).1
    }

    /// Calibrates a simulated bench and runs a session on it.
    fn capture() -> Self {
        let shot = |name, condition| Shot {
            name,
            condition,
            settling: SETTLING,
            deed: None,
        };
        let captures = Captures::default();
        let room = tempfile::tempdir().unwrap();
        let calibration = room.path().join("calibration.toml");
        let pages = [
            shot("pickup", is_reviewed),
            shot("plate", is_reviewed),
            shot("force", is_weighed),
        ];
        calibrate_bench(&calibration, pages, &captures);
        let shots = vec![
            shot("participant", |state| {
                let view = state.participant.as_ref().filter(|_| !state.phase.practice);
                view.is_some_and(|view| {
                    view.instruction == Instruction::FollowSlider && view.slider_m > Some(0.04)
                })
            }),
            shot("force shown", |state| {
                let view = state.participant.as_ref().filter(|_| !state.phase.practice);
                view.is_some_and(|view| view.instruction == Instruction::Feedback)
            }),
            shot("rejected", |state| {
                let verdict = state.verdict.as_ref();
                verdict.is_some_and(|verdict| !verdict.accepted && !verdict.practice)
                    && state.phase.kind == PhaseKind::Verdict
            }),
            shot("trial", |state| is_coming_back(state, 0.06)),
            Shot {
                name: "before the stop",
                settling: 1,
                condition: |state| is_coming_back(state, 0.03),
                deed: Some(Deed::PressEstop),
            },
            Shot {
                name: "stopped",
                settling: 4 * SETTLING,
                condition: |state| {
                    state.safety == Some(SafetyView::Tripped)
                        && state.phase.kind == PhaseKind::Paused
                },
                deed: Some(Deed::Leave),
            },
        ];
        session(room.path(), &calibration, shots, &captures);
        Self(std::mem::take(&mut *captures.lock().unwrap()))
    }
}

fn require_picture(name: &str, screen: &Buffer, title: &str) {
    let path = folder().join("src/pictures").join(name);
    super::require_same(&path, svg(screen, title, Paper::Dark));
}

#[test]
fn pictures_show_the_screens_of_this_program() {
    let states = States::capture();
    let mut rejected = states.state("rejected").clone();
    rejected.ui.page = Page::Trials;
    let view = states.state("participant").participant.as_ref().unwrap();
    let area = Rect::new(0, 0, 80, 22);
    let mut participant = Buffer::empty(area);
    participant_screen::view(view, Theme::Colour, area, &mut participant);
    let dashboard = |name| draw(states.state(name), DASHBOARD);
    let calibration = |name| draw(states.state(name), CALIBRATION);
    let screens = [
        (
            "screen-trial.svg",
            "The operator's dashboard in the middle of a trial",
            dashboard("trial"),
        ),
        (
            "screen-rejected.svg",
            "The page of the trials after one that must be repeated, with the reasons",
            draw(&rejected, DASHBOARD),
        ),
        (
            "screen-stopped.svg",
            "The dashboard after the e-stop has stopped the drive",
            dashboard("stopped"),
        ),
        (
            "screen-participant.svg",
            "The participant's screen while the finger follows the slider",
            participant,
        ),
        (
            "screen-pickup.svg",
            "calibrate pickup: the points are reviewed before anything is written",
            calibration("pickup"),
        ),
        (
            "screen-plate.svg",
            "calibrate plate: the response is reviewed",
            calibration("plate"),
        ),
        (
            "screen-force.svg",
            "calibrate force: a known mass is asked for, and its weight shown live",
            calibration("force"),
        ),
    ];
    for (name, title, screen) in &screens {
        require_picture(name, screen, title);
    }
    let view = |name| states.state(name).participant.as_ref().unwrap();
    window_pictures::require_same_views(view("participant"), view("force shown"));
}
