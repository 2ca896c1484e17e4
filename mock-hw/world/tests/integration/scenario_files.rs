//! Every scenario file is valid, states its purpose and builds the bench that it describes.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

use std::collections::BTreeSet;
use std::path::Path;

use mock_world::fingertip::Fingertip;
use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthWriter;
use mock_world::scenario::{Scenario, built_in_names};

fn shipped_scenario(name: &str) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios")
        .join(name);
    Scenario::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap()
}

#[test]
fn every_scenario_file_reads_states_its_purpose_and_is_built_in() {
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut files = BTreeSet::new();
    for folder in ["", "laws/"] {
        for entry in std::fs::read_dir(scenarios.join(folder)).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_file() {
                let name = format!("{folder}{}", entry.file_name().to_str().unwrap());
                assert!(!shipped_scenario(&name).purpose.is_empty(), "{name}");
                files.insert(name);
            }
        }
    }
    let built_in: BTreeSet<String> = built_in_names().map(|name| format!("{name}.toml")).into();
    assert_eq!(files, built_in, "every file is built in");
}

#[test]
fn nominal_is_the_published_bench_and_person_for_any_seed() {
    let nominal = shipped_scenario("nominal.toml");
    assert_eq!(nominal.plate, Scenario::default().plate);
    for seed in 0..5 {
        let skin = Fingertip::draw(&nominal, seed);
        assert_eq!(
            (skin.sigma_t_m, skin.z_t_n_s_per_m, skin.mu0),
            (1.7e-6, [0.47, 3.16], 0.8)
        );
    }
    assert_eq!(nominal.draw(3), nominal);
    let unknown = shipped_scenario("bench-unknown.toml");
    assert_ne!(unknown.draw(3).plate, unknown.draw(4).plate);
}

#[test]
fn the_truth_of_a_run_is_written_once_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut plant = Plant::new(&shipped_scenario("nominal.toml"), 1, 192e3);
    let mut truth = TruthWriter::create(folder.path(), &plant.constants()).unwrap();
    let finger = FingerState {
        normal_n: 0.65,
        touching: true,
        ..FingerState::default()
    };
    for _ in 0..20 {
        plant.step(&[0.0; 1920], true, &finger, &mut [0.0; 1920 * 4]);
        truth.record(plant.truth()).unwrap();
    }
    truth.finish().unwrap();

    let constants: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("truth.json")).unwrap()).unwrap();
    assert_eq!(constants["fingertip"]["sigma_t_m"], 1.7e-6);
    assert_eq!(constants["scenario"]["plate"]["resonance_hz"], 35e3);
    // The second mode changes the nominal 7.01 N·s/m only slightly.
    let re = constants["z_p_n_s_per_m"][0].as_f64().unwrap();
    assert!((re / 7.01 - 1.0).abs() < 5e-3, "{re}");

    let series = std::fs::read_to_string(folder.path().join("truth.csv")).unwrap();
    let rows: Vec<Vec<&str>> = series.lines().map(|l| l.split(',').collect()).collect();
    assert!(
        (198..=202).contains(&rows.len()),
        "{} rows in 0.2 s",
        rows.len()
    );
    assert!(rows.iter().all(|r| r.len() == rows[0].len()));
    let column = rows[0]
        .iter()
        .position(|name| *name == "k_c_n_per_m")
        .unwrap();
    let k_c: f64 = rows[rows.len() - 1][column].parse().unwrap();
    assert!((k_c / (0.65 / 1.7e-6) - 1.0).abs() < 0.1, "{k_c}");

    // New columns are appended, because readers rely on the positions of the old ones.
    assert_eq!(rows[0][..3], ["time_s", "frame", "sigma_t_m"]);
    assert_eq!(
        rows[0][13..],
        [
            "amplitude_m",
            "resonance_shift_hz",
            "damping_n_s_per_m",
            "contact_area_m2",
            "amplitude_ratio",
            "lag_s",
        ]
    );
    let last: Vec<f64> = rows[rows.len() - 1]
        .iter()
        .map(|cell| cell.parse().unwrap())
        .collect();
    assert_eq!(last[14..18], [0.0, 7.01, 300e-6, 1.0]);
    assert!((0.5e-3..1.5e-3).contains(&last[18]));
    let pad = &constants["fingertip"]["pad"];
    assert_eq!(
        (pad["contact_area_m2"].as_f64(), pad["floor"].as_f64()),
        (Some(300e-6), Some(0.0))
    );

    let result = TruthWriter::create(folder.path(), &plant.constants());
    assert_eq!(
        result.unwrap_err().kind(),
        std::io::ErrorKind::AlreadyExists
    );
}

#[test]
fn a_scenario_of_laws_is_nominal_but_for_one_thing() {
    let nominal = shipped_scenario("nominal.toml");
    for name in built_in_names()
        .iter()
        .filter(|name| name.starts_with("laws/"))
    {
        let mut broken = shipped_scenario(&format!("{name}.toml"));
        assert_ne!(broken.purpose, nominal.purpose);
        broken.purpose.clone_from(&nominal.purpose);
        let is_same = [
            broken.laws == nominal.laws,
            broken.film == nominal.film,
            broken.friction == nominal.friction,
            broken.plate == nominal.plate,
        ];
        assert_eq!(
            is_same.iter().filter(|is_same| !**is_same).count(),
            1,
            "{name}"
        );
        broken.laws = nominal.laws.clone();
        broken.film = nominal.film.clone();
        broken.friction = nominal.friction.clone();
        broken.plate = nominal.plate.clone();
        assert_eq!(broken, nominal, "{name}");
    }
}
