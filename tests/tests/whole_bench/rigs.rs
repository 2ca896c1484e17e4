//! Each supported laboratory rig, from `init` to results, unattended: its simulation measures the same person as the usual
//! bench.
#![expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};

use bench_tests::program::{bench, protocol};
use bench_tests::room::WEIGH;
use bench_tests::session::{finish, text};
use bench_tests::shared::shared_folder;
use serde::{Deserialize, Serialize};
use serde_json::Value;

const SEED: &str = "7";
/// The same person on each rig.
const PERSON: &str = "[participant]\nsigma_t_m = 1.7e-6\nz_t_n_s_per_m = [0.47, 3.16]\nmu0 = 0.8\n";
/// Greatest relative difference of a session's median from that on the usual bench.
const TOLERANCE: f64 = 0.02;

/// Estimates of the person from one session.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Estimates {
    sigma_t_m: f64,
    z_t_n_s_per_m: [f64; 2],
    mu0: f64,
}

/// A bench in a separate folder.
struct Rig {
    folder: tempfile::TempDir,
    scenario: String,
    /// Its configuration; `None` for the simulated bench's.
    config: Option<PathBuf>,
}

impl Rig {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let scenario = folder.path().join("scenario.toml");
        fs::write(&scenario, PERSON).unwrap();
        Self {
            scenario: scenario.to_str().unwrap().to_owned(),
            folder,
            config: None,
        }
    }

    /// Returns the rig that `init` writes with these words, on a simulated bench to which it adds the equipment.
    fn initialise(words: &[&str]) -> Self {
        let rig = Self::new();
        let mut init = bench();
        init.args(["init", "--mock", &rig.scenario, "--plate", "simulated"])
            .args(words)
            .current_dir(&rig.folder);
        let output = finish(&mut init);
        let transcript = text(&output);
        assert!(output.status.success(), "{transcript}");
        let twin = "bench-scenario.toml";
        let last_step =
            format!("calibrate plate --operator NAME --config bench.toml --mock {twin}");
        // No value of the simulated equipment is left to its owner.
        for step in [
            "is written for",
            "limits           as by default",
            &last_step,
        ] {
            assert!(transcript.contains(step), "no {step:?} in {transcript}");
        }
        let path = |name| rig.folder.path().join(name);
        Self {
            scenario: path(twin).to_str().unwrap().to_owned(),
            config: Some(path("bench.toml")),
            ..rig
        }
    }

    fn command(&self, words: &[&str]) -> std::process::Command {
        let mut command = bench();
        command
            .args(words)
            .args(["--mock", &self.scenario, "--seed", SEED])
            .args(["--calibration", "calibration.toml"])
            .current_dir(&self.folder);
        if let Some(config) = &self.config {
            command.arg("--config").arg(config);
        }
        command
    }

    fn succeed(&self, words: &[&str]) {
        let output = finish(&mut self.command(words));
        assert!(output.status.success(), "{words:?}: {}", text(&output));
    }

    fn calibrate(&self) {
        let calibrate = |words: &[&str]| {
            let operator = ["--operator", "A. Tester", "--speed", "max"];
            self.succeed(&[&["calibrate"][..], words, &operator].concat());
        };
        calibrate(&["output", "--meter", "simulated", "--reads", "rms"]);
        calibrate(&["channels"]);
        calibrate(&["pickup"]);
        calibrate(&["plate"]);
        calibrate(&WEIGH);
        self.succeed(&["check", "--protocol", "demo"]);
    }

    fn session(&self) -> Estimates {
        let study = ["--study", "study", "--participant", "sub-01"];
        let consent = ["--consent-by", "A. Tester", "--headless", "--speed", "max"];
        let protocol = protocol("one-exploration.toml");
        let protocol = protocol.to_str().unwrap();
        let run = ["run", "--protocol", protocol];
        self.succeed(&[&run[..], &study, &consent].concat());
        read_estimates(self.folder.path())
    }
}

fn read_estimates(folder: &Path) -> Estimates {
    let mut analyze = bench();
    analyze
        .args(["analyze", "study", "--json", "results.json"])
        .current_dir(folder);
    let output = finish(&mut analyze);
    assert!(output.status.success(), "{}", text(&output));
    let results = fs::read(folder.join("results.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    let instances: Vec<&Value> = results["recordings"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|recording| recording["instances"].as_array().unwrap())
        .collect();
    let median = |value: &dyn Fn(&Value) -> f64| {
        let mut values: Vec<f64> = instances
            .iter()
            .map(|instance| value(&instance["trial"]))
            .collect();
        assert!(values.len() >= 5, "{} instances", values.len());
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Estimates {
        sigma_t_m: median(&|results| results["sigma_t_m"].as_f64().unwrap()),
        z_t_n_s_per_m: [0, 1]
            .map(|part| median(&|results| results["z_t_n_s_per_m"][part].as_f64().unwrap())),
        mu0: median(&|results| results["mu0"].as_f64().unwrap()),
    }
}

fn assert_alike(rig: &str, estimates: Estimates, usual_estimates: Estimates) {
    let difference = |value: f64, reference: f64| (value / reference - 1.0).abs();
    let [re, im] =
        [0, 1].map(|part| estimates.z_t_n_s_per_m[part] - usual_estimates.z_t_n_s_per_m[part]);
    let [usual_re, usual_im] = usual_estimates.z_t_n_s_per_m;
    let differences = [
        difference(estimates.sigma_t_m, usual_estimates.sigma_t_m),
        re.hypot(im) / usual_re.hypot(usual_im),
        difference(estimates.mu0, usual_estimates.mu0),
    ];
    println!("{rig}: sigma_t, Z_t and mu0 apart by {differences:.4?}");
    assert!(
        differences.iter().all(|difference| *difference < TOLERANCE),
        "{rig}: {estimates:?}, on the usual bench {usual_estimates:?}"
    );
}

/// Returns the usual bench's estimates of the person, computed once for all tests of a run.
fn usual_estimates() -> Estimates {
    let folder = shared_folder("usual-rig", |folder| {
        let rig = Rig::new();
        rig.calibrate();
        let estimates = serde_json::to_string(&rig.session()).unwrap();
        fs::write(folder.join("measured.json"), estimates).unwrap();
    });
    let estimates = fs::read_to_string(folder.join("measured.json")).unwrap();
    serde_json::from_str(&estimates).unwrap()
}

fn assert_measures_the_same_person(name: &str, rig: &Rig) {
    rig.calibrate();
    assert_alike(name, rig.session(), usual_estimates());
}

#[test]
fn a_field_box() {
    let words = ["--rig", "field-box", "--box-port", "/dev/ttyACM0"];
    assert_measures_the_same_person("field box", &Rig::initialise(&words));
}

#[test]
fn six_axes_in_the_network_with_a_box() {
    let words = ["--net-ft", "192.168.1.1", "--box-port", "/dev/ttyACM0"];
    let rig = Rig::initialise(&[&["--rig", "six-axis"][..], &words].concat());
    assert_measures_the_same_person("six axes in the network", &rig);
}

#[test]
fn six_gauges_on_the_card_with_a_box() {
    let words = ["--cal-file", "FT00000.cal", "--box-port", "/dev/ttyACM0"];
    let rig = Rig::initialise(&[&["--rig", "six-axis"][..], &words].concat());
    assert_measures_the_same_person("six gauges on the card", &rig);
}
