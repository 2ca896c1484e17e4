//! Results of `analyze` for the fit of all instances together.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::analyze;

/// Returns a recording that violates every assumption of the other methods (bench/tests/data/reference/README.md).
fn unknown_skin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference/recording-d")
}

/// Stated standard errors of the calibration widen the intervals that depend on them, and change no estimate.
#[test]
fn stated_errors_of_the_calibration_are_in_the_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let analysed = |name: &str, line: &str| -> Value {
        let copy = folder.path().join(name);
        std::fs::create_dir(&copy).unwrap();
        for entry in std::fs::read_dir(unknown_skin()).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
        }
        let manifest = copy.join("recording.toml");
        let text = std::fs::read_to_string(&manifest).unwrap();
        std::fs::write(&manifest, format!("{text}\n[standard_errors]\n{line}\n")).unwrap();
        let json = folder.path().join(format!("{name}.json"));
        analyze(&["--json", json.to_str().unwrap()], &[&copy]);
        let results: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        results["recordings"][0].clone()
    };
    // Within the published laws: the doubt about them is wider than any of these.
    let width = |estimates: &Value, key: &str| {
        let interval = &estimates["interval95_within_laws"][key];
        let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
        ln_ratio(high, low)
    };
    let widths = |recording: &Value| {
        let instance = &recording["instances"][3]["trial"];
        [
            width(&recording["trial"], "contact_area_m2"),
            width(instance, "sigma_t_m"),
            width(instance, "mu0"),
        ]
    };
    let exact = analysed("exact", "");
    // For S, σ_t and μ0: whether a standard error of each constant widens the interval by more than a tenth.
    for (name, line, wider) in [
        (
            "amplitude",
            "amplitude_relative = 0.05",
            [true, false, false],
        ),
        (
            "impedance",
            "impedance_relative = 0.05",
            [true, true, false],
        ),
        ("phase", "pickup_phase_rad = 0.05", [true, true, false]),
        ("normal", "normal_force_relative = 0.05", [true, true, true]),
        (
            "lateral",
            "lateral_force_relative = 0.05",
            [false, false, true],
        ),
    ] {
        let inexact = analysed(name, line);
        for key in ["contact_area_m2", "q0_rad_per_m", "loss_factor", "tau_s"] {
            assert_eq!(inexact["trial"][key], exact["trial"][key], "{name}");
        }
        let (inexact_widths, exact_widths) = (widths(&inexact), widths(&exact));
        let widened = [0, 1, 2].map(|i| inexact_widths[i] > 1.1 * exact_widths[i]);
        assert_eq!(
            widened, wider,
            "{name}: {inexact_widths:?} {exact_widths:?}"
        );
        // The first key of the line is in the results.
        let key = line.split(' ').next().unwrap();
        assert!(inexact["standard_errors"][key].as_f64().unwrap() > 0.0);
    }
}

/// A narrow prior determines its parameter, regardless of the recording.
#[test]
fn a_prior_that_is_assumed_otherwise_holds() {
    let recording = unknown_skin();
    let prior_key = "trial_priors.contact_area_m2";
    let output = analyze(
        &[
            "--json",
            "-",
            "--assume",
            &format!("{prior_key}.median=200e-6"),
            "--assume",
            &format!("{prior_key}.ln_std=1e-5"),
        ],
        &[&recording],
    );
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let prior = &results["settings"]["trial_priors"]["contact_area_m2"];
    assert_eq!(prior["median"], 200e-6);
    let area_m2 = &results["recordings"][0]["trial"]["contact_area_m2"];
    let deviation = ln_ratio(area_m2.as_f64().unwrap(), 200e-6);
    assert!(deviation.abs() < 1e-3, "{area_m2}");
}

fn ln_ratio(to: f64, from: f64) -> f64 {
    (to / from).ln()
}

#[test]
fn the_trials_fit_stands_in_the_results_by_the_schema_and_in_the_summary() {
    let recording = unknown_skin();
    let results = |options: &[&str]| -> Value {
        let output = analyze(&[options, &["--json", "-"]].concat(), &[&recording]);
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let default_results = results(&[]);
    assert_eq!(default_results["settings"]["plate_offset"], true);
    // The prior is wide enough for the estimate, and far from the value assumed by the other methods.
    let prior = &default_results["settings"]["trial_priors"]["contact_area_m2"];
    assert!(prior["median"].as_f64().unwrap() < 200e-6 && prior["ln_std"].as_f64().unwrap() > 0.4);
    let shared = &default_results["recordings"][0]["trial"];
    let instances = default_results["recordings"][0]["instances"]
        .as_array()
        .unwrap();
    assert_eq!(shared["verdict"], "converged");
    assert_eq!(shared["n_instances"], instances.len());
    assert_eq!(shared["model_misfit"], false);
    assert_eq!(shared["misfit"], serde_json::json!([]));
    assert_eq!(shared["misfit_within_laws"], serde_json::json!([]));
    let inside = |estimates: &Value, key: &str, value: &Value| {
        let ends =
            |intervals: &str| [0, 1].map(|end| estimates[intervals][key][end].as_f64().unwrap());
        let ([low, high], within_laws) = (ends("interval95"), ends("interval95_within_laws"));
        let value = value.as_f64().unwrap();
        assert!(
            low < value && value < high,
            "{key}: {value} in {low} to {high}"
        );
        let middle = 0.5 * (within_laws[0] + within_laws[1]);
        assert!(
            low < middle && middle < high,
            "{key}: {within_laws:?} in {low} to {high}"
        );
    };
    for key in [
        "contact_area_m2",
        "q0_rad_per_m",
        "loss_factor",
        "tau_s",
        "area_force_exponent",
        "lag_gap_exponent",
        "friction_floor",
        "lateral_lag_s",
    ] {
        inside(shared, key, &shared[key]);
    }
    // Its value is given without an interval: the data hardly determine it.
    assert!(shared["film_mean_s"].is_f64() && shared["interval95"]["film_mean_s"].is_null());
    for instance in instances {
        let trial = &instance["trial"];
        for key in ["sigma_t_m", "mu0", "resonance_shift_hz"] {
            inside(trial, key, &trial[key]);
        }
        inside(trial, "z_t_re_n_s_per_m", &trial["z_t_n_s_per_m"][0]);
        inside(trial, "z_t_im_n_s_per_m", &trial["z_t_n_s_per_m"][1]);
        for (key, _) in instance["dynamic"].as_object().unwrap() {
            // `trial` has every value that `dynamic` has.
            assert!(trial.get(key).is_some(), "{key}");
        }
        for method in ["dynamic", "trial"] {
            let offset = &instance[method]["plate_offset_n_s_per_m"];
            let shift_hz = instance[method]["resonance_shift_hz"].as_f64().unwrap();
            // The resonance is lower than before.
            assert!(
                offset[1].as_f64().unwrap() > 0.1 && shift_hz < -1.0,
                "{instance}"
            );
            let std_hz = instance[method]["std"]["resonance_shift_hz"].as_f64();
            assert!(std_hz.is_some_and(|std_hz| std_hz > 0.0), "{instance}");
        }
        assert!(instance["paper"].get("plate_offset_n_s_per_m").is_none());
    }

    // The recording was made elsewhere and states no participant.
    let skin = &default_results["skin"];
    assert_eq!(skin["participants"], serde_json::json!([]));
    assert_eq!(skin["left_out"][0]["because"], "no participant is stated");

    let without_offset = results(&["--no-offset"]);
    assert_eq!(without_offset["settings"]["plate_offset"], false);
    for instance in without_offset["recordings"][0]["instances"]
        .as_array()
        .unwrap()
    {
        let zeros = serde_json::json!([0.0, 0.0]);
        assert_eq!(instance["dynamic"]["plate_offset_n_s_per_m"], zeros);
        assert_eq!(instance["dynamic"]["resonance_shift_hz"].to_string(), "0.0");
    }

    let folder = tempfile::tempdir().unwrap();
    let tables = folder.path().join("tables");
    let printed = analyze(&["--tables", tables.to_str().unwrap()], &[&recording]);
    let skin = std::fs::read_to_string(tables.join("skin.csv")).unwrap();
    assert!(
        skin.starts_with("level,participant,recording,parameter,value,"),
        "{skin}"
    );
    let header = skin.lines().next().unwrap();
    assert!(header.ends_with(",shrunken_low95_within_laws,shrunken_high95_within_laws"));
    let printed = String::from_utf8_lossy(&printed.stdout);
    // The true area is 240 mm².
    let interval_mm2 = |label: &str| -> [f64; 2] {
        let (_, area) = printed.split_once(label).expect("a skin");
        let (low, tail) = area.split_once(" to ").expect("an interval");
        let (high, _) = tail.split_once(" mm²").expect("its unit");
        [low, high].map(|text| text.parse().expect("a number"))
    };
    let [low, high] = interval_mm2("trial: S ");
    assert!(low < 240.0 && 240.0 < high, "{printed}");
    let [low, high] = interval_mm2("within the published laws: S ");
    assert!(
        low < 240.0 && 240.0 < high && high - low < 25.0,
        "{printed}"
    );
}
