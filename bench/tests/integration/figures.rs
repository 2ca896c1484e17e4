//! Figures keep their curves, units and captions, and are the same bytes each time. The measured ones are drawn from an
//! exploration that follows the contact model exactly.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::f64::consts::TAU;
use std::path::PathBuf;

use analysis::amplitude_profile::AmplitudeProfile;
use analysis::estimate::{InstanceAnalysis, Method, estimate};
use analysis::exploration_findings::ExplorationFindings;
use analysis::exploration_series::ExplorationSeries;
use analysis::findings::PlateReading;
use analysis::findings::RecordingFindings;
use analysis::measurements::FrameSeries;
use analysis::under_finger::UnderFinger;
use analysis::{
    Analysis, KeptSeries, RecordingAnalysis, RecordingSeries, SeriesSource, Settings, complete,
};
use clap::Parser;
use contact::{AssumedConstants, CalibrationErrors, Contact, harmonic};
use estimation::FitConditions;
use friction_bench::cli::{Cli, Command};
use impedance::{Mask, ZmFrame};
use num_complex::Complex64;
use plotting::{Figure, Mark};
use protocols::{Direction, Instance, Validity};
use published_figures::measured::{FigureSelection, measured_figures};
use published_figures::model::{Curves, ModelParameters};
use recording::Manifest;
use study::sessions::Sessions;

/// Name of a figure, and for each panel the labels of its axes and its number of series.
type Expected = (&'static str, &'static [(&'static str, &'static str, usize)]);

const AMPLITUDE: &str = "Vibration amplitude (µm)";
const MODEL: [Expected; 6] = [
    (
        "fig03_impedance_by_stiffness",
        &[
            ("Contact stiffness (N/µm)", "Re Zₘ (N·s/m)", 2),
            ("Contact stiffness (N/µm)", "Im Zₘ (N·s/m)", 2),
            ("Contact stiffness (N/µm)", "|ṽₜ/ṽₚ|", 2),
        ],
    ),
    (
        "fig05_force_balance_and_gap",
        &[("Gap (µm)", "Force (N)", 6), (AMPLITUDE, "Gap (µm)", 4)],
    ),
    (
        "fig06_stiffness",
        &[(AMPLITUDE, "Contact stiffness (N/µm)", 4)],
    ),
    (
        "fig07b_impedance",
        &[
            (AMPLITUDE, "Re Zₘ (N·s/m)", 4),
            (AMPLITUDE, "Im Zₘ (N·s/m)", 4),
        ],
    ),
    ("fig08_motion", &[("Time (µs)", "Position (µm)", 2); 4]),
    (
        "fig09_friction",
        &[(AMPLITUDE, "Friction coefficient μ", 2)],
    ),
];
const MEASURED: [Expected; 5] = [
    (
        "fig11_typical_trial",
        &[
            ("Time (s)", "Amplitude (µm)", 1),
            ("Time (s)", "|Zₘ| (N·s/m)", 2),
            ("Time (s)", "Force (N)", 3),
            ("Time (s)", "|f̃| (N)", 2),
            ("Time (s)", "Friction μ", 5),
            ("Time (s)", "Gap (µm)", 4),
        ],
    ),
    (
        "fig13_instances",
        &[
            (AMPLITUDE, "Re Zₘ (N·s/m)", 4),
            ("Measured μ", "Re Zₘ (N·s/m)", 4),
            (AMPLITUDE, "−Im Zₘ (N·s/m)", 4),
            ("Measured μ", "−Im Zₘ (N·s/m)", 4),
            (AMPLITUDE, "Stiffness (N/µm)", 4),
            ("Measured μ", "Stiffness (N/µm)", 4),
            (AMPLITUDE, "Gap (µm)", 4),
            ("Measured μ", "Gap (µm)", 4),
            (AMPLITUDE, "Friction coefficient μ", 5),
            ("Measured μ", "Friction coefficient μ", 3),
        ],
    ),
    (
        "fig14_variation",
        &[
            ("Δμ, measured", "Δ|Zₘ| (N·s/m)", 2),
            ("Δμ, measured", "Δ gap (µm)", 2),
            ("Δμ, measured", "Δμ, estimated", 3),
        ],
    ),
    (
        "fig15_agreement",
        &[
            ("Measured μ", "Estimated μ", 3),
            ("Measured μ", "Estimated μ", 2),
        ],
    ),
    (
        "resonance_shift",
        &[("Time (s)", "Resonance shift (Hz)", 3)],
    ),
];

fn options(arguments: &[&str]) -> published_figures::model::ModelOptions {
    let line = ["friction-bench", "model"].iter().chain(arguments);
    match Cli::parse_from(line).command {
        Command::Model(options) => options,
        _ => unreachable!("`model` was asked for"),
    }
}

fn model_figures() -> Vec<Figure> {
    let parameters = ModelParameters::from(&options(&[]).assume);
    published_figures::model::draw(&parameters, &Curves::compute(&parameters).unwrap())
}

/// Returns the texts of an SVG, in order.
fn texts(svg: &str) -> Vec<String> {
    let texts = svg.split("<text").skip(1).map(|element| {
        let content = element.split_once('>').unwrap().1;
        content.split_once("</text>").unwrap().0.trim().to_owned()
    });
    texts.collect()
}

/// Requires every series in its colour, every written label with its unit, and every name.
fn assert_shows(figure: &Figure, (name, panels): &Expected) {
    assert_eq!(figure.name, *name);
    assert_eq!(figure.panels.len(), panels.len(), "{name}: panels");
    let svg = figure.to_svg().unwrap();
    let texts = texts(&svg);
    for (panel, (x, y, series)) in figure.panels.iter().zip(*panels) {
        assert_eq!(
            (panel.x.label.as_str(), panel.y.label.as_str()),
            (*x, *y),
            "{name}"
        );
        assert_eq!(panel.series.len(), *series, "{name}: series over {x}");
        for axis in [&panel.x, &panel.y]
            .into_iter()
            .filter(|axis| axis.has_labels)
        {
            assert!(
                texts.contains(&axis.label),
                "{name}: {} is not written",
                axis.label
            );
        }
        for series in &panel.series {
            let (points, element) = match &series.mark {
                Mark::Line { points, .. } => (points.len(), "stroke"),
                Mark::Points { points, .. } => (points.len(), "fill"),
                Mark::Band { edges } | Mark::Bars { bars: edges } => (edges.len(), ""),
            };
            assert!(points > 1, "{name}: {:?} is empty", series.name);
            let (red, green, blue) = series.ink.rgb();
            let ink = format!("{element}=\"#{red:02X}{green:02X}{blue:02X}\"");
            assert!(
                element.is_empty() || svg.contains(&ink),
                "{name}: nothing has {ink}"
            );
            if let Some(label) = &series.name {
                assert!(texts.contains(label), "{name}: {label} is not in the key");
            }
        }
    }
    assert!(
        svg.contains(&format!("width=\"{}mm\"", figure.width.mm())),
        "{name}: width"
    );
    assert!(
        svg.contains("<title>") && svg.contains("Assumed: "),
        "{name}: caption"
    );
}

#[test]
fn model_figures_keep_their_curves_and_units() {
    let figures = model_figures();
    assert_eq!(figures.len(), MODEL.len());
    for (figure, expected) in figures.iter().zip(&MODEL) {
        assert_shows(figure, expected);
    }
}

/// Returns the published figures of measurements, without the description that precedes them.
fn published_figures(
    (analysed, series): &(Analysis, KeptSeries),
    sessions: &Sessions,
    selection: &FigureSelection,
) -> Vec<Figure> {
    let mut figures = measured_figures((analysed, series), sessions, selection).unwrap();
    figures.retain(|figure| figure.name != "friction_fall");
    figures
}

#[test]
fn measured_figures_keep_their_curves_and_units() {
    let figures = published_figures(
        &analysed(),
        &Sessions::default(),
        &FigureSelection::default(),
    );
    assert_eq!(figures.len(), MEASURED.len());
    for (figure, expected) in figures.iter().zip(&MEASURED) {
        assert_shows(figure, expected);
    }
    let shaded = figures[0]
        .panels
        .iter()
        .map(|panel| panel.shaded_ranges.len());
    assert!(shaded.eq([2; 6]), "both instances shaded in every panel");
    let agreement = &figures[3].panels[1];
    assert_eq!(
        agreement.notes,
        ["R² = 1.000"],
        "the model agrees with itself"
    );
    assert!(figures[0].caption.contains("S = 300 mm²"));
}

/// Returns the series of the first recording.
fn first_series(series: &KeptSeries) -> RecordingSeries {
    RecordingSeries::clone(&series.read(0).unwrap())
}

/// Returns the names of a panel's series, once each.
fn names(figure: &Figure, panel: usize) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for series in &figure.panels[panel].series {
        let name = series.name.as_deref().unwrap_or_default();
        if !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

#[test]
fn trial_is_drawn_with_the_others_and_replaces_dynamic_in_fig_13() {
    let mut analysed = analysed();
    let before = published_figures(&analysed, &Sessions::default(), &FigureSelection::default());
    let findings = analysed.0.recordings[0].findings.as_mut().unwrap();
    for instance in &mut findings.instances {
        instance.trial = Some(instance.dynamic.clone());
    }
    *analysed.0.agreement.get_mut(Method::Trial) = analysed.0.agreement.dynamic;
    let mut series = first_series(&analysed.1);
    for instance in &mut series.instances {
        instance.trial = Some(instance.dynamic.clone());
    }
    analysed.1 = KeptSeries::from(series);
    let figures = published_figures(&analysed, &Sessions::default(), &FigureSelection::default());
    // The readings of `trial` are those of `dynamic`, and are drawn once.
    assert_eq!(names(&figures[0], 1), ["dynamic", "paper"]);
    for panel in [3, 5] {
        assert_eq!(names(&figures[0], panel), ["dynamic", "trial", "paper"]);
    }
    let friction_series = ["dynamic", "trial", "paper", "measured friction"];
    assert_eq!(names(&figures[0], 4), friction_series);
    let trial_series = ["trial, model", "paper, model", "trial", "paper"];
    assert_eq!(names(&figures[1], 0), trial_series);
    assert!(
        figures[1]
            .caption
            .contains("Trial stands here in the place of dynamic")
    );
    assert_eq!(names(&figures[2], 0), ["dynamic", "trial", "paper"]);
    assert_eq!(figures[3].panels.len(), 3);
    assert_eq!(names(&figures[3], 2), ["trial", "slope 1"]);
    let words = "(a) the published method (paper), (b) the dynamic method and (c) the fit of whole trials (trial)";
    assert!(figures[3].caption.contains(words), "{}", figures[3].caption);

    // With `trial` for one instance only, it does not replace `dynamic`.
    let findings = analysed.0.recordings[0].findings.as_mut().unwrap();
    findings.instances[1].trial = None;
    let figures = published_figures(&analysed, &Sessions::default(), &FigureSelection::default());
    let dynamic_series = ["dynamic, model", "paper, model", "dynamic", "paper"];
    assert_eq!(names(&figures[1], 0), dynamic_series);
    assert!(figures[1].caption.contains("cannot be used"));
    assert!(figures[2].caption.contains("over 2 instances (1 by trial)"));
    for figure in &figures {
        figure.to_svg().unwrap();
    }
    let trial_only = FigureSelection {
        methods: vec![Method::Trial],
        whole_trial: false,
    };
    for instance in &mut analysed.0.recordings[0]
        .findings
        .as_mut()
        .unwrap()
        .instances
    {
        instance.trial = None;
    }
    let numbers =
        |figures: &[Figure]| -> Vec<String> { figures.iter().map(Figure::to_csv).collect() };
    let after = published_figures(&analysed, &Sessions::default(), &FigureSelection::default());
    assert_eq!(numbers(&after), numbers(&before));
    assert_eq!(
        published_figures(&analysed, &Sessions::default(), &trial_only).len(),
        1,
        "the trial in time"
    );
}

#[test]
fn the_fall_of_friction_comes_first_and_every_figure_states_a_simulation() {
    let (mut analysed, series) = analysed();
    let findings = analysed.recordings[0].findings.as_mut().unwrap();
    findings.provenance.simulated = true;
    let selection = FigureSelection::default();
    let figures = measured_figures((&analysed, &series), &Sessions::default(), &selection).unwrap();
    assert_eq!(figures[0].name, "friction_fall");
    let fall = points(&figures[0], 1, "mean");
    assert_eq!(fall.len(), 1);
    assert!((0.0..100.0).contains(&fall[0].1), "{fall:?} %");
    for figure in &figures {
        assert!(
            figure.caption.ends_with("simulated (1 of 1)."),
            "{}",
            figure.caption
        );
        let svg = figure.to_svg().unwrap();
        let words = "Recordings: simulated (1 of 1)";
        assert!(
            texts(&svg).iter().any(|text| text == words),
            "{}",
            figure.name
        );
    }
}

/// Returns the points of the first series of this name in a panel.
fn points(figure: &Figure, panel: usize, name: &str) -> Vec<(f64, f64)> {
    let mut series = figure.panels[panel].series.iter();
    let named_series = series.find(|series| series.name.as_deref() == Some(name));
    named_series.unwrap().extent()
}

#[test]
fn the_resonance_is_drawn_over_the_time_of_a_session_with_the_intervals_of_the_results() {
    let study = tempfile::tempdir().unwrap();
    let session = study.path().join("sub-01").join("ses-01");
    let (mut pair, first) = analysed();
    let (second, second_series) = analysed();
    pair.recordings.extend(second.recordings);
    let series = KeptSeries::from_iter([&first, &second_series].map(first_series));
    let mut log = r#"{"document":"start","time":"2026-01-01T09:00:00Z","resumed":false,"participant":"sub-01","session":1,"#
        .to_owned();
    log += r#""protocol":"p","seed":1,"software":"s","version":"1","devices":{},"calibration":null,"configuration":null}"#;
    for (index, recording) in pair.recordings.iter_mut().enumerate() {
        let number = index + 1;
        let folder = session.join(format!("trial-{number:03}_attempt-1"));
        std::fs::create_dir_all(&folder).unwrap();
        recording.path.clone_from(&folder);
        recording.findings.as_mut().unwrap().path = folder;
        let key = format!(r#"{{"number":{number},"attempt":1,"practice":false,"condition":"c"}}"#);
        log += &format!(
            "\n{{\"document\":\"event\",\"stream\":\"session\",\"seq_num\":{number},\"time\":\"\",\"audio_s\":{},\"data\":\
             {{\"event\":\"trial_began\",\"key\":{key}}}}}",
            2 + 30 * index,
        );
    }
    std::fs::write(session.join("events.jsonl"), log + "\n").unwrap();
    let sessions = Sessions::from_recordings(pair.recordings.iter().map(|r| r.path.as_path()));

    let shift = |analysed: &Analysis| {
        let selection = FigureSelection::default();
        let figures = measured_figures((analysed, &series), &sessions, &selection).unwrap();
        figures.into_iter().find(|f| f.name == "resonance_shift")
    };
    let figure = shift(&pair).unwrap();
    assert_eq!(figure.panels.len(), 1);
    assert_eq!(figure.panels[0].shaded_ranges.len(), 2);
    let findings = pair.recordings[0].findings.as_ref().unwrap();
    let middle = |instance: &InstanceAnalysis| 0.5 * (instance.start_s + instance.end_s);
    let expected = [0.0, 30.0].map(|start_s| {
        let instances = findings.instances.iter();
        instances.map(move |instance| {
            (
                start_s + middle(instance),
                instance.dynamic.plate_offset.unwrap().resonance_shift_hz,
            )
        })
    });
    let expected: Vec<(f64, f64)> = expected.into_iter().flatten().collect();
    assert_eq!(points(&figure, 0, "dynamic"), expected);
    let offset = findings.instances[0].dynamic.plate_offset.unwrap();
    let half_width_hz =
        0.5 * (points(&figure, 0, "dynamic, 95 %")[1].1 - points(&figure, 0, "dynamic, 95 %")[0].1);
    assert!((half_width_hz / offset.resonance_shift_std_hz - 1.96).abs() < 1e-3);

    // A single recording is drawn over its own time; with the offset held at 0, `dynamic` has no figure.
    pair.recordings.truncate(1);
    let single = shift(&pair).unwrap();
    assert_eq!(points(&single, 0, "dynamic"), expected[..2]);
    assert!(single.panels[0].shaded_ranges.is_empty());
    pair.settings.plate_offset = false;
    assert!(shift(&pair).is_none());
}

#[test]
fn the_same_figure_is_the_same_bytes() {
    let (mut first, mut second) = (model_figures(), model_figures());
    let analysed = analysed();
    first.extend(published_figures(
        &analysed,
        &Sessions::default(),
        &FigureSelection::default(),
    ));
    second.extend(published_figures(
        &analysed,
        &Sessions::default(),
        &FigureSelection::default(),
    ));
    for (first, second) in first.iter().zip(&second) {
        assert_eq!(
            first.to_svg().unwrap(),
            second.to_svg().unwrap(),
            "{}",
            first.name
        );
        assert!(
            first.to_png().unwrap() == second.to_png().unwrap(),
            "{}",
            first.name
        );
    }
}

#[test]
fn a_png_is_as_wide_as_printed_at_300_dpi_and_bears_its_caption() {
    let figure = &model_figures()[2];
    let bytes = figure.to_png().unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(&bytes))
        .read_info()
        .unwrap();
    let info = reader.info();
    let per_metre = info.pixel_dims.unwrap();
    assert_eq!(
        (info.width, per_metre.xppu, per_metre.yppu),
        (1004, 11811, 11811)
    );
    let texts = &info.utf8_text;
    assert!(
        texts
            .iter()
            .any(|text| text.get_text().unwrap() == figure.caption)
    );
}

#[test]
fn the_model_writes_each_figure_its_curves_and_the_captions() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new").join("model");
    let files = published_figures::model::run(&options(&["--out", out.to_str().unwrap()])).unwrap();
    for (name, _) in MODEL {
        for extension in ["svg", "png"] {
            assert!(
                files.contains(&out.join(format!("{name}.{extension}"))),
                "{name}"
            );
        }
    }
    let captions = std::fs::read_to_string(out.join("captions.md")).unwrap();
    assert_eq!(captions.matches("Assumed: ").count(), MODEL.len());

    // Eqs. 17 and 18 at 5 µm and 1 N give 12.7 % of the value at rest.
    let mut stiffness = csv::Reader::from_path(out.join("fig06_stiffness.csv")).unwrap();
    assert_eq!(
        stiffness.headers().unwrap(),
        &["normal_n", "amplitude_m", "k_c_n_per_m"][..]
    );
    let rows: Vec<(f64, f64, f64)> = stiffness.deserialize().map(Result::unwrap).collect();
    let stiffness_at = |amplitude_m: f64| {
        let row = rows
            .iter()
            .find(|row| row.0 == 1.0 && (row.1 - amplitude_m).abs() < 1e-12);
        row.unwrap().2
    };
    assert!((stiffness_at(5e-6) / stiffness_at(0.0) - 0.127).abs() < 5e-4);
}

#[test]
fn without_figures_only_curves_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let files = published_figures::model::run(&options(&["--csv-only", "--out", out])).unwrap();
    assert!(
        files
            .iter()
            .all(|path| path.extension().is_some_and(|e| e == "csv"))
    );
    let units = ["_n", "_m", "_s", "_m_per_s", "_n_per_m", "_n_s_per_m"];
    for path in files {
        let mut table = csv::Reader::from_path(&path).unwrap();
        for column in table.headers().unwrap() {
            let dimensionless = ["loss_factor", "mu", "skin_to_plate_velocity"].contains(&column);
            let has_unit = units.iter().any(|unit| column.ends_with(unit));
            assert!(
                has_unit || dimensionless,
                "{}: {column} has no unit",
                path.display()
            );
        }
        assert!(table.records().count() > 400, "{}", path.display());
    }
}

#[test]
fn an_assumption_without_meaning_is_refused() {
    let mut options = options(&["--csv-only"]);
    options.assume.poisson_ratio = 0.7;
    let error = published_figures::model::run(&options)
        .unwrap_err()
        .to_string();
    assert!(error.contains("Poisson's ratio = 0.7"), "{error}");
    let line = ["friction-bench", "model", "--sigma-t-m", "-1e-6"];
    assert!(Cli::try_parse_from(line).is_err());
}

#[test]
fn absent_results_are_not_drawn() {
    let mut empty = analysed();
    empty.0.recordings[0]
        .findings
        .as_mut()
        .unwrap()
        .instances
        .clear();
    let figures = published_figures(&empty, &Sessions::default(), &FigureSelection::default());
    assert_eq!(figures.len(), 1, "the trial in time remains");
    figures[0].to_svg().unwrap();
    empty.0.recordings.clear();
    assert_eq!(
        published_figures(&empty, &Sessions::default(), &FigureSelection::default()),
        []
    );
}

const CARRIER_HZ: f64 = 35e3;
const NORMAL_N: f64 = 0.6;
const Z_P: Complex64 = Complex64::new(7.0, 0.0);
const Z_T: Complex64 = Complex64::new(0.47, 3.16);
const MANIFEST: &str = r#"
format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
channels.drive = { index = 0, volts_per_unit = 1.0 }
channels.pickup = { index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }
plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.0525 }
"#;

/// Returns half a second of a finger in equilibrium with the film, σ_t = 1.8 µm, two instances.
fn analysed() -> (Analysis, KeptSeries) {
    let settings = Settings::default();
    let contact = Contact::new(&settings.assumed(), 1.8e-6).unwrap();
    let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) / 2000.0).collect();
    let amplitude_m: Vec<f64> = time_s
        .iter()
        .map(|t| 2e-6 * (1.0 - 0.95 * (TAU * 6.0 * t).cos()))
        .collect();
    let gap_m: Vec<f64> = amplitude_m
        .iter()
        .map(|&a| contact.equilibrium_gap_m(a, NORMAL_N).unwrap())
        .collect();
    let frame = |k: usize| {
        let k_c = contact.balance_stiffness_n_per_m(gap_m[k], NORMAL_N);
        let z_c = contact.impedance_n_s_per_m(k_c, TAU * CARRIER_HZ);
        let z_m = harmonic::observed(Z_P, Z_T, z_c);
        ZmFrame {
            sample: k as u64,
            time_s: time_s[k],
            mask: Mask::CLEAR,
            drive_v: Complex64::ONE,
            displacement_m: amplitude_m[k].into(),
            amplitude_m: amplitude_m[k],
            amplitude_rate_m_per_s: 0.0,
            amplitude_std_m: 1e-11,
            plain_n_s_per_m: z_m,
            plain_std_n_s_per_m: 1e-4,
            corrected_n_s_per_m: z_m,
            corrected_std_n_s_per_m: 1e-4,
        }
    };
    let n = time_s.len();
    let lateral = |gap: &f64| -0.8 * NORMAL_N * contact.friction_ratio(*gap, NORMAL_N);
    let frame_series = FrameSeries {
        frames: (0..n).map(frame).collect(),
        normal_n: vec![NORMAL_N; n],
        finger_force_n: vec![NORMAL_N; n],
        lateral_n: gap_m.iter().map(lateral).collect(),
        position_m: time_s.iter().map(|t| 0.04 + 0.05 * t).collect(),
        velocity_m_per_s: vec![0.05; n],
        validity: vec![Validity::Valid; n],
        amplitude_m,
        time_s,
    };
    let conditions = FitConditions {
        assumed: AssumedConstants::ESTIMATION,
        carrier_hz: CARRIER_HZ,
        z_p_plain_n_s_per_m: Z_P,
        z_p_corrected_n_s_per_m: Z_P,
        calibration: CalibrationErrors::default(),
        assumed_errors: CalibrationErrors::default(),
        mode_across: None,
    };
    let under_finger = UnderFinger::new(&frame_series, &AmplitudeProfile::default(), Some(Z_P));
    let direction = Direction::RightToLeft;
    let instances = [0.18, 0.346].map(|start_s| {
        let instance = Instance {
            start_s,
            end_s: start_s + 0.06,
        };
        estimate(
            (&frame_series, &under_finger),
            (0, direction),
            instance,
            (&conditions, 0.008),
            &settings,
        )
        .unwrap()
    });
    let (instances, samples) = instances.into_iter().unzip();
    let exploration = ExplorationSeries::new(frame_series, under_finger);
    let manifest = Manifest::parse(MANIFEST, "recording.toml").unwrap();
    let path = PathBuf::from("trial-01");
    let findings = RecordingFindings {
        path: path.clone(),
        participant: None,
        pickup: recording::pipeline::PickupOffset::default(),
        rules: settings.selection_rules(manifest.plate().unwrap().centre_m),
        vibration: analysis::vibration::Vibration::stated(&manifest),
        manifest,
        provenance: Default::default(),
        force_clock: None,
        zero: analysis::force_zero::ForceZero::default(),
        errors: analysis::error_budget::ErrorBudget::default(),
        z_p: Some(PlateReading {
            plain_n_s_per_m: Z_P,
            corrected_n_s_per_m: Z_P,
            frames: 1000,
        }),
        explorations: vec![ExplorationFindings::new(
            &exploration,
            direction,
            (0.0, 0.5),
            0.0,
        )],
        instances,
        trial: None,
        within_laws: None,
        sample_statistics: Default::default(),
        model_check: Vec::new(),
        rejected: Vec::new(),
        flaws: Vec::new(),
    };
    let series = KeptSeries::from_iter([RecordingSeries {
        explorations: vec![exploration],
        instances: samples,
    }]);
    let recordings = vec![RecordingAnalysis {
        path,
        participant: None,
        findings: Ok(findings),
    }];
    let analysed = complete(recordings, &settings, &series).unwrap();
    (analysed, series)
}
