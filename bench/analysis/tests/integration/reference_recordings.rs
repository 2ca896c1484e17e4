//! Recordings of an independent simulation, analysed and compared with their true values.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use analysis::analysed::RecordingFindings;
use analysis::flaw::Flaw;
use analysis::method::Method;
use analysis::recording_analysis::analyse;
use analysis::results::Results;
use analysis::{Analysed, Settings, tables};
use num_complex::Complex64;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;

/// Known results of the published method for a reference recording: the method's own bias must neither grow nor shrink.
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

/// Analyses `folder`, the reference recording `name` or a modified copy of it, and asserts the results.
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

/// A filter or a buffer in the pickup's channel delays its envelope, not only its phase.
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

/// Force and motion at the carrier from the true contact, gap and amplitude: f̃ = Z_t Z_c/(Z_t + Z_c) ṽ_p relative to ṽ_p, and
/// x̃_t/x̃_p = Z_c/(Z_t + Z_c), the two degrees of freedom of Eqs. 7 and 8 with Eqs. 6, 14, 15 and 18.
struct TrueMotion {
    time_s: f64,
    amplitude_m: f64,
    reaction_force_n: Complex64,
    skin_per_plate: Complex64,
}

fn true_motion(name: &str) -> Vec<TrueMotion> {
    let truth = fs::read(reference().join(format!("{name}.truth.json"))).unwrap();
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let series = |key: &str| -> Vec<f64> { serde_json::from_value(truth[key].clone()).unwrap() };
    let z_t = Complex64::new(series("z_t")[0], series("z_t")[1]);
    let sigma_m = truth["sigma_m"].as_f64().unwrap();
    let (modulus_pa, area_m2, omega) = (20e6 / (1.0 - 0.25), 300e-6, TAU * 35e3);
    let films = series("gap_m").into_iter().zip(series("amplitude_m"));
    let each = series("force_t").into_iter().zip(films);
    each.map(|(time_s, (gap_m, amplitude_m))| {
        let asperity = 0.375 * 1.4e4 * modulus_pa * area_m2 * (-gap_m / sigma_m).exp();
        let film_n = 1.25 * 101_325.0 * area_m2 * (amplitude_m / gap_m).powi(2);
        let k_c = asperity + 2.0 * film_n / gap_m;
        let z_c = Complex64::new(0.3, -1.0) * k_c / omega;
        let skin_per_plate = z_c / (z_t + z_c);
        TrueMotion {
            time_s,
            amplitude_m,
            reaction_force_n: z_t * skin_per_plate * omega * amplitude_m,
            skin_per_plate,
        }
    })
    .collect()
}

/// Interpolates linearly between samples in order.
fn at(time_s: f64, times_s: &[f64], values: &[Complex64]) -> Option<Complex64> {
    let after = times_s.partition_point(|&t| t < time_s);
    let before = after.checked_sub(1)?;
    let (from, to) = (times_s[before], *times_s.get(after)?);
    let part = (time_s - from) / (to - from);
    Some(values[before] * (1.0 - part) + values[after] * part)
}

fn p90(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() * 9 / 10]
}

#[test]
fn the_finger_pushes_and_the_skin_moves_as_the_truth_has_it() {
    let found = analyse(&reference().join("recording-a"), &Settings::default())
        .found
        .unwrap();
    let truth = true_motion("recording-a");
    let moving = || truth.iter().filter(|truth| truth.amplitude_m > 0.1e-6);

    // Over whole explorations, from measured data alone.
    let z_p = found.z_p.unwrap().corrected_n_s_per_m;
    let mut forces = Vec::new();
    for exploration in &found.explorations {
        let omega = TAU * found.manifest.carrier_hz;
        let frames = exploration.z_m(Method::Dynamic).iter();
        let force_n: Vec<Complex64> = frames
            .zip(&exploration.amplitude_m)
            .map(|(z_m, amplitude_m)| (z_m - z_p) * omega * amplitude_m)
            .collect();
        forces.extend(moving().filter_map(|truth| {
            let force_n = at(truth.time_s, &exploration.time_s, &force_n)?;
            Some((force_n.norm() / truth.reaction_force_n.norm() - 1.0).abs())
        }));
    }
    assert!(forces.len() > 1000, "{}", forces.len());
    let apart = p90(forces);
    assert!(apart < 0.02, "force: {apart}");

    // In the instances, where Z_t is known.
    let (mut motion, mut phase, mut power) = (Vec::new(), Vec::new(), Vec::new());
    for instance in &found.instances {
        let (times_s, skin) = (instance.samples.time_s(), &instance.dynamic.motion);
        let watts: Vec<Complex64> = skin.skin_power_w.iter().map(|&w| w.into()).collect();
        for truth in moving() {
            let Some(ratio) = at(truth.time_s, times_s, &skin.skin_per_plate) else {
                continue;
            };
            let part = ratio / truth.skin_per_plate;
            motion.push((part.norm() - 1.0).abs());
            phase.push(part.arg().abs());
            let v_t = truth.skin_per_plate.norm() * TAU * 35e3 * truth.amplitude_m;
            let true_w = 0.5 * 0.47 * v_t * v_t;
            power.push((at(truth.time_s, times_s, &watts).unwrap().re / true_w - 1.0).abs());
        }
    }
    assert!(motion.len() > 300, "{}", motion.len());
    let apart = [p90(motion), p90(phase), p90(power)];
    assert!(
        apart[0] < 0.02 && apart[1] < 0.02 && apart[2] < 0.1,
        "{apart:?}"
    );
}

/// Recording of a simulation in which every assumption is wrong.
fn unknown_skin() -> &'static Analysed {
    static ANALYSED: OnceLock<Analysed> = OnceLock::new();
    ANALYSED.get_or_init(|| {
        let folder = reference().join("recording-d");
        analysis::analyse(&[folder], &Settings::default(), |_| ())
    })
}

/// With every assumption wrong (bench/tests/data/reference/README.md), `trial` measures the values that `dynamic` assumes,
/// for each instance where they change.
#[test]
fn the_trials_fit_follows_a_drifting_plate_and_an_unknown_skin() {
    let truth = fs::read(reference().join("recording-d.truth.json")).unwrap();
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let number = |key: &str| truth[key].as_f64().unwrap();
    let found = unknown_skin().findings().next().unwrap();
    assert_eq!(found.instances.len(), 7);
    let trial = found.trial.as_ref().unwrap();
    let off = |found: f64, key: &str| (found / number(key) - 1.0).abs();
    assert!(off(trial.contact_area_m2.value, "contact_area_m2") < 0.06);
    assert!(off(trial.q0_rad_per_m.value, "q0_rad_per_m") < 0.15);
    assert!((trial.loss_factor.value - number("loss_factor")).abs() < 0.015);
    assert!((trial.tau_s.value - number("tau_s")).abs() < 0.1e-3);
    let floor = trial.friction_floor.unwrap().value;
    assert!((floor - number("friction_floor")).abs() < 0.005);
    // The stated intervals include the true values, and are no wider than necessary.
    for (interval, truth, widest) in [
        (
            trial.contact_area_m2.interval95(),
            number("contact_area_m2"),
            0.09,
        ),
        (
            trial.q0_rad_per_m.interval95(),
            number("q0_rad_per_m"),
            0.35,
        ),
        (trial.loss_factor.interval95(), number("loss_factor"), 0.3),
        (trial.tau_s.interval95(), number("tau_s"), 0.4),
    ] {
        let [from, to] = interval;
        assert!(from < truth && truth < to, "{interval:?} {truth}");
        assert!(to - from < widest * truth, "{interval:?} {truth}");
    }
    // In this world neither the lag nor the area grows.
    assert!(trial.lag_exponent.value.abs() < 0.05 && trial.area_exponent.value.abs() < 0.05);
    assert_eq!(trial.misfit, []);
    let lag_s = trial.lateral_lag_s.unwrap().value;
    assert!((lag_s - number("lateral_lag_s")).abs() < 0.15e-3);
    for instance in &found.instances {
        // From the file of true values: p(t) = clip((t - 1.1 s)/2.0 s, 0, 1); sigma_t and Im Z_t times 1 + 0.2 (p - 0.5).
        let progress = ((instance.start_s + instance.end_s) / 2.0 - 1.1) / 2.0;
        let growth = 1.0 + 0.2 * (progress - 0.5);
        let z_t = Complex64::new(0.55, 3.3 * growth);
        let found = instance.trial.as_ref().unwrap();
        assert!((found.sigma_t_m / (1.55e-6 * growth) - 1.0).abs() < 0.005);
        assert!((found.z_t_n_s_per_m - z_t).norm() < 0.012 * z_t.norm());
        let shift_hz = found.plate_offset.unwrap().resonance_shift_hz;
        assert!((shift_hz + 5.0 * progress).abs() < 0.05, "{shift_hz} Hz");
        assert!(found.agreement.rms_mu < 0.005);
        assert!(instance.dynamic.agreement.rms_mu > 0.03);
    }
}

/// Rows of a table, each by the names of its columns.
fn table(file: &Path) -> Vec<Vec<(String, Field)>> {
    let reader = SerializedFileReader::new(fs::File::open(file).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    rows.map(|row| row.unwrap().into_columns()).collect()
}

#[test]
fn the_table_of_instances_holds_what_the_results_hold_of_the_trials_fit() {
    let folder = tempfile::tempdir().unwrap();
    tables::write(unknown_skin(), folder.path()).unwrap();
    let results = Results::new(unknown_skin()).to_json().unwrap();
    let results: Value = serde_json::from_str(&results).unwrap();
    let recording = &results["recordings"][0];
    let shared = &recording["trial"];
    let rows = table(&folder.path().join(tables::INSTANCES_FILE));
    let instances = recording["instances"].as_array().unwrap();
    assert_eq!(rows.len(), 3 * instances.len());
    let mut compared = 0;
    for row in rows {
        let field = |name: &str| {
            let named = row.iter().find(|(column, _)| column == name);
            &named.unwrap_or_else(|| panic!("no column {name}")).1
        };
        let real = |name: &str| match field(name) {
            Field::Double(value) => *value,
            other => panic!("{name} is {other:?}"),
        };
        let (Field::Str(method), Field::Long(number)) = (field("method"), field("instance")) else {
            panic!("{row:?}");
        };
        if method != "trial" {
            assert_eq!(field("model_misfit"), &Field::Bool(false));
            for name in ["area_force_exponent", "film_mean_s", "lag_gap_exponent"] {
                assert_eq!(real(name), 0.0, "{name}");
            }
            for name in ["q0_ln_std", "film_mean_ln_std", "shared_tau_s"] {
                assert!(real(name).is_nan(), "{name}");
            }
            continue;
        }
        let trial = &instances[*number as usize - 1]["trial"];
        assert_eq!(field("verdict"), &Field::Str("converged".to_owned()));
        assert_eq!(shared["verdict"], "converged");
        assert_eq!(field("model_misfit"), &Field::Bool(false));
        assert_eq!(field("misfit"), &Field::Str(String::new()));
        let same = |name: &str, found: f64, of: &Value| {
            let expected = of.as_f64().unwrap();
            let slack = 1e-6 * expected.abs().max(1e-9);
            assert!((found - expected).abs() <= slack, "{name}: {found} {of}");
        };
        // Value and upper end of the interval, computed as docs/RECORDING.md describes.
        let mut holds = |column: &str, std: &str, of: &Value, key: &str| {
            let (value, deviations) = (real(column), 1.959_964 * real(std));
            same(column, value, &of[key]);
            let end = if std.ends_with("_ln_std") {
                value * deviations.exp()
            } else {
                value + deviations
            };
            same(std, end, &of["interval95"][key][1]);
            compared += 1;
        };
        for (column, std) in [
            ("contact_area_m2", "contact_area_ln_std"),
            ("q0_rad_per_m", "q0_ln_std"),
            ("loss_factor", "loss_factor_ln_std"),
            ("area_force_exponent", "area_force_exponent_std"),
            ("film_mean_s", "film_mean_ln_std"),
            ("lag_gap_exponent", "lag_gap_exponent_std"),
            ("friction_floor", "friction_floor_std"),
            ("lateral_lag_s", "lateral_lag_std_s"),
        ] {
            holds(column, std, shared, column);
        }
        holds("shared_tau_s", "shared_tau_ln_std", shared, "tau_s");
        holds("mu0", "mu0_std", trial, "mu0");
        let shift = "resonance_shift_hz";
        holds(shift, "resonance_shift_std_hz", trial, shift);
        same("tau_s", real("tau_s"), &trial["tau_s"]);
    }
    assert_eq!(compared, 11 * instances.len());
}
