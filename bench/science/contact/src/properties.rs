//! Properties of every physical contact.

use std::f64::consts::TAU;

use crate::{AssumedConstants, Contact, StiffnessBranch, harmonic};
use num_complex::Complex64;
use proptest::prelude::*;

const CARRIER_RAD_PER_S: f64 = TAU * 35_000.0;

/// A contact, an amplitude up to ten times the bench's, and a normal force of at most 99 % of the asperities'
/// limit.
fn physical() -> impl Strategy<Value = (Contact, f64, f64)> {
    let logarithmic = |low: f64, high: f64| (low.ln()..high.ln()).prop_map(f64::exp);
    let amplitude = prop_oneof![1 => Just(0.0), 9 => logarithmic(1e-10, 5e-5)];
    (
        logarithmic(0.2e-6, 20e-6),
        amplitude,
        logarithmic(1e-3, 10.0),
        3e3..5e4,
        100e-6..500e-6,
    )
        .prop_map(
            |(sigma_t_m, amplitude_m, normal_n, q0_rad_per_m, contact_area_m2)| {
                let assumed = AssumedConstants {
                    q0_rad_per_m,
                    contact_area_m2,
                    ..AssumedConstants::default()
                };
                let contact = Contact::new(&assumed, sigma_t_m).unwrap();
                let normal_n = normal_n.min(0.99 * contact.asperity_limit_n());
                (contact, amplitude_m, normal_n)
            },
        )
}

/// Numbers of either sign, from rounding errors to a tenth.
fn near_zero() -> impl Strategy<Value = f64> {
    (-16.0..-1.0, any::<bool>()).prop_map(|(decade, negative): (f64, bool)| {
        let size = 10f64.powf(decade);
        if negative { -size } else { size }
    })
}

/// Halves the bracket ninety times: slow, and independent of the solver's method.
fn bisected(contact: &Contact, amplitude_m: f64, normal_n: f64) -> f64 {
    let missing =
        |x: f64| contact.asperity_force_n(x) + contact.squeeze_force_n(x, amplitude_m) - normal_n;
    let mut lo = contact.rest_gap_m(normal_n).unwrap();
    let mut hi = lo + 1.0;
    for _ in 0..90 {
        let middle = 0.5 * (lo + hi);
        if missing(middle) > 0.0 {
            lo = middle
        } else {
            hi = middle
        }
    }
    0.5 * (lo + hi)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn forces_balance_at_the_equilibrium_gap((contact, amplitude_m, normal_n) in physical()) {
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
        let expected_m = bisected(&contact, amplitude_m, normal_n);
        prop_assert!((gap_m / expected_m - 1.0).abs() < 1e-12, "{gap_m} {expected_m}");
    }

    #[test]
    fn the_gap_grows_with_amplitude_and_falls_with_force((contact, amplitude_m, normal_n) in physical()) {
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
        prop_assert!(contact.equilibrium_gap_m(1.01 * amplitude_m + 1e-9, normal_n).unwrap() >= gap_m);
        prop_assert!(contact.equilibrium_gap_m(amplitude_m, 0.99 * normal_n).unwrap() > gap_m);
    }

    #[test]
    fn a_record_gives_the_results_of_its_single_samples((contact, amplitude_m, normal_n) in physical()) {
        let amplitudes: Vec<f64> = (0..12).map(|i| amplitude_m * f64::from(i * 7 % 12)).collect();
        let mut gaps = vec![0.0; 12];
        contact.equilibrium_gaps_m(&amplitudes, &[normal_n; 12], &mut gaps).unwrap();
        for (&a, &gap) in amplitudes.iter().zip(&gaps) {
            prop_assert!((gap / contact.equilibrium_gap_m(a, normal_n).unwrap() - 1.0).abs() < 1e-12);
        }
    }

    /// Forward to stiffness and back by both laws. In balance only the falling branch is recovered; close to the
    /// greatest stiffness the two gaps merge and no inverse can separate them.
    #[test]
    fn gap_to_stiffness_and_back((contact, amplitude_m, normal_n) in physical()) {
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
        let by_amplitude = contact.gap_from_stiffness_m(contact.stiffness_n_per_m(gap_m, amplitude_m), amplitude_m).unwrap();
        prop_assert!((by_amplitude / gap_m - 1.0).abs() < 1e-9);

        let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
        let inverted = contact.gap_from_balance_stiffness(k_c, normal_n).unwrap();
        let nearest = match inverted.branch {
            StiffnessBranch::Ambiguous { smaller_gap_m } if gap_m < 2.0 * contact.sigma_t_m()
                && (smaller_gap_m - gap_m).abs() < (inverted.gap_m - gap_m).abs() => smaller_gap_m,
            _ => inverted.gap_m,
        };
        let slope = (contact.balance_stiffness_n_per_m(gap_m * (1.0 + 1e-4), normal_n) / k_c - 1.0) / 1e-4;
        prop_assume!(slope.abs() > 1e-4);
        prop_assert!((nearest / gap_m - 1.0).abs() < 1e-9, "{inverted:?} for {gap_m}");
        if gap_m > 2.0 * contact.sigma_t_m() {
            prop_assert_eq!(nearest, inverted.gap_m);
        }
    }

    /// Around the greatest stiffness, where the curve is flat and the gap is poorly determined, the gap found
    /// still has the given stiffness.
    #[test]
    fn a_flat_stiffness_curve_is_inverted_too(
        sigma_t_m in 0.2e-6..20e-6, rest_from_peak in near_zero(), from_rest in near_zero()
    ) {
        let contact = Contact::new(&AssumedConstants::default(), sigma_t_m).unwrap();
        let normal_n = contact.asperity_limit_n() * (-2.0 - rest_from_peak).exp();
        let gap_m = contact.rest_gap_m(normal_n).unwrap() + sigma_t_m * from_rest.abs();
        let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
        let inverted = contact.gap_from_balance_stiffness(k_c, normal_n).unwrap();
        let error = |x| contact.balance_stiffness_n_per_m(x, normal_n) / k_c - 1.0;
        prop_assert!(error(inverted.gap_m).abs() < 1e-14, "{inverted:?} for {gap_m}: {}", error(inverted.gap_m));
        if let StiffnessBranch::Ambiguous { smaller_gap_m } = inverted.branch {
            prop_assert!(smaller_gap_m <= inverted.gap_m);
            prop_assert!(error(smaller_gap_m).abs() < 1e-14, "{inverted:?} for {gap_m}: {}", error(smaller_gap_m));
        }
    }

    /// The same through the impedance: amplitude → gap → Z_m → Z_c → k_c → gap.
    #[test]
    fn impedance_and_back((contact, amplitude_m, normal_n) in physical(), re in 0.05..2.0, im in 0.5..6.0, z_p in 1.0..20.0) {
        let (z_p, z_t) = (Complex64::new(z_p, 0.0), Complex64::new(re, im));
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
        let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
        let z_c = contact.impedance_n_s_per_m(k_c, CARRIER_RAD_PER_S);
        let z_m = harmonic::observed(z_p, z_t, z_c);
        // Eq. 12 takes the difference of Z_t and the finger's part, and of Z_m and Z_p: where one nearly vanishes, digits
        // are lost.
        let digits_left = (z_c.norm() / z_p.re).min(z_t.norm() / z_c.norm()).min(1.0);
        prop_assume!(digits_left > 1e-4);
        let k_c_back = harmonic::stiffness_n_per_m(harmonic::contact_from_observed(z_m, z_p, z_t), CARRIER_RAD_PER_S);
        prop_assert!((k_c_back / k_c - 1.0).abs() < 1e-9);
        prop_assert!((contact.gap_from_stiffness_m(k_c_back, amplitude_m).unwrap() / gap_m - 1.0).abs() < 1e-9);
    }

    /// Passive parts make a passive whole: Re Z_m ≥ Re Z_p.
    /// Hazard 5.
    #[test]
    fn the_finger_only_takes_power((contact, amplitude_m, normal_n) in physical(), re in 0.0..2.0, im in -6.0..6.0) {
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).unwrap();
        let z_c = contact.impedance_n_s_per_m(contact.stiffness_n_per_m(gap_m, amplitude_m), CARRIER_RAD_PER_S);
        let z_m = harmonic::observed(Complex64::new(7.01, 0.0), Complex64::new(re, im), z_c);
        prop_assert!(z_m.re >= 7.01 - 1e-12 * z_m.norm());
    }
}
