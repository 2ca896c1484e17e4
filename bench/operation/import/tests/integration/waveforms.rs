//! Channels of a TDMS file, each with an interval and a start of its own.

use std::fs;
use std::path::PathBuf;

use recording::reader::position_rows;

use crate::laboratory::{Laboratory, tdms};
use crate::{import_all, refusal};

const FORCE_S: f64 = 1e-3;
const POSITION_S: f64 = 1.0 / 60.0;
const MAP: &str = r#"
format = 1
files = 'run_(?<participant>\d)\.tdms'
normal = { from = "slow/Fn", rate_hz = "file", newtons_per_unit = 1.0 }
lateral = { from = "slow/Ft", newtons_per_unit = 1.0 }
position = { from = "slow/x", rate_hz = "file", metres_per_unit = 1.0 }
intervals = { exploration = "30 to 50 mm/s for 0.5 s" }
"#;

fn series(step_s: f64, value: fn(f64) -> f64) -> Vec<f64> {
    let count = (4.0 / step_s) as usize;
    (0..count).map(|n| value(n as f64 * step_s)).collect()
}

/// Writes forces from `force_start_s` on and positions from `position_start_s` on, of a slide from 1 to 3 s of the positions.
fn write(laboratory: &Laboratory, force_start_s: f64, position_start_s: f64) -> PathBuf {
    let normal = series(FORCE_S, |t| 0.6 * f64::from((1.0..3.0).contains(&t)));
    let lateral: Vec<f64> = normal.iter().map(|force| 0.4 * force).collect();
    let position = series(POSITION_S, |t| 0.02 + 0.04 * (t - 1.0).clamp(0.0, 2.0));
    let channels = [
        ("Fn", &normal[..], [FORCE_S, force_start_s]),
        ("Ft", &lateral[..], [FORCE_S, force_start_s]),
        ("x", &position[..], [POSITION_S, position_start_s]),
    ];
    fs::write(laboratory.folder().join("run_3.tdms"), tdms(&channels)).unwrap();
    laboratory.study().join("sub-3/ses-01/trial-001_attempt-1")
}

fn last_position_s(folder: &std::path::Path) -> f64 {
    let rows = position_rows(folder, f64::INFINITY).unwrap();
    rows.map(|row| row.unwrap().time_s).last().unwrap()
}

#[test]
fn channels_of_one_file_have_the_rate_that_it_states_of_each() {
    let laboratory = Laboratory::with_reference();
    let folder = write(&laboratory, 0.0, 0.0);
    let reports = import_all(&laboratory, MAP);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let last_s = last_position_s(&folder);
    assert!((last_s - 4.0).abs() < 0.05, "{last_s}");
    // With one rate for both, they would be two streams that cannot be of one recording.
    let text = refusal(
        &laboratory,
        &MAP.replace("rate_hz = \"file\", metres", "rate_hz = 1000, metres"),
    );
    assert!(text.contains("rate_hz"), "{text}");
}

/// Regression test: starts of channels were printed and not used.
#[test]
fn channels_of_one_file_have_the_start_that_it_states_of_each() {
    for (force_start_s, position_start_s, later_s, words) in [
        (0.0, 0.35, 0.35, Some("begin 0.350000 s after")),
        (7.5, 7.25, -0.25, Some("begin 0.250000 s before")),
        (7.5, 7.5, 0.0, None),
    ] {
        let laboratory = Laboratory::with_reference();
        let folder = write(&laboratory, force_start_s, position_start_s);
        let reports = import_all(&laboratory, MAP);
        assert!(reports[0].outcome.is_ok(), "{reports:?}");
        let notes = reports[0].notes.join("\n");
        assert_eq!(
            notes.contains("position: its samples begin"),
            words.is_some(),
            "{notes}"
        );
        assert!(words.is_none_or(|words| notes.contains(words)), "{notes}");
        let last_s = last_position_s(&folder);
        let stated_s = 4.0 - POSITION_S + later_s;
        assert!((last_s - stated_s).abs() < 1e-3, "{last_s}");
    }
    // An offset of the map has the last word.
    let laboratory = Laboratory::with_reference();
    let folder = write(&laboratory, 0.0, 0.35);
    let map = MAP.replace(
        "metres_per_unit",
        "offset_s = 0.1, clock = \"own\", metres_per_unit",
    );
    let reports = import_all(&laboratory, &map);
    assert!(reports[0].outcome.is_ok(), "{reports:?}");
    let last_s = last_position_s(&folder);
    assert!((last_s - (4.1 - POSITION_S)).abs() < 1e-3, "{last_s}");
}
