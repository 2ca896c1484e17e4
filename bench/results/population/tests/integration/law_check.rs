//! Reference recordings, compared as if all were of one finger.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::f64::consts::TAU;
use std::path::Path;

use analysis::{Analysis, Settings, analyse};
use population::law_check::{Difference, LawCheck, Setting, law_checks};
use recording::manifest::Streams;

/// Returns two analyses of each recording with this name, all of one participant, with these modulation frequencies.
fn analysed(names: [&str; 2], modulations_hz: [f64; 2]) -> Analysis {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference");
    let folders = [names[0], names[0], names[1], names[1]].map(|name| reference.join(name));
    let mut analysed = analyse(&folders, &Settings::default(), |_| ());
    for (number, recording) in analysed.recordings.iter_mut().enumerate() {
        recording.participant = Some("sub-01".to_owned());
        let findings = recording.findings.as_mut().unwrap();
        if let Streams::Signals(signals) = &mut findings.manifest.streams {
            signals.modulation.frequency_hz = modulations_hz[number / 2];
        }
    }
    analysed
}

/// Returns the differences of the only comparison.
fn differences(check: &LawCheck, setting: Setting) -> [Difference; 5] {
    assert_eq!(check.comparisons.len(), 1, "{check:?}");
    assert_eq!(check.comparisons[0].setting, setting);
    let differences = check.comparisons[0].differences;
    differences.as_array().map(|difference| difference.unwrap())
}

#[test]
fn one_finger_agrees_with_itself() {
    let checks = law_checks(&analysed(["recording-a", "recording-a"], [3.0, 6.0]));
    assert_eq!(checks.len(), 1);
    let drive_v = checks[0].conditions[0].condition.drive_v;
    assert!((drive_v / DRIVE_V - 1.0).abs() < 0.005, "{drive_v}");
    for difference in differences(&checks[0], Setting::ModulationHz) {
        assert!(
            difference.agrees && difference.value.abs() < 1e-9,
            "{difference:?}"
        );
    }
}

/// Largest sample of the drive in recording-a over 1 + 0.95, V.
const DRIVE_V: f64 = 23.72;

#[test]
fn two_fingers_differ_by_their_true_values() {
    let checks = law_checks(&analysed(["recording-c", "recording-a"], [6.0, 6.0]));
    let [sigma_t, area, _, re_z_t, mass] = differences(&checks[0], Setting::DriveV);
    // The truth of recording-a, which was driven by more, minus that of recording-c.
    let expected = [
        (sigma_t, (1.7_f64 / 1.3).ln(), 0.02),
        (area, 0.0, 0.05),
        (re_z_t, 0.47 - 0.30, 0.05),
        (mass, (3.16 - 2.60) / (TAU * 35e3), 0.1e-6),
    ];
    for (difference, expected, tolerance) in expected {
        assert!(
            (difference.value - expected).abs() < tolerance,
            "{difference:?}, truth {expected}"
        );
    }
    assert!(!sigma_t.agrees && area.agrees, "{:?}", checks[0].lines());
}

#[test]
fn recordings_without_a_participant_or_with_another_are_not_compared() {
    let mut analysed = analysed(["recording-c", "recording-a"], [6.0, 6.0]);
    analysed.recordings[0].participant = None;
    analysed.recordings[1].participant = Some("sub-02".to_owned());
    assert_eq!(law_checks(&analysed), []);
}
