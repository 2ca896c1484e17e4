//! The standard errors of a calibration are included in the errors of the live values of a session.

use std::f64::consts::TAU;
use std::fs;

use analysis::amplitude_profile::AmplitudeProfile;
use contact::harmonic::observed;
use contact::live_estimator::{LiveEstimate, LiveEstimator, LiveFrame};
use live::trial_fit::TrialContact;

use super::PUBLISHED;
use super::uneven_plate::trial_fit;

/// Returns the estimate for a frame of the fitted finger.
fn estimate(fit: &TrialContact) -> LiveEstimate {
    let finger = &fit.finger;
    let mut live = LiveEstimator::new(*finger, fit.interval_s).unwrap();
    let (amplitude_m, normal_n) = (1.5e-6, 0.6);
    let contact = finger.contact();
    let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
    let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
    let z_c = contact.impedance_n_s_per_m(k_c, TAU * 35e3);
    let frame = LiveFrame {
        z_m_corrected_n_s_per_m: observed(finger.z_p_n_s_per_m(), finger.z_t_n_s_per_m(), z_c),
        amplitude_m,
        normal_n: Some(normal_n),
    };
    (0..5).map(|_| live.update(&frame).unwrap()).last().unwrap()
}

#[test]
fn stated_errors_of_the_calibration_are_in_the_live_ones() {
    let profile = AmplitudeProfile::default();
    let fitted = |line: &str| {
        let folder = tempfile::tempdir().unwrap();
        PUBLISHED.record(folder.path());
        let path = folder.path().join("recording.toml");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(path, format!("{text}\n[standard_errors]\n{line}\n")).unwrap();
        trial_fit(folder.path(), &profile)
    };
    let exact = fitted("");
    let exact_estimate = estimate(&exact);
    for (line, gap, mu0) in [
        ("amplitude_relative = 0.03", true, false),
        ("impedance_relative = 0.03", true, false),
        ("normal_force_relative = 0.03", false, true),
        ("lateral_force_relative = 0.03", false, true),
        ("lateral_per_normal = 0.03", false, true),
    ] {
        let inexact = fitted(line);
        // A stated error may change which instance is the typical one.
        let ln_shift = (inexact.sigma_t_m.value / exact.sigma_t_m.value).ln();
        assert!(ln_shift.abs() < 0.01, "{line}: {ln_shift}");
        let inexact_estimate = estimate(&inexact);
        let wider = inexact_estimate.gap_m.std / exact_estimate.gap_m.std;
        println!("{line}: live gap {wider:.2} times as wide");
        assert_eq!(wider > 1.2, gap, "{line}: {wider}");
        assert_eq!(inexact.mu0.std > 0.03 * inexact.mu0.value, mu0, "{line}");
    }
}
