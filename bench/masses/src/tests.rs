//! Procedure on a sensor that is a function of load and time.

use anyhow::bail;

use super::*;
use crate::common::TARE_WINDOWS;
use crate::force_setup::UNKNOWN_GRAVITY;
use calibration::capture::Capture;
use calibration::judged::{Calibrates, Judged, Part};
use calibration::operator::{Answer, ForceAxis, GRAVITY_M_PER_S2, Request};
use calibration::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use config::Quantity;

const G: f64 = GRAVITY_M_PER_S2;
const EXACT: Accuracy = Accuracy {
    masses: 0.0,
    pulley: 0.0,
};

fn config() -> Config {
    Config::parse(include_str!("../../mock-bench.toml"), "bench.toml").unwrap()
}

fn masses() -> Vec<Mass> {
    [
        from_g(ForceAxis::Normal, &[20.0, 50.0, 100.0, 200.0]),
        from_g(ForceAxis::Lateral, &[20.0, 50.0, 100.0]),
    ]
    .concat()
}

/// Simulated sensor: maps forces, N, and time, s, to readings.
type Sensor<'a> = dyn Fn([f64; 2], f64) -> [f64; 2] + 'a;

fn capture(sensor: &Sensor<'_>, load_n: [f64; 2], from_s: f64) -> Capture {
    let read: Vec<[f64; 2]> = (0..1000)
        .map(|i| {
            let ripple = 1e-4 * if i % 2 == 0 { 1.0 } else { -1.0 };
            sensor(load_n, from_s + 1e-3 * f64::from(i)).map(|n| n + ripple)
        })
        .collect();
    let at_end = |axis: usize| read.iter().filter(|of| of[axis].abs() >= 5.0).count();
    Capture {
        samples: vec![0.0; 1000],
        channels: 1,
        rate_hz: 1000.0,
        from_s,
        normal_n: read.iter().map(|of| of[0]).collect(),
        lateral_n: read.iter().map(|of| of[1]).collect(),
        force_saturated: [at_end(0), at_end(1)],
        ..Capture::default()
    }
}

/// Runs a procedure with an operator who does everything as requested; the first review is answered with `redo`.
fn measured(
    setup: ForceSetup,
    sensor: &Sensor<'_>,
    mut redo: Option<usize>,
) -> anyhow::Result<ForceProcedure> {
    let mut procedure = ForceProcedure::new(setup, false);
    let (mut load_n, mut now_s) = ([0.0; 2], 10.0);
    let mut outcome = StepOutcome::Began;
    loop {
        outcome = match procedure.next(outcome)? {
            NextStep::Listen(seconds) => {
                now_s += seconds;
                StepOutcome::Captured(capture(sensor, load_n, now_s - seconds))
            }
            NextStep::Ask(request) => {
                now_s += 3.0;
                let mut answer = Answer::Ready;
                match request {
                    Request::Load { axis, mass_kg } => load_n[axis.index()] = mass_kg * G,
                    Request::Unload => load_n = [0.0; 2],
                    _ => answer = redo.take().map_or(Answer::Ready, Answer::Redo),
                }
                StepOutcome::Answered(answer, Capture::default())
            }
            NextStep::Done => return Ok(procedure),
            other => bail!("{other:?}"),
        };
    }
}

fn setup() -> ForceSetup {
    ForceSetup::new(&config(), masses(), EXACT, Some(G)).unwrap()
}

fn judged(procedure: &ForceProcedure) -> (config::MeasuredForce, Vec<String>) {
    let judged = procedure.judge(jiff::Timestamp::UNIX_EPOCH, "A. Tester");
    let Judged { part, faults, .. } = judged.unwrap();
    match part {
        Part::Force { force, sensor } => {
            assert_eq!(sensor, "/dev/ttyUSB0, frames");
            (*force, faults)
        }
        other => panic!("{other:?}"),
    }
}

fn response(of: [f64; 2]) -> [f64; 2] {
    [1.2 * of[0] + 0.03 * of[1], -0.05 * of[0] + 0.85 * of[1]]
}

#[test]
fn matrix_tare_and_drift_of_a_linear_sensor_are_found() {
    // 3 and −6 mN/min.
    let sensor = |of: [f64; 2], t: f64| {
        let [n, l] = response(of);
        [n + 0.4 + 5e-5 * t, l - 0.2 - 1e-4 * t]
    };
    let procedure = measured(setup(), &sensor, None).unwrap();
    let (force, faults) = judged(&procedure);
    assert_eq!(faults, Vec::<String>::new());
    let last_s = procedure.zeros.last().unwrap().at_s;
    let correction = force.correction();
    let loads = [[0.7, 0.2], [0.0, -0.5], [1.5, 0.0]];
    for load_n in loads {
        let [n, l] = correction.forces_n(sensor(load_n, last_s));
        assert!((n - load_n[0]).abs() < 1e-6, "{n} {load_n:?}");
        assert!((l - load_n[1]).abs() < 1e-6, "{l} {load_n:?}");
    }
    // Drift in newtons is the drift of the readings times the matrix: det = 1.0215.
    let (n, l) = (3e-3, -6e-3);
    let expected = [
        (0.85 * n - 0.03 * l) / 1.021_5,
        (0.05 * n + 1.2 * l) / 1.021_5,
    ];
    assert!((force.normal_drift.value - expected[0]).abs() < 1e-6);
    assert!((force.lateral_drift.value - expected[1]).abs() < 1e-6);
    assert_eq!(force.masses, 7);
}

#[test]
fn what_is_known_badly_widens_the_errors_and_the_pulley_only_its_row() {
    let sensor = |of: [f64; 2], _: f64| response(of);
    let accuracy = Accuracy {
        masses: 1e-3,
        pulley: 5e-3,
    };
    let setup = ForceSetup::new(&config(), masses(), accuracy, None).unwrap();
    let (force, _) = judged(&measured(setup, &sensor, None).unwrap());
    let relative = |of: &Quantity| of.standard_error / of.value.abs();
    let common = 1e-3f64.hypot(UNKNOWN_GRAVITY);
    assert!((relative(&force.normal_per_normal) / common - 1.0).abs() < 0.01);
    let lateral = common.hypot(5e-3);
    assert!((relative(&force.lateral_per_lateral) / lateral - 1.0).abs() < 0.01);
}

#[test]
fn a_zero_is_of_one_clearing_alone() {
    let mut procedure = ForceProcedure::new(setup(), true);
    let mut now_s = 10.0;
    let mut window = |zero_n: f64, restless: bool| {
        now_s += 1.0;
        let moves = |of: [f64; 2], t: f64| {
            let swing = if restless { (2.0 * t).sin() } else { 0.0 };
            of.map(|n| n + zero_n + swing)
        };
        StepOutcome::Captured(capture(&moves, [0.0; 2], now_s))
    };
    let ready = || StepOutcome::Answered(Answer::Ready, Capture::default());
    procedure.next(StepOutcome::Began).unwrap();
    procedure.next(ready()).unwrap();
    // A load lies on the plate, swings, rests for two windows, and swings again until the limit is reached.
    for restless in std::iter::repeat_n(true, 17).chain([false, false]) {
        procedure.next(window(0.2, restless)).unwrap();
    }
    let step = procedure.next(window(0.2, true)).unwrap();
    assert!(matches!(step, NextStep::Ask(Request::Unload)), "{step:?}");
    procedure.next(ready()).unwrap();
    for _ in 0..TARE_WINDOWS {
        procedure.next(window(0.0, false)).unwrap();
    }
    let zero = &procedure.zeros[0];
    assert!(zero.mean[0].abs() < 1e-3, "{zero:?}");
}

#[test]
fn a_mass_can_be_measured_again() {
    let asked = std::cell::Cell::new(0);
    let sensor = |of: [f64; 2], _: f64| {
        if of[0] > 0.9 && of[0] < 1.1 {
            asked.set(asked.get() + 1);
        }
        // The first reading of 100 g is wrong.
        let slip = if asked.get() <= 1000 && of[0] > 0.9 && of[0] < 1.1 {
            0.05
        } else {
            0.0
        };
        [of[0] + slip, of[1]]
    };
    let wrong = judged(&measured(setup(), &sensor, None).unwrap());
    assert!(wrong.1.iter().any(|fault| fault.contains("depart")));
    asked.set(0);
    let right = judged(&measured(setup(), &sensor, Some(2)).unwrap());
    assert_eq!(right.1, Vec::<String>::new());
}

#[test]
fn an_operator_names_the_masses() {
    use Answer::{Number, Ready, Redo};
    let setup = ForceSetup::to_be_named(&config(), EXACT, Some(G)).unwrap();
    let mut procedure = ForceProcedure::new(setup, true);
    let mut asked = procedure.next(StepOutcome::Began).unwrap();
    let said: [(ForceAxis, Answer, &str); 9] = [
        (ForceAxis::Normal, Number(0.02), ""),
        (ForceAxis::Normal, Ready, "1 masses on the normal axis"),
        (ForceAxis::Normal, Number(0.4), "use masses up to 305 g"),
        (ForceAxis::Normal, Number(-0.05), "above 0"),
        (ForceAxis::Normal, Number(0.05), ""),
        (ForceAxis::Normal, Number(0.06), ""),
        (ForceAxis::Normal, Redo(2), ""),
        (ForceAxis::Normal, Ready, ""),
        (ForceAxis::Lateral, Ready, ""),
    ];
    for (wanted, answer, note) in said {
        let NextStep::Ask(Request::NameMass { axis }) = asked else {
            panic!("{asked:?}")
        };
        assert_eq!(axis, wanted);
        asked = procedure
            .next(StepOutcome::Answered(answer, Capture::default()))
            .unwrap();
        let told = procedure.progress().note.unwrap_or_default();
        assert!(
            told.contains(note) && note.is_empty() == told.is_empty(),
            "{told:?}"
        );
    }
    assert!(matches!(asked, NextStep::Ask(Request::Unload)), "{asked:?}");
    let expected = [ForceAxis::Normal, ForceAxis::Lateral].map(|axis| from_g(axis, &[20.0, 50.0]));
    assert_eq!(procedure.setup.masses, expected.concat());
    assert_eq!(procedure.progress().steps, 5);
}

/// When 20 g are requested, the operator places nothing, then 60 g; then leaves the right mass in place at the next request for
/// a clear plate, then does everything right.
#[test]
fn where_somebody_is_there_a_slip_is_asked_for_again() {
    let mut procedure = ForceProcedure::new(setup(), true);
    let (mut load_n, mut now_s) = ([0.0; 2], 10.0);
    let mut slips = vec![0.06, 0.0];
    let mut leaves = true;
    let mut notes = Vec::new();
    let mut outcome = StepOutcome::Began;
    loop {
        let next = procedure.next(outcome).unwrap();
        notes.extend(procedure.progress().note);
        now_s += 3.0;
        outcome = match next {
            NextStep::Listen(_) => StepOutcome::Captured(capture(&|of, _| of, load_n, now_s)),
            NextStep::Ask(Request::Load { axis, mass_kg }) => {
                let placed_kg = slips.pop().unwrap_or(mass_kg);
                load_n[axis.index()] = placed_kg * G;
                StepOutcome::Answered(Answer::Ready, Capture::default())
            }
            NextStep::Ask(request) => {
                let left = request == Request::Unload && load_n[0] > 0.0 && leaves;
                if left {
                    leaves = false;
                } else {
                    load_n = [0.0; 2];
                }
                StepOutcome::Answered(Answer::Ready, Capture::default())
            }
            NextStep::Done => break,
            other => panic!("{other:?}"),
        };
    }
    let words = [
        "check that it was placed",
        "check that the mass is 20 g",
        "remove the mass",
    ];
    for (note, word) in notes.iter().zip(words) {
        assert!(
            note.contains(word) && note.contains("is rejected"),
            "{note}"
        );
    }
    assert_eq!(notes.len(), words.len(), "{notes:?}");
    let (force, faults) = judged(&procedure);
    assert_eq!(faults, Vec::<String>::new());
    assert!((force.normal_per_normal.value - 1.0).abs() < 1e-6);

    let mut crossed = ForceProcedure::new(setup(), true);
    crossed.next(StepOutcome::Began).unwrap();
    let silence = || StepOutcome::Answered(Answer::Ready, Capture::default());
    crossed.next(silence()).unwrap();
    for _ in 0..TARE_WINDOWS {
        crossed
            .next(StepOutcome::Captured(capture(&|of, _| of, [0.0; 2], 0.0)))
            .unwrap();
    }
    crossed.next(silence()).unwrap();
    let crosswise = capture(&|of, _| [of[1], of[0]], [0.02 * G, 0.0], 5.0);
    let ended = crossed
        .next(StepOutcome::Captured(crosswise))
        .err()
        .unwrap();
    assert!(ended.to_string().contains("exchanged"), "{ended}");
}

#[test]
fn every_way_to_go_wrong_has_its_words() {
    type Wrong = (&'static [&'static str], Box<Sensor<'static>>);
    let wrongs: [Wrong; 9] = [
        (
            &[
                "20 g on the normal axis",
                "0.0 mN",
                "196 mN",
                "check that it was placed",
            ],
            Box::new(|_, _| [0.0; 2]),
        ),
        (
            &["normal axis has the wrong sign", "positive"],
            Box::new(|of, _| [-of[0], of[1]]),
        ),
        (
            &["lateral axis has the wrong sign", "other side"],
            Box::new(|of, _| [of[0], -of[1]]),
        ),
        (
            &["the axes are exchanged"],
            Box::new(|of, _| [of[1], of[0]]),
        ),
        (
            &["instead of 0.196 N", "check that the mass is 20 g"],
            Box::new(|of, _| [10.0 * of[0], of[1]]),
        ),
        (
            &["the range of the normal axis is exceeded"],
            Box::new(|of, _| [of[0].min(1.2), of[1]]),
        ),
        (
            &["the normal axis is at the end of its range", "200 g"],
            Box::new(|of, _| [if of[0] > 1.9 { 5.0 } else { of[0] }, of[1]]),
        ),
        (
            &["does not come to rest", "hang still", "force_rest_n"],
            Box::new(|of, t| [of[0] * (1.0 + 0.1 * (15.0 * t).sin()), of[1]]),
        ),
        (
            &["without load", "tare the sensor itself"],
            Box::new(|of, _| [of[0] + 3.5, of[1]]),
        ),
    ];
    for (words, sensor) in wrongs {
        let said = match measured(setup(), &*sensor, None) {
            Err(error) => format!("{error:#}"),
            Ok(_) => panic!("{words:?} was not refused"),
        };
        for word in words {
            assert!(said.contains(word), "no {word:?} in: {said}");
        }
    }
    let stays = |of: [f64; 2], t: f64| {
        // The operator leaves the 20 g on the plate.
        [if t > 20.0 { of[0].max(0.196) } else { of[0] }, of[1]]
    };
    let said = measured(setup(), &stays, None).err().unwrap().to_string();
    assert!(said.contains("remove the mass"), "{said}");
}

#[test]
fn what_is_beyond_a_limit_does_not_pass_and_says_so() {
    type Poor = (&'static str, Box<Sensor<'static>>);
    let poor: [Poor; 4] = [
        (
            "calibration.force_drift_n_per_min",
            Box::new(|of, t| [of[0] + 5e-4 * t, of[1]]),
        ),
        (
            "calibration.force_crosstalk",
            Box::new(|of, _| [of[0], of[1] + 0.25 * of[0]]),
        ),
        (
            "calibration.force_nonlinearity",
            Box::new(|of, _| [of[0] * (1.0 + 0.05 * of[0]), of[1]]),
        ),
        (
            "calibration.force_zero_return_n",
            Box::new(|of, t| [of[0] + if t > 30.0 && t < 36.0 { 0.03 } else { 0.0 }, of[1]]),
        ),
    ];
    for (key, sensor) in poor {
        let (_, faults) = judged(&measured(setup(), &*sensor, None).unwrap());
        assert!(faults.iter().any(|fault| fault.contains(key)), "{faults:?}");
    }
    let mut strict = config();
    strict.calibration.force_error = 1e-4;
    strict.calibration.force_noise_n_per_sqrt_hz = 1e-6;
    let accuracy = Accuracy {
        masses: 1e-2,
        pulley: 0.0,
    };
    let setup = ForceSetup::new(&strict, masses(), accuracy, Some(G)).unwrap();
    let (_, faults) = judged(&measured(setup, &|of, _| of, None).unwrap());
    for key in ["force_error", "force_noise_n_per_sqrt_hz"] {
        assert!(faults.iter().any(|fault| fault.contains(key)), "{faults:?}");
    }
}

#[test]
fn what_cannot_be_asked_for_is_refused_before_anything_is_opened() {
    let of = |masses: &[Mass], gravity| {
        let setup = ForceSetup::new(&config(), masses.to_vec(), EXACT, gravity);
        setup.err().unwrap().to_string()
    };
    let only_normal = from_g(ForceAxis::Normal, &[20.0, 50.0, 100.0]);
    assert!(of(&only_normal, None).contains("0 masses on the lateral axis"));
    let lateral = from_g(ForceAxis::Lateral, &[20.0, 50.0]);
    let few = [from_g(ForceAxis::Normal, &[20.0]), lateral.clone()].concat();
    assert!(of(&few, None).contains("1 masses on the normal axis"));
    let heavy = [from_g(ForceAxis::Normal, &[20.0, 400.0]), lateral.clone()].concat();
    let said = of(&heavy, None);
    assert!(
        said.contains("400 g")
            && said.contains("safety.max_normal_n = 3")
            && said.contains("305 g"),
        "{said}"
    );
    let mut weak = config();
    weak.safety.max_lateral_n = 0.4;
    let said = ForceSetup::new(&weak, masses(), EXACT, None).err().unwrap();
    assert!(
        said.to_string().contains("safety.max_lateral_n = 0.4"),
        "{said}"
    );
    let none = [from_g(ForceAxis::Normal, &[20.0, -5.0]), lateral].concat();
    assert!(of(&none, None).contains("above 0"));
    assert!(of(&masses(), Some(1.62)).contains("--gravity"));
    let mut blind = config();
    blind.force = None;
    let said = ForceSetup::new(&blind, masses(), EXACT, None)
        .err()
        .unwrap();
    assert!(said.to_string().contains("[force]"), "{said}");
}

/// Returns the setup of a bench with the gauges on inputs of the card.
fn on_inputs() -> ForceSetup {
    let text = include_str!("../../mock-bench.toml");
    let channels = "source = \"channels\"\nchannels = { inputs = [2, 3], newtons_per_v = [[1.0, 0.0], [0.0, 1.0]] }";
    let text = text.replace("port = \"/dev/ttyUSB0\"", channels);
    let config = Config::parse(&text, "bench.toml").unwrap();
    ForceSetup::new(&config, masses(), EXACT, Some(G)).unwrap()
}

/// Reads a load behind a capacitor with this time constant, s, while it is placed and while it rests.
fn behind_a_capacitor(tau_s: f64) -> anyhow::Result<()> {
    let mut procedure = ForceProcedure::new(on_inputs(), false);
    let (mut load_n, mut before_n, mut changed_s, mut now_s) = ([0.0; 2], [0.0; 2], 0.0, 10.0);
    let mut outcome = StepOutcome::Began;
    loop {
        let next = procedure.next(outcome)?;
        let (asks, seconds) = match &next {
            NextStep::Listen(seconds) => (false, *seconds),
            NextStep::Ask(_) => (true, 1.0),
            _ => return Ok(()),
        };
        if let NextStep::Ask(request) = &next {
            (before_n, changed_s) = (load_n, now_s);
            match request {
                Request::Load { axis, mass_kg } => load_n[axis.index()] = mass_kg * G,
                _ => load_n = [0.0; 2],
            }
        }
        let sensor = |of: [f64; 2], t: f64| {
            let left = (-(t - changed_s) / tau_s).exp();
            [0, 1].map(|axis| (of[axis] - before_n[axis]) * left)
        };
        let captured = capture(&sensor, load_n, now_s);
        now_s += seconds;
        outcome = if asks {
            StepOutcome::Answered(Answer::Ready, captured)
        } else {
            StepOutcome::Captured(captured)
        };
    }
}

/// Fault 46.
#[test]
fn an_input_behind_a_capacitor_is_found_by_a_constant_load_that_fades() {
    // Corner frequencies from 5 Hz to 0.001 Hz.
    for tau_s in [0.03, 0.1, 0.5, 2.0, 10.0, 60.0, 160.0] {
        let said = behind_a_capacitor(tau_s).unwrap_err().to_string();
        for word in ["AC-coupled", "faded", "force.channels.inputs", "20 g"] {
            assert!(said.contains(word), "{tau_s} s: {said}");
        }
    }
    // A load at rest still passes, and so does one that swings while it is placed.
    let swings = |of: [f64; 2], t: f64| of.map(|n| n * (1.0 + (-(t % 4.0) * 9.0).exp()));
    measured(on_inputs(), &|of, _| of, None).unwrap();
    measured(on_inputs(), &swings, None).unwrap();
}

#[test]
fn a_new_tare_keeps_the_matrix() {
    let sensor = |of: [f64; 2], _: f64| response(of);
    let (kept, _) = judged(&measured(setup(), &sensor, None).unwrap());
    let moved = |of: [f64; 2], _: f64| response(of).map(|n| n + 0.12);
    let setup = ForceSetup::retare(&config(), kept.clone()).unwrap();
    let (tared, faults) = judged(&measured(setup, &moved, None).unwrap());
    assert_eq!(faults, Vec::<String>::new());
    assert_eq!(tared.correction().matrix, kept.correction().matrix);
    for tare_n in tared.correction().tare_n {
        assert!((tare_n - 0.12).abs() < 1e-6, "{tare_n}");
    }
}
