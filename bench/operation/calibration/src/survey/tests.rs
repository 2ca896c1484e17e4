//! Steps of a measurement under a finger that rests, presses too hard, or trembles.

use crate::plate_procedure::{PlateProcedure, PlateSetup};
use calibration_rig::capture::Capture;
use calibration_rig::operator::{Answer, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::{CalibrationFile, Config, Identity, PROFILE_RATIOS, Uniformity};

use crate::survey::finger_procedure::FingerProcedure;
use crate::survey::profile_procedure::{ProfilePoint, ProfileProcedure};
use crate::survey::profile_verdict::{judge_length, judge_places};
use crate::survey::survey_axis::{PLACES, PLACES_ACROSS, SurveyAxis};

const CONFIG: &str = config::rigs::MOCK_BENCH;

fn plate(config: &Config) -> anyhow::Result<PlateProcedure> {
    let identity = Identity::from_config(config, String::new(), String::new());
    let setup = PlateSetup::new(config, &CalibrationFile::new(identity), 20.0)?;
    Ok(PlateProcedure::new(setup))
}

fn procedure(config: &str, attended: bool) -> anyhow::Result<FingerProcedure> {
    let config = Config::parse(config, "test")?;
    FingerProcedure::new(plate(&config)?, &config, attended)
}

/// Returns a capture with this normal force, N, alternating by ± `tremor_n`.
fn capture_under(normal_n: f64, tremor_n: f64) -> Capture {
    Capture {
        normal_n: vec![normal_n - tremor_n, normal_n + tremor_n],
        lateral_n: vec![0.0; 2],
        ..Capture::default()
    }
}

fn asks_for_the_finger(step: &NextStep) -> bool {
    matches!(step, NextStep::Ask(Request::RestFinger { .. }))
}

/// Places a finger in a procedure that has measured the bare plate.
fn place_finger(finger: &mut FingerProcedure) {
    finger.ask();
    let ready = StepOutcome::Answered(Answer::Ready, Capture::default());
    assert!(matches!(finger.next(ready).unwrap(), NextStep::Listen(_)));
}

/// Hazard 10.
#[test]
fn nothing_is_driven_under_a_finger_that_does_not_rest_as_it_must() {
    for (normal_n, tremor_n) in [
        (0.0, 0.0),
        (0.29, 0.0),
        (1.01, 0.0),
        (0.6, 0.2),
        (f64::NAN, 0.0),
    ] {
        let mut finger = procedure(CONFIG, true).unwrap();
        place_finger(&mut finger);
        let step = finger
            .next(StepOutcome::Captured(capture_under(normal_n, tremor_n)))
            .unwrap();
        assert!(
            asks_for_the_finger(&step),
            "{normal_n} ± {tremor_n}: {step:?}"
        );
        assert!(finger.progress().note.is_some());
    }
}

#[test]
fn without_an_operator_the_survey_ends() {
    let mut finger = procedure(CONFIG, false).unwrap();
    for last in [false, false, true] {
        place_finger(&mut finger);
        let next = finger.next(StepOutcome::Captured(capture_under(2.0, 0.0)));
        assert_eq!(next.is_err(), last);
    }
}

/// Hazard 5.
#[test]
fn a_bench_that_wants_a_held_switch_or_has_no_force_sensor_drives_no_finger() {
    assert!(procedure(CONFIG, true).is_ok());
    let dead_man = CONFIG.replace("[safety]\n", "[safety]\ndead_man = \"button\"\n");
    let refusal = |text: &str| procedure(text, true).err().map(|error| error.to_string());
    let why = refusal(&dead_man).unwrap_or_default();
    assert!(why.contains("dead_man"), "{why}");
    let from = CONFIG.find("[force]").unwrap();
    let to = CONFIG.find("[encoder]").unwrap();
    let without_force = format!("{}{}", &CONFIG[..from], &CONFIG[to..]);
    let why = refusal(&without_force).unwrap_or_default();
    assert!(why.contains("[force]"), "{why}");
}

/// Returns places with ratios that deviate from one by `departures`, each with this relative error.
fn places(departures: &[f64], error: f64) -> Vec<ProfilePoint> {
    let place = |departure: &f64| ProfilePoint {
        position_m: 0.0,
        ratio: 1.1 * (1.0 + departure),
        error: 1.1 * error,
    };
    departures.iter().map(place).collect()
}

#[test]
fn a_plate_is_uniform_only_if_its_errors_allow_to_say_so() {
    for (departures, error, expected) in [
        ([0.0, 0.0, 0.0], 1e-3, Uniformity::Uniform),
        ([0.009, -0.004, -0.005], 1e-3, Uniformity::Uniform),
        ([0.009, -0.004, -0.005], 1e-2, Uniformity::Undecided),
        ([-0.05, 0.025, 0.025], 1e-3, Uniformity::NotUniform),
        ([-0.05, 0.025, 0.025], 2e-2, Uniformity::Undecided),
    ] {
        let (departure, deviation, verdict) = judge_places(&places(&departures, error));
        assert_eq!(verdict, expected, "{departures:?} ± {error}");
        // The mean includes a third of each place's error, its own included.
        let (own_weight, other_weight) = ((2.0 - departure) / 3.0, (1.0 + departure) / 3.0);
        let expected_error =
            error * (own_weight * own_weight + 2.0 * other_weight * other_weight).sqrt();
        assert!((deviation - expected_error).abs() < 1e-12, "{deviation}");
        let largest = departures[0];
        assert!(
            (departure - largest).abs() < 1e-12,
            "{departure} for {largest}"
        );
    }
}

#[test]
fn a_plate_is_judged_by_each_of_its_places_with_its_error() {
    let verdict = |ratios: [(f64, f64); 3]| {
        let place = |(ratio, error)| ProfilePoint {
            position_m: 0.0,
            ratio,
            error,
        };
        let (departure, _, verdict) = judge_places(&ratios.map(place));
        (verdict, (1e3 * departure).round())
    };
    // The largest deviation is well known; another one may be larger.
    let uncertain_ratios = [(1.015, 1e-4), (0.988, 0.02), (0.997, 1e-4)];
    assert_eq!(verdict(uncertain_ratios), (Uniformity::Undecided, -12.0));
    // The largest deviation is uncertain, another one is not.
    let certain_ratios = [(1.04, 0.02), (0.965, 1e-4), (0.995, 1e-4)];
    assert_eq!(verdict(certain_ratios), (Uniformity::NotUniform, -35.0));
    // The second place differs significantly from the others, but not from a mean that an uncertain place shifts.
    let shifted_ratios = [(1.06, 0.06), (0.975, 1e-4), (0.985, 1e-4)];
    assert_eq!(verdict(shifted_ratios).0, Uniformity::Undecided);
    assert_eq!(judge_places(&[]).2, Uniformity::Undecided);
}

#[test]
fn the_kept_length_is_judged_by_itself_up_to_its_ends() {
    // From 5 mm to 5 mm before the end of a plate of 105 mm; the kept length is from 22.5 to 82.5 mm.
    let profile = |count: u32, drop: f64| -> Vec<ProfilePoint> {
        let place = |i| {
            let position_m = 0.005 + 0.095 * f64::from(i) / f64::from(count - 1);
            let offset = position_m / 0.0525 - 1.0;
            ProfilePoint {
                position_m,
                ratio: 1.1 * (1.0 - drop * offset * offset),
                error: 1e-3,
            }
        };
        (0..count).map(place).collect()
    };
    for (count, drop, plate_verdict, kept_verdict) in [
        (7, 0.0, Uniformity::Uniform, Uniformity::Uniform),
        // Uniform within the kept length, not uniform at the plate's ends.
        (7, 0.06, Uniformity::NotUniform, Uniformity::Uniform),
        (7, 0.2, Uniformity::NotUniform, Uniformity::NotUniform),
        (4, 0.06, Uniformity::NotUniform, Uniformity::Uniform),
        (4, 0.2, Uniformity::NotUniform, Uniformity::NotUniform),
        (3, 0.2, Uniformity::NotUniform, Uniformity::NotUniform),
    ] {
        let places = profile(count, drop);
        assert_eq!(judge_places(&places).2, plate_verdict, "{count}, {drop}");
        let judgement = judge_length(&places, 0.0525).map(|length| length.verdict);
        assert_eq!(judgement, Some(kept_verdict), "{count}, {drop}");
    }
    // The kept length lies about the plate's centre, at any position.
    assert_eq!(judge_length(&profile(7, 0.0), 10.0), None);
    // The ends deviate most: without a reading at one of them, there is no verdict on the whole.
    for (skipped, count_taken) in [(4, 3), (0, 8), (3, 8)] {
        let measured: Vec<ProfilePoint> = profile(11, 0.2)
            .into_iter()
            .skip(skipped)
            .take(count_taken)
            .collect();
        assert_eq!(judge_length(&measured, 0.0525), None, "{measured:?}");
    }
}

#[test]
fn a_ratio_that_no_recording_takes_is_not_kept() {
    let [least, greatest] = PROFILE_RATIOS;
    for usable in [least, 1.0, greatest] {
        assert_eq!(SurveyAxis::Along.unusable(usable), None);
    }
    for ratio in [0.0, least - 1e-9, greatest + 1e-9, f64::INFINITY, f64::NAN] {
        assert!(SurveyAxis::Along.unusable(ratio).is_some(), "{ratio}");
    }
}

#[test]
fn too_few_or_too_many_places_and_a_plate_too_short_for_them_are_refused() {
    let config = Config::parse(CONFIG, "test").unwrap();
    let procedure = |config: &Config, places| {
        ProfileProcedure::along(plate(config).unwrap(), config, 1e-6, places, true)
    };
    let [fewest, most] = PLACES;
    assert!(procedure(&config, fewest).is_ok() && procedure(&config, most).is_ok());
    for places in [0, 1, fewest - 1, most + 1, u32::MAX] {
        assert!(procedure(&config, places).is_err(), "{places}");
    }
    let mut short = config;
    short.plate.length_m = 0.01;
    assert!(procedure(&short, fewest).is_err());
}

#[test]
fn places_across_the_plate_lie_about_the_fingers_line_and_need_its_width() {
    let mut config = Config::parse(CONFIG, "test").unwrap();
    let procedure = |config: &Config, places| {
        ProfileProcedure::across(plate(config).unwrap(), config, 1e-6, places, true)
    };
    config.plate.width_m = None;
    let why = procedure(&config, 9).err().unwrap().to_string();
    assert!(why.contains("plate.width_m"), "{why}");

    config.plate.width_m = Some(0.022);
    let [fewest, most] = PLACES_ACROSS;
    for places in [fewest, most] {
        assert!(procedure(&config, places).is_ok(), "{places}");
    }
    for places in [0, 1, 2, fewest - 1, most + 1, u32::MAX] {
        assert!(procedure(&config, places).is_err(), "{places}");
    }
    let axis = SurveyAxis::across(&config.plate);
    for (width_m, edge_m) in [(0.022, 8e-3), (0.010, 4e-3), (0.3, 8e-3)] {
        config.plate.width_m = Some(width_m);
        let places_m = axis.places_m(&config.plate, 9).unwrap();
        assert!((places_m[0] + edge_m).abs() < 1e-12, "{places_m:?}");
        assert!((places_m[8] - edge_m).abs() < 1e-12 && places_m[4].abs() < 1e-12);
    }
    config.plate.width_m = Some(4e-3);
    assert!(procedure(&config, 9).is_err());
}

#[test]
fn a_place_across_is_named_by_its_side_and_may_be_a_node() {
    let config = Config::parse(CONFIG, "test").unwrap();
    let axis = SurveyAxis::across(&config.plate);
    for (across_m, words) in [
        (0.0, "52.5 mm from its left end and on the line"),
        (4e-3, "and 4.0 mm beyond the line"),
        (-4e-3, "and 4.0 mm before the line"),
    ] {
        let text = axis.request(across_m).words();
        assert!(text.contains(words), "{text}");
    }
    for usable in [0.0, 0.01, 1.0, 5.0] {
        assert_eq!(axis.unusable(usable), None);
    }
    for ratio in [-0.01, 5.01, f64::NAN] {
        assert!(axis.unusable(ratio).is_some(), "{ratio}");
    }
}
