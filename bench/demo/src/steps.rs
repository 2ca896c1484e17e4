//! The steps of the demonstration.

use std::ffi::OsString;
use std::path::Path;

/// A step: what it is for, and the words of its command.
#[derive(Debug)]
pub struct Step {
    /// What it is for, with the command that a user would type.
    pub title: &'static str,
    /// Words after the program's name.
    pub words: Vec<OsString>,
}

/// Words of every step at the bench. The simulated bench's constants differ from its description; they come from the seed, and
/// calibration must find them.
const BENCH: [&str; 4] = ["--mock", "bench-unknown", "--seed", "7"];
/// Name of whoever is asked for an operator or a consent.
const OPERATOR: &str = "the demonstration";

/// Returns the steps of a demonstration in `folder`.
pub fn steps(folder: &Path) -> Vec<Step> {
    let path = |name: &str| folder.join(name).into_os_string();
    let bench = |words: &[&str]| -> Vec<OsString> {
        let mut all: Vec<_> = words.iter().chain(&BENCH).map(OsString::from).collect();
        all.extend(["--calibration".into(), path("calibration/calibration.toml")]);
        all
    };
    let calibrate = |title, what: &[&str]| {
        let mut words = bench(&[&["calibrate"][..], what].concat());
        words.extend(["--speed", "max", "--operator", OPERATOR, "--headless"].map(OsString::from));
        Step { title, words }
    };
    let of_the_study = |title, words: &[&str], more: &[&str]| {
        let mut words = bench(words);
        words.extend(["--protocol", "demo"].map(OsString::from));
        words.extend(["--study".into(), path("study")]);
        words.extend(more.iter().map(OsString::from));
        Step { title, words }
    };
    vec![
        calibrate(
            "Calibrate the inputs: gain, delay, noise  (friction-bench calibrate channels)",
            &["channels"],
        ),
        calibrate(
            "Calibrate the pickup against a vibrometer  (friction-bench calibrate pickup)",
            &["pickup"],
        ),
        calibrate(
            "Measure the plate: resonance, damping, force factor  (friction-bench calibrate plate)",
            &["plate"],
        ),
        calibrate(
            "Calibrate the force sensor with known masses  (friction-bench calibrate force)",
            &[
                "force",
                "--normal-g",
                "20,50,100,200",
                "--lateral-g",
                "20,50,100",
            ],
        ),
        of_the_study(
            "Check that the bench is connected, works, and is as calibrated  (friction-bench check)",
            &["check"],
            &[],
        ),
        of_the_study(
            "Run a session of one virtual participant, faster than real time  (friction-bench run)",
            &["run", "--speed", "max", "--headless"],
            &["--participant", "sub-01", "--consent-by", OPERATOR],
        ),
        Step {
            title: "Analyse the recordings: impedance, gap, friction  (friction-bench analyze)",
            words: vec![
                "analyze".into(),
                path("study"),
                "--table".into(),
                "--json".into(),
                path("results.json"),
                "--figures".into(),
                path("figures"),
            ],
        },
    ]
}
