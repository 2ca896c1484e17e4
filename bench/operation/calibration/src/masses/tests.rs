//! Procedure on a sensor that is a function of load and time.

use anyhow::bail;

use super::*;
use crate::masses::common::TARE_WINDOWS;
use crate::masses::force_setup::UNKNOWN_GRAVITY;
use calibration_rig::capture::Capture;
use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::operator::{Answer, ForceAxis, GRAVITY_M_PER_S2, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use config::Quantity;

const G: f64 = GRAVITY_M_PER_S2;
const EXACT: Accuracy = Accuracy {
    masses: 0.0,
    pulley: 0.0,
};

fn config() -> Config {
    Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap()
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
    let readings_n: Vec<[f64; 2]> = (0..1000)
        .map(|i| {
            let ripple = 1e-4 * if i % 2 == 0 { 1.0 } else { -1.0 };
            sensor(load_n, from_s + 1e-3 * f64::from(i)).map(|n| n + ripple)
        })
        .collect();
    let out_of_range = |axis: usize| {
        readings_n
            .iter()
            .filter(|reading_n| reading_n[axis].abs() >= 5.0)
            .count()
    };
    Capture {
        samples: vec![0.0; 1000],
        channels: 1,
        rate_hz: 1000.0,
        from_s,
        normal_n: readings_n.iter().map(|reading_n| reading_n[0]).collect(),
        lateral_n: readings_n.iter().map(|reading_n| reading_n[1]).collect(),
        force_saturated: [out_of_range(0), out_of_range(1)],
        ..Capture::default()
    }
}

/// Runs a procedure with an operator who does everything as requested; the first review is answered with `redo`.
fn run_procedure(
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

fn judgement(procedure: &ForceProcedure) -> (config::MeasuredForce, Vec<String>) {
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

fn response(load_n: [f64; 2]) -> [f64; 2] {
    [
        1.2 * load_n[0] + 0.03 * load_n[1],
        -0.05 * load_n[0] + 0.85 * load_n[1],
    ]
}

#[test]
fn matrix_tare_and_drift_of_a_linear_sensor_are_found() {
    // 3 and −6 mN/min.
    let sensor = |load_n: [f64; 2], t: f64| {
        let [n, l] = response(load_n);
        [n + 0.4 + 5e-5 * t, l - 0.2 - 1e-4 * t]
    };
    let procedure = run_procedure(setup(), &sensor, None).unwrap();
    let (force, faults) = judgement(&procedure);
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
fn uncertain_masses_widen_the_errors_and_the_pulley_only_its_row() {
    let sensor = |load_n: [f64; 2], _: f64| response(load_n);
    let accuracy = Accuracy {
        masses: 1e-3,
        pulley: 5e-3,
    };
    let setup = ForceSetup::new(&config(), masses(), accuracy, None).unwrap();
    let (force, _) = judgement(&run_procedure(setup, &sensor, None).unwrap());
    let relative = |quantity: &Quantity| quantity.standard_error / quantity.value.abs();
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
        let load_sensor = |load_n: [f64; 2], t: f64| {
            let swing = if restless { (2.0 * t).sin() } else { 0.0 };
            load_n.map(|n| n + zero_n + swing)
        };
        StepOutcome::Captured(capture(&load_sensor, [0.0; 2], now_s))
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
    let readings = std::cell::Cell::new(0);
    let sensor = |load_n: [f64; 2], _: f64| {
        if load_n[0] > 0.9 && load_n[0] < 1.1 {
            readings.set(readings.get() + 1);
        }
        // The first reading of 100 g is wrong.
        let slip = if readings.get() <= 1000 && load_n[0] > 0.9 && load_n[0] < 1.1 {
            0.05
        } else {
            0.0
        };
        [load_n[0] + slip, load_n[1]]
    };
    let first_pass = judgement(&run_procedure(setup(), &sensor, None).unwrap());
    assert!(first_pass.1.iter().any(|fault| fault.contains("depart")));
    readings.set(0);
    let second_pass = judgement(&run_procedure(setup(), &sensor, Some(2)).unwrap());
    assert_eq!(second_pass.1, Vec::<String>::new());
}

#[test]
fn an_operator_names_the_masses() {
    use Answer::{Number, Ready, Redo};
    let setup = ForceSetup::to_be_named(&config(), EXACT, Some(G)).unwrap();
    let mut procedure = ForceProcedure::new(setup, true);
    let mut step = procedure.next(StepOutcome::Began).unwrap();
    let script: [(ForceAxis, Answer, &str); 9] = [
        (ForceAxis::Normal, Number(0.02), ""),
        (ForceAxis::Normal, Ready, "1 mass on the normal axis"),
        (ForceAxis::Normal, Number(0.4), "use masses up to 305 g"),
        (ForceAxis::Normal, Number(-0.05), "above 0"),
        (ForceAxis::Normal, Number(0.05), ""),
        (ForceAxis::Normal, Number(0.06), ""),
        (ForceAxis::Normal, Redo(2), ""),
        (ForceAxis::Normal, Ready, ""),
        (ForceAxis::Lateral, Ready, ""),
    ];
    for (requested_axis, answer, note) in script {
        let NextStep::Ask(Request::NameMass { axis }) = step else {
            panic!("{step:?}")
        };
        assert_eq!(axis, requested_axis);
        step = procedure
            .next(StepOutcome::Answered(answer, Capture::default()))
            .unwrap();
        let note_text = procedure.progress().note.unwrap_or_default();
        assert!(
            note_text.contains(note) && note.is_empty() == note_text.is_empty(),
            "{note_text:?}"
        );
    }
    assert!(matches!(step, NextStep::Ask(Request::Unload)), "{step:?}");
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
    let mut forgets = true;
    let mut notes = Vec::new();
    let mut outcome = StepOutcome::Began;
    loop {
        let next = procedure.next(outcome).unwrap();
        notes.extend(procedure.progress().note);
        now_s += 3.0;
        outcome = match next {
            NextStep::Listen(_) => {
                StepOutcome::Captured(capture(&|reading_n, _| reading_n, load_n, now_s))
            }
            NextStep::Ask(Request::Load { axis, mass_kg }) => {
                let placed_kg = slips.pop().unwrap_or(mass_kg);
                load_n[axis.index()] = placed_kg * G;
                StepOutcome::Answered(Answer::Ready, Capture::default())
            }
            NextStep::Ask(request) => {
                let is_forgotten = request == Request::Unload && load_n[0] > 0.0 && forgets;
                if is_forgotten {
                    forgets = false;
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
    let (force, faults) = judgement(&procedure);
    assert_eq!(faults, Vec::<String>::new());
    assert!((force.normal_per_normal.value - 1.0).abs() < 1e-6);

    let mut crossed = ForceProcedure::new(setup(), true);
    crossed.next(StepOutcome::Began).unwrap();
    let silence = || StepOutcome::Answered(Answer::Ready, Capture::default());
    crossed.next(silence()).unwrap();
    for _ in 0..TARE_WINDOWS {
        crossed
            .next(StepOutcome::Captured(capture(
                &|reading_n, _| reading_n,
                [0.0; 2],
                0.0,
            )))
            .unwrap();
    }
    crossed.next(silence()).unwrap();
    let crosswise = capture(
        &|reading_n, _| [reading_n[1], reading_n[0]],
        [0.02 * G, 0.0],
        5.0,
    );
    let error = crossed
        .next(StepOutcome::Captured(crosswise))
        .err()
        .unwrap();
    assert!(error.to_string().contains("exchanged"), "{error}");
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
            Box::new(|load_n, _| [-load_n[0], load_n[1]]),
        ),
        (
            &["lateral axis has the wrong sign", "other side"],
            Box::new(|load_n, _| [load_n[0], -load_n[1]]),
        ),
        (
            &["the axes are exchanged"],
            Box::new(|load_n, _| [load_n[1], load_n[0]]),
        ),
        (
            &["instead of 0.196 N", "check that the mass is 20 g"],
            Box::new(|load_n, _| [10.0 * load_n[0], load_n[1]]),
        ),
        (
            &["the range of the normal axis is exceeded"],
            Box::new(|load_n, _| [load_n[0].min(1.2), load_n[1]]),
        ),
        (
            &["the normal axis is at the end of its range", "200 g"],
            Box::new(|load_n, _| [if load_n[0] > 1.9 { 5.0 } else { load_n[0] }, load_n[1]]),
        ),
        (
            &["does not come to rest", "hang still", "force_rest_n"],
            Box::new(|load_n, t| [load_n[0] * (1.0 + 0.1 * (15.0 * t).sin()), load_n[1]]),
        ),
        (
            &["without load", "tare the sensor itself"],
            Box::new(|load_n, _| [load_n[0] + 3.5, load_n[1]]),
        ),
    ];
    for (words, sensor) in wrongs {
        let message = match run_procedure(setup(), &*sensor, None) {
            Err(error) => format!("{error:#}"),
            Ok(_) => panic!("{words:?} was not refused"),
        };
        for word in words {
            assert!(message.contains(word), "no {word:?} in: {message}");
        }
    }
    let forgotten_mass = |load_n: [f64; 2], t: f64| {
        // The operator leaves the 20 g on the plate.
        [
            if t > 20.0 {
                load_n[0].max(0.196)
            } else {
                load_n[0]
            },
            load_n[1],
        ]
    };
    let message = run_procedure(setup(), &forgotten_mass, None)
        .err()
        .unwrap()
        .to_string();
    assert!(message.contains("remove the mass"), "{message}");
}

#[test]
fn a_value_beyond_a_limit_fails_with_its_reason() {
    type Poor = (&'static str, Box<Sensor<'static>>);
    let poor: [Poor; 4] = [
        (
            "calibration.force_drift_n_per_min",
            Box::new(|load_n, t| [load_n[0] + 5e-4 * t, load_n[1]]),
        ),
        (
            "calibration.force_crosstalk",
            Box::new(|load_n, _| [load_n[0], load_n[1] + 0.25 * load_n[0]]),
        ),
        (
            "calibration.force_nonlinearity",
            Box::new(|load_n, _| [load_n[0] * (1.0 + 0.05 * load_n[0]), load_n[1]]),
        ),
        (
            "calibration.force_zero_return_n",
            Box::new(|load_n, t| {
                [
                    load_n[0] + if t > 30.0 && t < 36.0 { 0.03 } else { 0.0 },
                    load_n[1],
                ]
            }),
        ),
    ];
    for (key, sensor) in poor {
        let (_, faults) = judgement(&run_procedure(setup(), &*sensor, None).unwrap());
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
    let (_, faults) = judgement(&run_procedure(setup, &|load_n, _| load_n, None).unwrap());
    for key in ["force_error", "force_noise_n_per_sqrt_hz"] {
        assert!(faults.iter().any(|fault| fault.contains(key)), "{faults:?}");
    }
}

#[test]
fn an_impossible_request_is_refused_before_hardware_is_opened() {
    let refusal = |masses: &[Mass], gravity| {
        let setup = ForceSetup::new(&config(), masses.to_vec(), EXACT, gravity);
        setup.err().unwrap().to_string()
    };
    let only_normal = from_g(ForceAxis::Normal, &[20.0, 50.0, 100.0]);
    assert!(refusal(&only_normal, None).contains("0 masses on the lateral axis"));
    let lateral = from_g(ForceAxis::Lateral, &[20.0, 50.0]);
    let few = [from_g(ForceAxis::Normal, &[20.0]), lateral.clone()].concat();
    assert!(refusal(&few, None).contains("1 mass on the normal axis"));
    let heavy = [from_g(ForceAxis::Normal, &[20.0, 400.0]), lateral.clone()].concat();
    let message = refusal(&heavy, None);
    assert!(
        message.contains("400 g")
            && message.contains("safety.max_normal_n = 3")
            && message.contains("305 g"),
        "{message}"
    );
    let mut weak = config();
    weak.safety.max_lateral_n = 0.4;
    let message = ForceSetup::new(&weak, masses(), EXACT, None).err().unwrap();
    assert!(
        message.to_string().contains("safety.max_lateral_n = 0.4"),
        "{message}"
    );
    let not_positive = [from_g(ForceAxis::Normal, &[20.0, -5.0]), lateral].concat();
    assert!(refusal(&not_positive, None).contains("above 0"));
    assert!(refusal(&masses(), Some(1.62)).contains("--gravity"));
    let mut blind = config();
    blind.force = None;
    let message = ForceSetup::new(&blind, masses(), EXACT, None)
        .err()
        .unwrap();
    assert!(message.to_string().contains("[force]"), "{message}");
}

/// Returns the setup of a bench with the gauges on inputs of the card.
fn inputs_setup() -> ForceSetup {
    let text = config::rigs::MOCK_BENCH;
    let channels = "source = \"channels\"\nchannels = { inputs = [2, 3], newtons_per_v = [[1.0, 0.0], [0.0, 1.0]] }";
    let text = text.replace("port = \"/dev/ttyUSB0\"", channels);
    let config = Config::parse(&text, "bench.toml").unwrap();
    ForceSetup::new(&config, masses(), EXACT, Some(G)).unwrap()
}

/// Reads a load behind a capacitor with this time constant, s, while it is placed and while it rests.
fn behind_a_capacitor(tau_s: f64) -> anyhow::Result<()> {
    let mut procedure = ForceProcedure::new(inputs_setup(), false);
    let (mut load_n, mut previous_n, mut changed_s, mut now_s) = ([0.0; 2], [0.0; 2], 0.0, 10.0);
    let mut outcome = StepOutcome::Began;
    loop {
        let next = procedure.next(outcome)?;
        let (asks, seconds) = match &next {
            NextStep::Listen(seconds) => (false, *seconds),
            NextStep::Ask(_) => (true, 1.0),
            _ => return Ok(()),
        };
        if let NextStep::Ask(request) = &next {
            (previous_n, changed_s) = (load_n, now_s);
            match request {
                Request::Load { axis, mass_kg } => load_n[axis.index()] = mass_kg * G,
                _ => load_n = [0.0; 2],
            }
        }
        let sensor = |target_n: [f64; 2], t: f64| {
            let remainder = (-(t - changed_s) / tau_s).exp();
            [0, 1].map(|axis| (target_n[axis] - previous_n[axis]) * remainder)
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
        let message = behind_a_capacitor(tau_s).unwrap_err().to_string();
        for word in ["AC-coupled", "faded", "force.channels.inputs", "20 g"] {
            assert!(message.contains(word), "{tau_s} s: {message}");
        }
    }
    // A load at rest still passes, and so does one that swings while it is placed.
    let swings = |load_n: [f64; 2], t: f64| load_n.map(|n| n * (1.0 + (-(t % 4.0) * 9.0).exp()));
    run_procedure(inputs_setup(), &|load_n, _| load_n, None).unwrap();
    run_procedure(inputs_setup(), &swings, None).unwrap();
}

#[test]
fn a_new_tare_keeps_the_matrix() {
    let sensor = |load_n: [f64; 2], _: f64| response(load_n);
    let (force, _) = judgement(&run_procedure(setup(), &sensor, None).unwrap());
    let shifted_sensor = |load_n: [f64; 2], _: f64| response(load_n).map(|n| n + 0.12);
    let setup = ForceSetup::retare(&config(), force.clone()).unwrap();
    let (tared, faults) = judgement(&run_procedure(setup, &shifted_sensor, None).unwrap());
    assert_eq!(faults, Vec::<String>::new());
    assert_eq!(tared.correction().matrix, force.correction().matrix);
    for tare_n in tared.correction().tare_n {
        assert!((tare_n - 0.12).abs() < 1e-6, "{tare_n}");
    }
}
