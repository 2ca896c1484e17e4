//! A finger over a Reynolds film in steady state, over the amplitude of the plate.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::process::Command;

use num_complex::Complex64;

use super::law::{Finger, State, Width};
use crate::reynolds_world::programs::CURVE;

/// Shape of the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// A disc of the finger's area.
    Disc,
    /// Strips side by side.
    Strips { half_width_m: f64 },
    /// Ridges of 0.4 mm between grooves 0.12 mm wide and 60 µm deep.
    Ridges { groove_length_m: f64 },
}

/// Returns the steady states at `points` amplitudes up to `most_m`, or fewer if the curve ends before.
pub fn states(
    finger: &Finger,
    outline: Outline,
    width: Option<Width>,
    most_m: f64,
    points: usize,
) -> Vec<State> {
    let (is_disc, half_width_m, groove) = match outline {
        Outline::Disc => (1.0, 0.0, [0.0; 3]),
        Outline::Strips { half_width_m } => (0.0, half_width_m, [0.0; 3]),
        Outline::Ridges { groove_length_m } => (0.0, 0.2e-3, [60e-6, 60e-6, groove_length_m]),
    };
    let numbers = [
        is_disc,
        finger.area_m2,
        half_width_m,
        groove[0],
        groove[1],
        groove[2],
        width.map_or(0.0, |width| width.width_m / 2.0),
        width.map_or(0.0, |width| width.wavelength_m),
        finger.normal_n,
        finger.sigma_t_m,
        finger.asperity_pa_per_m * finger.sigma_t_m,
        finger.loss_factor,
        finger.z_t.re,
        finger.z_t.im,
        most_m,
    ];
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(CURVE.compile(folder.path()))
        .args(numbers.iter().map(|number| format!("{number:e}")))
        .arg(points.to_string())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let states = text.lines().map(|line| {
        let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
        State {
            amplitude_m: numbers[0],
            gap_m: numbers[1],
            asperity_share: numbers[3] / finger.normal_n,
            impedance: Complex64::new(numbers[5], numbers[6]),
        }
    });
    states.collect()
}
