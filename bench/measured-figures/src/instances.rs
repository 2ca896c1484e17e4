//! Fig. 13: impedance, stiffness, gap and friction of one exploration against amplitude and against measured friction.

use estimation::ModelledSeries;

use crate::drawn::Drawn;
use crate::elements::{
    AMPLITUDE, FRICTION, GAP, MEASURED, MICRO, MODELLED, assumed, by_trial, model_ink, name_of,
    points, thinned,
};
use analysis::Settings;
use analysis::analysed::RecordingFindings;
use analysis::estimate::{InstanceAnalysis, InstanceBy, Method};
use figures::{Axis, Figure, Key, Panel, Series};
use figures::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned.
const DRAWN: usize = 400;

type Value = fn(&InstanceBy<'_>, usize) -> f64;
type Modelled = fn(&ModelledSeries, usize) -> f64;

/// Quantity of the vertical axes.
struct Quantity {
    axis: Axis,
    value: Value,
    modelled: Modelled,
}

fn amplitude(of: &InstanceBy<'_>, sample: usize) -> f64 {
    of.amplitude_m()[sample] * MICRO
}

fn measured_mu(of: &InstanceBy<'_>, sample: usize) -> f64 {
    of.instance.samples.mu()[sample]
}

fn quantities() -> [Quantity; 5] {
    [
        Quantity {
            axis: Axis::linear("Re Zₘ (N·s/m)"),
            value: |of, k| of.z_m()[k].re,
            modelled: |model, k| model.z_m_n_s_per_m[k].re,
        },
        Quantity {
            axis: Axis::linear("−Im Zₘ (N·s/m)"),
            value: |of, k| -of.z_m()[k].im,
            modelled: |model, k| -model.z_m_n_s_per_m[k].im,
        },
        Quantity {
            axis: Axis::logarithmic("Stiffness (N/µm)"),
            value: |of, k| of.estimated.series.k_c_n_per_m[k] / MICRO,
            modelled: |model, k| model.k_c_n_per_m[k] / MICRO,
        },
        Quantity {
            axis: Axis::linear(GAP).from_zero(),
            value: |of, k| of.estimated.series.gap_m[k] * MICRO,
            modelled: |model, k| model.gap_m[k] * MICRO,
        },
        Quantity {
            axis: Axis::linear(FRICTION).from_zero(),
            value: |of, k| of.estimated.series.mu[k],
            modelled: |model, k| model.mu[k],
        },
    ]
}

/// Returns the instances to draw: of the exploration with the most instances (the first of equals), or of the whole
/// trial.
fn chosen<'a>(found: &'a RecordingFindings, drawn: &Drawn) -> &'a [InstanceAnalysis] {
    if drawn.whole_trial {
        return &found.instances;
    }
    found
        .instances
        .chunk_by(|a, b| a.exploration == b.exploration)
        .rev()
        .max_by_key(|of| of.len())
        .unwrap_or_default()
}

/// Draws the figure; `None` for a recording without instances.
pub(super) fn figure(
    found: &RecordingFindings,
    settings: &Settings,
    drawn: &Drawn,
) -> Option<Figure> {
    let instances = chosen(found, drawn);
    let methods = drawn.two_of(instances);
    if instances.is_empty() || methods.is_empty() {
        return None;
    }
    let samples: usize = instances.iter().map(|i| i.samples.time_s().len()).sum();
    let step = samples.div_ceil(DRAWN).max(1);
    let cloud = |x: Value, y: Value, method: Method, step: usize| -> Vec<(f64, f64)> {
        let of = |of: InstanceBy<'_>| -> Vec<(f64, f64)> {
            (0..of.instance.samples.time_s().len())
                .map(|k| (x(&of, k), y(&of, k)))
                .collect()
        };
        let instances = instances.iter().filter_map(|i| i.by(method));
        instances.flat_map(of).step_by(step).collect()
    };
    // Broken between instances. Against friction, the model's impedance is drawn over the model's friction.
    let curve = |y: Modelled, over_mu: bool, method: Method| -> Series {
        let mut line = Vec::new();
        for of in instances.iter().filter_map(|i| i.by(method)) {
            if let Some(model) = &of.estimated.averaged.series {
                line.extend((0..model.mu.len()).map(|k| {
                    let x = if over_mu {
                        model.mu[k]
                    } else {
                        amplitude(&of, k)
                    };
                    (x, y(model, k))
                }));
                line.push((f64::NAN, f64::NAN));
            }
        }
        let (ink, dash) = model_ink(method);
        Series::line(ink, dash, line).named(format!("{}, {MODELLED}", method.name()))
    };
    let of_methods = |quantity: &Quantity, x: Value, over_mu: bool| -> Vec<Series> {
        let clouds = methods
            .iter()
            .map(|&method| points(method, cloud(x, quantity.value, method, step)));
        let curves = methods
            .iter()
            .map(|&method| curve(quantity.modelled, over_mu, method));
        // Against itself, the model's friction is the line of slope 1.
        let of_friction = over_mu && quantity.axis.label == FRICTION;
        let curves = curves.filter(|_| !of_friction);
        curves.chain(clouds).collect()
    };

    // One axis for each column, so that the rows align.
    let across = |label: &str, x: Value| {
        let each = methods.iter().flat_map(|&method| cloud(x, x, method, 1));
        let greatest = each.map(|(x, _)| x).fold(0.0, f64::max);
        let axis = Axis::linear(label).between(0.0, 1.05 * greatest);
        move |written: bool| {
            if written {
                axis.clone()
            } else {
                axis.clone().unwritten()
            }
        }
    };
    let across_amplitude = across(AMPLITUDE, amplitude);
    let across_mu = across("Measured μ", measured_mu);
    let quantities = quantities();
    let mut panels: Vec<Panel> = Vec::new();
    for (row, quantity) in quantities.iter().enumerate() {
        let lowest = row + 1 == quantities.len();
        panels.push(Panel {
            series: of_methods(quantity, amplitude, false),
            ..Panel::new(across_amplitude(lowest), quantity.axis.clone())
        });
        panels.push(Panel {
            series: of_methods(quantity, measured_mu, true),
            ..Panel::new(across_mu(lowest), quantity.axis.clone())
        });
    }
    if let [.., against_amplitude, against_mu] = &mut panels[..] {
        // Few enough to show the estimates between them; not a divisor of the length of an instance, so that no amplitude
        // is left out.
        let measured = cloud(amplitude, measured_mu, Method::Paper, step * 7);
        against_amplitude
            .series
            .push(Series::points(Ink::Black, Marker::Triangle, measured).named(MEASURED));
        let extents = against_mu.series.iter().flat_map(Series::extent);
        let greatest = extents
            .map(|(measured, _)| measured)
            .filter(|mu| mu.is_finite())
            .fold(0.0, f64::max);
        let equal = vec![(0.0, 0.0), (greatest, greatest)];
        against_mu
            .series
            .push(Series::line(Ink::Grey, Dash::Dotted, equal).named("slope 1"));
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
            if drawn.whole_trial {
                "the trial"
            } else {
                "one exploration"
            },
            name_of(found),
            thinned(step),
            averages(&instances[0], &methods),
            instead(drawn, &methods),
            by_trial(found, drawn),
            assumed(settings, drawn),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 32.0,
        key: Key::Above,
        panels,
    })
}

/// Returns a sentence on the average σ_t of each method.
fn averages(instance: &InstanceAnalysis, methods: &[Method]) -> String {
    let each = methods.iter().filter_map(|&method| {
        let sigma_t_m = instance.estimated(method)?.averaged.sigma_t_m;
        Some(format!("{:.2} µm ({})", sigma_t_m * MICRO, method.name()))
    });
    each.collect::<Vec<_>>().join(" and ")
}

/// Returns the sentence on a method that another one replaces.
fn instead(drawn: &Drawn, methods: &[Method]) -> &'static str {
    let left = |method| drawn.methods.contains(&method) && !methods.contains(&method);
    if left(Method::Dynamic) {
        "Trial stands here in the place of dynamic, whose impedance and amplitude it reads. "
    } else if left(Method::Trial) {
        "The fit by trial of this recording cannot be used. "
    } else {
        ""
    }
}
