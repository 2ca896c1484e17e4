//! Figures and numbers of docs/laws.md.

use num_complex::Complex64;

use super::drawn::require_same;
use super::film_figures;
use super::fitted::fit;
use super::impedance_figures::{self, WAVELENGTH_M};
use super::law::{AT_REST, AVERAGE, Finger, Law, OF_FIG_3, State, Width};
use super::reynolds_finger::{Outline, states};
use crate::reynolds_world::film::{Linear, Shape};

#[test]
fn the_figures_of_the_film_are_those_of_the_page() {
    rayon::join(
        || require_same(&film_figures::stiffness()),
        || require_same(&film_figures::force()),
    );
}

#[test]
fn the_figures_of_the_impedance_are_those_of_the_page() {
    rayon::join(
        || require_same(&impedance_figures::impedance()),
        || require_same(&impedance_figures::width()),
    );
}

/// Film's mean force over Eq. 14 and stiffness over p0 S/x are one function of the squeeze number.
#[test]
fn a_vented_film_is_as_stiff_as_it_is_strong() {
    for shape in [Shape::Strip, Shape::Disc] {
        for squeeze in [0.1, 1.0, 3.0, 10.0, 100.0, 1000.0] {
            let linear = Linear::new(shape, squeeze);
            let (force, stiffness) = (linear.mean_overpressure() / 1.25, linear.mean_pressure().re);
            assert!(
                (force / stiffness - 1.0).abs() < 1e-3,
                "{shape:?} {squeeze}: {force} {stiffness}"
            );
        }
    }
}

#[test]
fn half_of_eq_14_needs_a_squeeze_number_of_3_or_9() {
    let strength = |shape, squeeze| Linear::new(shape, squeeze).mean_overpressure() / 1.25;
    for (shape, squeeze) in [(Shape::Strip, 3.1), (Shape::Disc, 9.1)] {
        let half = strength(shape, squeeze);
        assert!((half - 0.5).abs() < 0.01, "{shape:?}: {half}");
    }
    // A fingertip, a strip of 1 mm and a ridge of 0.4 mm at a gap of 8 µm.
    for (shape, squeeze, expected) in [
        (Shape::Disc, 707.0, 0.95),
        (Shape::Strip, 1.85, 0.29),
        (Shape::Strip, 0.30, 0.012),
    ] {
        let found = strength(shape, squeeze);
        assert!((found / expected - 1.0).abs() < 0.03, "{squeeze}: {found}");
    }
}

fn assert_z_m(name: &str, state: &State, re: f64, im: f64) {
    let z_m = state.impedance + 7.01;
    let error = (z_m - Complex64::new(re, im)).norm();
    assert!(error < 0.1, "{name}: {z_m} at {} m", state.amplitude_m);
}

#[test]
fn the_impedances_of_the_page_are_those_of_the_laws() {
    let lossless = Law {
        film_loss_factor: Some(0.0),
        ..Law::default()
    };
    let trapped = Law {
        trapped: 1.0,
        ..lossless
    };
    let tenth = Law {
        trapped: 0.1,
        ..Law::default()
    };
    let relative = Law {
        relative: 1.0,
        ..Law::default()
    };
    let averaged = Law {
        averaged: 1.0,
        ..Law::default()
    };
    for (name, finger, law, expected) in [
        (
            "published",
            AVERAGE,
            Law::default(),
            [(9.3, -2.4), (7.7, -1.3), (7.2, -0.4)],
        ),
        (
            "lossless",
            AVERAGE,
            lossless,
            [(9.3, -2.4), (7.5, -1.4), (7.0, -0.5)],
        ),
        (
            "averaged",
            AVERAGE,
            averaged,
            [(9.3, -2.4), (7.7, -1.4), (7.2, -0.5)],
        ),
        (
            "relative",
            AVERAGE,
            relative,
            [(9.2, -2.4), (7.4, -0.9), (7.2, -0.4)],
        ),
        (
            "tenth",
            AVERAGE,
            tenth,
            [(14.1, 2.5), (12.3, -2.3), (8.1, -1.7)],
        ),
        (
            "published, skin of Fig. 3",
            OF_FIG_3,
            Law::default(),
            [(7.6, -1.7), (7.4, -1.0), (7.1, -0.4)],
        ),
        (
            "trapped, skin of Fig. 3",
            OF_FIG_3,
            trapped,
            [(18.6, -19.4), (13.9, -16.2), (9.2, -9.9)],
        ),
    ] {
        for (amplitude_m, (re, im)) in [0.1e-6, 1e-6, 2e-6].into_iter().zip(expected) {
            assert_z_m(name, &law.state(&finger, amplitude_m), re, im);
        }
    }
}

#[test]
fn the_impedances_of_the_page_are_those_of_reynolds_equation() {
    let at = |finger: &Finger, outline| states(finger, outline, None, 4e-6, 40);
    let ridges = Outline::Ridges {
        groove_length_m: 5e-3,
    };
    for (name, finger, outline, expected) in [
        (
            "average",
            AVERAGE,
            Outline::Disc,
            [(7.8, 3.8), (7.8, 3.8), (7.8, 3.8)],
        ),
        (
            "skin of Fig. 3",
            OF_FIG_3,
            Outline::Disc,
            [(18.2, -17.7), (13.4, -14.0), (9.7, -8.4)],
        ),
        (
            "skin at rest",
            AT_REST,
            Outline::Disc,
            [(8.4, -18.7), (8.1, -14.9), (7.9, -8.9)],
        ),
        (
            "ridges",
            OF_FIG_3,
            ridges,
            [(12.4, -5.9), (12.3, -5.9), (12.1, -5.8)],
        ),
    ] {
        let states = at(&finger, outline);
        for (index, (re, im)) in [0, 9, 19].into_iter().zip(expected) {
            println!("{name} {:?}", states[index]);
            assert_z_m(name, &states[index], re, im);
        }
    }
}

/// Errors of the published laws, fitted to steady impedances under another law: σ_t and S in per cent, Z_t, residual.
#[test]
fn the_published_laws_fit_others_closely_and_wrongly() {
    let lossy = |factor| Law {
        film_loss_factor: Some(factor),
        ..Law::default()
    };
    let trapped = |share| Law {
        trapped: share,
        ..Law::default()
    };
    let wide = |width_m| Law {
        width: Some(Width {
            width_m,
            wavelength_m: WAVELENGTH_M,
        }),
        ..Law::default()
    };
    let averaged = Law {
        averaged: 1.0,
        ..Law::default()
    };
    let relative = Law {
        relative: 0.1,
        ..Law::default()
    };
    for (name, law, sigma, area, z_t, rms) in [
        ("published", Law::default(), 0.0, 0.0, (0.47, 3.16), 0.0),
        (
            "film without loss",
            lossy(0.0),
            -13.5,
            -19.8,
            (1.72, 2.27),
            0.0120,
        ),
        (
            "film with loss 0.6",
            lossy(0.6),
            -6.3,
            -13.1,
            (-1.25, 5.53),
            0.0037,
        ),
        ("I0", averaged, 6.2, -0.2, (0.31, 2.88), 0.0012),
        (
            "a tenth of the relative motion",
            relative,
            8.7,
            1.9,
            (0.27, 2.78),
            0.0028,
        ),
        (
            "0.5 % trapped",
            trapped(0.005),
            -8.3,
            -21.1,
            (0.59, 3.33),
            0.0005,
        ),
        (
            "2 % trapped",
            trapped(0.02),
            -25.4,
            -56.2,
            (0.83, 3.59),
            0.0023,
        ),
        (
            "10 % trapped",
            trapped(0.1),
            -77.1,
            -95.4,
            (2.73, 4.24),
            0.0282,
        ),
        ("4 mm wide", wide(4e-3), 7.4, 6.1, (0.47, 2.95), 0.0001),
        ("8 mm wide", wide(8e-3), 18.9, -0.8, (0.84, 2.72), 0.0014),
        ("12 mm wide", wide(12e-3), -5.1, -64.6, (3.20, 1.10), 0.0036),
    ] {
        let fitted = fit(&law);
        let finger = fitted.finger;
        let error = |found: f64, truth: f64| 100.0 * (found / truth - 1.0);
        let sigma_error = error(finger.sigma_t_m, AVERAGE.sigma_t_m);
        let area_error = error(finger.area_m2, AVERAGE.area_m2);
        assert!(
            (sigma_error - sigma).abs() < 0.5
                && (area_error - area).abs() < 0.5
                && (finger.z_t - Complex64::new(z_t.0, z_t.1)).norm() < 0.03
                && (fitted.rms - rms).abs() < 0.0001,
            "{name}: {sigma_error} {area_error} {finger:?} {}",
            fitted.rms
        );
    }
}
