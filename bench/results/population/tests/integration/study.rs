//! Pooling of studies with known fits.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::PathBuf;

use analysis::findings::{RecordingError, RecordingFindings};
use analysis::{Analysis, RecordingAnalysis};
use contact::uncertain::{LogUncertain, Uncertain};
use estimation::trial::{Misfit, SharedFit};
use estimation::{FitParameter, FitVerdict};
use population::skin::{SKIN_FILE, Skin, write};
use protocols::SelectionRules;
use recording::Manifest;
use recording::manifest::MINIMAL;
use serde_json::Value;

/// Returns a fit with this area, with a standard error of its logarithm of `ln_std`; 5 % for the other parameters.
fn fit(area_m2: f64, ln_std: f64) -> SharedFit {
    let log_value = |value| LogUncertain {
        value,
        ln_std: 0.05,
    };
    let law = Uncertain {
        value: 0.3,
        std: 0.3,
    };
    SharedFit {
        verdict: FitVerdict::Converged,
        contact_area_m2: LogUncertain {
            value: area_m2,
            ln_std,
        },
        q0_rad_per_m: log_value(2e4),
        loss_factor: log_value(0.4),
        tau_s: log_value(1e-3),
        area_exponent: law,
        film_mean_s: 1e-4,
        lag_exponent: law,
        misfit: Vec::new(),
        friction_floor: None,
        lateral_lag_s: None,
    }
}

fn misfit_fit(area_m2: f64) -> SharedFit {
    SharedFit {
        misfit: vec![Misfit::Friction { rms_mu: 0.1 }],
        ..fit(area_m2, 0.05)
    }
}

fn recording(
    number: usize,
    participant: Option<&str>,
    trial: Option<SharedFit>,
    within_laws: Option<SharedFit>,
) -> RecordingAnalysis {
    let participant_line =
        participant.map(|id| format!("participant = {{ id = \"{id}\", session = 1 }}"));
    let text = format!("{MINIMAL}{}", participant_line.unwrap_or_default());
    let participant = participant.map(str::to_owned);
    let path = PathBuf::from(format!("study/{number}"));
    RecordingAnalysis {
        path: path.clone(),
        participant: participant.clone(),
        findings: Ok(RecordingFindings {
            path,
            participant,
            manifest: Manifest::parse(&text, "recording.toml").unwrap(),
            vibration: None,
            provenance: Default::default(),
            rules: SelectionRules::published(0.05),
            pickup: recording::pipeline::PickupOffset::default(),
            force_clock: None,
            zero: analysis::force_zero::ForceZero::default(),
            errors: analysis::error_budget::ErrorBudget::default(),
            z_p: None,
            explorations: Vec::new(),
            instances: Vec::new(),
            trial,
            within_laws,
            sample_statistics: Default::default(),
            model_check: Vec::new(),
            rejected: Vec::new(),
            flaws: Vec::new(),
        }),
    }
}

fn study(trials: Vec<(Option<&str>, Option<SharedFit>)>) -> Analysis {
    let numbered = trials.into_iter().zip(1..);
    Analysis {
        recordings: numbered
            .map(|((participant, fit), number)| recording(number, participant, fit.clone(), fit))
            .collect(),
        ..Analysis::default()
    }
}

/// Four people with 200 to 260 mm² and three trials each, plus all kinds of excluded recordings.
fn full_study() -> Analysis {
    let mut trials = Vec::new();
    for (person, area_m2) in [("a", 200e-6), ("b", 220e-6), ("c", 240e-6), ("d", 260e-6)] {
        for (trial, ln_std) in [(0.9, 0.04), (1.0, 0.05), (1.1, 0.06)] {
            trials.push((Some(person), Some(fit(trial * area_m2, ln_std))));
        }
    }
    trials.push((Some("a"), Some(misfit_fit(1e-3))));
    trials.push((Some("d"), None));
    trials.extend([1e-3, 2e-3].map(|area_m2| (Some("e"), Some(misfit_fit(area_m2)))));
    let open_verdict = FitVerdict::NotIdentifiable {
        parameter: FitParameter::ContactArea,
        std: 2.0,
    };
    let open_fit = SharedFit {
        verdict: open_verdict,
        ..fit(1e-3, 2.0)
    };
    trials.push((Some("b"), Some(open_fit)));
    trials.push((None, Some(fit(1e-3, 0.05))));
    let mut analysed = study(trials);
    analysed.recordings.push(RecordingAnalysis {
        path: PathBuf::from("study/broken"),
        participant: Some("c".to_owned()),
        findings: Err(RecordingError::TooManyRows {
            file: "force.csv",
            limit: 1,
        }),
    });
    analysed
}

#[test]
fn participants_and_the_study_have_means_and_unusable_fits_are_counted() {
    let skin = Skin::from_analysis(&full_study());
    let n_left_out: Vec<_> = skin
        .participants
        .iter()
        .map(|person| person.n_left_out)
        .collect();
    let n_used: Vec<_> = skin
        .participants
        .iter()
        .map(|person| person.trials.len())
        .collect();
    assert_eq!(
        (n_left_out, n_used),
        (vec![1, 1, 1, 1, 2], vec![3, 3, 3, 3, 0])
    );
    assert_eq!(skin.left_out.len(), 7);
    // Unreadable recordings were missing from all counts.
    assert!(skin.left_out[6].because.starts_with("it cannot be read: "));
    assert!(
        skin.left_out[0]
            .because
            .starts_with("the model does not hold: ")
    );
    let has_participant: Vec<bool> = skin
        .left_out
        .iter()
        .map(|exclusion| exclusion.participant.is_some())
        .collect();
    assert_eq!(has_participant, [true, true, true, true, true, false, true]);

    let mut means = Vec::new();
    for (person, area_m2) in skin
        .participants
        .iter()
        .zip([200e-6, 220e-6, 240e-6, 260e-6])
    {
        let area = person.parameters.contact_area_m2.unwrap();
        let [lower, upper] = area.mean.interval95;
        assert!((area.mean.value / area_m2 - 1.0).abs() < 0.03, "{area:?}");
        assert!(
            lower < area_m2 && area_m2 < upper && upper < 1.4 * lower,
            "{area:?}"
        );
        assert_eq!(area.n_trials, 3);
        let shrunken = area.shrunken.unwrap();
        means.push((area.mean.value, shrunken.value));
        for trial in &person.trials {
            let trial_area = trial.parameters.contact_area_m2;
            let shrunken_range = trial_area.shrunken.unwrap();
            let width =
                |range: population::skin::Ranged| (range.interval95[1] / range.interval95[0]).ln();
            assert!(
                width(shrunken_range) < width(trial_area.raw),
                "{trial_area:?}"
            );
        }
        // The trials are 10 % from the mean, with errors of 5 %: most of the distance remains, but not all.
        let low = person.trials[0].parameters.contact_area_m2;
        let remainder =
            (low.shrunken.unwrap().value / area_m2).ln() / (low.raw.value / area_m2).ln();
        assert!((0.5..1.0).contains(&remainder), "{remainder}");
    }
    let [(first, first_shrunken), .., (last, last_shrunken)] = means[..] else {
        panic!("{means:?}");
    };
    assert!(first < first_shrunken && last_shrunken < last, "{means:?}");

    let area = skin.study.contact_area_m2;
    let mean = area.mean.unwrap();
    assert_eq!(area.n_participants, 4);
    assert!((mean.value / 228e-6 - 1.0).abs() < 0.02, "{mean:?}");
    assert!(mean.interval95[0] < 220e-6 && mean.interval95[1] > 240e-6);
    let [least, most] = area.between_participants_ln_std_interval95.unwrap();
    let between = area.between_participants_ln_std.unwrap();
    assert!(
        least <= between && between < most && most > 0.11,
        "{area:?}"
    );
    assert!(area.between_trials_ln_std.unwrap() > 0.05);
    // A parameter with equal values has no scatter between trials or participants.
    assert_eq!(skin.study.tau_s.between_trials_ln_std, Some(0.0));
    assert_eq!(skin.study.tau_s.between_participants_ln_std, Some(0.0));
    // Its error, if any, is then the same in all trials.
    assert!(skin.study.tau_s.shared_error_part > 0.99 && area.shared_error_part == 0.0);

    let empty_person = skin.participants.last().unwrap();
    assert_eq!(
        (
            empty_person.participant.as_str(),
            empty_person.parameters.tau_s
        ),
        ("e", None)
    );
    let lines = skin.lines();
    assert_eq!(lines.len(), 12);
    assert!(
        lines[0].starts_with("skin of a, 3 trials, 1 left out: S 1"),
        "{lines:?}"
    );
    assert_eq!(
        lines[1],
        lines[0].replace(
            "skin of a, 3 trials, 1 left out",
            "  within the published laws"
        )
    );
    assert_eq!(lines[8], "skin of e, 0 trials, 2 left out");
    assert!(
        lines[9].starts_with("mean of 4 participants: S 190 to 273 mm², "),
        "{lines:?}"
    );
    assert!(lines[10].starts_with("  within the published laws: S 190 to 273 mm², "));
    assert!(lines[11].contains("τ ± 0 %"), "{lines:?}");
}

#[test]
fn a_single_trial_has_an_interval_and_unknown_values_are_null() {
    let skin = Skin::from_analysis(&study(vec![(Some("a"), Some(fit(200e-6, 0.05)))]));
    let area = skin.participants[0].parameters.contact_area_m2.unwrap();
    assert!((area.mean.value / 200e-6 - 1.0).abs() < 0.01);
    assert!((area.mean.interval95[1] / area.mean.value).ln() < 2.0 * 0.051);
    let json = serde_json::to_value(&skin).unwrap();
    let study_area = &json["study"]["contact_area_m2"];
    for key in [
        "mean",
        "between_participants_ln_std",
        "between_trials_ln_std",
    ] {
        assert_eq!(study_area[key], Value::Null, "{key}");
    }
    let trial = &json["participants"][0]["trials"][0]["contact_area_m2"];
    assert_eq!(trial["value"], 200e-6);
    assert_eq!(trial["shrunken"], Value::Null);
    assert_eq!(skin.lines().len(), 2);
}

/// Laws in doubt make each S uncertain by 20 %, in the same direction in all trials; the published laws leave 5 %.
#[test]
fn the_error_of_the_laws_remains_in_the_means_and_not_in_those_within_the_laws() {
    let mut recordings = Vec::new();
    for person in ["a", "b", "c", "d"] {
        for trial in 0..25 {
            let scatter = if trial % 2 == 0 { 1.05 } else { 0.95 };
            let within_laws = fit(scatter * 200e-6, 0.05);
            let total = fit(scatter * 220e-6, 0.2);
            let number = recordings.len();
            let fits = (Some(total), Some(within_laws));
            recordings.push(recording(number, Some(person), fits.0, fits.1));
        }
    }
    // The published laws do not hold: the whole error may be common.
    let total = Some(fit(220e-6, 0.2));
    recordings.push(recording(100, Some("e"), total, Some(misfit_fit(100e-6))));
    let analysed = Analysis {
        recordings,
        ..Analysis::default()
    };
    let skin = Skin::from_analysis(&analysed);
    let half_width = |[low, high]: [f64; 2]| (high / low).ln() / 2.0;
    let area = skin.participants[0].parameters.contact_area_m2.unwrap();
    let study = skin.study.contact_area_m2.mean.unwrap();
    // √(0.2² − 0.05²) = 0.194, a little more without the prior.
    for mean in [area.mean, study] {
        let total = half_width(mean.interval95) / 1.96;
        assert!((0.19..0.25).contains(&total), "{mean:?}");
        let within_laws = mean.interval95_within_laws.unwrap();
        assert!(half_width(within_laws) / 1.96 < 0.03, "{mean:?}");
        assert!((within_laws[0] * within_laws[1]).sqrt() < 205e-6);
        assert!(mean.value > 215e-6);
    }
    let unexplained = &skin.participants[4];
    assert_eq!(unexplained.trials.len(), 1);
    let area = unexplained.parameters.contact_area_m2.unwrap();
    assert_eq!(area.mean.interval95_within_laws, None);
    assert!(half_width(area.mean.interval95) / 1.96 >= 0.2);
    let lines = skin.lines();
    assert!(
        lines[1].starts_with("  within the published laws: S 19"),
        "{lines:?}"
    );
    let json = serde_json::to_value(&skin).unwrap();
    let person = &json["participants"][0]["contact_area_m2"];
    assert!(person["interval95_within_laws"][0].is_f64());
    let trial = &json["participants"][4]["trials"][0]["contact_area_m2"];
    assert_eq!(trial["interval95_within_laws"], Value::Null);
}

/// Where the data do not reject the published laws, both fits have the same value, and so have their means.
#[test]
fn intervals_about_the_same_values_have_the_same_middle() {
    let trials = [0.95, 1.0, 1.08].iter().zip(1..);
    let recordings = trials.flat_map(|(factor, number)| {
        ["a", "b", "c", "d"].map(|person| {
            let area_m2 = factor * 220e-6;
            let fits = (fit(area_m2, 0.3), fit(area_m2, 0.05));
            recording(number, Some(person), Some(fits.0), Some(fits.1))
        })
    });
    let skin = Skin::from_analysis(&Analysis {
        recordings: recordings.collect(),
        ..Analysis::default()
    });
    let person = skin.participants[0].parameters.contact_area_m2.unwrap();
    for range in [person.mean, skin.study.contact_area_m2.mean.unwrap()] {
        let ([low, high], within_laws) = (range.interval95, range.interval95_within_laws.unwrap());
        let middle = (within_laws[0] * within_laws[1]).sqrt();
        assert!((range.value / middle - 1.0).abs() < 1e-9, "{range:?}");
        assert!((range.value / 222e-6 - 1.0).abs() < 0.02, "{range:?}");
        assert!(
            low < 0.62 * range.value && high > 1.6 * range.value,
            "{range:?}"
        );
    }
}

/// A parameter that a trial leaves to the prior is not pooled.
#[test]
fn an_open_parameter_of_a_trial_is_not_pooled() {
    let skin = Skin::from_analysis(&study(vec![
        (Some("a"), Some(fit(200e-6, 0.6))),
        (Some("a"), Some(fit(220e-6, 0.05))),
        (Some("b"), Some(fit(f64::NAN, f64::NAN))),
    ]));
    let parameters = |person: usize| skin.participants[person].parameters;
    assert_eq!(parameters(0).contact_area_m2.unwrap().n_trials, 1);
    assert_eq!(parameters(0).tau_s.unwrap().n_trials, 2);
    assert_eq!(parameters(1).contact_area_m2, None);
    assert_eq!(parameters(1).tau_s.unwrap().n_trials, 1);
    assert_eq!(skin.study.contact_area_m2.mean, None);
    assert!(skin.study.tau_s.mean.is_some());
}

#[test]
fn the_table_has_a_row_for_each_parameter_and_each_recording_that_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let skin = Skin::from_analysis(&full_study());
    write(&skin, folder.path()).unwrap();
    let mut reader = csv::Reader::from_path(folder.path().join(SKIN_FILE)).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let column = |row: &csv::StringRecord, name: &str| {
        let index = header.iter().position(|cell| cell == name).unwrap();
        row[index].to_owned()
    };
    let level = |name: &str| {
        rows.iter()
            .filter(|row| column(row, "level") == name)
            .count()
    };
    assert_eq!(
        [level("trial"), level("participant"), level("study")],
        [12 * 4 + 7, 5 * 4, 4]
    );
    let study = rows
        .iter()
        .find(|row| column(row, "level") == "study")
        .unwrap();
    let value: f64 = column(study, "value").parse().unwrap();
    assert_eq!(value, skin.study.contact_area_m2.mean.unwrap().value);
    let empty_row = rows
        .iter()
        .find(|row| column(row, "level") == "participant" && column(row, "participant") == "e");
    let empty_row = empty_row.unwrap();
    assert_eq!(column(empty_row, "value"), "");
    assert_eq!(
        (column(empty_row, "n"), column(empty_row, "left_out")),
        ("0".to_owned(), "2 of 2 trials".to_owned())
    );
    let raw = rows
        .iter()
        .filter(|row| column(row, "level") == "trial" && column(row, "left_out").is_empty());
    for row in raw {
        let [low, value, high] =
            ["low95", "value", "high95"].map(|name| column(row, name).parse::<f64>().unwrap());
        assert!(low < value && value < high);
        assert!(column(row, "shrunken").parse::<f64>().is_ok());
    }
}
