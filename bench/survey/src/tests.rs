//! The steps of a measurement under a finger that rests, presses too hard, or trembles.

use calibration::capture::Capture;
use calibration::operator::{Answer, Request};
use calibration::plate_procedure::{PlateProcedure, PlateSetup};
use calibration::procedure::{NextStep, Procedure, StepOutcome};
use config::{CalibrationFile, Config, Identity, Uniformity};

use crate::finger_procedure::FingerProcedure;
use crate::profile_procedure::{PLACES, Place, ProfileProcedure};
use crate::profile_verdict::judged;

const CONFIG: &str = include_str!("../../mock-bench.toml");

fn plate(config: &Config) -> anyhow::Result<PlateProcedure> {
    let identity = Identity::of(config, String::new(), String::new());
    let setup = PlateSetup::new(config, &CalibrationFile::of(identity), 20.0)?;
    Ok(PlateProcedure::new(setup))
}

fn procedure(config: &str, attended: bool) -> anyhow::Result<FingerProcedure> {
    let config = Config::parse(config, "test")?;
    FingerProcedure::new(plate(&config)?, &config, attended)
}

/// A capture of so many newtons, alternating by ± `tremor_n`.
fn under(normal_n: f64, tremor_n: f64) -> Capture {
    Capture {
        normal_n: vec![normal_n - tremor_n, normal_n + tremor_n],
        lateral_n: vec![0.0; 2],
        ..Capture::default()
    }
}

fn asks_for_the_finger(step: &NextStep) -> bool {
    matches!(step, NextStep::Ask(Request::RestFinger { .. }))
}

/// Places a finger before a procedure whose plate has been measured bare.
fn placed(finger: &mut FingerProcedure) {
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
        placed(&mut finger);
        let step = finger
            .next(StepOutcome::Captured(under(normal_n, tremor_n)))
            .unwrap();
        assert!(
            asks_for_the_finger(&step),
            "{normal_n} ± {tremor_n}: {step:?}"
        );
        assert!(finger.progress().note.is_some());
    }
}

#[test]
fn where_nobody_can_be_asked_it_gives_up() {
    let mut finger = procedure(CONFIG, false).unwrap();
    for last in [false, false, true] {
        placed(&mut finger);
        let next = finger.next(StepOutcome::Captured(under(2.0, 0.0)));
        assert_eq!(next.is_err(), last);
    }
}

/// Hazard 5.
#[test]
fn a_bench_that_wants_a_held_switch_or_has_no_force_sensor_drives_no_finger() {
    assert!(procedure(CONFIG, true).is_ok());
    let dead_man = CONFIG.replace("[safety]\n", "[safety]\ndead_man = \"button\"\n");
    let refused = |text: &str| procedure(text, true).err().map(|error| error.to_string());
    let why = refused(&dead_man).unwrap_or_default();
    assert!(why.contains("dead_man"), "{why}");
    let from = CONFIG.find("[force]").unwrap();
    let to = CONFIG.find("[encoder]").unwrap();
    let without = format!("{}{}", &CONFIG[..from], &CONFIG[to..]);
    let why = refused(&without).unwrap_or_default();
    assert!(why.contains("[force]"), "{why}");
}

/// Places whose ratios depart from one by so much, each with this relative error.
fn places(departures: &[f64], error: f64) -> Vec<Place> {
    let place = |departure: &f64| Place {
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
        let (departure, of, verdict) = judged(&places(&departures, error));
        assert_eq!(verdict, expected, "{departures:?} ± {error}");
        assert!((of - error).abs() < 1e-12);
        let largest = departures[0];
        assert!(
            (departure - largest).abs() < 1e-12,
            "{departure} for {largest}"
        );
    }
}

#[test]
fn too_few_or_too_many_places_and_a_plate_too_short_for_them_are_refused() {
    let config = Config::parse(CONFIG, "test").unwrap();
    let along = |config: &Config, places| {
        ProfileProcedure::new(plate(config).unwrap(), config, 1e-6, places, true)
    };
    let [fewest, most] = PLACES;
    assert!(along(&config, fewest).is_ok() && along(&config, most).is_ok());
    for places in [0, 1, fewest - 1, most + 1, u32::MAX] {
        assert!(along(&config, places).is_err(), "{places}");
    }
    let mut short = config;
    short.plate.length_m = 0.01;
    assert!(along(&short, fewest).is_err());
}
