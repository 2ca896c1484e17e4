//! Fingers over a Reynolds film in steady state, over the amplitude of the plate.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use num_complex::Complex64;
use rayon::prelude::*;

use super::law::{AT_REST, AVERAGE, Finger, OF_FIG_3, State, Width};
use crate::reynolds_world::programs::CURVE;

/// Largest amplitude of the curves.
pub const MOST_M: f64 = 4.8e-6;
/// Number of amplitudes: a tenth of a micrometre apart.
const POINTS: usize = 48;
/// Wavelength across the paper's plate.
pub const WAVELENGTH_M: f64 = 22e-3;
/// Widths of the contact across the mode, for the fingers of a closed film.
pub const WIDTHS_M: [f64; 4] = [0.0, 4e-3, 8e-3, 12e-3];

/// Paths of the air.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Outline {
    /// A disc of the finger's area.
    Disc,
    /// Strips side by side.
    Strips { half_width_m: f64 },
    /// Ridges of 0.4 mm between grooves 0.12 mm wide and 60 µm deep.
    Ridges { groove_length_m: f64 },
}

/// Steady states of fingers, named by film and skin.
pub struct Curves {
    pub disc_average: Vec<State>,
    pub disc_of_fig_3: Vec<State>,
    pub disc_at_rest: Vec<State>,
    pub strips: Vec<State>,
    pub leaking_ridges: Vec<State>,
    pub open_ridges: Vec<State>,
    /// Strips of 10 mm with each of the widths, under the skin of Fig. 3.
    pub wide: Vec<Vec<State>>,
}

impl Curves {
    pub fn compute() -> Self {
        let of_fig_3 = [(OF_FIG_3, None)];
        let wide = WIDTHS_M.map(|width_m| {
            let width = Width {
                width_m,
                wavelength_m: WAVELENGTH_M,
            };
            (OF_FIG_3, Some(width))
        });
        let discs = [AVERAGE, OF_FIG_3, AT_REST].map(|finger| (finger, None));
        let strips = |half_width_m| Outline::Strips { half_width_m };
        let ridges = |groove_length_m| Outline::Ridges { groove_length_m };
        let films: [(Outline, &[(Finger, Option<Width>)]); 5] = [
            (Outline::Disc, &discs),
            (strips(0.5e-3), &of_fig_3),
            (ridges(5e-3), &of_fig_3),
            (ridges(0.0), &of_fig_3),
            (strips(5e-3), &wide),
        ];
        let curves: Vec<Vec<Vec<State>>> = films
            .into_par_iter()
            .map(|(outline, fingers)| states(outline, fingers))
            .collect();
        let [discs, strips, leaking, open, wide]: [Vec<Vec<State>>; 5] = curves.try_into().unwrap();
        let [disc_average, disc_of_fig_3, disc_at_rest] = discs.try_into().unwrap();
        let only = |curves: Vec<Vec<State>>| curves.into_iter().next().unwrap();
        Self {
            disc_average,
            disc_of_fig_3,
            disc_at_rest,
            strips: only(strips),
            leaking_ridges: only(leaking),
            open_ridges: only(open),
            wide,
        }
    }
}

/// Returns the steady states of fingers that differ in skin and width alone.
fn states(outline: Outline, fingers: &[(Finger, Option<Width>)]) -> Vec<Vec<State>> {
    let (is_disc, half_width_m, groove) = match outline {
        Outline::Disc => (1.0, 0.0, [0.0; 3]),
        Outline::Strips { half_width_m } => (0.0, half_width_m, [0.0; 3]),
        Outline::Ridges { groove_length_m } => (0.0, 0.2e-3, [60e-6, 60e-6, groove_length_m]),
    };
    let finger = fingers[0].0;
    let numbers = [
        is_disc,
        finger.area_m2,
        half_width_m,
        groove[0],
        groove[1],
        groove[2],
        0.0,
        finger.normal_n,
        finger.sigma_t_m,
        finger.asperity_pa_per_m * finger.sigma_t_m,
        finger.loss_factor,
        MOST_M,
    ];
    let folder = tempfile::tempdir().unwrap();
    let mut lines = String::new();
    for (finger, width) in fingers {
        let (half_length_m, wavelength_m) = width.map_or((0.0, 0.0), |width| {
            (width.width_m / 2.0, width.wavelength_m)
        });
        let z_t = finger.z_t;
        writeln!(
            lines,
            "{:e} {:e} {half_length_m:e} {wavelength_m:e}",
            z_t.re, z_t.im
        )
        .unwrap();
    }
    let input = folder.path().join("fingers");
    fs::write(&input, lines).unwrap();
    let output = Command::new(CURVE.compile(folder.path()))
        .args(numbers.iter().map(|number| format!("{number:e}")))
        .arg(POINTS.to_string())
        .stdin(fs::File::open(input).unwrap())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let curves: Vec<Vec<State>> = text
        .split_terminator("\n\n")
        .map(|curve| {
            curve
                .lines()
                .map(|line| state(line, finger.normal_n))
                .collect()
        })
        .collect();
    assert_eq!(curves.len(), fingers.len());
    curves
}

fn state(line: &str, normal_n: f64) -> State {
    let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
    State {
        amplitude_m: numbers[0],
        gap_m: numbers[1],
        asperity_share: numbers[3] / normal_n,
        impedance: Complex64::new(numbers[5], numbers[6]),
    }
}
