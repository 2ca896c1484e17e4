//! Fig. 15: estimated against measured friction.

use crate::measured::elements::{assumption_note, ink, marker, thinning_note};
use crate::measured::figure_selection::FigureSelection;
use analysis::estimate::{InstanceAnalysis, Method};
use analysis::findings::Analysis;
use analysis::sample_statistics::{ByMethod, estimated_samples};
use analysis::sampled_quantity::SampledQuantity;
use analysis::{MuAgreement, SeriesError, SeriesSource};
use plotting::{Axis, Figure, Key, Panel, Series};
use plotting::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned.
const MAX_SAMPLES: usize = 4000;

/// Measured and estimated friction of a sample.
type Pair = (f64, f64);

/// Draws the figure.
///
/// # Errors
/// The series cannot be read.
pub(super) fn figure(
    (analysed, series): (&Analysis, &dyn SeriesSource),
    selection: &FigureSelection,
) -> Result<Figure, SeriesError> {
    // The published method first, regardless of the order in other figures.
    let methods = Method::ALL
        .into_iter()
        .filter(|m| selection.methods.contains(m));
    let methods: Vec<Method> = methods.collect();
    let greatest = methods
        .iter()
        .flat_map(|method| greatest_of_instances(analysed, *method))
        .filter(|mu| mu.is_finite())
        .fold(0.0, f64::max);
    let counts: Vec<(Method, MuAgreement)> = methods
        .iter()
        .map(|method| (*method, *analysed.agreement.get(*method)))
        .collect();
    let n = counts.first().map_or(0, |(_, agreement)| agreement.samples);
    let step = n.div_ceil(MAX_SAMPLES).max(1);
    let names = method_list(&counts);
    let mut clouds = shown_samples(analysed, series, step)?;
    let panels: Vec<Panel> = counts
        .into_iter()
        .map(|(method, MuAgreement { r2, .. })| {
            let shown_samples = std::mem::take(clouds.get_mut(method));
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
    Ok(Figure {
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
    })
}

/// Returns the greatest measured and estimated friction of each instance that a method estimates.
fn greatest_of_instances(analysed: &Analysis, method: Method) -> impl Iterator<Item = f64> {
    let instances = analysed.instances();
    let estimates = instances.filter_map(move |(_, instance)| instance.estimate_by(method));
    estimates.flat_map(|fit| {
        let quantities = [SampledQuantity::Mu, SampledQuantity::MuEstimated];
        quantities.map(|quantity| fit.estimate.extents.get(quantity).greatest)
    })
}

/// Returns every `step`th sample of all that each method estimates.
fn shown_samples(
    analysed: &Analysis,
    series: &dyn SeriesSource,
    step: usize,
) -> Result<ByMethod<Vec<Pair>>, SeriesError> {
    let mut shown = ByMethod::<Vec<Pair>>::default();
    let mut skipped = ByMethod::<usize>::default();
    for (number, findings) in analysed.numbered_findings() {
        if findings.instances.is_empty() {
            continue;
        }
        let series = series.read(number)?;
        for method in Method::ALL {
            let instances = estimated_samples(&findings.instances, &series.instances, method);
            for estimated in instances {
                let estimated_mu = &estimated.estimate.contact.mu;
                for pair in estimated.instance.samples.mu().iter().zip(estimated_mu) {
                    let skipped = skipped.get_mut(method);
                    if skipped.is_multiple_of(step) {
                        shown.get_mut(method).push((*pair.0, *pair.1));
                    }
                    *skipped += 1;
                }
            }
        }
    }
    Ok(shown)
}

/// Returns a sentence on the methods, with the letters of their panels, and the number of samples where some are missing.
fn method_list(counts: &[(Method, MuAgreement)]) -> String {
    let n_max = counts.iter().map(|(_, agreement)| agreement.samples).max();
    let texts = counts
        .iter()
        .zip('a'..)
        .map(|((method, agreement), letter)| {
            let letter = match counts.len() {
                1 => String::new(),
                _ => format!("({letter}) "),
            };
            let words = match method {
                Method::Paper => "the published method (paper)",
                Method::Dynamic => "the dynamic method",
                Method::Trial => "the fit of whole trials (trial)",
            };
            let sample_clause = match agreement.samples {
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
    let rest_mean = |i: &InstanceAnalysis| i.estimate(Method::Paper)?.mu_at_rest;
    analysed
        .instances()
        .filter_map(|(_, i)| rest_mean(i))
        .collect()
}
