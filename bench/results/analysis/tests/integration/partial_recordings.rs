//! Recordings that lack a stream or have another in its place: the results that remain are those of the whole recording.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use analysis::RecordingSeries;
use analysis::Settings;
use analysis::findings::RecordingFindings;
use analysis::flaw::{Flaw, MissingStream};
use analysis::recording_analysis::analyse_with_series;
use approx::assert_relative_eq;
use envelope_files::{EnvelopeRow, EnvelopeWriter};
use impedance::{Demodulator, Filter, InputChannel};
use tempfile::TempDir;

const SIGNALS: &str = "signals.wav";
const FORCE: &str = "force.csv";
const POSITION: &str = "position.csv";

fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a")
}

fn findings(folder: &Path) -> RecordingFindings {
    findings_and_series(folder).0
}

fn findings_and_series(folder: &Path) -> (RecordingFindings, RecordingSeries) {
    let (analysis, series) = analyse_with_series(folder, &Settings::default());
    (analysis.findings.unwrap(), series)
}

static WHOLE: LazyLock<(RecordingFindings, RecordingSeries)> =
    LazyLock::new(|| findings_and_series(&reference()));

/// Returns the reference recording with these files and an edited description.
fn partial(files: &[&str], edit: impl Fn(&str) -> String) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        fs::copy(reference().join(file), folder.path().join(file)).unwrap();
    }
    let text = fs::read_to_string(reference().join("recording.toml")).unwrap();
    fs::write(folder.path().join("recording.toml"), edit(&text)).unwrap();
    folder
}

/// Returns the text without the part from one word up to another, or up to the end.
fn shortened(text: &str, first: &str, next: Option<&str>) -> String {
    let start = text.find(first).unwrap();
    let end = next.map_or(text.len(), |next| start + text[start..].find(next).unwrap());
    [&text[..start], &text[end..]].concat()
}

#[test]
fn without_forces_amplitudes_and_impedances_remain() {
    let folder = partial(&[SIGNALS, POSITION], str::to_owned);
    let (findings, series) = findings_and_series(folder.path());
    assert!(
        findings
            .flaws
            .contains(&Flaw::Missing(MissingStream::Forces))
    );
    assert!(!findings.flaws.contains(&Flaw::ForceZeroUnread));
    assert_eq!(findings.z_p, WHOLE.0.z_p);
    let (exploration, whole) = (&series.explorations[0], &WHOLE.1.explorations[0]);
    assert_eq!(exploration.amplitude_m, whole.amplitude_m);
    assert_eq!(exploration.velocity_m_per_s, whole.velocity_m_per_s);
    assert!(exploration.mu.iter().all(|mu| mu.is_nan()));
    assert!(findings.instances.is_empty() && findings.has_result());
    assert!(
        findings
            .rejected
            .iter()
            .any(|stretch| stretch.reason.contains("force or position"))
    );
}

#[test]
fn without_positions_friction_remains() {
    let folder = partial(&[SIGNALS, FORCE], str::to_owned);
    let (findings, series) = findings_and_series(folder.path());
    assert!(
        findings
            .flaws
            .contains(&Flaw::Missing(MissingStream::Positions))
    );
    assert_eq!(series.explorations[0].mu, WHOLE.1.explorations[0].mu);
    assert!(series.explorations[0].position_m.iter().all(|x| x.is_nan()));
    assert!(findings.instances.is_empty() && findings.has_result());
}

#[test]
fn without_an_unloaded_interval_friction_remains() {
    let second = "[[intervals]]\nkind = \"exploration\"";
    let folder = partial(&[SIGNALS, FORCE, POSITION], |text| {
        shortened(text, "[[intervals]]\nkind = \"unloaded\"", Some(second))
    });
    let findings = findings(folder.path());
    assert_eq!(findings.z_p, None);
    let mu = findings.explorations[0].stroke.mu;
    // The forces are not taken against a zero.
    assert_relative_eq!(mu, WHOLE.0.explorations[0].stroke.mu, max_relative = 0.05);
    assert!(findings.has_result());
}

#[test]
fn without_an_exploration_the_plate_remains() {
    let folder = partial(&[SIGNALS, FORCE, POSITION], |text| {
        shortened(text, "[[intervals]]\nkind = \"exploration\"", None)
    });
    let findings = findings(folder.path());
    assert!(findings.flaws.contains(&Flaw::NoExploration) && findings.has_result());
    let (z_p, whole) = (findings.z_p.unwrap(), WHOLE.0.z_p.unwrap());
    assert!((z_p.corrected_n_s_per_m - whole.corrected_n_s_per_m).norm() < 1e-3);
}

#[test]
fn instances_of_an_exploration_stated_twice_count_once() {
    let folder = partial(&[SIGNALS, FORCE, POSITION], |text| {
        let copy = shortened(
            text,
            "format",
            Some("[[intervals]]\nkind = \"exploration\""),
        );
        format!("{text}\n{copy}")
    });
    let findings = findings(folder.path());
    let is_named = |flaw: &Flaw| matches!(flaw, Flaw::CoincidingExplorations { .. });
    assert!(findings.flaws.iter().any(is_named));
    assert_eq!(findings.instances.len(), WHOLE.0.instances.len());
    let counted = findings
        .rejected
        .iter()
        .filter(|stretch| stretch.kind.starts_with("counted already"));
    assert_eq!(counted.count(), WHOLE.0.instances.len());
    assert!(!WHOLE.0.flaws.iter().any(is_named));
}

/// Requires the estimates of `dynamic` and the friction of the whole recording, to a relative tolerance.
fn require_equal_estimates(findings: &RecordingFindings, tolerance: f64) {
    assert_eq!(findings.instances.len(), WHOLE.0.instances.len());
    for (instance, whole) in findings.instances.iter().zip(&WHOLE.0.instances) {
        let (dynamic, expected) = (&instance.dynamic, &whole.dynamic);
        assert_relative_eq!(
            dynamic.sigma_t_m(),
            expected.sigma_t_m(),
            max_relative = tolerance
        );
        assert_relative_eq!(dynamic.mu0, expected.mu0, max_relative = tolerance);
        let z_t = expected.z_t_n_s_per_m;
        assert!((dynamic.z_t_n_s_per_m - z_t).norm() < tolerance * z_t.norm());
    }
}

#[test]
fn envelopes_give_the_results_of_the_samples() {
    let mut wav = hound::WavReader::open(reference().join(SIGNALS)).unwrap();
    let rate_hz = f64::from(wav.spec().sample_rate);
    let samples: Vec<f32> = wav.samples::<f32>().map(Result::unwrap).collect();
    let input = |channel| InputChannel {
        channel,
        clip_level: f32::INFINITY,
    };
    // 10 kHz, flat to 1.5 kHz.
    let filter = Filter::with_hop(rate_hz, 35e3, 10).unwrap();
    let mut demodulator = Demodulator::new(filter, 2, [input(0), input(1)]).unwrap();
    let mut rows = Vec::new();
    demodulator
        .push(&samples, |frame| {
            rows.push(EnvelopeRow {
                time_s: frame.time_s,
                drive_v: frame.drive().value,
                pickup_m: 2e-6 * frame.pickup().value,
            });
        })
        .unwrap();
    let folder = partial(&[FORCE, POSITION], |text| {
        shortened(text, "[channels.drive]", Some("[plate]"))
    });
    let mut writer = EnvelopeWriter::create(&folder.path().join("envelopes.parquet")).unwrap();
    writer.write(&rows).unwrap();
    writer.finish().unwrap();
    let findings = findings(folder.path());
    assert!(
        findings.flaws.contains(&Flaw::ConverterUnchecked),
        "{:?}",
        findings.flaws
    );
    require_equal_estimates(&findings, 2e-3);
}

#[test]
fn a_carrier_read_from_the_drive_gives_the_results_of_the_stated_one() {
    let folder = partial(&[SIGNALS, FORCE, POSITION], |text| {
        let stated = text
            .lines()
            .find(|line| line.starts_with("carrier_hz"))
            .unwrap();
        text.replace(stated, "carrier_hz = \"follows\"")
    });
    let findings = findings(folder.path());
    let is_followed = |flaw: &Flaw| matches!(flaw, Flaw::CarrierFollowed { .. });
    assert!(
        findings.flaws.iter().any(is_followed),
        "{:?}",
        findings.flaws
    );
    assert!((findings.carrier_hz().unwrap() - 35e3).abs() < 2.0);
    require_equal_estimates(&findings, 1e-3);
}

/// Rows of the friction rig of tests/fixtures: time in s, normal force in N, position in m, friction force in N.
fn rig() -> Vec<[f64; 4]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../tests/fixtures/friction-rig/friction-rig.txt");
    let text = fs::read_to_string(path).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let fields: Vec<f64> = line
            .split('\t')
            .map(|field| field.trim().parse().unwrap())
            .collect();
        [
            fields[0],
            1e-6 * fields[1],
            1e-3 * fields[2],
            1e-6 * fields[3],
        ]
    });
    rows.collect()
}

/// Strokes of the rig, s: it reverses every 2 s.
fn rig_strokes() -> Vec<(f64, f64)> {
    (0..20)
        .map(|k| 8.55 + 2.0 * f64::from(k))
        .map(|start_s| (start_s, start_s + 1.45))
        .collect()
}

/// Returns a recording of the rig with the lateral force times a factor at each time, and a stimulus if there is one.
fn rig_recording(factor: impl Fn(f64) -> f64, stimulus: Option<&dyn Fn(f64) -> f64>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut force = "time_s,normal_n,lateral_n\n".to_owned();
    let mut position = "time_s,position_m\n".to_owned();
    let mut stimuli = "time_s,stimulus\n".to_owned();
    for [time_s, normal_n, position_m, lateral_n] in rig() {
        writeln!(force, "{time_s},{normal_n},{}", lateral_n * factor(time_s)).unwrap();
        writeln!(position, "{time_s},{position_m}").unwrap();
        if let Some(stimulus) = stimulus {
            writeln!(stimuli, "{time_s},{}", stimulus(time_s)).unwrap();
        }
    }
    let mut text = "format = 1\n[contact]\nbody = \"other\"\n".to_owned();
    for (index, (start_s, end_s)) in rig_strokes().into_iter().enumerate() {
        let direction = ["left_to_right", "right_to_left"][index % 2];
        writeln!(
            text,
            "[[intervals]]\nkind = \"exploration\"\ndirection = \"{direction}\"\nstart_s = {start_s}\nend_s = {end_s}"
        )
        .unwrap();
    }
    fs::write(folder.path().join("recording.toml"), text).unwrap();
    fs::write(folder.path().join(FORCE), force).unwrap();
    fs::write(folder.path().join(POSITION), position).unwrap();
    if stimulus.is_some() {
        fs::write(folder.path().join("stimulus.csv"), stimuli).unwrap();
    }
    folder
}

#[test]
fn the_friction_of_forces_alone_is_that_of_their_rows() {
    let folder = rig_recording(|_| 1.0, None);
    let (findings, series) = findings_and_series(folder.path());
    assert_eq!(
        findings.flaws,
        [Flaw::Missing(MissingStream::Vibration), Flaw::ForcesAsRead]
    );
    assert_eq!(
        (findings.carrier_hz(), findings.plate(), findings.z_p),
        (None, None, None)
    );
    assert!(findings.has_result());
    assert_eq!(findings.explorations.len(), rig_strokes().len());
    let rows = rig();
    let strokes = findings
        .explorations
        .iter()
        .map(|exploration| &exploration.stroke);
    let explorations = series.explorations.iter().zip(strokes);
    for ((exploration, stroke), (start_s, end_s)) in explorations.zip(rig_strokes()) {
        let inside = rows
            .iter()
            .filter(|row| (start_s..=end_s).contains(&row[0]));
        let mu: Vec<f64> = inside
            .map(|[_, normal_n, _, lateral_n]| (lateral_n / normal_n).abs())
            .collect();
        assert_eq!(exploration.mu.len(), mu.len());
        for (read, expected) in exploration.mu.iter().zip(&mu) {
            assert_relative_eq!(*read, *expected, max_relative = 1e-9);
        }
        let mean = mu.iter().sum::<f64>() / mu.len() as f64;
        assert_relative_eq!(stroke.mu, mean, max_relative = 1e-9);
        assert_eq!(stroke.effect, None);
        assert!(
            exploration
                .amplitude_m
                .iter()
                .all(|amplitude| amplitude.is_nan())
        );
    }
}

/// A stimulus of 5 Hz lowers the friction by 30 %, 20 ms late. That of the rig itself grows along each stroke, and changes with the place.
#[test]
fn contrast_and_lag_of_forces_alone_are_those_of_their_stimulus() {
    let stimulus = |time_s: f64| {
        if (5.0 * time_s).fract() < 0.5 {
            0.0
        } else {
            120.0
        }
    };
    let factor = |time_s: f64| 1.0 - 0.3 * stimulus(time_s - 0.02) / 120.0;
    let folder = rig_recording(factor, Some(&stimulus));
    let effects: Vec<_> = findings(folder.path())
        .explorations
        .iter()
        .filter_map(|exploration| exploration.stroke.effect)
        .collect();
    assert_eq!(effects.len(), rig_strokes().len());
    for effect in effects {
        assert!((effect.contrast - 0.3).abs() < 0.02, "{effect:?}");
        assert!((effect.lag_s - 0.02).abs() < 3e-3, "{effect:?}");
    }
}

/// Without drive and pickup no modulation tells the axes apart: the strokes there and back do.
#[test]
fn exchanged_columns_of_forces_alone_have_a_name_and_no_friction() {
    let folder = rig_recording(|_| 1.0, None);
    let path = folder.path().join(FORCE);
    let text = fs::read_to_string(&path).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        format!("{},{},{}\n", fields[0], fields[2], fields[1])
    });
    let rows: String = rows.collect();
    fs::write(&path, format!("time_s,normal_n,lateral_n\n{rows}")).unwrap();
    let (findings, series) = findings_and_series(folder.path());
    let is_exchange = |flaw: &Flaw| flaw.to_string().contains("the columns are exchanged");
    assert!(
        findings.flaws.iter().any(is_exchange),
        "{:?}",
        findings.flaws
    );
    let strokes = findings.explorations.iter();
    assert!(
        strokes
            .clone()
            .all(|exploration| exploration.stroke.mu.is_nan())
    );
    let series = series.explorations.iter();
    assert!(
        series
            .flat_map(|exploration| &exploration.mu)
            .all(|mu| mu.is_nan())
    );
}
