//! The steps of the demonstration.

use std::ffi::OsString;
use std::path::Path;

/// A step: its purpose and the arguments of its command.
#[derive(Debug)]
pub struct Step {
    /// Purpose, with the command that a user would type.
    pub title: &'static str,
    /// Arguments after the program's name.
    pub words: Vec<OsString>,
}

/// Arguments of every step at the bench. The constants of the simulated bench differ from its description; the seed determines
/// them, and the calibration must find them.
const BENCH: [&str; 4] = ["--mock", "bench-unknown", "--seed", "7"];
/// Name given as operator and for the consent.
const OPERATOR: &str = "the demonstration";

/// Returns the arguments of a command at the demonstration's bench, with its calibration.
fn at_bench(folder: &Path, words: &[&str]) -> Vec<OsString> {
    let calibration = folder.join("calibration/calibration.toml");
    let mut all: Vec<_> = words.iter().chain(&BENCH).map(OsString::from).collect();
    all.extend(["--calibration".into(), calibration.into_os_string()]);
    all
}

/// Returns the arguments of a further session of the study, in real time and with the dashboard.
pub fn further_session(folder: &Path) -> Vec<OsString> {
    let mut words = at_bench(folder, &["run"]);
    words.extend(["--protocol", "demo", "--study"].map(OsString::from));
    words.push(folder.join("study").into_os_string());
    words.extend(["--participant", "sub-02", "--consent-by", "ME"].map(OsString::from));
    words
}

/// Returns the steps of a demonstration in `folder`.
pub fn steps(folder: &Path) -> Vec<Step> {
    let path = |name: &str| folder.join(name).into_os_string();
    let bench = |words: &[&str]| at_bench(folder, words);
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
            "Check the volts against a meter  (friction-bench calibrate output)",
            &["output", "--meter", "simulated", "--reads", "rms"],
        ),
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

#[cfg(test)]
mod tests {
    use config::CalibrationKind;

    use super::*;

    #[test]
    fn the_calibrations_come_in_their_order() {
        let names = steps(Path::new("demo")).into_iter().filter_map(|step| {
            let is_calibration = step.words.first().is_some_and(|word| word == "calibrate");
            let name = step.words.get(1)?.to_string_lossy().into_owned();
            is_calibration.then_some(name)
        });
        let names: Vec<String> = names.collect();
        assert_eq!(names, CalibrationKind::ORDER.map(CalibrationKind::name));
    }
}
