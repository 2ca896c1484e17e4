//! What `analyze` says of the fit of all instances together.

use std::path::Path;

use serde_json::Value;

use crate::analyze;

/// A recording of which every assumption of the other methods fails (bench/tests/data/reference/README.md).
#[test]
fn the_trials_fit_stands_in_the_results_by_the_schema_and_in_the_summary() {
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference/recording-d");
    let results = |options: &[&str]| -> Value {
        let output = analyze(&[options, &["--json", "-"]].concat(), &[&recording]);
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let found = results(&[]);
    assert_eq!(found["settings"]["plate_offset"], true);
    // Wide enough for what is found, far from where the others assume it.
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
            // What a result owes to constants that are assumed, a fit that assumes none has not.
            assert!(trial.get(key).is_some(), "{key}");
        }
        for method in ["dynamic", "trial"] {
            let offset = &instance[method]["plate_offset_n_s_per_m"];
            let shift_hz = instance[method]["resonance_shift_hz"].as_f64().unwrap();
            // The resonance falls.
            assert!(
                offset[1].as_f64().unwrap() > 0.1 && shift_hz < -1.0,
                "{instance}"
            );
            let std_hz = instance[method]["std"]["resonance_shift_hz"].as_f64();
            assert!(std_hz.is_some_and(|std_hz| std_hz > 0.0), "{instance}");
        }
        assert!(instance["paper"].get("plate_offset_n_s_per_m").is_none());
    }

    // Made elsewhere, of nobody who is named.
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
    // Of 240 mm² that are true.
    let (_, area) = printed.split_once("trial: S ").expect("the trial's skin");
    let (from, rest) = area.split_once(" to ").expect("an interval");
    let (to, _) = rest.split_once(" mm²").expect("its unit");
    let [from, to] = [from, to].map(|of| of.parse::<f64>().expect("a number"));
    assert!(from < 240.0 && 240.0 < to && to - from < 25.0, "{printed}");
}
