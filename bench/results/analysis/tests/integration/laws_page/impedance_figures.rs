//! Figures of Z_m: over the amplitude under each law, and of a finger with a width across the plate's mode.

use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};

use super::law::{AVERAGE, Finger, Law, OF_FIG_3, State, Width as FingerWidth};
use super::reynolds_finger::{Curves, WAVELENGTH_M, WIDTHS_M};

const MICRO: f64 = 1e6;
/// b_p of the paper's plate, N·s/m: Z_p at resonance.
const PLATE: f64 = 7.01;
const MOST_M: f64 = 4e-6;

/// States of a finger under one law, with name and line.
struct Curve {
    name: &'static str,
    ink: Ink,
    dash: Dash,
    states: Vec<State>,
}

fn curve(name: &'static str, ink: Ink, dash: Dash, states: Vec<State>) -> Curve {
    Curve {
        name,
        ink,
        dash,
        states,
    }
}

fn by_law(finger: &Finger, law: Law) -> Vec<State> {
    let count = 80;
    (1..=count)
        .map(|i| law.state(finger, MOST_M * f64::from(i) / f64::from(count)))
        .collect()
}

fn amplitude() -> Axis {
    Axis::linear("Plate amplitude (µm)").with_range(0.0, MOST_M * MICRO)
}

fn lines(curves: &[Curve], value: impl Fn(&State) -> f64) -> Vec<Series> {
    curves
        .iter()
        .map(|curve| {
            let points = curve.states.iter();
            let points = points.map(|state| (state.amplitude_m * MICRO, value(state)));
            Series::line(curve.ink, curve.dash, points.collect()).with_name(curve.name)
        })
        .collect()
}

/// Panels of Re Z_m and −Im Z_m, with the printed value at rest.
fn impedance_panels(curves: &[Curve]) -> [Panel; 2] {
    let printed = |value| {
        Series::points(Ink::Black, Marker::Triangle, vec![(0.1, value)])
            .with_name("printed, at rest")
    };
    let mut real = Panel::new(
        amplitude().without_labels(),
        Axis::linear("Re Zₘ (N·s/m)").with_range(0.0, 25.0),
    );
    real.series = lines(curves, |state| PLATE + state.impedance.re);
    real.series.push(printed(10.0));
    let mut imaginary = Panel::new(
        amplitude(),
        Axis::linear("−Im Zₘ (N·s/m)").with_range(-6.0, 30.0),
    );
    imaginary.series = lines(curves, |state| -state.impedance.im);
    imaginary.series.push(printed(20.0));
    [real, imaginary]
}

/// Z_m over the amplitude, as in Fig. 13a of the paper.
pub fn impedance(curves: &Curves) -> Figure {
    let trapped = Law {
        trapped: 1.0,
        film_loss_factor: Some(0.0),
        ..Law::default()
    };
    let averages = [
        curve(
            "Eqs. 14–18",
            Ink::Black,
            Dash::Solid,
            by_law(&AVERAGE, Law::default()),
        ),
        curve(
            "film without loss",
            Ink::Blue,
            Dash::Dashed,
            by_law(
                &AVERAGE,
                Law {
                    film_loss_factor: Some(0.0),
                    ..Law::default()
                },
            ),
        ),
        curve(
            "I₀ average",
            Ink::Green,
            Dash::Dotted,
            by_law(
                &AVERAGE,
                Law {
                    averaged: 1.0,
                    ..Law::default()
                },
            ),
        ),
        curve(
            "relative motion",
            Ink::Orange,
            Dash::DashDotted,
            by_law(
                &AVERAGE,
                Law {
                    relative: 1.0,
                    ..Law::default()
                },
            ),
        ),
        curve(
            "10 % of the air trapped",
            Ink::Vermillion,
            Dash::Dashed,
            by_law(
                &AVERAGE,
                Law {
                    trapped: 0.1,
                    ..Law::default()
                },
            ),
        ),
        curve(
            "Reynolds, disc",
            Ink::Grey,
            Dash::Solid,
            curves.disc_average.clone(),
        ),
    ];
    let of_fig_3 = [
        curve(
            "Eqs. 14–18",
            Ink::Black,
            Dash::Solid,
            by_law(&OF_FIG_3, Law::default()),
        ),
        curve(
            "all air trapped, no loss",
            Ink::Vermillion,
            Dash::Dashed,
            by_law(&OF_FIG_3, trapped),
        ),
        curve(
            "Reynolds, disc, skin at rest",
            Ink::Orange,
            Dash::DashDotted,
            curves.disc_at_rest.clone(),
        ),
        curve(
            "Reynolds, disc",
            Ink::Grey,
            Dash::Solid,
            curves.disc_of_fig_3.clone(),
        ),
        curve(
            "Reynolds, strips of 1 mm",
            Ink::Green,
            Dash::Dashed,
            curves.strips.clone(),
        ),
        curve(
            "Reynolds, ridges",
            Ink::Blue,
            Dash::Dotted,
            curves.leaking_ridges.clone(),
        ),
    ];
    let [average_real, average_imaginary] = impedance_panels(&averages);
    let [skin_real, skin_imaginary] = impedance_panels(&of_fig_3);
    Figure {
        name: "laws_impedance".to_owned(),
        title: "Impedance against amplitude under several laws".to_owned(),
        caption: "Z_m in steady state against the plate's amplitude, to compare with Fig. 13a of Huloux 2021, whose values at rest \
                  the text gives as close to 10 and 20 N·s/m (triangles). (a, c) Skin of the published average, 0.47 + 3.16i N·s/m; \
                  (b, d) skin of the paper's Fig. 3, 0.1 g and 32 N·s/m. Assumed: S = 300 mm², σₜ = 1.7 µm, q₀ = 1.4e4 rad/m, \
                  E = 20 MPa, ν = 0.5, η = 0.3, 0.65 N, Zₚ = 7.01 N·s/m."
            .to_owned(),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 55.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![average_real, skin_real, average_imaginary, skin_imaginary],
    }
}

/// A finger with a width across the mode.
pub fn width(curves: &Curves) -> Figure {
    let of_width = |width_m: f64| FingerWidth {
        width_m,
        wavelength_m: WAVELENGTH_M,
    };
    let moments: Vec<(f64, (f64, f64))> = (0..=28)
        .map(|i| 0.5e-3 * f64::from(i))
        .map(|width_m| (width_m * 1e3, of_width(width_m).moments()))
        .collect();
    let moment = |ink, dash, name: &str, value: fn(&(f64, f64)) -> f64| {
        let points = moments
            .iter()
            .map(|(width, moments)| (*width, value(moments)));
        Series::line(ink, dash, points.collect()).with_name(name)
    };
    let shares = Panel {
        series: vec![
            moment(
                Ink::Black,
                Dash::Solid,
                "⟨φ²⟩: mean force",
                |moments| moments.1,
            ),
            moment(Ink::Blue, Dash::Dashed, "⟨φ⟩²", |moments| {
                moments.0.powi(2)
            }),
            moment(
                Ink::Vermillion,
                Dash::DashDotted,
                "⟨φ²⟩ − ⟨φ⟩²",
                |moments| moments.1 - moments.0.powi(2),
            ),
        ],
        ..Panel::new(
            Axis::linear("Width of the contact (mm)").with_range(0.0, 14.0),
            Axis::linear("Mean over the contact").with_range(0.0, 1.2),
        )
    };
    const STYLES: [(&str, Ink, Dash); WIDTHS_M.len()] = [
        ("narrow", Ink::Black, Dash::Solid),
        ("4 mm", Ink::Blue, Dash::Dashed),
        ("8 mm", Ink::Orange, Dash::DashDotted),
        ("12 mm", Ink::Vermillion, Dash::Dotted),
    ];
    let styled = |states: Vec<Vec<State>>| -> Vec<Curve> {
        let styles = states.into_iter().zip(STYLES);
        styles
            .map(|(states, (name, ink, dash))| curve(name, ink, dash, states))
            .collect()
    };
    let by_width = WIDTHS_M.map(|width_m| {
        let width = Some(of_width(width_m)).filter(|_| width_m > 0.0);
        by_law(
            &AVERAGE,
            Law {
                width,
                ..Law::default()
            },
        )
    });
    let (published, reynolds) = (styled(by_width.into()), styled(curves.wide.clone()));
    let friction = Panel {
        series: lines(&published, |state| state.asperity_share),
        ..Panel::new(
            amplitude(),
            Axis::linear("μ/μ₀, Eqs. 14–19").with_range(0.0, 1.2),
        )
    };
    let impedance = Panel {
        series: lines(&published, |state| state.impedance.norm()),
        ..Panel::new(
            amplitude(),
            Axis::linear("|Zₘ − Zₚ|, Eqs. 14–18 (N·s/m)").from_zero(),
        )
    };
    let on_film = Panel {
        series: lines(&reynolds, |state| state.impedance.norm()),
        ..Panel::new(
            amplitude(),
            Axis::linear("|Zₘ − Zₚ|, Reynolds (N·s/m)").from_zero(),
        )
    };
    Figure {
        name: "laws_width".to_owned(),
        title: "A finger with a width across the plate's mode".to_owned(),
        caption: "(a) Means over an elliptical contact of the mode φ = cos(2πy/λ), λ = 22 mm, and of its square, against the \
                  width. (b) Friction and (c) the finger's part of Z_m against the amplitude at the crest, with Eqs. 14–19 in \
                  each strip, one gap, and a skin of the published average that moves as one. (d) The finger's part on a \
                  Reynolds film of 10 mm along the plate, with a gap and a skin (0.1 g, 32 N·s/m) in each of five places. \
                  Assumed: S = 300 mm² in all, other constants as in the figure before."
            .to_owned(),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 50.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![shares, friction, impedance, on_film],
    }
}
