//! The curves shown to the operator after a trial, compared with the measurements.

use analysis::Settings;
use analysis::amplitude_profile::AmplitudeProfile;
use live::contact_curves::contact_curves;
use live::trial_fit::fit;
use tui::event::ComplexImpedance;

use super::PUBLISHED;
use super::uneven_plate::fit_request;

#[test]
fn the_curves_of_a_fit_pass_through_the_measurements() {
    let folder = tempfile::tempdir().unwrap();
    PUBLISHED.record(folder.path());
    let request = fit_request(folder.path());
    let profile = AmplitudeProfile::default();
    let fitted = fit(&request, Settings::default().assumed(), &profile).unwrap();
    let curves = contact_curves(&request, &fitted).unwrap();
    assert!(curves.measured.len() >= 15);
    assert!(curves.measured.is_sorted_by(|a, b| a.0 < b.0));
    for (amplitude_m, measured) in &curves.measured {
        let nearest = curves.friction.iter().min_by(|a, b| {
            (a.0 - amplitude_m)
                .abs()
                .total_cmp(&(b.0 - amplitude_m).abs())
        });
        let (_, estimated) = nearest.unwrap();
        // The measured curve lags behind the quasi-static one because of the levitation lag.
        assert!(
            (measured - estimated).abs() < 0.1,
            "{amplitude_m}: {measured} {estimated}"
        );
    }
    // A finger adds dissipation and inertia, less of each as it is levitated.
    let distance = |z: &ComplexImpedance| {
        let z_p = &curves.z_p_n_s_per_m;
        (z.re_n_s_per_m - z_p.re_n_s_per_m).hypot(z.im_n_s_per_m - z_p.im_n_s_per_m)
    };
    let [first, .., last] = &curves.locus[..] else {
        panic!("a locus of {} points", curves.locus.len());
    };
    assert!(distance(first) > 1.5 * distance(last));

    let empty = contact_curves(
        &live::trial_fit::FitRequest {
            explorations: Vec::new(),
            ..request
        },
        &fitted,
    );
    assert_eq!(empty, None);
}
