//! Figures of the film alone: its stiffness and loss at the carrier, and its mean force.

use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};

use super::law::{AVERAGE, Law, State};
use super::reynolds_finger::{Curves, MOST_M};
use crate::reynolds_world::film::{
    AMBIENT_PA, Film, Groove, Linear, OMEGA, RECORDED, Response, Shape, responses,
};

const AREA_M2: f64 = AVERAGE.area_m2;
const MICRO: f64 = 1e6;
/// Amplitude in the panels over the gap.
const AMPLITUDE_M: f64 = 1e-6;

/// A finger's film at a gap, with its name and line.
struct Kind {
    name: &'static str,
    ink: Ink,
    dash: Dash,
    half_width_m: f64,
    film: Film,
}

/// Films of a whole fingertip, of wide and narrow strips, and of ridges with closed and open grooves.
fn kinds() -> Vec<Kind> {
    let strip = Film::new(Shape::Strip, 1.0, 0.1);
    let ridge = |length_m: f64| Film {
        groove: Some(Groove {
            half_width_m: 60e-6,
            depth_m: 60e-6,
            length_m,
        }),
        ..strip
    };
    let kind = |name, ink, dash, half_width_m, film| Kind {
        name,
        ink,
        dash,
        half_width_m,
        film,
    };
    let radius_m = (AREA_M2 / std::f64::consts::PI).sqrt();
    vec![
        kind(
            "disc of 300 mm²",
            Ink::Blue,
            Dash::Solid,
            radius_m,
            Film::new(Shape::Disc, 1.0, 0.1),
        ),
        kind("strips of 1 mm", Ink::Green, Dash::Dashed, 0.5e-3, strip),
        kind(
            "ridges, grooves leak at their ends",
            Ink::Vermillion,
            Dash::DashDotted,
            0.2e-3,
            ridge(5e-3),
        ),
        kind(
            "ridges, grooves open",
            Ink::Orange,
            Dash::Dotted,
            0.2e-3,
            ridge(0.0),
        ),
    ]
}

fn spaced(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = (high / low).ln() / (count - 1) as f64;
    (0..count).map(|i| low * (step * i as f64).exp()).collect()
}

fn gaps_m() -> Vec<f64> {
    spaced(1.25e-6, 25e-6, 28)
}

/// Returns the response of a film at each gap and amplitude.
fn responses_at(kind: &Kind, places: &[(f64, f64)]) -> Vec<Response> {
    let films: Vec<Film> = places
        .iter()
        .map(|&(gap_m, amplitude_m)| {
            kind.film
                .at_gap(kind.half_width_m, gap_m, amplitude_m / gap_m)
        })
        .collect();
    responses(&films, RECORDED)
}

const SQUEEZE: &str = "Squeeze number";
const RATIOS: [f64; 2] = [0.3, 0.8];

/// Panel of a response over the squeeze number: linear theory, and Reynolds' equation at two amplitudes over the gap.
fn over_squeeze(y: Axis, part: fn(&Response, f64) -> f64, linear: fn(&Linear) -> f64) -> Panel {
    let squeezes = spaced(0.01, 1e4, 61);
    let theory = |shape| -> Vec<(f64, f64)> {
        let at = |&squeeze: &f64| (squeeze, linear(&Linear::new(shape, squeeze)));
        squeezes.iter().map(at).collect()
    };
    let points = |ratio: f64| -> Vec<(f64, f64)> {
        let squeezes = spaced(0.01, 1e4, 13);
        let films: Vec<Film> = squeezes
            .iter()
            .map(|&squeeze| Film::new(Shape::Strip, squeeze, ratio))
            .collect();
        let values = responses(&films, RECORDED);
        squeezes
            .into_iter()
            .zip(values.iter().map(|response| part(response, ratio)))
            .collect()
    };
    Panel {
        series: vec![
            Series::line(Ink::Black, Dash::Solid, theory(Shape::Strip))
                .with_name("strip, small amplitude"),
            Series::line(Ink::Blue, Dash::Dashed, theory(Shape::Disc))
                .with_name("disc, small amplitude"),
            Series::points(Ink::Green, Marker::Circle, points(RATIOS[0]))
                .with_name("strip, a/x = 0.3"),
            Series::points(Ink::Orange, Marker::Disc, points(RATIOS[1]))
                .with_name("strip, a/x = 0.8"),
        ],
        ..Panel::new(Axis::logarithmic(SQUEEZE), y)
    }
}

fn level(value: f64) -> Vec<(f64, f64)> {
    vec![(0.01, value), (1e4, value)]
}

/// Stiffness and loss of the film at the carrier.
pub fn stiffness() -> Figure {
    let relative = |label: &str| Axis::logarithmic(label).with_range(1e-3, 5.0);
    let mut stiffness = over_squeeze(
        relative("Stiffness · x/(p₀ S)"),
        |response, ratio| response.carrier.re / ratio,
        |linear| linear.mean_pressure().re,
    );
    let published = RATIOS.map(|ratio| 2.5 * ratio * ratio);
    stiffness.series.push(
        Series::line(Ink::Vermillion, Dash::DashDotted, level(published[0]))
            .with_name("Eq. 18, a/x = 0.3"),
    );
    stiffness.series.push(
        Series::line(Ink::Vermillion, Dash::Dotted, level(published[1]))
            .with_name("Eq. 18, a/x = 0.8"),
    );
    let mut loss = over_squeeze(
        relative("Loss · x/(p₀ S)"),
        |response, ratio| response.carrier.im / ratio,
        |linear| linear.mean_pressure().im,
    );
    loss.series.push(
        Series::line(
            Ink::Grey,
            Dash::Dotted,
            spaced(0.01, 3.0, 5)
                .into_iter()
                .map(|squeeze| (squeeze, squeeze / 3.0))
                .collect(),
        )
        .with_name("strip, incompressible"),
    );
    let gaps_m = gaps_m();
    let places: Vec<(f64, f64)> = gaps_m.iter().map(|&gap_m| (gap_m, AMPLITUDE_M)).collect();
    let gap = || Axis::linear("Gap x (µm)").with_range(0.0, 20.0);
    let mut by_gap = [
        Panel::new(
            gap(),
            Axis::logarithmic("Stiffness (N/µm)").with_range(1e-3, 30.0),
        ),
        Panel::new(
            gap(),
            Axis::logarithmic("Loss (N·s/m)").with_range(1e-3, 100.0),
        ),
    ];
    let law = |value: fn(f64) -> f64| -> Vec<(f64, f64)> {
        gaps_m
            .iter()
            .map(|&gap_m| (gap_m * MICRO, value(gap_m)))
            .collect()
    };
    let trapped = law(|gap_m| AMBIENT_PA * AREA_M2 / gap_m / MICRO);
    let eq_18 = |gap_m: f64| 2.5 * AMBIENT_PA * AREA_M2 * AMPLITUDE_M.powi(2) / gap_m.powi(3);
    by_gap[0].series = vec![
        Series::line(Ink::Grey, Dash::Solid, trapped).with_name("p₀ S/x"),
        Series::line(
            Ink::Black,
            Dash::Solid,
            gaps_m
                .iter()
                .map(|&x| (x * MICRO, eq_18(x) / MICRO))
                .collect(),
        )
        .with_name("Eq. 18"),
    ];
    by_gap[1].series = vec![
        Series::line(
            Ink::Black,
            Dash::Solid,
            gaps_m
                .iter()
                .map(|&x| (x * MICRO, 0.3 * eq_18(x) / OMEGA))
                .collect(),
        )
        .with_name("0.3 of Eq. 18"),
    ];
    for kind in kinds() {
        let values = responses_at(&kind, &places);
        let curve = |part: fn(&Response) -> f64, unit: f64| -> Vec<(f64, f64)> {
            gaps_m
                .iter()
                .zip(&values)
                .map(|(gap_m, response)| {
                    (
                        gap_m * MICRO,
                        part(response) * AMBIENT_PA * AREA_M2 / AMPLITUDE_M / unit,
                    )
                })
                .collect()
        };
        let line = |points| Series::line(kind.ink, kind.dash, points).with_name(kind.name);
        by_gap[0]
            .series
            .push(line(curve(|response| response.carrier.re, MICRO)));
        by_gap[1]
            .series
            .push(line(curve(|response| response.carrier.im, OMEGA)));
    }
    let [stiffness_by_gap, loss_by_gap] = by_gap;
    Figure {
        name: "laws_film_at_the_carrier".to_owned(),
        title: "Stiffness and loss of the film at the carrier".to_owned(),
        caption: "(a) Stiffness and (b) loss of a gas film at the carrier, over those of trapped gas, p₀ S/x, against the \
                  squeeze number; lines: linear theory (Langlois 1962); markers: Reynolds' equation at two amplitudes a over \
                  gap x; Eq. 18 of Huloux 2021 is the stiffness of the mean force. (c) Stiffness and (d) loss against the gap \
                  at an amplitude of 1 µm, over 300 mm² at 35 kHz, for a disc, for strips 1 mm wide, and for ridges 0.4 mm \
                  wide with grooves 0.12 mm wide and 60 µm deep, whose ends are 5 mm away or which are at ambient pressure. \
                  Assumed: p₀ = 101325 Pa, viscosity 18.2 µPa·s."
            .to_owned(),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 55.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![stiffness, loss, stiffness_by_gap, loss_by_gap],
    }
}

/// Returns the curves of μ/μ0 over the amplitude.
fn friction(states: &[State]) -> Vec<(f64, f64)> {
    states
        .iter()
        .map(|state| (state.amplitude_m * MICRO, state.asperity_share))
        .collect()
}

/// Mean force of the film, and the friction that it leaves.
pub fn force(curves: &Curves) -> Figure {
    let mut over_eq_14 = over_squeeze(
        Axis::linear("Mean force over Eq. 14").with_range(-0.1, 1.6),
        |response, ratio| response.mean / (1.25 * ratio * ratio),
        |linear| linear.mean_overpressure() / 1.25,
    );
    over_eq_14
        .series
        .push(Series::line(Ink::Vermillion, Dash::DashDotted, level(1.0)).with_name("Eq. 14"));
    const GAP_M: f64 = 8e-6;
    let amplitudes_m: Vec<f64> = (1..=20).map(|i| 0.3e-6 * f64::from(i)).collect();
    let eq_14 =
        |gap_m: f64, amplitude_m: f64| 1.25 * AMBIENT_PA * AREA_M2 * (amplitude_m / gap_m).powi(2);
    let mut by_amplitude = Panel::new(
        Axis::linear("Amplitude (µm)").with_range(0.0, 6.0),
        Axis::linear("Mean force (N)").with_range(-2.0, 30.0),
    );
    let published: Vec<(f64, f64)> = amplitudes_m
        .iter()
        .map(|&a| (a * MICRO, eq_14(GAP_M, a)))
        .collect();
    by_amplitude
        .series
        .push(Series::line(Ink::Black, Dash::Solid, published).with_name("Eq. 14"));
    let gaps_m = gaps_m();
    let mut by_gap = Panel::new(
        Axis::logarithmic("Gap x (µm)"),
        Axis::logarithmic("Mean force (N)").with_range(1e-3, 30.0),
    );
    let published: Vec<(f64, f64)> = gaps_m
        .iter()
        .map(|&x| (x * MICRO, eq_14(x, AMPLITUDE_M)))
        .collect();
    by_gap
        .series
        .push(Series::line(Ink::Black, Dash::Solid, published).with_name("Eq. 14"));
    for kind in kinds() {
        let line = |points| Series::line(kind.ink, kind.dash, points).with_name(kind.name);
        let places: Vec<(f64, f64)> = amplitudes_m.iter().map(|&a| (GAP_M, a)).collect();
        let newtons = |response: &Response| response.mean * AMBIENT_PA * AREA_M2;
        let values = responses_at(&kind, &places);
        let curve = amplitudes_m
            .iter()
            .zip(&values)
            .map(|(a, r)| (a * MICRO, newtons(r)));
        by_amplitude.series.push(line(curve.collect()));
        let places: Vec<(f64, f64)> = gaps_m.iter().map(|&x| (x, AMPLITUDE_M)).collect();
        let values = responses_at(&kind, &places);
        // A logarithmic axis has no place for a force that pulls.
        let curve = gaps_m.iter().zip(&values).map(|(x, r)| {
            let force_n = newtons(r);
            (x * MICRO, if force_n > 0.0 { force_n } else { f64::NAN })
        });
        by_gap.series.push(line(curve.collect()));
    }
    Figure {
        name: "laws_mean_force".to_owned(),
        title: "Mean force of the film".to_owned(),
        caption: "(a) Mean force of the film over Eq. 14 of Huloux 2021 against the squeeze number: second-order theory \
                  (Minikes and Bucher 2006) and Reynolds' equation at two amplitudes a over gap x. (b) Mean force against the \
                  amplitude at a gap of 8 µm, (c) against the gap at 1 µm, for the fingers of the figure before; the ridges' \
                  film pulls where its curve in (c) is absent. (d) Friction in steady state against the plate's amplitude. \
                  Assumed: S = 300 mm², σₜ = 1.7 µm, q₀ = 1.4e4 rad/m, E = 20 MPa, ν = 0.5, η = 0.3, 0.65 N; published average \
                  of the skin 0.47 + 3.16i N·s/m, skin of Fig. 3 0.1 g and 32 N·s/m."
            .to_owned(),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 55.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![over_eq_14, by_amplitude, by_gap, friction_panel(curves)],
    }
}

fn friction_panel(curves: &Curves) -> Panel {
    let published: Vec<State> = (1..=60)
        .map(|i| Law::default().state(&AVERAGE, MOST_M * f64::from(i) / 60.0))
        .collect();
    let series = [
        (Ink::Black, Dash::Solid, &published, "Eqs. 14–19"),
        (
            Ink::Blue,
            Dash::Solid,
            &curves.disc_average,
            "disc, average skin",
        ),
        (
            Ink::Blue,
            Dash::Dashed,
            &curves.disc_of_fig_3,
            "disc, skin of Fig. 3",
        ),
        (
            Ink::Green,
            Dash::Dashed,
            &curves.strips,
            "strips of 1 mm, skin of Fig. 3",
        ),
        (
            Ink::Vermillion,
            Dash::DashDotted,
            &curves.leaking_ridges,
            "ridges, leaking grooves, Fig. 3",
        ),
        (
            Ink::Orange,
            Dash::Dotted,
            &curves.open_ridges,
            "ridges, open grooves, Fig. 3",
        ),
    ];
    Panel {
        series: series
            .map(|(ink, dash, states, name)| {
                Series::line(ink, dash, friction(states)).with_name(name)
            })
            .into(),
        ..Panel::new(
            Axis::linear("Plate amplitude (µm)").with_range(0.0, MOST_M * MICRO),
            Axis::linear("μ/μ₀").with_range(0.0, 2.0),
        )
    }
}
