//! Tests that the page shows everything in the results, and nothing that a browser would execute or fetch.

#![expect(clippy::unwrap_used, reason = "a test")]

mod small_study;

use std::path::{Path, PathBuf};

use attempts::OmittedAttempt;
use config::{CalibrationFile, Identity, MeasuredPickup, Provenance, Quantity};
use jiff::Timestamp;
use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};
use population::law_check::{CheckedTrial, Condition, Estimate, LawCheck, Quantities, check};
use recording::Manifest;
use report::recording_results::Recording;
use report::trial_quantity::TrialQuantity;
use report::{Recorded, ReportContent, ReportError, Results, html};
use small_study::{HOSTILE, SmallStudy, file};
use study::sessions::{Sessions, Standing};

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

fn figure() -> Figure {
    Figure {
        name: "some".to_owned(),
        title: HOSTILE.to_owned(),
        caption: HOSTILE.to_owned(),
        width: Width::Column,
        columns: 1,
        panel_height_mm: 20.0,
        footnote: None,
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

fn page(participant: &str, figures: &[Figure]) -> Result<String, ReportError> {
    page_of(participant, &SmallStudy::new(participant), figures)
}

fn page_of(
    participant: &str,
    study: &SmallStudy,
    figures: &[Figure],
) -> Result<String, ReportError> {
    page_of_results((&study.results(), &study.recordings), participant, figures)
}

fn page_of_results(
    (results, rows): (&Results<'_>, &[Recording]),
    participant: &str,
    figures: &[Figure],
) -> Result<String, ReportError> {
    let manifest = manifest(participant);
    let recordings = [
        Recorded {
            path: Path::new("/home/somebody/study/a"),
            manifest: Some(&manifest),
            result: &rows[0],
        },
        Recorded {
            path: Path::new("/home/somebody/study/b"),
            manifest: None,
            result: &rows[1],
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
    let page = page(HOSTILE, &[figure()]).unwrap();
    let escaped = "&lt;script&gt;alert(";
    // Participant, condition, warning, rejection, exclusion's reason and author, and six places of the figure.
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
    let page = page("sub-01", &[]).unwrap();
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
    let page = page("sub-01", &[]).unwrap();
    let (_, body) = page.split_once("<body>").unwrap();
    // One line for each element, for a readable diff.
    let lines = body.replace("><", ">\n<");
    insta::assert_snapshot!(lines);
}

#[test]
fn the_fit_of_the_model_is_reported() {
    let page = page("sub-01", &[]).unwrap();
    assert!(
        page.contains("in which the fit was tested (1 recording)")
            && page.contains("does not fit 0 of the 1 recording "),
        "{page}"
    );
}

/// Most studies have a recording that the model does not fit, which has no interval.
#[test]
fn a_recording_without_intervals_is_shown_with_the_signs_of_misfit() {
    let mut study = SmallStudy::new("sub-01");
    let trial = study.trial_mut();
    trial.model_misfit = true;
    trial.misfit = vec!["friction is off by 0.05".to_owned(), HOSTILE.to_owned()];
    trial.interval95 = None;
    trial.interval95_within_laws = None;
    for instance in &mut study.recordings[0].instances {
        if let Some(trial) = &mut instance.trial {
            trial.interval95 = None;
            trial.interval95_within_laws = None;
            trial.estimate.model_misfit = true;
        }
    }
    let page = page_of("sub-01", &study, &[]).unwrap();
    assert!(page.contains("the model does not fit"));
    assert!(page.contains("; friction is off by 0.05; &lt;script&gt;"));
    assert!(page.contains("so no interval is given"));
    let (_, by_trial) = page.split_once("<td>trial</td>").unwrap();
    let (row, _) = by_trial.split_once("</tr>").unwrap();
    assert!(
        row.contains("1.900") && !row.contains('±') && !row.contains(" to "),
        "{row}"
    );
}

/// The laws in doubt may fit a recording that the published laws do not fit.
#[test]
fn a_recording_outside_the_published_laws_has_total_intervals_alone() {
    let mut study = SmallStudy::new("sub-01");
    let trial = study.trial_mut();
    trial.interval95_within_laws = None;
    trial.misfit_within_laws = vec!["q0 would be far off".to_owned(), HOSTILE.to_owned()];
    for instance in &mut study.recordings[0].instances {
        if let Some(trial) = &mut instance.trial {
            trial.interval95_within_laws = None;
        }
    }
    let page = page_of("sub-01", &study, &[]).unwrap();
    assert!(page.contains("but the published laws do not"), "{page}");
    assert!(page.contains("q0 would be far off; &lt;script&gt;"));
    assert!(page.contains("The published laws alone do not fit 1 of them"));
    let (_, by_trial) = page.split_once("<td>trial</td>").unwrap();
    let (row, _) = by_trial.split_once("</tr>").unwrap();
    assert!(
        row.contains("1.800 to 2.000") && !row.contains("within"),
        "{row}"
    );
}

#[test]
fn quantities_that_hold_under_every_law_tried_are_marked() {
    let study = SmallStudy::new("sub-01");
    let mut results = study.results();
    assert_eq!(results.holds_under_every_law_tried, [TrialQuantity::Mu0]);
    let page = page_of_results((&results, &study.recordings), "sub-01", &[]).unwrap();
    assert_eq!(page.matches(">†</sup>").count(), 1, "{page}");
    results.holds_under_every_law_tried = vec![
        TrialQuantity::Mu0,
        TrialQuantity::GapPerSigmaT,
        TrialQuantity::Tau,
    ];
    let file: serde_json::Value = serde_json::from_str(&file(&results)).unwrap();
    assert_eq!(
        file["holds_under_every_law_tried"],
        serde_json::json!(["mu0", "gap_per_sigma_t", "tau_s"])
    );
    let page = page_of_results((&results, &study.recordings), "sub-01", &[]).unwrap();
    assert!(page.contains("† Holds under every law tried."));
    // μ0 of the instances, and τ of the recording and of the participants.
    assert_eq!(page.matches(">†</sup>").count(), 3, "{page}");
    results.holds_under_every_law_tried = Vec::new();
    let page = page_of_results((&results, &study.recordings), "sub-01", &[]).unwrap();
    assert!(!page.contains('†'));
}

#[test]
fn assumed_errors_are_among_the_assumptions() {
    let mut study = SmallStudy::new("sub-01");
    study.recordings[0].assumed_errors.ambient_pressure_relative = 0.05;
    let page = page_of("sub-01", &study, &[]).unwrap();
    assert!(page.contains("ambient pressure 5 %"), "{page}");
}

/// An instance outside the laws of `paper` or `dynamic` is named with its signs, and its values have no errors.
#[test]
fn an_instance_outside_the_laws_of_a_method_is_shown_with_its_signs() {
    let converged_page = page("sub-01", &[]).unwrap();
    assert!(!converged_page.contains("Signs of the first"));
    let mut study = SmallStudy::new("sub-01");
    let dynamic = &mut study.recordings[0].instances[1].methods.dynamic;
    dynamic.model_misfit = true;
    dynamic.misfit = vec!["Re Z_t is below 0".to_owned(), HOSTILE.to_owned()];
    let page = page_of("sub-01", &study, &[]).unwrap();
    let (_, row) = page.split_once("Signs of the first").unwrap();
    let (row, _) = row.split_once("</table>").unwrap();
    assert!(
        row.contains("<td>dynamic</td><td>2</td><td>Re Z_t is below 0; &lt;script&gt;"),
        "{row}"
    );
    let (_, second) = page.split_once("2.10–2.16").unwrap();
    let (_, by_dynamic) = second.split_once("<td>dynamic</td>").unwrap();
    let (row, _) = by_dynamic.split_once("</tr>").unwrap();
    assert!(row.contains("1.900") && !row.contains('±'), "{row}");
}

/// Unknown values were absent while the page was made from JSON, and are NaN in the results.
#[test]
fn unknown_values_have_neither_digits_nor_errors() {
    let mut study = SmallStudy::new("sub-01");
    let instance = &mut study.recordings[0].instances[1];
    let dynamic = &mut instance.methods.dynamic;
    dynamic.mu0 = f64::NAN;
    dynamic.std.sigma_t_m = Some(f64::NAN);
    study.statistics.rows[0].dynamic.main.std = Some(f64::NAN);
    study.statistics.rows[0].dynamic.main.p = Some(f64::NAN);
    let page = page_of("sub-01", &study, &[]).unwrap();
    let (_, second) = page.split_once("2.10–2.16").unwrap();
    let (_, by_dynamic) = second.split_once("<td>dynamic</td>").unwrap();
    let (row, _) = by_dynamic.split_once("</tr>").unwrap();
    let cells: Vec<&str> = row.split("</td>").collect();
    assert_eq!(cells[0], r#"<td class="n">1.900"#);
    assert_eq!(cells[3], r#"<td class="n">–"#);
    assert!(page.contains(r#"1.90<span class="also">n = 2 instances, too few people"#));
    assert!(!page.contains("NaN"));
}

/// Returns two trials under each of two drive levels, with this difference of σ_t.
fn law_check(participant: &str, difference: f64) -> LawCheck {
    let trials = [(12.0, 1.0), (12.0, 1.01), (24.0, 1.0), (24.0, 1.01)].map(|(drive_v, value)| {
        let shift = if drive_v > 20.0 { difference } else { 0.0 };
        CheckedTrial {
            condition: Condition {
                drive_v,
                modulation_hz: 6.0,
                carrier_hz: 35_000.0,
            },
            estimates: Quantities {
                ln_sigma_t: Estimate::new(value + shift, 0.01),
                ln_contact_area: Estimate::new(value, 0.01),
                ..Quantities::default()
            },
        }
    });
    check(participant, &trials, 1).unwrap()
}

#[test]
fn estimates_under_several_conditions_are_compared_on_the_page_and_in_the_file() {
    let mut study = SmallStudy::new("sub-01");
    study.law_check = vec![law_check("sub-01", 1.0), law_check(HOSTILE, 0.0)];
    let page = page_of("sub-01", &study, &[]).unwrap();
    assert!(page.contains("<a href=\"#law-check\">Check of the laws</a>"));
    assert!(page.contains("Over 4 trials (1 left out): 1 of 2 differences exceed their errors."));
    assert!(page.contains(": the estimates agree."));
    assert!(page.contains("<b>differs by +171.8 ± 2.7 % (p "), "{page}");
    assert!(page.contains("<li>12.0 V, 6.0 Hz, carrier 35000 Hz: 2 trials</li>"));
    assert!(page.contains("not compared: too few trials"));
    assert!(!page.contains("<script>"));

    let file: serde_json::Value = serde_json::from_str(&study.file()).unwrap();
    let check = &file["law_check"][0];
    assert_eq!(check["n_left_out"], 1);
    assert_eq!(check["conditions"][1]["drive_v"], 24.0);
    let comparison = &check["comparisons"][0];
    assert_eq!(comparison["setting"], "drive_v");
    assert_eq!(comparison["differences"]["ln_sigma_t"]["agrees"], false);
    assert!(comparison["differences"]["ln_tau"].is_null());
    study.law_check.clear();
    assert!(!study.file().contains("law_check"));
}

#[test]
fn the_file_states_unknown_values_as_null() {
    let study = SmallStudy::new("sub-01");
    let text = study.file();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rows = serde_json::to_value(&study.recordings).unwrap();
    let instances = &rows[0]["instances"];
    assert!(instances[0]["paper"]["rms_mu"].is_null());
    assert_eq!(file["format"], 2);
    assert_eq!(instances[0]["trial"]["interval95"]["mu0"][0], 0.79);
    let within_laws = &instances[0]["trial"]["interval95_within_laws"];
    assert_eq!(within_laws["mu0"][0], 0.795);
    assert!(within_laws["resonance_shift_hz"].is_null());
    assert!(instances[1].get("trial").is_none());
    assert!(rows[1].get("trial").is_none());
    let [zeta, alpha] = ["\"zeta\"", "\"alpha\""].map(|name| text.find(name).unwrap());
    assert!(zeta < alpha, "in the order of the rows");
    assert_eq!(
        file["excluded"][0],
        serde_json::json!({
            "participant": "sub-07", "session": "all", "trial": "3", "reason": HOSTILE, "by": HOSTILE, "date": null,
            "recordings": ["/home/somebody/study/c"],
        })
    );
    assert!(file.get("exclusions_overridden").is_none());
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
    let small_study = SmallStudy::new("sub-01");
    let other_folder = study.path().join("elsewhere");
    let recordings = [
        Recorded {
            path: &folder,
            manifest: Some(&manifest),
            result: &small_study.recordings[0],
        },
        Recorded {
            path: &other_folder,
            manifest: None,
            result: &small_study.recordings[1],
        },
    ];
    let page = html(&ReportContent {
        name: "study",
        results: &small_study.results(),
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
    let mut study = SmallStudy::new("sub-01");
    study.selection.overridden = std::mem::take(&mut study.selection.excluded);
    study.account.accepted = 3;
    study.account.left_out = vec![OmittedAttempt {
        path: PathBuf::from("/home/somebody/study/sub-01/ses-01/trial-003_attempt-1"),
        standing: Some(Standing::Accepted),
        because: "its recording was broken off".to_owned(),
    }];
    let page = page_of("sub-01", &study, &[]).unwrap();
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
