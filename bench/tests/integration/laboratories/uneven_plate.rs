//! A plate with a smaller amplitude at its ends, with and without its profile.

use std::fs;
use std::path::{Path, PathBuf};

use analysis::amplitude_profile::AmplitudeProfile;
use analysis::error_budget::ErrorBudget;
use analysis::estimate::Method;
use analysis::findings::RecordingFindings;
use analysis::printed_settings::PrintedSettings;
use analysis::{RecordingSeries, Settings, demodulation};
use live::trial_fit::{FitRequest, SelectedExploration, TrialContact, fit};
use protocols::Direction;
use protocols::selection::select;
use recording::RecordingSource;
use recording::pipeline::PickupOffset;
use report::recording_results::Recording;

use super::{EXPLORATION_S, Laboratory, PUBLISHED, Z_T, findings, findings_and_series};

/// States the amplitude along the plate, as `calibrate plate --along 5` would measure it.
fn state_profile(folder: &Path, ratio: impl Fn(f64) -> f64) {
    let places_m = [0.005, 0.02875, 0.0525, 0.07625, 0.1];
    let (path, ratios) = (folder.join("recording.toml"), places_m.map(ratio));
    let profile = format!("profile = {{ positions_m = {places_m:?}, ratios = {ratios:?} }}");
    let text = fs::read_to_string(&path).unwrap();
    let edited = text.replace(
        "centre_m = 0.0525 }",
        &format!("centre_m = 0.0525, {profile} }}"),
    );
    assert_ne!(edited, text);
    fs::write(path, edited).unwrap();
}

/// Returns all digits of a method's estimates.
fn estimates((findings, series): (&RecordingFindings, &RecordingSeries), method: Method) -> String {
    let instances = findings.instances.iter().zip(&series.instances);
    let texts = instances.map(|(i, samples)| {
        let e = i.estimate(method).unwrap();
        let series = samples.estimate(method).unwrap();
        let skin = (e.sigma_t_m(), e.z_t_n_s_per_m, e.tau_s, e.mu0);
        format!(
            "{skin:?} {:?} {:?} {:?}",
            series.contact, series.motion, series.film_force_n
        )
    });
    texts.collect()
}

/// An amplitude that is 15.3 % less at the plate's ends is 5 % less at the ends of the 60 mm that are kept.
#[test]
fn a_plate_that_moves_less_at_its_ends_serves_once_its_profile_is_known() {
    let uneven = Laboratory {
        end_drop: 0.153,
        ..PUBLISHED
    };
    let [even_folder, folder] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    PUBLISHED.record(even_folder.path());
    uneven.record(folder.path());
    let even = findings(even_folder.path());
    let (unknown, unknown_series) = findings_and_series(folder.path());
    state_profile(folder.path(), |x| uneven.scenario().plate.shape(x));
    let (known, known_series) = findings_and_series(folder.path());
    // Compared with the same finger on an even plate, which has the other errors of `dynamic` too.
    let greatest = |findings: &RecordingFindings| {
        let pairs = findings.instances.iter().zip(&even.instances);
        let deviations = pairs.map(|(instance, even)| {
            assert!((instance.start_s - even.start_s).abs() < 5e-3);
            let (estimate, even) = (&instance.dynamic, &even.dynamic);
            let z_t = (estimate.z_t_n_s_per_m - even.z_t_n_s_per_m).norm() / Z_T.norm();
            [(estimate.sigma_t_m() / even.sigma_t_m() - 1.0).abs(), z_t]
        });
        deviations.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
    };
    let ([sigma_t, z_t], biased) = (greatest(&known), greatest(&unknown));
    println!("5 % less: sigma_t, Z_t off by {biased:.4?}; with the profile {sigma_t:.4}, {z_t:.4}");
    assert!(known.instances.len() >= 6);
    assert!(known.flaws.is_empty(), "{:?}", known.flaws);
    assert!(biased[0] > 0.025 && biased[1] > 0.02, "{biased:?}");
    assert!(sigma_t < 0.003 && z_t < 0.004, "{sigma_t} {z_t}");
    let recordings = [(&known, &known_series), (&unknown, &unknown_series)];
    let paper_estimates = recordings.map(|recording| estimates(recording, Method::Paper));
    assert_eq!(paper_estimates[0], paper_estimates[1]);
}

/// Returns the request to fit a recording's exploration, as a session makes it after a trial.
pub(super) fn fit_request(folder: &Path) -> FitRequest {
    let reading =
        demodulation::read(&RecordingSource::folder(folder), PickupOffset::default()).unwrap();
    let settings = Settings::default();
    let vibration = reading.vibration.unwrap();
    let rules = settings.selection_rules(vibration.plate.centre_m);
    let (start_s, end_s) = EXPLORATION_S;
    let series = reading.record.series(start_s, end_s);
    let stretches = select(&series.exploration(Direction::LeftToRight), &rules).unwrap();
    FitRequest {
        label: "trial 1".to_owned(),
        carrier_hz: vibration.carrier_hz,
        errors: ErrorBudget::without_assumptions(
            reading.manifest.standard_errors.unwrap_or_default(),
        ),
        pickup: PickupOffset::default(),
        plate: Ok(findings(folder).z_p.unwrap()),
        record: reading.record,
        explorations: vec![SelectedExploration {
            start_s,
            end_s,
            stretches,
        }],
        rules,
    }
}

/// Fits a recording's exploration as a session does after a trial.
pub(super) fn trial_fit(folder: &Path, profile: &AmplitudeProfile) -> TrialContact {
    let request = fit_request(folder);
    fit(&request, Settings::default().assumed(), profile).unwrap()
}

#[test]
fn the_fit_of_a_session_knows_the_profile_too_and_hands_it_on() {
    let uneven = Laboratory {
        end_drop: 0.5,
        ..PUBLISHED
    };
    let [even_folder, folder] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    PUBLISHED.record(even_folder.path());
    uneven.record(folder.path());
    state_profile(folder.path(), |x| uneven.scenario().plate.shape(x));
    let profile = AmplitudeProfile::from(findings(folder.path()).plate().unwrap());
    let uniform = AmplitudeProfile::default();
    let even = trial_fit(even_folder.path(), &uniform);
    let [known, unknown] = [&profile, &uniform].map(|profile| trial_fit(folder.path(), profile));
    let off = |fit: &TrialContact| (fit.z_t_n_s_per_m - even.z_t_n_s_per_m).norm() / Z_T.norm();
    println!(
        "half at the ends: Z_t off by {:.4}, with the profile {:.4}",
        off(&unknown),
        off(&known)
    );
    assert!(off(&known) < 0.004 && off(&unknown) > 0.006);
    assert!(
        known.sigma_t_spread_m < 0.5 * unknown.sigma_t_spread_m,
        "{unknown:?}"
    );
    assert!(known.force_difference.unwrap() < 0.5 * unknown.force_difference.unwrap());
    assert_eq!(known.profile, profile);
}

#[test]
fn results_say_how_each_method_takes_the_amplitude() {
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    for folder in &folders {
        PUBLISHED.record(folder.path());
    }
    state_profile(folders[0].path(), |_| 0.97);
    let folders = folders.each_ref().map(|folder| folder.path().to_owned());
    let analyse = |folders: &[PathBuf]| analysis::analyse(folders, &Settings::default(), |_| ());
    for (folders, dynamic) in [
        (&folders[..1], "as measured: plate.profile"),
        (&folders[1..], "uniform: no recording has plate.profile"),
        (
            &folders[..],
            "as measured, plate.profile, in 1 of 2 recordings; uniform in the others",
        ),
    ] {
        let settings = serde_json::to_value(PrintedSettings::new(&analyse(folders))).unwrap();
        let amplitude = &settings["amplitude_along_plate"];
        let paper = amplitude["paper"].as_str().unwrap();
        assert!(paper.starts_with("uniform, as published"), "{paper}");
        assert_eq!(amplitude["dynamic"], dynamic);
        assert_eq!(settings["loss_factor"], 0.3);
    }
    let recordings = analyse(&folders).recordings;
    let [first, second] =
        [0, 1].map(|number| serde_json::to_value(Recording::from(&recordings[number])).unwrap());
    assert_eq!(first["plate_profile"], true);
    assert!(second.get("plate_profile").is_none());
}

#[test]
fn a_profile_of_ones_changes_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    PUBLISHED.record(folder.path());
    let (plain, plain_series) = findings_and_series(folder.path());
    state_profile(folder.path(), |_| 1.0);
    let (profiled, profiled_series) = findings_and_series(folder.path());
    assert!(profiled.plate().unwrap().profile.is_some() && !profiled.instances.is_empty());
    for method in Method::BOTH {
        assert_eq!(
            estimates((&profiled, &profiled_series), method),
            estimates((&plain, &plain_series), method)
        );
    }
    assert_eq!(profiled.model_check, plain.model_check);
}
