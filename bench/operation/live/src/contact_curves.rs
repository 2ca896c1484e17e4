//! Curves of a fitted contact over the vibration amplitude, together with the measured friction.
//!
//! The curves are quasi-static: at each amplitude the gap balances the forces. In a real period the gap lags by τ, which opens
//! the trace around the curve.

use crate::trial_fit::{FitRequest, TrialContact};
use contact::harmonic;
use num_complex::Complex64;
use protocols::Stretch;
use statistics::median;
use tui::event::{ComplexImpedance, ContactCurves};

/// Number of points of the curves.
const POINTS: usize = 48;
/// Number of measured points, each the median of an equal share of the samples.
const PARTS: usize = 16;

/// Returns the curves of `fit` and the measured friction in the trial's instances; `None` without a valid sample.
pub fn contact_curves(request: &FitRequest, fit: &TrialContact) -> Option<ContactCurves> {
    // Amplitude under the finger, normal force, friction coefficient.
    let mut samples: Vec<(f64, f64, f64)> = Vec::new();
    for exploration in &request.explorations {
        let series = request
            .record
            .series(exploration.start_s, exploration.end_s);
        for instance in exploration.stretches.iter().filter_map(Stretch::instance) {
            let start = series.time_s.partition_point(|t_s| *t_s < instance.start_s);
            let end = series.time_s.partition_point(|t_s| *t_s <= instance.end_s);
            samples.extend((start..end).map(|i| {
                let normal_n = series.normal_n[i];
                let amplitude_m =
                    fit.profile.ratio_at(series.position_m[i]) * series.amplitude_m[i];
                (
                    amplitude_m,
                    normal_n,
                    (series.lateral_n[i] / normal_n).abs(),
                )
            }));
        }
    }
    samples.retain(|(amplitude_m, normal_n, mu)| {
        amplitude_m.is_finite() && mu.is_finite() && *normal_n > 0.0
    });
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (smallest, largest) = (samples.first()?.0, samples.last()?.0);
    let normal_n = median(samples.iter().map(|sample| sample.1))?;
    let part = samples.len().div_ceil(PARTS);
    let measured = samples.chunks(part).filter_map(|part| {
        let amplitude_m = median(part.iter().map(|sample| sample.0))?;
        Some((amplitude_m, median(part.iter().map(|sample| sample.2))?))
    });
    let (finger, contact) = (&fit.finger, fit.finger.contact());
    let (z_p, z_t) = (finger.z_p_n_s_per_m(), finger.z_t_n_s_per_m());
    let omega = std::f64::consts::TAU * request.carrier_hz;
    let (mut locus, mut friction) = (Vec::new(), Vec::new());
    for i in 0..POINTS {
        let amplitude_m = smallest + (largest - smallest) * i as f64 / (POINTS - 1) as f64;
        let Ok(gap_m) = contact.equilibrium_gap_m(amplitude_m, normal_n) else {
            continue;
        };
        let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
        let z_c = contact.impedance_n_s_per_m(k_c, omega);
        let z_finger = harmonic::observed(Complex64::ZERO, z_t, z_c);
        locus.push(impedance(z_p + finger.inversion.finger_scale * z_finger));
        friction.push((
            amplitude_m,
            fit.mu0.value * contact.friction_ratio(gap_m, normal_n),
        ));
    }
    Some(ContactCurves {
        normal_n,
        z_p_n_s_per_m: impedance(z_p),
        locus,
        friction,
        measured: measured.collect(),
    })
}

fn impedance(z: Complex64) -> ComplexImpedance {
    ComplexImpedance {
        re_n_s_per_m: z.re,
        im_n_s_per_m: z.im,
    }
}
