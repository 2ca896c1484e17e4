//! Tests that the page shows everything in the results, and nothing that a browser would execute or fetch.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::path::Path;

use config::{CalibrationFile, Identity, MeasuredPickup, Provenance, Quantity};
use jiff::Timestamp;
use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};
use recording::Manifest;
use report::{Recorded, ReportContent, ReportError, html};
use study::sessions::Sessions;

const HOSTILE: &str =
    "<script>alert('x')</script><img src=http://evil.test/a onerror=\"b\">&\u{202e}\u{1b}[2J";

fn manifest(participant: &str) -> Manifest {
    // A JSON string is also a TOML string.
    let [participant, condition] =
        [participant, HOSTILE].map(|text| serde_json::to_string(text).unwrap());
    let text = format!(
        r#"
format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
channels.drive = {{ index = 0, volts_per_unit = 20.0 }}
channels.pickup = {{ index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }}
plate = {{ resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.05 }}
standard_errors = {{ amplitude_relative = 0.004, impedance_relative = 0.011 }}
participant = {{ id = {participant}, session = 1 }}
trial = {{ number = 1, attempt = 2, practice = false, condition = {condition}, protocol = "p", seed = 1 }}
"#
    );
    Manifest::parse(&text, "recording.toml").unwrap()
}

/// Results of one recording with two instances, of which the first has an estimate by `trial`, and of one recording that
/// cannot be read.
fn results(participant: &str, extra: &str) -> String {
    let estimate = |method: &str| {
        format!(
            r#""{method}": {{ "sigma_t_m": 1.9e-6, "z_t_n_s_per_m": [0.47, -3.1], "mu0": 0.8, "r2_impedance": 0.9, "rms_mu": null,
            "resonance_shift_hz": -1.25, "tau_s": 0.0012, "verdict": "tau held at its bound 0 s; unbounded it would be -1e-3 s",
            "std": {{ "sigma_t_m": 1e-8, "z_t_n_s_per_m": [0.01, 0.02], "mu0": 0.001 }},
            "interval95": {{ "sigma_t_m": [1.8e-6, 2.0e-6], "mu0": [0.79, 0.81], "resonance_shift_hz": [-1.5, null] }} }}"#
        )
    };
    let instance = |start_s: f64, methods: &[&str]| {
        let methods: Vec<String> = methods.iter().map(|method| estimate(method)).collect();
        format!(
            r#"{{ "start_s": {start_s}, "end_s": {}, "direction": "left_to_right", "normal_n": 0.64, "delta_mu": 0.7, {} }}"#,
            start_s + 0.06,
            methods.join(", ")
        )
    };
    let statistic = r#"{ "value": 1.9e-6, "std": 1e-7, "p": 0.0001, "clustered": { "p": null, "people": 3 }, "n": 2, "over": "instances",
        "also": [{ "value": null, "n": 1, "over": "trials" }] }"#;
    let participant = serde_json::to_string(participant).unwrap();
    let area = r#""contact_area_m2": { "value": 2.2e-4, "interval95": [2.1e-4, 2.3e-4], "n_trials": 1,
        "shrunken": { "value": 2.25e-4, "interval95": [2.15e-4, 2.35e-4] } }"#;
    let hostile = serde_json::to_string(HOSTILE).unwrap();
    format!(
        r#"{{ "format": 1,
        "settings": {{ "contact_area_m2": 0.0003, "plate_offset": true, "later": {{ "of": [1, {hostile}], "x": 0.25 }} }},
        "recordings": [ {{ "path": "/home/somebody/study/a", "participant": {participant},
            "z_p_n_s_per_m": {{ "paper": [7.0, 0.0], "dynamic": [7.0, -0.1] }},
            "instances": [ {}, {} ],
            "trial": {{ "contact_area_m2": 2.2e-4, "q0_rad_per_m": 2.2e4, "loss_factor": 0.42, "tau_s": 8e-4, "friction_floor": null,
                "lateral_lag_s": null, "interval95": {{ "contact_area_m2": [2.1e-4, 2.3e-4] }}, "n_instances": 2,
                "verdict": "converged"{extra} }},
            "model_check": [], "rejected": [ {{ "start_s": 1.4, "end_s": 1.48, "direction": "left_to_right", "reason": {hostile} }} ],
            "warnings": [ {hostile} ] }},
          {{ "path": "/home/somebody/study/b", "z_p_n_s_per_m": {{ "paper": null, "dynamic": null }}, "instances": [],
            "model_check": [], "rejected": [], "warnings": [ "cannot be read: recording.toml" ] }} ],
        "skin": {{ "pooling": "in words",
            "study": {{ "contact_area_m2": {{ "mean": {{ "value": 2.3e-4, "interval95": [2.0e-4, 2.6e-4] }}, "n_participants": 4,
                "between_participants_ln_std": 0.12, "between_participants_ln_std_interval95": [0.05, 0.4],
                "between_trials_ln_std": 0.04, "shared_error_part": 0.3 }},
                "tau_s": {{ "mean": null, "n_participants": 0, "between_participants_ln_std": null,
                "between_participants_ln_std_interval95": null, "between_trials_ln_std": null }} }},
            "participants": [ {{ "participant": {participant}, {area}, "tau_s": null, "n_left_out": 2,
                "trials": [ {{ "path": "/home/somebody/study/a", {area} }} ] }} ],
            "left_out": [ {{ "path": "/home/somebody/study/c", "participant": null, "because": {hostile} }} ] }},
        "excluded": [ {{ "participant": "sub-07", "session": "all", "trial": "3", "reason": {hostile}, "by": {hostile}, "date": null,
            "recordings": ["/home/somebody/study/c"] }} ],
        "statistics": {{ "zeta": {{ "meaning": "sigma_t, m", "published": "(1.7 ± 0.4)e-6", "paper": {statistic}, "dynamic": {statistic} }},
            "alpha": {{ "meaning": "second of mu0", "published": "0.1", "paper": {statistic}, "dynamic": {statistic}, "trial": {statistic} }} }} }}"#,
        instance(1.9, &["paper", "dynamic", "trial"]),
        instance(2.1, &["paper", "dynamic"]),
    )
}

fn figure() -> Figure {
    Figure {
        name: "some".to_owned(),
        title: HOSTILE.to_owned(),
        caption: HOSTILE.to_owned(),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 20.0,
        key: Key::InPanels,
        panels: vec![Panel {
            series: vec![
                Series::line(Ink::Blue, Dash::Solid, vec![(0.0, 0.0), (1.0, 1.0)])
                    .with_name(HOSTILE),
            ],
            notes: vec![HOSTILE.to_owned()],
            ..Panel::new(Axis::linear(HOSTILE), Axis::linear("y"))
        }],
    }
}

fn page(participant: &str, figures: &[Figure], extra: &str) -> Result<String, ReportError> {
    page_of(participant, &results(participant, extra), figures)
}

fn page_of(participant: &str, results: &str, figures: &[Figure]) -> Result<String, ReportError> {
    let manifest = manifest(participant);
    let recordings = [
        Recorded {
            path: Path::new("/home/somebody/study/a"),
            manifest: Some(&manifest),
        },
        Recorded {
            path: Path::new("/home/somebody/study/b"),
            manifest: None,
        },
    ];
    html(&ReportContent {
        name: participant,
        results,
        recordings: &recordings,
        sessions: &Sessions::default(),
        figures,
        date: Timestamp::UNIX_EPOCH,
        program: "friction-bench 0.0.0",
    })
}

#[test]
fn hostile_texts_are_escaped_and_no_resource_is_fetched() {
    let page = page(HOSTILE, &[figure()], "").unwrap();
    let escaped = "&lt;script&gt;alert(";
    // Participant, condition, warning, rejection, exclusion's reason and author, setting, and six places of the figure.
    assert!(
        page.matches(escaped).count() >= 12,
        "{}",
        page.matches(escaped).count()
    );
    for code in [
        "<script",
        "<img",
        "onload=",
        "javascript:",
        "@import",
        "url(",
        "<link",
        "<iframe",
    ] {
        assert!(!page.contains(code), "{code}");
    }
    // Within tags, not within a user's text.
    let tags = page
        .split('<')
        .skip(1)
        .filter_map(|rest| rest.split_once('>'));
    for (tag, _) in tags {
        assert!(!tag.contains("http") && !tag.contains("src="), "{tag}");
        if let Some((_, link)) = tag.split_once("href=") {
            assert!(link.starts_with("\"#"), "{tag}");
        }
    }
    assert!(!page.contains("somebody"), "where the study lies");
    assert!(!page.contains(['\0', '\u{1b}', '\u{202e}']));
}

#[test]
fn every_link_within_the_page_has_an_end() {
    let page = page("sub-01", &[], "").unwrap();
    let ends: Vec<&str> = page
        .split("href=\"#")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    assert!(ends.len() > 14);
    for end in ends {
        assert!(page.contains(&format!("id=\"{end}\"")), "{end}");
    }
}

#[test]
fn the_page_of_a_small_study() {
    let page = page("sub-01", &[], "").unwrap();
    let (_, body) = page.split_once("<body>").unwrap();
    // One line for each element, for a readable diff.
    let lines = body.replace("><", ">\n<");
    insta::assert_snapshot!(lines);
}

#[test]
fn the_misfit_of_the_model_is_reported() {
    let untested = page("sub-01", &[], "").unwrap();
    assert!(untested.contains("did not test the fit"));
    let fits = page("sub-01", &[], r#", "model_misfit": false"#).unwrap();
    assert!(
        fits.contains("in which the fit was tested (1 recording)")
            && fits.contains("does not fit 0 of the 1 recording "),
        "{fits}"
    );
    let extra = r#", "model_misfit": true, "misfit_ratio": 3.5, "area_exponent": 0.25"#;
    let misfit = page("sub-01", &[], extra).unwrap();
    assert!(misfit.contains("misfit_ratio = 3.5") && misfit.contains("the model does not fit"));
    assert!(misfit.contains("<code>area_exponent</code>"));
}

/// Most studies have a recording that the model does not fit, which has no interval.
#[test]
fn a_recording_without_intervals_is_shown_with_the_signs_of_misfit() {
    let extra = format!(
        r#", "model_misfit": true, "misfit": ["friction is off by 0.05", {}]"#,
        serde_json::to_string(HOSTILE).unwrap()
    );
    let text = results("sub-01", &extra);
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut misfit_results = value;
    misfit_results["recordings"][0]["trial"]["interval95"] = serde_json::Value::Null;
    for instance in misfit_results["recordings"][0]["instances"]
        .as_array_mut()
        .unwrap()
    {
        if let Some(trial) = instance.get_mut("trial") {
            trial["interval95"] = serde_json::Value::Null;
        }
    }
    let page = page_of("sub-01", &misfit_results.to_string(), &[]).unwrap();
    assert!(page.contains("; friction is off by 0.05; &lt;script&gt;"));
    assert!(page.contains("so no interval is given"));
    let (_, by_trial) = page.split_once("<td>trial</td>").unwrap();
    let (row, _) = by_trial.split_once("</tr>").unwrap();
    assert!(
        row.contains("1.900") && !row.contains('±') && !row.contains(" to "),
        "{row}"
    );
}

#[test]
fn results_without_skin_are_shown_with_a_note() {
    let mut old_results: serde_json::Value = serde_json::from_str(&results("sub-01", "")).unwrap();
    old_results.as_object_mut().unwrap().remove("skin").unwrap();
    let page = page_of("sub-01", &old_results.to_string(), &[]).unwrap();
    assert!(page.contains("made by an earlier version"));
}

#[test]
fn invalid_results_and_results_of_other_recordings_are_refused() {
    let sessions = Sessions::default();
    let content = |results| ReportContent {
        name: "x",
        results,
        recordings: &[],
        sessions: &sessions,
        figures: &[],
        date: Timestamp::UNIX_EPOCH,
        program: "p",
    };
    assert!(matches!(html(&content("{")), Err(ReportError::Results(_))));
    let text = results("sub-01", "");
    let result = html(&content(&text));
    assert!(matches!(
        result,
        Err(ReportError::Recordings {
            recordings: 0,
            results: 2
        })
    ));
}

fn calibration() -> String {
    let mut file = CalibrationFile::new(Identity {
        input_device: "card".to_owned(),
        output_device: "card".to_owned(),
        rate_hz: 192_000,
        sample_format: "i32".to_owned(),
        output_channel: 0,
        drive_channel: 0,
        pickup_channel: 1,
        output_volts_per_unit: 60.0,
        drive_volts_per_unit: 60.0,
        plate_id: "glass".to_owned(),
        modal_mass_kg: 0.008,
        gains: String::new(),
        force_sensor: None,
        sound_card: None,
    });
    file.pickup = Some(MeasuredPickup {
        measured: Provenance {
            date: "2025-12-22T09:00:00Z".parse().unwrap(),
            operator: "O. Perator".to_owned(),
            method: "vibrometer".to_owned(),
        },
        metres_per_unit: Quantity::new(5.012_345_6e-6, 1.2e-8, 9, "m"),
        phase_rad: None,
        offset: Quantity::new(0.0, 1e-9, 9, "m"),
        nonlinearity: 0.001,
        points: 11,
        carrier_hz: 35_000.0,
    });
    file.to_text().unwrap()
}

#[test]
fn a_session_shows_verdicts_and_its_calibration_without_names() {
    let study = tempfile::tempdir().unwrap();
    let session = study.path().join("ses-01");
    let folder = session.join("trial-001_attempt-2");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(session.join("calibration.toml"), calibration()).unwrap();
    let event = |number: u32, data: &str| {
        format!(
            "{{\"document\":\"event\",\"stream\":\"session\",\"seq_num\":{number},\"time\":\"\",\"audio_s\":{number},\"data\":{data}}}\n"
        )
    };
    let key = |attempt: u32| {
        format!(r#"{{"number":1,"attempt":{attempt},"practice":false,"condition":"c<b>"}}"#)
    };
    let start_event = |attempt| format!(r#"{{"event":"trial_began","key":{}}}"#, key(attempt));
    let end_event = |attempt, outcome: &str| {
        format!(
            r#"{{"event":"trial_settled","record":{{"key":{},"outcome":{outcome},"analysis":null}}}}"#,
            key(attempt)
        )
    };
    let redo = r#"{"outcome":"redo","reasons":[{"reason":"lost_samples","frames":3,"limit":0}]}"#;
    let start = "{\"document\":\"start\",\"time\":\"2026-01-01T09:00:00Z\",\"resumed\":false,\"participant\":\"sub-01\",\"session\":1,\
                 \"protocol\":\"p\",\"seed\":7,\"software\":\"s\",\"version\":\"1\",\"devices\":{},\"calibration\":\"by O. Perator\",\
                 \"configuration\":null}\n";
    let consent = event(1, r#"{"event":"consent_given","by":"W. Itness"}"#);
    let log = [
        start.to_owned(),
        consent,
        event(2, &start_event(1)),
        event(7, &end_event(1, redo)),
        event(8, &start_event(2)),
        event(13, &end_event(2, r#"{"outcome":"accepted"}"#)),
        "{\"document\":\"stop\",\"time\":\"\",\"exit_status\":\"success\",\"num_events\":5}\n"
            .to_owned(),
    ];
    std::fs::write(session.join("events.jsonl"), log.concat()).unwrap();

    let manifest = manifest("sub-01");
    let other_folder = study.path().join("elsewhere");
    let recordings = [
        Recorded {
            path: &folder,
            manifest: Some(&manifest),
        },
        Recorded {
            path: &other_folder,
            manifest: None,
        },
    ];
    let page = html(&ReportContent {
        name: "study",
        results: &results("sub-01", ""),
        recordings: &recordings,
        sessions: &Sessions::from_recordings(recordings.iter().map(|recording| recording.path)),
        figures: &[],
        date: Timestamp::UNIX_EPOCH,
        program: "friction-bench 0.0.0",
    })
    .unwrap();
    for part in [
        "Protocol p, seed 7; completed.",
        "<td>repeated</td><td>3 lost frames, 0 allowed</td><td>no</td>",
        "<td class=\"n\">6</td><td>accepted</td><td></td><td><a href=\"#recording-1\">2 instances</a>",
        "c&lt;b&gt;",
        "2025-12-22</td><td class=\"n\" rowspan=\"2\">10.0</td>",
        "5.012346e−6 ± 1.20e−8",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for name in ["O. Perator", "W. Itness"] {
        assert!(!page.contains(name), "{name}");
    }
}

/// The page said "No recording is excluded by decision" although decisions were overridden.
#[test]
fn overridden_decisions_and_missed_trials_are_reported() {
    let results = results("sub-01", "").replacen(
        "\"excluded\":",
        r#""attempts": { "accepted": 3, "analysed": 1, "not_accepted": 0, "excluded": 0, "unread_logs": [], "left_out": [
            { "path": "/home/somebody/study/sub-01/ses-01/trial-003_attempt-1", "standing": "accepted",
              "because": "its recording was broken off" } ] },
        "exclusions_overridden":"#,
        1,
    );
    let page = page_of("sub-01", &results, &[]).unwrap();
    for part in [
        "These decisions were overridden",
        "1 of the recordings is excluded by decision, but analysed",
        "3 trials were accepted",
        "1 of which could not be analysed",
        "sub-01/ses-01/trial-003_attempt-1",
        "its recording was broken off",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("No recording is excluded"));
    assert!(!page.contains("somebody"), "where the study lies");
}
