//! Fig. 13: impedance, stiffness, gap and friction of one exploration against amplitude and against measured friction.

use std::ops::Range;

use estimation::{EstimatedSeries, ModelledSeries};
use num_complex::Complex64;

use crate::measured::elements::{
    AMPLITUDE, FRICTION, GAP, MEASUREMENT, MICRO, MODEL, assumption_note, model_ink, points,
    recording_name, thinning_note, trial_note,
};
use crate::measured::figure_selection::FigureSelection;
use analysis::estimate::{InstanceAnalysis, Method};
use analysis::findings::{Analysis, RecordingFindings};
use analysis::instance::PreparedInstance;
use analysis::sample_statistics::estimated_samples;
use analysis::{RecordingSeries, averaged_models};
use plotting::{Axis, Figure, Key, Panel, Series};
use plotting::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned.
const MAX_SAMPLES: usize = 400;

type Value = fn(&MethodSamples<'_>, usize) -> f64;
type ModelValue = fn(&ModelledSeries, usize) -> f64;

/// Samples of an instance by a method.
struct MethodSamples<'a> {
    method: Method,
    samples: &'a PreparedInstance,
    contact: &'a EstimatedSeries,
    /// Model with the participant's average σ_t.
    averaged: Option<&'a ModelledSeries>,
}

impl MethodSamples<'_> {
    fn z_m(&self) -> &[Complex64] {
        self.samples.z_m(self.method)
    }
}

/// Quantity of the vertical axes.
struct Quantity {
    axis: Axis,
    value: Value,
    model: ModelValue,
}

fn amplitude(instance: &MethodSamples<'_>, sample: usize) -> f64 {
    instance.samples.amplitude_m(instance.method)[sample] * MICRO
}

fn measured_mu(instance: &MethodSamples<'_>, sample: usize) -> f64 {
    instance.samples.mu()[sample]
}

fn quantities() -> [Quantity; 5] {
    [
        Quantity {
            axis: Axis::linear("Re Zₘ (N·s/m)"),
            value: |instance, k| instance.z_m()[k].re,
            model: |model, k| model.z_m_n_s_per_m[k].re,
        },
        Quantity {
            axis: Axis::linear("−Im Zₘ (N·s/m)"),
            value: |instance, k| -instance.z_m()[k].im,
            model: |model, k| -model.z_m_n_s_per_m[k].im,
        },
        Quantity {
            axis: Axis::logarithmic("Stiffness (N/µm)"),
            value: |instance, k| instance.contact.k_c_n_per_m[k] / MICRO,
            model: |model, k| model.k_c_n_per_m[k] / MICRO,
        },
        Quantity {
            axis: Axis::linear(GAP).from_zero(),
            value: |instance, k| instance.contact.gap_m[k] * MICRO,
            model: |model, k| model.gap_m[k] * MICRO,
        },
        Quantity {
            axis: Axis::linear(FRICTION).from_zero(),
            value: |instance, k| instance.contact.mu[k],
            model: |model, k| model.mu[k],
        },
    ]
}

/// Returns the instances to draw: of the exploration with the most instances (the first of equals), or of the whole
/// trial.
fn selected_instances(findings: &RecordingFindings, selection: &FigureSelection) -> Range<usize> {
    if selection.whole_trial {
        return 0..findings.instances.len();
    }
    let mut start = 0;
    let chunks = findings
        .instances
        .chunk_by(|a, b| a.exploration == b.exploration)
        .map(|chunk| {
            start += chunk.len();
            start - chunk.len()..start
        });
    let chunks: Vec<Range<usize>> = chunks.collect();
    let most = chunks.into_iter().rev().max_by_key(Range::len);
    most.unwrap_or_default()
}

/// Draws the figure; `None` for a recording without instances.
pub(super) fn figure(
    findings: &RecordingFindings,
    recording: &RecordingSeries,
    analysed: &Analysis,
    selection: &FigureSelection,
) -> Option<Figure> {
    let numbers = selected_instances(findings, selection);
    let instances = &findings.instances[numbers.clone()];
    let methods = selection.method_pair(instances);
    if instances.is_empty() || methods.is_empty() {
        return None;
    }
    let samples: usize = instances.iter().map(|i| i.samples).sum();
    let models = averaged_models(findings, recording, &analysed.settings);
    let estimated = |method: Method| {
        let shown = numbers.clone();
        let all = estimated_samples(&findings.instances, &recording.instances, method);
        let models = &models;
        all.filter(move |estimated| shown.contains(&estimated.number))
            .map(move |estimated| MethodSamples {
                method,
                samples: &estimated.instance.samples,
                contact: &estimated.estimate.contact,
                averaged: models
                    .get(estimated.number)
                    .and_then(|models| models.get(method).as_ref()),
            })
    };
    let step = samples.div_ceil(MAX_SAMPLES).max(1);
    let cloud = |x: Value, y: Value, method: Method, step: usize| -> Vec<(f64, f64)> {
        let instance_points = |instance: MethodSamples<'_>| -> Vec<(f64, f64)> {
            (0..instance.samples.time_s().len())
                .map(|k| (x(&instance, k), y(&instance, k)))
                .collect()
        };
        let instances = estimated(method);
        instances.flat_map(instance_points).step_by(step).collect()
    };
    // Broken between instances. Against friction, the model's impedance is drawn over the model's friction.
    let curve = |y: ModelValue, over_mu: bool, method: Method| -> Series {
        let mut line = Vec::new();
        for instance in estimated(method) {
            if let Some(model) = instance.averaged {
                line.extend((0..model.mu.len()).map(|k| {
                    let x = if over_mu {
                        model.mu[k]
                    } else {
                        amplitude(&instance, k)
                    };
                    (x, y(model, k))
                }));
                line.push((f64::NAN, f64::NAN));
            }
        }
        let (ink, dash) = model_ink(method);
        Series::line(ink, dash, line).with_name(format!("{}, {MODEL}", method.name()))
    };
    let method_series = |quantity: &Quantity, x: Value, over_mu: bool| -> Vec<Series> {
        let clouds = methods
            .iter()
            .map(|&method| points(method, cloud(x, quantity.value, method, step)));
        let curves = methods
            .iter()
            .map(|&method| curve(quantity.model, over_mu, method));
        // Against itself, the model's friction is the line of slope 1.
        let is_friction = over_mu && quantity.axis.label == FRICTION;
        let curves = curves.filter(|_| !is_friction);
        curves.chain(clouds).collect()
    };

    // One axis for each column, so that the rows align.
    let shared_axis = |label: &str, x: Value| {
        let cloud_points = methods.iter().flat_map(|&method| cloud(x, x, method, 1));
        let greatest = cloud_points.map(|(x, _)| x).fold(0.0, f64::max);
        let axis = Axis::linear(label).with_range(0.0, 1.05 * greatest);
        move |is_lowest: bool| {
            if is_lowest {
                axis.clone()
            } else {
                axis.clone().without_labels()
            }
        }
    };
    let amplitude_axis = shared_axis(AMPLITUDE, amplitude);
    let mu_axis = shared_axis("Measured μ", measured_mu);
    let quantities = quantities();
    let mut panels: Vec<Panel> = Vec::new();
    for (row, quantity) in quantities.iter().enumerate() {
        let is_lowest = row + 1 == quantities.len();
        panels.push(Panel {
            series: method_series(quantity, amplitude, false),
            ..Panel::new(amplitude_axis(is_lowest), quantity.axis.clone())
        });
        panels.push(Panel {
            series: method_series(quantity, measured_mu, true),
            ..Panel::new(mu_axis(is_lowest), quantity.axis.clone())
        });
    }
    if let [.., amplitude_panel, mu_panel] = &mut panels[..] {
        // Few enough to show the estimates between them; not a divisor of the length of an instance, so that no amplitude
        // is left out.
        let measured_points = cloud(amplitude, measured_mu, Method::Paper, step * 7);
        amplitude_panel.series.push(
            Series::points(Ink::Black, Marker::Triangle, measured_points).with_name(MEASUREMENT),
        );
        let extents = mu_panel.series.iter().flat_map(Series::extent);
        let greatest = extents
            .map(|(mu, _)| mu)
            .filter(|mu| mu.is_finite())
            .fold(0.0, f64::max);
        let diagonal = vec![(0.0, 0.0), (greatest, greatest)];
        mu_panel
            .series
            .push(Series::line(Ink::Grey, Dash::Dotted, diagonal).with_name("slope 1"));
    }
    Some(Figure {
        name: "fig13_instances".to_owned(),
        title: "Impedance, stiffness, gap and friction against amplitude and friction".to_owned(),
        caption: format!(
            "{} samples of the {} instances of {} of {}{}: (a, b) real and (c, d) negative imaginary part of the observed impedance, \
             (e, f) contact stiffness, (g, h) levitation gap and (i, j) friction, against (left) vibration amplitude (peak) and (right) \
             measured friction. Lines: the model with the participant's average σₜ = {} (Huloux 2021, Fig. 13). {}{}{}",
            samples,
            instances.len(),
            if selection.whole_trial {
                "the trial"
            } else {
                "one exploration"
            },
            recording_name(findings),
            thinning_note(step),
            averages(&instances[0], &methods),
            replacement_note(selection, &methods),
            trial_note(findings, selection),
            assumption_note(analysed, selection),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 32.0,
        footnote: None,
        key: Key::Above,
        panels,
    })
}

/// Returns a sentence on the average σ_t of each method.
fn averages(instance: &InstanceAnalysis, methods: &[Method]) -> String {
    let texts = methods.iter().filter_map(|&method| {
        let sigma_t_m = instance.estimate(method)?.averaged.sigma_t_m().ok()?;
        Some(format!("{:.2} µm ({})", sigma_t_m * MICRO, method.name()))
    });
    texts.collect::<Vec<_>>().join(" and ")
}

/// Returns the sentence on a method that another one replaces.
fn replacement_note(selection: &FigureSelection, methods: &[Method]) -> &'static str {
    let is_omitted = |method| selection.methods.contains(&method) && !methods.contains(&method);
    if is_omitted(Method::Dynamic) {
        "Trial stands here in the place of dynamic, whose impedance and amplitude it reads. "
    } else if is_omitted(Method::Trial) {
        "The fit by trial of this recording cannot be used. "
    } else {
        ""
    }
}
