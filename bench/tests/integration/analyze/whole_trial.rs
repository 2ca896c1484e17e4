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
    let shared = |of: &Value, key: &str| {
        let interval = &of["trial"]["interval95"][key];
        let [from, to] = [0, 1].map(|at| interval[at].as_f64().unwrap());
        ln_ratio(to, from)
    };
    let own = |of: &Value, key: &str| of["instances"][3]["trial"]["std"][key].as_f64().unwrap();
    let widths = |of: &Value| {
        [
            shared(of, "contact_area_m2"),
            own(of, "sigma_t_m"),
            own(of, "mu0"),
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
        let stated = analysed(name, line);
        for key in ["contact_area_m2", "q0_rad_per_m", "loss_factor", "tau_s"] {
            assert_eq!(stated["trial"][key], exact["trial"][key], "{name}");
        }
        let (found, before) = (widths(&stated), widths(&exact));
        let widened = [0, 1, 2].map(|at| found[at] > 1.1 * before[at]);
        assert_eq!(widened, wider, "{name}: {found:?} {before:?}");
        // The first key of the line is in the results.
        let key = line.split(' ').next().unwrap();
        assert!(stated["standard_errors"][key].as_f64().unwrap() > 0.0);
    }
}

/// A narrow prior determines its parameter, regardless of the recording.
#[test]
fn a_prior_that_is_assumed_otherwise_holds() {
    let recording = unknown_skin();
    let held = "trial_priors.contact_area_m2";
    let output = analyze(
        &[
            "--json",
            "-",
            "--assume",
            &format!("{held}.median=200e-6"),
            "--assume",
            &format!("{held}.ln_std=1e-5"),
        ],
        &[&recording],
    );
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let prior = &found["settings"]["trial_priors"]["contact_area_m2"];
    assert_eq!(prior["median"], 200e-6);
    let area_m2 = &found["recordings"][0]["trial"]["contact_area_m2"];
    let off = ln_ratio(area_m2.as_f64().unwrap(), 200e-6);
    assert!(off.abs() < 1e-3, "{area_m2}");
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
    let found = results(&[]);
    assert_eq!(found["settings"]["plate_offset"], true);
    // The prior is wide enough for the estimate, and far from the value assumed by the other methods.
    let prior = &found["settings"]["trial_priors"]["contact_area_m2"];
    assert!(prior["median"].as_f64().unwrap() < 200e-6 && prior["ln_std"].as_f64().unwrap() > 0.4);
    let shared = &found["recordings"][0]["trial"];
    let instances = found["recordings"][0]["instances"].as_array().unwrap();
    assert_eq!(shared["verdict"], "converged");
    assert_eq!(shared["n_instances"], instances.len());
    assert_eq!(shared["model_misfit"], false);
    assert_eq!(shared["misfit"], serde_json::json!([]));
    let inside = |of: &Value, key: &str, value: &Value| {
        let interval = of["interval95"][key].as_array().unwrap();
        let [from, to] = [0, 1].map(|end| interval[end].as_f64().unwrap());
        let value = value.as_f64().unwrap();
        assert!(from < value && value < to, "{key}: {value} in {interval:?}");
    };
    for key in [
        "contact_area_m2",
        "q0_rad_per_m",
        "loss_factor",
        "tau_s",
        "area_force_exponent",
        "film_mean_s",
        "lag_gap_exponent",
        "friction_floor",
        "lateral_lag_s",
    ] {
        inside(shared, key, &shared[key]);
    }
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
    let skin = &found["skin"];
    assert_eq!(skin["participants"], serde_json::json!([]));
    assert_eq!(skin["left_out"][0]["because"], "no participant is stated");

    let held = results(&["--no-offset"]);
    assert_eq!(held["settings"]["plate_offset"], false);
    for instance in held["recordings"][0]["instances"].as_array().unwrap() {
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
    let printed = String::from_utf8_lossy(&printed.stdout);
    // The true area is 240 mm².
    let (_, area) = printed.split_once("trial: S ").expect("the trial's skin");
    let (from, rest) = area.split_once(" to ").expect("an interval");
    let (to, _) = rest.split_once(" mm²").expect("its unit");
    let [from, to] = [from, to].map(|of| of.parse::<f64>().expect("a number"));
    assert!(from < 240.0 && 240.0 < to && to - from < 25.0, "{printed}");
}
