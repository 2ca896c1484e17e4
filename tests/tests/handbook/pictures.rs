//! The handbook's screenshots, drawn by the program from calibrations and a session on a simulated bench.

use std::sync::OnceLock;

use bench_tests::handbook::folder;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use tui::calibration_page::Question;
use tui::event::{PhaseKind, SafetyState};
use tui::picture::{Paper, svg};
use tui::{Instruction, Page, State, Theme, participant_screen};

use super::simulated::{Deed, Shot, Taken, calibrated, drawn, session};

/// Columns and rows of the dashboard, and of a calibration's page.
const DASHBOARD: (u16, u16) = (110, 36);
const CALIBRATION: (u16, u16) = (92, 26);
/// Number of readings, 20 or 30 a second, for which a screen settles before it is taken.
const SETTLING: u32 = 12;

fn reviewed(state: &State) -> bool {
    let page = state.calibration.as_ref();
    page.is_some_and(|page| page.asked == Some(Question::Review))
}

/// A mass of 100 g is asked for and lies on the plate.
fn weighed(state: &State) -> bool {
    let page = state.calibration.as_ref();
    let shown_n = state.readings.and_then(|now| now.normal_n);
    page.is_some_and(|page| page.instruction.starts_with("Put 100 g")) && shown_n > Some(0.9)
}

/// The second exploration of a second attempt, whose slider comes back and is past `to_m`.
fn coming_back(state: &State, to_m: f64) -> bool {
    let phase = &state.phase;
    (phase.kind, phase.attempt, phase.exploration) == (PhaseKind::Exploration, 2, 2)
        && state
            .live()
            .is_some_and(|live| live.slider_m < Some(to_m) && live.mu.is_some())
}

/// The states of the screen that the pictures show: made once, for all of them.
pub fn taken() -> &'static [(&'static str, State)] {
    static TAKEN: OnceLock<Vec<(&str, State)>> = OnceLock::new();
    TAKEN.get_or_init(|| {
        let shot = |name, when| Shot {
            name,
            when,
            after: SETTLING,
            then: None,
        };
        let taken = Taken::default();
        let room = tempfile::tempdir().unwrap();
        let calibration = room.path().join("calibration.toml");
        let pages = [
            shot("pickup", reviewed),
            shot("plate", reviewed),
            shot("force", weighed),
        ];
        calibrated(&calibration, pages, &taken);
        let shots = vec![
            shot("participant", |state| {
                let shown = state.participant.as_ref().filter(|_| !state.phase.practice);
                shown.is_some_and(|shown| {
                    shown.instruction == Instruction::FollowSlider && shown.slider_m > Some(0.04)
                })
            }),
            shot("force shown", |state| {
                let shown = state.participant.as_ref().filter(|_| !state.phase.practice);
                shown.is_some_and(|shown| shown.instruction == Instruction::Feedback)
            }),
            shot("rejected", |state| {
                let verdict = state.verdict.as_ref();
                verdict.is_some_and(|verdict| !verdict.accepted && !verdict.practice)
                    && state.phase.kind == PhaseKind::Verdict
            }),
            shot("trial", |state| coming_back(state, 0.06)),
            Shot {
                name: "before the stop",
                after: 1,
                when: |state| coming_back(state, 0.03),
                then: Some(Deed::PressEstop),
            },
            Shot {
                name: "stopped",
                after: 4 * SETTLING,
                when: |state| {
                    state.safety == Some(SafetyState::Tripped)
                        && state.phase.kind == PhaseKind::Paused
                },
                then: Some(Deed::Leave),
            },
        ];
        session(room.path(), &calibration, shots, &taken);
        std::mem::take(&mut *taken.lock().unwrap())
    })
}

pub fn state(name: &str) -> &'static State {
    let found = taken().iter().find(|(taken, _)| *taken == name);
    &found.unwrap_or_else(|| panic!("{name} never came")).1
}

fn kept(name: &str, screen: &Buffer, title: &str) {
    let path = folder().join("src/pictures").join(name);
    super::same(&path, svg(screen, title, Paper::Dark));
}

#[test]
fn the_dashboard_in_a_trial() {
    let title = "The operator's dashboard in the middle of a trial";
    kept("screen-trial.svg", &drawn(state("trial"), DASHBOARD), title);
}

#[test]
fn the_dashboard_after_a_rejected_trial() {
    let title = "The page of the trials after one that must be repeated, with the reasons";
    let mut state = state("rejected").clone();
    state.ui.page = Page::Trials;
    kept("screen-rejected.svg", &drawn(&state, DASHBOARD), title);
}

#[test]
fn the_dashboard_after_a_stop() {
    let title = "The dashboard after the e-stop has stopped the drive";
    kept(
        "screen-stopped.svg",
        &drawn(state("stopped"), DASHBOARD),
        title,
    );
}

#[test]
fn what_the_participant_sees() {
    let shown = state("participant").participant.as_ref().unwrap();
    let area = Rect::new(0, 0, 80, 22);
    let mut screen = Buffer::empty(area);
    participant_screen::view(shown, Theme::Colour, area, &mut screen);
    let title = "The participant's screen while the finger follows the slider";
    kept("screen-participant.svg", &screen, title);
}

#[test]
fn the_page_of_calibrate_pickup() {
    let title = "calibrate pickup: the points are reviewed before anything is written";
    kept(
        "screen-pickup.svg",
        &drawn(state("pickup"), CALIBRATION),
        title,
    );
}

#[test]
fn the_page_of_calibrate_plate() {
    let title = "calibrate plate: the response is reviewed";
    kept(
        "screen-plate.svg",
        &drawn(state("plate"), CALIBRATION),
        title,
    );
}

#[test]
fn the_page_of_calibrate_force() {
    let title = "calibrate force: a known mass is asked for, and its weight shown live";
    kept(
        "screen-force.svg",
        &drawn(state("force"), CALIBRATION),
        title,
    );
}
