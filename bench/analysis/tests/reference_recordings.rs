//! Recordings of an independent simulation, analysed beside the truth that made them.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use analysis::Settings;
use analysis::analysed::RecordingFindings;
use analysis::flaw::Flaw;
use analysis::recording_analysis::analyse;
use num_complex::Complex64;
use serde_json::Value;

/// What the published method is known to make of a reference recording: its bias is its own, and must neither grow nor be mended.
struct Published {
    sigma_t_m: f64,
    z_t: Complex64,
}

const FIRST: Published = Published {
    sigma_t_m: 2.93e-6,
    z_t: Complex64::new(-0.13, 1.24),
};
const SECOND: Published = Published {
    sigma_t_m: 2.02e-6,
    z_t: Complex64::new(-0.13, 1.77),
};

/// Two recordings of an independent simulation, with their truth (bench/tests/data/reference/README.md).
fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/reference")
}

/// `folder` holds the reference recording `name`, or what was made of it.
fn assert_reference(folder: &Path, name: &str, published: &Published) -> RecordingFindings {
    let truth = fs::read(reference().join(format!("{name}.truth.json"))).unwrap();
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let number = |key: &str| truth[key].as_f64().unwrap();
    let part = |at: usize| truth["z_t"][at].as_f64().unwrap();
    let z_t = Complex64::new(part(0), part(1));
    let analysis = analyse(folder, &Settings::default());
    let found = analysis.found.unwrap();
    assert_eq!(found.instances.len(), 7);
    for instance in &found.instances {
        let dynamic = &instance.dynamic;
        assert!((dynamic.sigma_t_m / number("sigma_m") - 1.0).abs() < 0.03);
        assert!((dynamic.z_t_n_s_per_m - z_t).norm() < 0.05 * z_t.norm());
        assert!((dynamic.tau_s.unwrap().0 - number("tau_s")).abs() < 0.5e-3);
        assert!(dynamic.agreement.rms_mu <= 0.03);
    }
    assert!(!found.model_check.is_empty());
    for band in &found.model_check {
        assert!(band.p90 < 0.05, "{band:?}");
    }
    let paper = found.instances.iter().map(|i| &i.paper);
    let sigma_t_m = mean(paper.clone().map(|e| e.sigma_t_m));
    let z_t = Complex64::new(
        mean(paper.clone().map(|e| e.z_t_n_s_per_m.re)),
        mean(paper.map(|e| e.z_t_n_s_per_m.im)),
    );
    assert!(
        (sigma_t_m / published.sigma_t_m - 1.0).abs() < 0.05,
        "{sigma_t_m}"
    );
    assert!(
        (z_t - published.z_t).norm() < 0.05 * published.z_t.norm(),
        "{z_t}"
    );
    found
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

#[test]
fn the_first_reference_recording_is_estimated_within_the_stated_limits() {
    let found = assert_reference(&reference().join("recording-a"), "recording-a", &FIRST);
    assert_eq!(found.flaws, []);
    let rms_mu = mean(found.instances.iter().map(|i| i.paper.agreement.rms_mu));
    assert!((rms_mu / 0.16 - 1.0).abs() < 0.05, "{rms_mu}");
}

#[test]
fn the_second_reference_recording_is_estimated_within_the_stated_limits() {
    let found = assert_reference(&reference().join("recording-c"), "recording-c", &SECOND);
    assert_eq!(found.flaws, []);
}

/// A filter or a buffer in the pickup's channel: its envelope is late, not its phase alone.
#[test]
fn a_pickup_that_is_late_by_many_samples_is_found_and_undone() {
    for late_samples in [10, 30] {
        let folder = tempfile::tempdir().unwrap();
        for file in ["recording.toml", "force.csv", "position.csv"] {
            fs::copy(
                reference().join("recording-a").join(file),
                folder.path().join(file),
            )
            .unwrap();
        }
        let mut reader =
            hound::WavReader::open(reference().join("recording-a/signals.wav")).unwrap();
        let spec = reader.spec();
        let samples: Vec<f32> = reader.samples::<f32>().map(Result::unwrap).collect();
        let mut writer = hound::WavWriter::create(folder.path().join("signals.wav"), spec).unwrap();
        for (n, frame) in samples.chunks_exact(2).enumerate() {
            writer.write_sample(frame[0]).unwrap();
            let before = n.checked_sub(late_samples);
            writer
                .write_sample(before.map_or(0.0, |n| samples[2 * n + 1]))
                .unwrap();
        }
        writer.finalize().unwrap();

        let found = assert_reference(folder.path(), "recording-a", &FIRST);
        let late_s = late_samples as f64 / f64::from(spec.sample_rate);
        let [
            Flaw::PickupPhase { found_rad, .. },
            Flaw::PickupLate { delay_s },
        ] = found.flaws[..]
        else {
            panic!("{:?}", found.flaws);
        };
        assert!((delay_s - late_s).abs() < 2e-6, "{delay_s}");
        let off = Complex64::cis(found_rad) - Complex64::cis(TAU * 35e3 * late_s);
        assert!(off.norm() < 1e-3, "{found_rad}");
    }
}
