//! The screen after a device is lost for good.

use tui::event::{
    BenchFacts, BenchLine, Live, LostDevices, PartFact, PhaseKind, SafetyView, SystemHealth,
};
use tui::{Event, Page, State};

use crate::rig::{draw, play_until, press};

fn screen(state: &State) -> String {
    let buffer = draw(state, 120, 40).backend().buffer().clone();
    let row = |y| (0..buffer.area.width).map(move |x| (x, y));
    let rows = (0..buffer.area.height).map(row);
    rows.map(|cells| {
        cells
            .map(|place| buffer[place].symbol())
            .collect::<String>()
            + "\n"
    })
    .collect()
}

/// Returns a session that is stopped because devices are lost.
fn stopped(lost: LostDevices) -> State {
    let mut state = play_until(|state| state.phase.kind == PhaseKind::Exploration);
    let part = |name: &str, line| PartFact {
        name: name.to_owned(),
        words: "serial".to_owned(),
        well: true,
        line: Some(line),
    };
    state.apply(&Event::Bench(BenchFacts {
        parts: vec![
            part("force", BenchLine::ForceSensor),
            part("sound card", BenchLine::SoundCard),
        ],
        ..BenchFacts::default()
    }));
    state.apply(&Event::Safety {
        state: SafetyView::Tripped,
        reason: Some("the device is gone".to_owned()),
    });
    state.apply(&Event::Health(SystemHealth {
        force_rate_hz: Some(0.0),
        speed: 1.0,
        lost,
        ..SystemHealth::default()
    }));
    state.phase.kind = PhaseKind::Paused;
    state.phase.stopped = true;
    state
}

#[test]
fn a_lost_force_sensor_is_marked_and_re_arming_is_refused_with_the_remedy() {
    let mut state = stopped(LostDevices {
        force_sensor: true,
        ..LostDevices::default()
    });
    let run = screen(&state);
    assert!(
        !run.contains("bench well") && !run.contains("nothing lost"),
        "{run}"
    );
    assert!(run.contains("no force readings"), "{run}");
    assert!(
        !run.contains("x re-arms") && !run.contains("x to re-arm"),
        "{run}"
    );
    assert!(run.contains("x cannot re-arm"), "{run}");
    assert!(run.contains("q, y ends the session"), "{run}");
    assert!(run.contains("run --resume"), "{run}");
    assert_eq!(press(&mut state, "x"), Vec::new());
    assert_eq!(state.ui.confirm, None);
    let answer = state.ui.note.clone().unwrap();
    assert!(
        answer.contains("q, y") && answer.contains("--resume"),
        "{answer}"
    );
    state.ui.page = Page::Bench;
    let bench = screen(&state);
    assert!(
        bench.contains("✗ force") && bench.contains("LOST"),
        "{bench}"
    );
    assert!(bench.contains("✓ sound card"), "{bench}");
    assert!(bench.contains("no: force readings"), "{bench}");
    assert!(!bench.contains("0 Hz"), "{bench}");
}

#[test]
fn no_value_of_a_lost_card_is_shown_as_live() {
    let mut state = stopped(LostDevices {
        sound_card: true,
        ..LostDevices::default()
    });
    let last = *state.live().unwrap();
    assert_eq!(
        last,
        Live {
            t_s: last.t_s,
            ..Live::default()
        }
    );
    // The bench still reports the last values that it has.
    state.apply(&Event::Live(Live {
        normal_n: Some(0.62),
        ..last
    }));
    assert_eq!(state.live().unwrap().normal_n, None);
    state.ui.page = Page::Bench;
    let bench = screen(&state);
    assert!(
        bench.contains("✗ sound card") && bench.contains("no: audio"),
        "{bench}"
    );
}

/// A sensor that is only silent can come back: the keys stay those of a stop that can be re-armed.
#[test]
fn a_silent_force_sensor_is_not_well_and_can_be_re_armed() {
    let mut state = stopped(LostDevices::default());
    let run = screen(&state);
    assert!(
        !run.contains("bench well") && run.contains("x re-arms"),
        "{run}"
    );
    press(&mut state, "x");
    assert_eq!(state.ui.confirm, Some(tui::Action::Rearm));
}
