//! Recordings of the simulated plate and finger, as arrays with their truth.

use std::path::{Path, PathBuf};

use mock_world::run_truth::TruthSample;
use mock_world::scenario::{Scenario, ScenarioError, built_in};
use mock_world::trial::{SensorReadings, Trial, TrialPlan, TrialRecording};
use num_complex::Complex64;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::description::about_dict;
use crate::error::FrictionBenchError;

/// Periods simulated between two looks for Ctrl-C: 0.1 s of the recording.
const BLOCK: usize = 100;
/// Name of a scenario in errors that was not read from a file.
const UNNAMED: &str = "scenario";

/// Simulates a trial; `friction_bench.simulate` documents the arguments, and names the streams of the result.
///
/// # Errors
/// A scenario or a value that cannot be simulated, an exception of `progress`, or Ctrl-C.
#[pyfunction]
#[pyo3(signature = (
    scenario, seed, participant_seed, strokes, duration_s, rate_hz, carrier_hz, mean_amplitude_v, modulation_hz,
    modulation_index, calibrated, progress,
))]
#[expect(clippy::too_many_arguments, reason = "they have names in Python")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    scenario: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    participant_seed: Option<&Bound<'py, PyAny>>,
    strokes: &Bound<'py, PyAny>,
    duration_s: Option<f64>,
    rate_hz: &Bound<'py, PyAny>,
    carrier_hz: Option<f64>,
    mean_amplitude_v: f64,
    modulation_hz: f64,
    modulation_index: f64,
    calibrated: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let scenario = read(scenario)?;
    let seed = whole("seed", seed)?;
    let participant_seed = match participant_seed {
        Some(seed) => whole("participant_seed", seed)?,
        None => seed,
    };
    let plan = TrialPlan {
        rate_hz: whole("rate_hz", rate_hz)?,
        carrier_hz,
        mean_amplitude_v,
        modulation_hz,
        modulation_index,
        strokes: whole("strokes", strokes)?,
        duration_s,
        calibrated,
    };
    let mut trial =
        Trial::new(&scenario, &plan, seed, participant_seed).map_err(|error| refused(&error))?;
    let mut reported_s = 0;
    loop {
        let continues = py.detach(|| (0..BLOCK).all(|_| trial.advance()));
        py.check_signals()?;
        let expected_s = trial.expected_s().ceil() as u64;
        let done_s = if continues {
            trial.elapsed_s() as u64
        } else {
            expected_s
        };
        if let Some(progress) = progress.filter(|_| done_s > reported_s) {
            progress.call1((done_s, expected_s))?;
            reported_s = done_s;
        }
        if !continues {
            return dictionary(py, trial.finish());
        }
    }
}

/// Returns a whole number that is not negative.
fn whole<'py, T: TryFrom<u64>>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T> {
    let number: Option<u64> = value.extract().ok();
    number
        .and_then(|number| T::try_from(number).ok())
        .ok_or_else(|| {
            FrictionBenchError::new_err(format!(
                "`{name}` is not a whole number from 0, or is too large: pass one, as {name}=1"
            ))
        })
}

/// Reads a scenario: the name of a built-in one, the path of a file, the text of one, or a dictionary of its keys.
fn read(scenario: &Bound<'_, PyAny>) -> PyResult<Scenario> {
    if let Ok(keys) = scenario.cast::<PyDict>() {
        let scenario = Scenario::parse(&toml_text(keys)?, UNNAMED);
        return scenario
            .map_err(|error| refused(&about_dict(&error.to_string(), UNNAMED, UNNAMED)));
    }
    let Ok(text) = scenario.cast::<PyString>() else {
        return match scenario.extract::<PathBuf>() {
            Ok(path) => read_file(&path),
            Err(_) => Err(FrictionBenchError::new_err(
                "`scenario` is not a scenario: pass the name of a built-in one, the path or the text of a scenario file, or a dictionary \
                 of its keys",
            )),
        };
    };
    let text = text.to_cow()?;
    if text.contains(['\n', '=']) {
        return Scenario::parse(&text, UNNAMED).map_err(|error| refused(&error));
    }
    match built_in(&text) {
        Err(ScenarioError::UnknownName { .. }) if is_path(&text) => read_file(Path::new(&*text)),
        scenario => scenario.map_err(|error| refused(&error)),
    }
}

/// Returns whether a text is a path.
fn is_path(text: &str) -> bool {
    let path = Path::new(text);
    path.extension().is_some() || path.exists()
}

fn read_file(path: &Path) -> PyResult<Scenario> {
    let file = path.display().to_string();
    let text =
        bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES).map_err(|error| {
            let cause = bounded_files::cause(&error);
            FrictionBenchError::new_err(format!("cannot read the scenario {file}: {cause}"))
        })?;
    Scenario::parse(&text, &file).map_err(|error| refused(&error))
}

/// Returns the keys of a scenario as the text of its file.
fn toml_text(keys: &Bound<'_, PyDict>) -> PyResult<String> {
    let json: Option<String> = keys
        .py()
        .import("json")?
        .call_method1("dumps", (keys,))
        .and_then(|json| json.extract())
        .ok();
    let value = json.and_then(|json| serde_json::from_str::<serde_json::Value>(&json).ok());
    value
        .and_then(|value| toml::to_string(&value).ok())
        .ok_or_else(|| {
            FrictionBenchError::new_err(
                "the dictionary `scenario` has a value that no scenario file has: pass texts, numbers, True and False, and lists and \
                 dictionaries of them, and omit keys instead of passing None",
            )
        })
}

fn refused(error: &impl ToString) -> PyErr {
    FrictionBenchError::new_err(error.to_string())
}

/// Value of a sample of the truth.
type TruthValue = fn(&TruthSample) -> f64;

/// Returns the streams, the stated constants and the truth of a trial.
fn dictionary(py: Python<'_>, trial: TrialRecording) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    let truth = truth(py, &trial)?;
    let TrialRecording {
        plan,
        carrier_hz,
        drive,
        pickup,
        normal_n,
        lateral_n,
        position,
        unloaded_s,
        strokes,
        constants,
        stated,
        ..
    } = trial;
    let to_volts = stated.drive_volts_per_unit;
    let drive_v: Vec<f32> = py.detach(|| {
        let volts = drive.iter().map(|&sample| f64::from(sample) * to_volts);
        volts.map(|volts| volts as f32).collect()
    });
    out.set_item("drive", drive_v.into_pyarray(py))?;
    out.set_item("pickup", pickup.into_pyarray(py))?;
    out.set_item("rate_hz", f64::from(plan.rate_hz))?;
    out.set_item("carrier_hz", carrier_hz)?;
    out.set_item("modulation_hz", plan.modulation_hz)?;
    out.set_item("modulation_index", plan.modulation_index)?;
    out.set_item("metres_per_unit", stated.metres_per_unit)?;
    out.set_item("phase_rad", stated.phase_rad(carrier_hz))?;
    for (name, readings) in [
        ("normal", normal_n),
        ("lateral", lateral_n),
        ("position", position),
    ] {
        let SensorReadings { time_s, values } = readings;
        out.set_item(name, (time_s.into_pyarray(py), values.into_pyarray(py)))?;
    }
    let plate = PyDict::new(py);
    plate.set_item("resonance_hz", stated.resonance_hz)?;
    plate.set_item("modal_mass_kg", stated.modal_mass_kg)?;
    plate.set_item("force_factor_n_per_v", stated.force_factor_n_per_v)?;
    plate.set_item("centre_m", stated.centre_m)?;
    out.set_item("plate", plate)?;
    out.set_item("unloaded_s", unloaded_s)?;
    let strokes = strokes.iter().map(|stroke| {
        let direction = if stroke.rightwards {
            "left_to_right"
        } else {
            "right_to_left"
        };
        (stroke.start_s, stroke.end_s, direction)
    });
    out.set_item("strokes", strokes.collect::<Vec<_>>())?;
    let room = PyDict::new(py);
    let pressure_hpa = 0.01 * constants.scenario.film.ambient_pressure_pa;
    room.set_item("pressure_hpa", pressure_hpa)?;
    out.set_item("room", room)?;
    out.set_item("truth", truth)?;
    Ok(out)
}

fn truth<'py>(py: Python<'py>, trial: &TrialRecording) -> PyResult<Bound<'py, PyDict>> {
    let truth = PyDict::new(py);
    let constants = &trial.constants;
    let (skin, pad) = (&constants.fingertip, &constants.fingertip.pad);
    truth.set_item("sigma_t_m", skin.sigma_t_m)?;
    truth.set_item("z_t_n_s_per_m", complex(skin.z_t_n_s_per_m))?;
    truth.set_item("mu0", skin.mu0)?;
    truth.set_item("contact_area_m2", pad.contact_area_m2)?;
    truth.set_item("area_force_exponent", pad.area_force_exponent)?;
    truth.set_item("q0_rad_per_m", pad.q0_rad_per_m)?;
    truth.set_item("young_modulus_pa", pad.youngs_modulus_pa)?;
    truth.set_item("poisson_ratio", pad.poisson_ratio)?;
    truth.set_item("loss_factor", pad.loss_factor)?;
    truth.set_item("tau_s", pad.lag_s)?;
    truth.set_item("tau_gap_exponent", pad.lag_gap_exponent)?;
    truth.set_item("friction_floor", pad.floor)?;
    truth.set_item("z_p_n_s_per_m", complex(constants.z_p_n_s_per_m))?;
    truth.set_item("frames_per_s", constants.frames_per_s)?;
    let scenario = serde_json::to_string(&constants.scenario).map_err(|error| refused(&error))?;
    let scenario = py.import("json")?.call_method1("loads", (scenario,))?;
    truth.set_item("scenario", scenario)?;

    let series = PyDict::new(py);
    let times: Vec<f64> = trial.truth.iter().map(|s| trial.clock_s(s)).collect();
    series.set_item("time_s", times.into_pyarray(py))?;
    let z_t: Vec<Complex64> = trial
        .truth
        .iter()
        .map(|s| complex(s.z_t_n_s_per_m))
        .collect();
    series.set_item("z_t_n_s_per_m", z_t.into_pyarray(py))?;
    let columns: [(&str, TruthValue); 15] = [
        ("sigma_t_m", |s| s.sigma_t_m),
        ("mu0", |s| s.mu0),
        ("gap_m", |s| s.gap_m),
        ("stiffness_n_per_m", |s| s.k_c_n_per_m),
        ("mu", |s| s.mu),
        ("normal_n", |s| s.normal_n),
        ("lateral_n", |s| s.lateral_n),
        ("position_m", |s| s.position_m),
        ("velocity_m_per_s", |s| s.velocity_m_per_s),
        ("amplitude_m", |s| s.amplitude_m),
        ("resonance_shift_hz", |s| s.resonance_shift_hz),
        ("damping_n_s_per_m", |s| s.damping_n_s_per_m),
        ("contact_area_m2", |s| s.contact_area_m2),
        ("amplitude_ratio", |s| s.amplitude_ratio),
        ("tau_s", |s| s.lag_s),
    ];
    for (name, value) in columns {
        let values: Vec<f64> = trial.truth.iter().map(value).collect();
        series.set_item(name, values.into_pyarray(py))?;
    }
    truth.set_item("series", series)?;
    Ok(truth)
}

fn complex([re, im]: [f64; 2]) -> Complex64 {
    Complex64::new(re, im)
}
