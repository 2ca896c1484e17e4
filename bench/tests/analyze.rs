//! `analyze` on a session of the simulated bench: what a sound recording gives, and what it says of damaged ones.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use friction_bench::analysis::reading::{Channel, Flaw};
use friction_bench::analysis::unloaded::UnloadedError;
use friction_bench::analysis::{RecordingAnalysis, Settings, find, recording};
use friction_bench::recording::reader::Warning;
use serde_json::Value;

const BIN: &str = env!("CARGO_BIN_EXE_friction-bench");

/// One trial of one exploration of the simulated bench.
fn study() -> &'static Path {
    static STUDY: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, study) = STUDY.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path().join("study");
        let protocol =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/protocols/one-exploration.toml");
        let status = Command::new(BIN)
            .args([
                "run",
                "--mock",
                "--headless",
                "--speed",
                "max",
                "--seed",
                "1",
            ])
            .args([
                "--participant",
                "sub-01",
                "--consent-by",
                "A. Tester",
                "--study",
            ])
            .arg(&study)
            .arg("--protocol")
            .arg(protocol)
            .output()
            .unwrap();
        assert!(
            status.status.success(),
            "{}",
            String::from_utf8_lossy(&status.stderr)
        );
        (folder, study)
    });
    study
}

/// A copy of its recording, to damage.
fn copied() -> (tempfile::TempDir, PathBuf) {
    let sound = find::recordings(&[study().to_owned()], false).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("recording");
    fs::create_dir(&copy).unwrap();
    for entry in fs::read_dir(&sound[0]).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
    }
    (folder, copy)
}

fn damaged(damage: impl FnOnce(&Path)) -> RecordingAnalysis {
    let (_folder, copy) = copied();
    damage(&copy);
    recording::analyse(&copy, &Settings::default())
}

fn edit(path: PathBuf, change: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(&path).unwrap();
    let changed = change(text.clone());
    assert_ne!(changed, text, "nothing was changed in {}", path.display());
    fs::write(path, changed).unwrap();
}

/// Changes samples of one channel of `signals.wav`, given time in s and value.
fn edit_samples(recording: &Path, channel: usize, change: impl Fn(f64, f32) -> f32) {
    let path = recording.join("signals.wav");
    let mut reader = hound::WavReader::open(&path).unwrap();
    let spec = reader.spec();
    let channels = usize::from(spec.channels);
    let samples: Vec<f32> = reader.samples::<f32>().map(Result::unwrap).collect();
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for (at, sample) in samples.into_iter().enumerate() {
        let time_s = (at / channels) as f64 / f64::from(spec.sample_rate);
        let value = if at % channels == channel {
            change(time_s, sample)
        } else {
            sample
        };
        writer.write_sample(value).unwrap();
    }
    writer.finalize().unwrap();
}

fn pickup(recording: &Path) -> usize {
    let manifest = friction_bench::recording::reader::read_manifest(recording).unwrap();
    usize::from(manifest.channels.pickup.index)
}

fn analyze(arguments: &[&str], recordings: &[&Path]) -> Output {
    Command::new(BIN)
        .arg("analyze")
        .args(arguments)
        .args(recordings)
        .output()
        .unwrap()
}

#[test]
fn a_study_gives_results_by_the_schema() {
    let output = analyze(&["--json", "-"], &[study()]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(results["format"], 1);
    assert_eq!(results["settings"]["sigma_q0_rad_per_m"], 14000.0);
    let recording = &results["recordings"][0];
    for method in ["paper", "dynamic"] {
        assert!(recording["z_p_n_s_per_m"][method][0].is_f64());
    }
    let instances = recording["instances"].as_array().unwrap();
    assert!(instances.len() >= 5, "{} instances", instances.len());
    for instance in instances {
        for key in [
            "start_s",
            "end_s",
            "normal_n",
            "delta_z_m_n_s_per_m",
            "delta_mu",
        ] {
            assert!(instance[key].is_f64(), "{key}");
        }
        for method in ["paper", "dynamic"] {
            for key in [
                "sigma_t_m",
                "mu0",
                "r2_impedance",
                "rms_mu",
                "spearman_mu",
                "delta_gap_m",
                "delta_mu",
            ] {
                assert!(instance[method][key].is_f64(), "{method}.{key}");
            }
            assert_eq!(
                instance[method]["z_t_n_s_per_m"].as_array().unwrap().len(),
                2
            );
        }
        assert!(instance["paper"].get("tau_s").is_none());
        for key in ["sigma_t_m", "tau_s"] {
            assert!(instance["dynamic"]["std"][key].is_f64(), "{key}");
        }
    }
    let bands = recording["model_check"].as_array().unwrap();
    assert!(!bands.is_empty());
    for band in bands {
        assert!(
            band["force_relative_difference_p90"].as_f64().unwrap() < 0.1,
            "{band}"
        );
    }
    let sigma_t = &results["statistics"]["sigma_t_m"];
    assert_eq!(sigma_t["dynamic"]["n"], instances.len());
}

#[test]
fn one_bad_recording_is_reported_and_does_not_stop_the_others() {
    let (_folder, bad) = copied();
    fs::remove_file(bad.join("force.csv")).unwrap();
    let output = analyze(&["--json", "-"], &[&bad, study()]);
    assert_eq!(output.status.code(), Some(1));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(complaint.contains("force.csv"), "{complaint}");
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warning = results["recordings"][0]["warnings"][0].as_str().unwrap();
    assert!(warning.contains("cannot be read"), "{warning}");
    assert!(
        !results["recordings"][1]["instances"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

#[test]
fn what_cannot_be_read_is_named() {
    let error = |damage: fn(&Path)| damaged(damage).found.unwrap_err().to_string();
    let missing = error(|r| {
        edit(r.join("force.csv"), |text| {
            text.replacen("lateral_n", "sideways_n", 1)
        });
    });
    assert!(missing.contains("no column `lateral_n`"), "{missing}");
    let slow = error(|r| {
        let path = r.join("signals.wav");
        let mut bytes = fs::read(&path).unwrap();
        bytes[24..28].copy_from_slice(&48_000u32.to_le_bytes());
        fs::write(path, bytes).unwrap();
    });
    assert!(slow.contains("48000"), "{slow}");
    let torn = error(|r| fs::write(r.join("signals.wav"), b"RIFF").unwrap());
    assert!(torn.contains("signals.wav"), "{torn}");
}

#[test]
fn flaws_are_told_and_the_sound_rest_is_analysed() {
    let cut = damaged(|r| {
        let path = r.join("signals.wav");
        let bytes = fs::read(&path).unwrap();
        fs::write(path, &bytes[..bytes.len() * 3 / 4]).unwrap();
    });
    let found = cut.found.unwrap();
    assert!(
        found
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::Signals(_))))
    );

    let lost = damaged(|r| {
        let start_s = exploration_s(r);
        let inside = move |t: f64| (start_s + 0.6..start_s + 0.601).contains(&t);
        edit_samples(
            r,
            pickup(r),
            move |t, x| if inside(t) { f32::NAN } else { x },
        );
    });
    let found = lost.found.unwrap();
    assert!(found.flaws.iter().any(|f| matches!(
        f,
        Flaw::LostSamples { channel: Channel::Pickup, samples } if (180..=200).contains(samples)
    )));
    assert!(!found.instances.is_empty());
    let lost_frames = found
        .rejected
        .iter()
        .filter(|r| r.reason.contains("lost samples"));
    assert_eq!(lost_frames.count(), 1);

    let clipped = damaged(|r| {
        edit_samples(r, pickup(r), |_, x| x.clamp(-0.3, 0.3));
    });
    let found = clipped.found.unwrap();
    assert!(
        found.flaws.iter().any(|f| matches!(
            f,
            Flaw::Clipped { channel: Channel::Pickup, level, .. } if (level - 0.3).abs() < 1e-6
        )),
        "{:?}",
        found.flaws
    );
    assert!(found.rejected.iter().any(|r| r.reason.contains("clipped")));

    let unsorted = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let mut lines: Vec<&str> = text.lines().collect();
            lines.swap(5000, 5020);
            lines.join("\n") + "\n"
        });
    });
    let found = unsorted.found.unwrap();
    assert!(
        found
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::TimeDisorder { .. })))
    );
    assert!(found.instances.len() >= 5);

    let not_a_number = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let lines = text
                .lines()
                .enumerate()
                .map(|(n, line)| match line.split_once(',') {
                    Some((time, _)) if n % 500 == 499 => format!("{time},NaN,NaN"),
                    _ => line.to_owned(),
                });
            lines.collect::<Vec<_>>().join("\n") + "\n"
        });
    });
    let found = not_a_number.found.unwrap();
    assert!(
        found
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::NotFinite { .. })))
    );
    assert!(found.instances.len() >= 5, "{:?}", found.rejected);
}

#[test]
fn without_a_free_plate_nothing_is_estimated() {
    let none = damaged(|r| {
        edit(r.join("recording.toml"), |text| {
            text.replacen(
                "kind = \"unloaded\"",
                "kind = \"exploration\"\ndirection = \"left_to_right\"",
                1,
            )
        });
    });
    let found = none.found.unwrap();
    assert!(
        found
            .flaws
            .contains(&Flaw::Unloaded(UnloadedError::NoInterval))
    );
    assert!(found.instances.is_empty() && found.z_p.is_none());
    assert!(
        found
            .rejected
            .iter()
            .any(|r| r.reason.contains("Z_p is not known"))
    );

    let touched = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let lines = text.lines().enumerate().map(|(n, line)| {
                let fields: Vec<&str> = line.split(',').collect();
                if n == 0 {
                    line.to_owned()
                } else {
                    format!("{},0.6,{}", fields[0], fields[2])
                }
            });
            lines.collect::<Vec<_>>().join("\n") + "\n"
        });
    });
    let found = touched.found.unwrap();
    assert!(
        found
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::Unloaded(UnloadedError::Touched { .. })))
    );
    assert!(found.instances.is_empty());
}

#[test]
fn a_carrier_that_is_not_there_is_named() {
    let gone = damaged(|r| {
        // White, of the carrier's strength.
        let noise =
            |t: f64| (((t * 192e3).round() * 78.233).sin() * 43758.547).fract() as f32 - 0.5;
        edit_samples(r, pickup(r), move |t, _| noise(t));
    });
    let found = gone.found.unwrap();
    assert!(
        found.flaws.iter().any(|f| matches!(
            f,
            Flaw::CarrierMissing {
                channel: Channel::Pickup,
                ..
            }
        )),
        "{:?}",
        found.flaws
    );
    assert!(found.instances.is_empty());
    assert!(found.rejected.iter().all(|r| r.reason.contains("carrier")));
}

/// Start of the exploration, s.
fn exploration_s(recording: &Path) -> f64 {
    use friction_bench::recording::manifest::IntervalKind;
    let manifest = friction_bench::recording::reader::read_manifest(recording).unwrap();
    let exploration = manifest
        .intervals
        .iter()
        .find(|i| matches!(i.kind, IntervalKind::Exploration(_)));
    exploration.unwrap().start_s
}

/// Two recordings from an independent simulation lie beside the checkout where the project is developed.
#[test]
fn reference_recordings_are_estimated_within_the_stated_limits() {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference");
    if !reference.exists() {
        return;
    }
    for (name, paper_sigma_t_m, paper_z_t_im) in [
        ("recording-a", 2.93e-6, 1.24),
        ("recording-c", 2.02e-6, 1.77),
    ] {
        let truth: Value = serde_json::from_slice(
            &fs::read(reference.join(format!("{name}.truth.json"))).unwrap(),
        )
        .unwrap();
        let number = |key: &str| truth[key].as_f64().unwrap();
        let (re, im) = (
            truth["z_t"][0].as_f64().unwrap(),
            truth["z_t"][1].as_f64().unwrap(),
        );
        let analysis = recording::analyse(&reference.join(name), &Settings::default());
        let found = analysis.found.unwrap();
        assert_eq!(found.instances.len(), 7);
        for instance in &found.instances {
            let dynamic = &instance.dynamic;
            assert!((dynamic.sigma_t_m / number("sigma_m") - 1.0).abs() < 0.03);
            let z_t = dynamic.z_t_n_s_per_m;
            assert!((z_t.norm() / re.hypot(im) - 1.0).abs() < 0.05);
            assert!((dynamic.tau_s.unwrap().0 - number("tau_s")).abs() < 0.5e-3);
            assert!(dynamic.agreement.rms_mu <= 0.03);
        }
        let n = found.instances.len() as f64;
        let sigma_t_m = found
            .instances
            .iter()
            .map(|i| i.paper.sigma_t_m)
            .sum::<f64>()
            / n;
        let z_t_im = found
            .instances
            .iter()
            .map(|i| i.paper.z_t_n_s_per_m.im)
            .sum::<f64>()
            / n;
        assert!(
            (sigma_t_m / paper_sigma_t_m - 1.0).abs() < 0.05,
            "{sigma_t_m}"
        );
        assert!((z_t_im / paper_z_t_im - 1.0).abs() < 0.05, "{z_t_im}");
        assert!(found.model_check.iter().all(|band| band.p90 < 0.05));
    }
}
