//! Figures and numbers of docs/laws.md.

use num_complex::Complex64;

use super::drawn::require_same;
use super::film_figures;
use super::fitted::fit;
use super::impedance_figures::{self, WAVELENGTH_M};
use super::law::{AVERAGE, Law, OF_FIG_3, Width};
use super::reynolds_finger::{Outline, states};

#[test]
fn the_figures_of_the_film_are_those_of_the_page() {
    require_same(&film_figures::stiffness());
    require_same(&film_figures::force());
}

#[test]
fn the_figures_of_the_impedance_are_those_of_the_page() {
    require_same(&impedance_figures::impedance());
    require_same(&impedance_figures::width());
}

#[test]
fn fits_of_the_published_laws_to_others() {
    let width = |width_m| Law {
        width: Some(Width {
            width_m,
            wavelength_m: WAVELENGTH_M,
        }),
        ..Law::default()
    };
    for (name, law) in [
        ("published", Law::default()),
        (
            "lossless",
            Law {
                film_loss_factor: Some(0.0),
                ..Law::default()
            },
        ),
        (
            "loss .6",
            Law {
                film_loss_factor: Some(0.6),
                ..Law::default()
            },
        ),
        (
            "I0",
            Law {
                averaged: 1.0,
                ..Law::default()
            },
        ),
        (
            "relative .1",
            Law {
                relative: 0.1,
                ..Law::default()
            },
        ),
        (
            "relative 1",
            Law {
                relative: 1.0,
                ..Law::default()
            },
        ),
        (
            "trapped .005",
            Law {
                trapped: 0.005,
                ..Law::default()
            },
        ),
        (
            "trapped .02",
            Law {
                trapped: 0.02,
                ..Law::default()
            },
        ),
        (
            "trapped .1",
            Law {
                trapped: 0.1,
                ..Law::default()
            },
        ),
        ("width 4", width(4e-3)),
        ("width 8", width(8e-3)),
        ("width 12", width(12e-3)),
    ] {
        let fitted = fit(&law);
        let finger = fitted.finger;
        let mid = law.state(&AVERAGE, 1e-6);
        let est = Law::default().state(&finger, 1e-6);
        println!(
            "{name}: rms {:.4}, sigma {:+.1} %, S {:+.1} %, q {:+.1} %, eta {:.2}, Zt {:.2}, mu/mu0 {:.3} {:.3}",
            fitted.rms,
            100.0 * (finger.sigma_t_m / AVERAGE.sigma_t_m - 1.0),
            100.0 * (finger.area_m2 / AVERAGE.area_m2 - 1.0),
            100.0 * (finger.asperity_pa_per_m / AVERAGE.asperity_pa_per_m - 1.0),
            finger.loss_factor,
            finger.z_t,
            mid.asperity_share,
            est.asperity_share
        );
    }
    let _ = (Complex64::ZERO, OF_FIG_3, Outline::Disc);
    let _ = states;
}
