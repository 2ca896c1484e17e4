//! Fig. 15: estimated against measured friction.

use crate::measured::elements::{assumption_note, ink, marker, thinning_note};
use crate::measured::figure_selection::FigureSelection;
use analysis::estimate::{InstanceAnalysis, Method};
use analysis::findings::Analysis;
use analysis::statistics::r_squared;
use plotting::{Axis, Figure, Key, Panel, Series};
use plotting::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned.
const MAX_SAMPLES: usize = 4000;

/// Measured and estimated friction of a sample.
type Pair = (f64, f64);

pub(super) fn figure(analysed: &Analysis, selection: &FigureSelection) -> Figure {
    let samples = |method: Method| -> Vec<Pair> {
        analysed
            .instances()
            .filter_map(|(_, i)| i.estimate_by(method))
            .flat_map(|instance| {
                let estimated = instance.estimate.series.mu.iter().copied();
                instance
                    .instance
                    .samples
                    .mu()
                    .iter()
                    .copied()
                    .zip(estimated)
            })
            .collect()
    };
    // The published method first, regardless of the order in other figures.
    let methods = Method::ALL
        .into_iter()
        .filter(|m| selection.methods.contains(m));
    let clouds: Vec<(Method, Vec<Pair>)> = methods.map(|m| (m, samples(m))).collect();
    let greatest = clouds
        .iter()
        .flat_map(|(_, samples)| samples)
        .flat_map(|&(measured, estimated)| [measured, estimated])
        .filter(|mu| mu.is_finite())
        .fold(0.0, f64::max);
    let n = clouds.first().map_or(0, |(_, samples)| samples.len());
    let step = n.div_ceil(MAX_SAMPLES).max(1);
    let names = method_list(&clouds);
    let panels: Vec<Panel> = clouds
        .into_iter()
        .map(|(method, samples)| {
            let (measured, estimated): (Vec<f64>, Vec<f64>) = samples.iter().copied().unzip();
            let r2 = r_squared(&measured, &estimated);
            let shown_samples = samples.into_iter().step_by(step).collect();
            let axis = |label: &str| Axis::linear(label).with_range(0.0, 1.05 * greatest);
            let mut series = vec![
                Series::points(ink(method), marker(method), shown_samples).with_name(method.name()),
                Series::line(
                    Ink::Black,
                    Dash::Dashed,
                    vec![(0.0, 0.0), (2.0 * greatest, 2.0 * greatest)],
                )
                .with_name("slope 1"),
            ];
            if method == Method::Paper {
                let points = initialisation(analysed);
                series.push(
                    Series::points(Ink::Black, Marker::Triangle, points).with_name("Zₜ read here"),
                );
            }
            Panel {
                series,
                notes: r2.map(|r2| format!("R² = {r2:.3}")).into_iter().collect(),
                ..Panel::new(axis("Measured μ"), axis("Estimated μ"))
            }
        })
        .collect();
    let n_panels = panels.len();
    Figure {
        name: "fig15_agreement".to_owned(),
        title: "Estimated against measured friction".to_owned(),
        caption: format!(
            "Friction estimated from the observed impedance against measured friction, {n} samples of {} instances{}, by {names}, with R² \
             about the line of slope 1 (Huloux 2021, Fig. 15, who give 0.93 and 0.98). {}{}",
            analysed.instances().count(),
            thinning_note(step),
            if selection.methods.contains(&Method::Paper) {
                "Triangles: the samples from which the published method reads Zₜ, one for each instance at their mean. "
            } else {
                ""
            },
            assumption_note(analysed, selection),
        ),
        width: Width::Page,
        columns: n_panels.max(1),
        panel_height_mm: if n_panels > 2 { 48.0 } else { 70.0 },
        footnote: None,
        key: Key::InPanels,
        panels,
    }
}

/// Returns a sentence on the methods, with the letters of their panels, and the number of samples where some are missing.
fn method_list(clouds: &[(Method, Vec<Pair>)]) -> String {
    let n_max = clouds.iter().map(|(_, samples)| samples.len()).max();
    let texts = clouds.iter().zip('a'..).map(|((method, samples), letter)| {
        let letter = match clouds.len() {
            1 => String::new(),
            _ => format!("({letter}) "),
        };
        let words = match method {
            Method::Paper => "the published method (paper)",
            Method::Dynamic => "the dynamic method",
            Method::Trial => "the fit of whole trials (trial)",
        };
        let sample_clause = match samples.len() {
            n if Some(n) == n_max => String::new(),
            n => format!(" of {n} samples"),
        };
        format!("{letter}{words}{sample_clause}")
    });
    let texts: Vec<String> = texts.collect();
    match texts.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// Returns, for each instance, the mean of the samples from which `paper` determines Z_m⁰.
fn initialisation(analysed: &Analysis) -> Vec<Pair> {
    let rest_mean = |i: &InstanceAnalysis| -> Option<Pair> {
        let paper = i.estimate(Method::Paper)?;
        let limit_m = paper.rest?.up_to_amplitude_m;
        let pairs: Vec<Pair> = (0..i.samples.mu().len())
            .filter(|&k| {
                i.samples.amplitude_m(Method::Paper)[k] <= limit_m && paper.series.mu[k].is_finite()
            })
            .map(|k| (i.samples.mu()[k], paper.series.mu[k]))
            .collect();
        let n = pairs.len() as f64;
        let sum = pairs
            .iter()
            .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        (n > 0.0).then(|| (sum.0 / n, sum.1 / n))
    };
    analysed
        .instances()
        .filter_map(|(_, i)| rest_mean(i))
        .collect()
}
