//! Recordings of an independent simulation, analysed and compared with their true values.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use analysis::findings::RecordingFindings;
use analysis::flaw::Flaw;
use analysis::method::Method;
use analysis::printed_settings::PrintedSettings;
use analysis::recording_analysis::{analyse, analyse_with_series};
use analysis::{Analysis, Settings};
use estimation::InstanceMisfit;
use num_complex::Complex64;
use serde_json::Value;

/// Known results of the published method for a reference recording: the method's own bias must neither grow nor shrink.
struct PublishedResult {
    sigma_t_m: f64,
    z_t: Complex64,
}

const RECORDING_A: PublishedResult = PublishedResult {
    sigma_t_m: 2.93e-6,
    z_t: Complex64::new(-0.13, 1.24),
};
const RECORDING_C: PublishedResult = PublishedResult {
    sigma_t_m: 2.02e-6,
    z_t: Complex64::new(-0.13, 1.77),
};

/// Two recordings of an independent simulation, with their truth (bench/tests/data/reference/README.md).
fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference")
}

/// Analyses `folder`, the reference recording `name` or a modified copy of it, and asserts the results.
fn assert_reference(folder: &Path, name: &str, published: &PublishedResult) -> RecordingFindings {
    let truth = fs::read(reference().join(format!("{name}.truth.json"))).unwrap();
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let number = |key: &str| truth[key].as_f64().unwrap();
    let z_t_part = |index: usize| truth["z_t"][index].as_f64().unwrap();
    let z_t = Complex64::new(z_t_part(0), z_t_part(1));
    let analysis = analyse(folder, &Settings::default());
    let findings = analysis.findings.unwrap();
    assert_eq!(findings.instances.len(), 7);
    for instance in &findings.instances {
        let dynamic = &instance.dynamic;
        assert!((dynamic.sigma_t_m() / number("sigma_m") - 1.0).abs() < 0.03);
        assert!((dynamic.z_t_n_s_per_m - z_t).norm() < 0.05 * z_t.norm());
        assert!((dynamic.tau_s.unwrap().0 - number("tau_s")).abs() < 0.5e-3);
        assert!(dynamic.agreement.rms_mu <= 0.03);
        // The assumptions of `dynamic` hold here, and those of `paper` but for its known bias.
        assert_eq!(dynamic.misfit, []);
        assert_eq!(instance.paper.misfit, []);
    }
    assert_eq!(findings.trial.as_ref().unwrap().misfit, []);
    assert!(!findings.model_check.is_empty());
    for band in &findings.model_check {
        assert!(band.p90 < 0.05, "{band:?}");
    }
    let paper = findings.instances.iter().map(|i| &i.paper);
    let sigma_t_m = mean(paper.clone().map(|e| e.sigma_t_m()));
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
    findings
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

#[test]
fn the_first_reference_recording_is_estimated_within_the_stated_limits() {
    let findings = assert_reference(
        &reference().join("recording-a"),
        "recording-a",
        &RECORDING_A,
    );
    assert_eq!(findings.flaws, []);
    let rms_mu = mean(findings.instances.iter().map(|i| i.paper.agreement.rms_mu));
    assert!((rms_mu / 0.16 - 1.0).abs() < 0.05, "{rms_mu}");
}

#[test]
fn the_second_reference_recording_is_estimated_within_the_stated_limits() {
    let findings = assert_reference(
        &reference().join("recording-c"),
        "recording-c",
        &RECORDING_C,
    );
    assert_eq!(findings.flaws, []);
}

/// A filter or a buffer in the pickup's channel delays its envelope, not only its phase.
#[test]
fn a_pickup_delay_of_many_samples_is_found_and_corrected() {
    for delay_samples in [10, 30] {
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
            let source_index = n.checked_sub(delay_samples);
            writer
                .write_sample(source_index.map_or(0.0, |n| samples[2 * n + 1]))
                .unwrap();
        }
        writer.finalize().unwrap();

        let findings = assert_reference(folder.path(), "recording-a", &RECORDING_A);
        let true_delay_s = delay_samples as f64 / f64::from(spec.sample_rate);
        let [
            Flaw::PickupPhase { found_rad, .. },
            Flaw::PickupLate { delay_s },
        ] = findings.flaws[..]
        else {
            panic!("{:?}", findings.flaws);
        };
        assert!((delay_s - true_delay_s).abs() < 2e-6, "{delay_s}");
        let phasor_error = Complex64::cis(found_rad) - Complex64::cis(TAU * 35e3 * true_delay_s);
        assert!(phasor_error.norm() < 1e-3, "{found_rad}");
    }
}

/// Force and motion at the carrier from the true contact, gap and amplitude: f̃ = Z_t Z_c/(Z_t + Z_c) ṽ_p relative to ṽ_p, and
/// x̃_t/x̃_p = Z_c/(Z_t + Z_c), the two degrees of freedom of Eqs. 4–8 with Eqs. 14, 15 and 18.
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
    let samples = series("force_t").into_iter().zip(films);
    samples
        .map(|(time_s, (gap_m, amplitude_m))| {
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
fn interpolate(time_s: f64, times_s: &[f64], values: &[Complex64]) -> Option<Complex64> {
    let next = times_s.partition_point(|&t| t < time_s);
    let previous = next.checked_sub(1)?;
    let (start, end) = (times_s[previous], *times_s.get(next)?);
    let fraction = (time_s - start) / (end - start);
    Some(values[previous] * (1.0 - fraction) + values[next] * fraction)
}

fn p90(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() * 9 / 10]
}

#[test]
fn forces_and_skin_motion_agree_with_the_true_values() {
    let folder = reference().join("recording-a");
    let (analysis, series) = analyse_with_series(&folder, &Settings::default());
    let findings = analysis.findings.unwrap();
    let truth = true_motion("recording-a");
    let moving_samples = || truth.iter().filter(|truth| truth.amplitude_m > 0.1e-6);

    // Over whole explorations, from measured data alone.
    let z_p = findings.z_p.unwrap().corrected_n_s_per_m;
    let mut forces = Vec::new();
    for exploration in &series.explorations {
        let omega = TAU * findings.carrier_hz().unwrap();
        let frames = exploration.z_m(Method::Dynamic).iter();
        let force_n: Vec<Complex64> = frames
            .zip(&exploration.amplitude_m)
            .map(|(z_m, amplitude_m)| (z_m - z_p) * omega * amplitude_m)
            .collect();
        forces.extend(moving_samples().filter_map(|truth| {
            let force_n = interpolate(truth.time_s, &exploration.time_s, &force_n)?;
            Some((force_n.norm() / truth.reaction_force_n.norm() - 1.0).abs())
        }));
    }
    assert!(forces.len() > 1000, "{}", forces.len());
    let force_error = p90(forces);
    assert!(force_error < 0.02, "force: {force_error}");

    // In the instances, where Z_t is known.
    let (mut motion, mut phase, mut power) = (Vec::new(), Vec::new(), Vec::new());
    for instance in &series.instances {
        let (times_s, skin) = (instance.samples.time_s(), &instance.dynamic.motion);
        let watts: Vec<Complex64> = skin.skin_power_w.iter().map(|&w| w.into()).collect();
        for truth in moving_samples() {
            let Some(ratio) = interpolate(truth.time_s, times_s, &skin.skin_per_plate) else {
                continue;
            };
            let quotient = ratio / truth.skin_per_plate;
            motion.push((quotient.norm() - 1.0).abs());
            phase.push(quotient.arg().abs());
            let v_t = truth.skin_per_plate.norm() * TAU * 35e3 * truth.amplitude_m;
            let true_w = 0.5 * 0.47 * v_t * v_t;
            power.push(
                (interpolate(truth.time_s, times_s, &watts).unwrap().re / true_w - 1.0).abs(),
            );
        }
    }
    assert!(motion.len() > 300, "{}", motion.len());
    let errors = [p90(motion), p90(phase), p90(power)];
    assert!(
        errors[0] < 0.02 && errors[1] < 0.02 && errors[2] < 0.1,
        "{errors:?}"
    );
}

/// Copies a reference recording, with more text at the end of its `recording.toml`.
fn copy_with(name: &str, more: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in ["signals.wav", "force.csv", "position.csv"] {
        fs::copy(reference().join(name).join(file), folder.path().join(file)).unwrap();
    }
    let text = fs::read_to_string(reference().join(name).join("recording.toml")).unwrap();
    fs::write(folder.path().join("recording.toml"), text + more).unwrap();
    folder
}

/// A recorded pressure has the effect of an assumed one, in all methods; S · p0 is measured.
#[test]
fn a_recorded_ambient_pressure_takes_the_place_of_the_assumed_one() {
    let recorded = copy_with("recording-a", "\n[room]\npressure_hpa = 850.0\n");
    let folders = [recorded.path().to_owned(), reference().join("recording-a")];
    let analysed = analysis::analyse(&folders, &Settings::default(), |_| ());
    let printed = PrintedSettings::new(&analysed);
    assert_eq!(
        printed.ambient_pressure,
        "as measured, room.pressure_hpa, in 1 of 2 recordings; assumed in the others"
    );
    let [measured, standard] = [0, 1].map(|k| analysed.recordings[k].findings.as_ref().unwrap());
    assert_eq!(measured.manifest.room.unwrap().pressure_hpa, 850.0);

    let mut settings = Settings::default();
    settings.assume("ambient_pressure_pa = 85e3").unwrap();
    let assumed = analyse(&folders[1], &settings).findings.unwrap();
    assert_eq!(measured.instances.len(), assumed.instances.len());
    for (measured, assumed) in measured.instances.iter().zip(&assumed.instances) {
        for method in Method::ALL {
            let (a, b) = (measured.estimate(method), assumed.estimate(method));
            let (a, b) = (a.unwrap(), b.unwrap());
            assert_eq!(a.skin.ambient_pressure_pa, 85_000.0);
            assert_eq!(
                (a.sigma_t_m(), a.z_t_n_s_per_m),
                (b.sigma_t_m(), b.z_t_n_s_per_m)
            );
        }
    }
    let area_m2 =
        |findings: &RecordingFindings| findings.trial.as_ref().unwrap().contact_area_m2.value;
    let ratio = area_m2(measured) / area_m2(standard);
    assert!(
        (ratio / (101_325.0 / 85_000.0) - 1.0).abs() < 0.02,
        "{ratio}"
    );

    let analysed = analysis::analyse(&folders[1..], &Settings::default(), |_| ());
    let printed = PrintedSettings::new(&analysed);
    assert_eq!(
        printed.ambient_pressure,
        "assumed: no recording has room.pressure_hpa"
    );
}

#[test]
fn a_recorded_wavelength_across_is_stated_and_its_absence_too() {
    let across =
        "\n[plate.across]\nwavelength_m = 0.0245\nstandard_error_m = 3e-4\nsource = \"measured\"\n";
    let recorded = copy_with("recording-a", across);
    let folders = [recorded.path().to_owned(), reference().join("recording-a")];
    for (range, statement) in [
        (
            0..1,
            "wavelength across the plate as recorded: plate.across",
        ),
        (
            0..2,
            "wavelength across the plate as recorded: plate.across, in 1 of 2 recordings; in the others width of the finger across \
             the mode not known: included in interval95 of trial",
        ),
        (
            1..2,
            "width of the finger across the mode not known: included in interval95 of trial",
        ),
    ] {
        let analysed = analysis::analyse(&folders[range], &Settings::default(), |_| ());
        assert_eq!(
            PrintedSettings::new(&analysed).finger_across_mode,
            statement
        );
    }
}

/// SCIENCE.md section 8: the published damping factor, read as a damping ratio.
#[test]
fn damping_read_as_a_ratio_lowers_the_published_roughness() {
    let sigma_t_m = |assumption: &str| {
        let mut settings = Settings::default();
        settings.assume(assumption).unwrap();
        let findings = analyse(&reference().join("recording-a"), &settings).findings;
        let instances = findings.unwrap().instances;
        mean(instances.iter().map(|instance| instance.paper.sigma_t_m()))
    };
    for (assumption, expected_m) in [("damping=loss_factor", 2.88e-6), ("damping=ratio", 2.74e-6)] {
        let sigma_t_m = sigma_t_m(assumption);
        assert!(
            (sigma_t_m / expected_m - 1.0).abs() < 0.005,
            "{assumption}: {sigma_t_m}"
        );
    }
}

/// Recording of a simulation in which every assumption is wrong.
fn unknown_skin() -> &'static Analysis {
    static ANALYSED: OnceLock<Analysis> = OnceLock::new();
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
    let findings = unknown_skin().findings().next().unwrap();
    assert_eq!(findings.instances.len(), 7);
    let trial = findings.trial.as_ref().unwrap();
    let relative_error = |value: f64, key: &str| (value / number(key) - 1.0).abs();
    assert!(relative_error(trial.contact_area_m2.value, "contact_area_m2") < 0.06);
    assert!(relative_error(trial.q0_rad_per_m.value, "q0_rad_per_m") < 0.15);
    assert!((trial.loss_factor.value - number("loss_factor")).abs() < 0.015);
    assert!((trial.tau_s.value - number("tau_s")).abs() < 0.1e-3);
    let floor = trial.friction_floor.unwrap().value;
    assert!((floor - number("friction_floor")).abs() < 0.005);
    // The stated intervals include the true values; those within the published laws, which this world follows, are no wider than
    // necessary.
    let published = findings.within_laws.as_ref().unwrap();
    for (total, interval, truth, greatest_width) in [
        (
            trial.contact_area_m2.interval95(),
            published.contact_area_m2.interval95(),
            number("contact_area_m2"),
            0.09,
        ),
        (
            trial.q0_rad_per_m.interval95(),
            published.q0_rad_per_m.interval95(),
            number("q0_rad_per_m"),
            0.35,
        ),
        (
            trial.loss_factor.interval95(),
            published.loss_factor.interval95(),
            number("loss_factor"),
            0.3,
        ),
        (
            trial.tau_s.interval95(),
            published.tau_s.interval95(),
            number("tau_s"),
            0.4,
        ),
    ] {
        let [low, high] = interval;
        assert!(low < truth && truth < high, "{interval:?} {truth}");
        assert!(high - low < greatest_width * truth, "{interval:?} {truth}");
        assert!(
            total[0] <= low && high <= total[1],
            "{total:?} {interval:?}"
        );
    }
    // In this world neither the lag nor the area grows.
    assert!(trial.lag_exponent.value.abs() < 0.05 && trial.area_exponent.value.abs() < 0.05);
    assert_eq!(trial.misfit, []);
    let lag_s = trial.lateral_lag_s.unwrap().value;
    assert!((lag_s - number("lateral_lag_s")).abs() < 0.15e-3);
    for instance in &findings.instances {
        // From the file of true values: p(t) = clip((t - 1.1 s)/2.0 s, 0, 1); sigma_t and Im Z_t times 1 + 0.2 (p - 0.5).
        let progress = ((instance.start_s + instance.end_s) / 2.0 - 1.1) / 2.0;
        let growth = 1.0 + 0.2 * (progress - 0.5);
        let z_t = Complex64::new(0.55, 3.3 * growth);
        let estimate = instance.trial.as_ref().unwrap();
        assert!((estimate.sigma_t_m() / (1.55e-6 * growth) - 1.0).abs() < 0.005);
        assert!((estimate.z_t_n_s_per_m - z_t).norm() < 0.012 * z_t.norm());
        let shift_hz = estimate.plate_offset.unwrap().resonance_shift_hz;
        assert!((shift_hz + 5.0 * progress).abs() < 0.05, "{shift_hz} Hz");
        assert!(estimate.agreement.rms_mu < 0.005);
        assert!(instance.dynamic.agreement.rms_mu > 0.03);
        let is_friction = |sign: &InstanceMisfit| matches!(sign, InstanceMisfit::Friction { .. });
        let is_impedance = |sign: &InstanceMisfit| matches!(sign, InstanceMisfit::Impedance { .. });
        let signs = &instance.dynamic.misfit;
        assert!(
            signs.iter().any(is_friction) && signs.iter().any(is_impedance),
            "{signs:?}"
        );
        assert_eq!(instance.paper.misfit, []);
    }
}
