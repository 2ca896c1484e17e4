//! Fig. 15: estimated against measured friction.

use super::drawn::Drawn;
use super::elements::{assumed, ink, marker, thinned};
use crate::analysed::Analysed;
use crate::estimate::{InstanceAnalysis, Method};
use crate::statistics::r_squared;
use figures::{Axis, Figure, Key, Panel, Series};
use figures::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned out.
const DRAWN: usize = 4000;

/// Measured and estimated friction of a sample.
type Pair = (f64, f64);

pub(super) fn figure(analysed: &Analysed, drawn: &Drawn) -> Figure {
    let samples = |method: Method| -> Vec<Pair> {
        analysed
            .instances()
            .flat_map(|(_, i)| {
                let estimated = i.estimated(method).series.mu.iter().copied();
                i.samples.mu().iter().copied().zip(estimated)
            })
            .collect()
    };
    // As published first, whichever lies on top elsewhere.
    let methods = Method::BOTH
        .into_iter()
        .filter(|m| drawn.methods.contains(m));
    let clouds: Vec<(Method, Vec<Pair>)> = methods.map(|m| (m, samples(m))).collect();
    let greatest = clouds
        .iter()
        .flat_map(|(_, samples)| samples)
        .flat_map(|&(measured, estimated)| [measured, estimated])
        .filter(|mu| mu.is_finite())
        .fold(0.0, f64::max);
    let n = clouds.first().map_or(0, |(_, samples)| samples.len());
    let step = n.div_ceil(DRAWN).max(1);
    let panels: Vec<Panel> = clouds
        .into_iter()
        .map(|(method, samples)| {
            let (measured, estimated): (Vec<f64>, Vec<f64>) = samples.iter().copied().unzip();
            let r2 = r_squared(&measured, &estimated);
            let drawn = samples.into_iter().step_by(step).collect();
            let axis = |label: &str| Axis::linear(label).between(0.0, 1.05 * greatest);
            let mut series = vec![
                Series::points(ink(method), marker(method), drawn).named(method.name()),
                Series::line(
                    Ink::Black,
                    Dash::Dashed,
                    vec![(0.0, 0.0), (2.0 * greatest, 2.0 * greatest)],
                )
                .named("slope 1"),
            ];
            if method == Method::Paper {
                let points = initialisation(analysed);
                series.push(
                    Series::points(Ink::Black, Marker::Triangle, points).named("initialisation"),
                );
            }
            Panel {
                series,
                notes: r2.map(|r2| format!("R² = {r2:.3}")).into_iter().collect(),
                ..Panel::new(axis("Measured μ"), axis("Estimated μ"))
            }
        })
        .collect();
    let of = panels.len();
    Figure {
        name: "fig15_agreement".to_owned(),
        title: "Estimated against measured friction".to_owned(),
        caption: format!(
            "Friction estimated from the observed impedance against measured friction, {n} samples of {} instances{}, by {}, with R² \
             about the line of slope 1 (Huloux 2021, Fig. 15, who give 0.93 and 0.98). {}{}",
            analysed.instances().count(),
            thinned(step),
            match (of, drawn.methods.first()) {
                (1, Some(Method::Paper)) => "the published method (paper)",
                (1, _) => "the dynamic method",
                _ => "(a) the published (paper) and (b) the dynamic method",
            },
            if drawn.methods.contains(&Method::Paper) {
                "Triangles: the samples from which the published method reads Zₜ, one for each instance at their mean. "
            } else {
                ""
            },
            assumed(&analysed.settings),
        ),
        width: Width::Page,
        columns: of.max(1),
        panel_height_mm: 70.0,
        key: Key::InPanels,
        panels,
    }
}

/// Returns, for each instance, the mean of the samples where `paper` reads Z_m⁰.
fn initialisation(analysed: &Analysed) -> Vec<Pair> {
    let of = |i: &InstanceAnalysis| -> Option<Pair> {
        let up_to_m = i.paper.rest?.up_to_amplitude_m;
        let pairs: Vec<Pair> = (0..i.samples.mu().len())
            .filter(|&k| {
                i.samples.amplitude_m(Method::Paper)[k] <= up_to_m
                    && i.paper.series.mu[k].is_finite()
            })
            .map(|k| (i.samples.mu()[k], i.paper.series.mu[k]))
            .collect();
        let n = pairs.len() as f64;
        let sum = pairs
            .iter()
            .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        (n > 0.0).then(|| (sum.0 / n, sum.1 / n))
    };
    analysed.instances().filter_map(|(_, i)| of(i)).collect()
}
