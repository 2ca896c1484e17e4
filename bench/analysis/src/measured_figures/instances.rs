//! Fig. 13: impedance, stiffness, gap and friction of one trial against amplitude and against measured friction.

use super::elements::{
    ABS_Z_M, AMPLITUDE, FRICTION, GAP, MEASURED, MICRO, STIFFNESS, assumed, points, thinned,
};
use crate::analysed::RecordingFindings;
use crate::analysis_settings::Settings;
use crate::estimate::{InstanceAnalysis, Method};
use figures::{Axis, Figure, Key, Panel, Series};
use figures::{Dash, Ink, Marker, Width};

/// Number of samples above which they are thinned out.
const DRAWN: usize = 400;

type Value = fn(&InstanceAnalysis, Method, usize) -> f64;

fn amplitude(instance: &InstanceAnalysis, _: Method, sample: usize) -> f64 {
    instance.samples.amplitude_m[sample] * MICRO
}

fn measured_mu(instance: &InstanceAnalysis, _: Method, sample: usize) -> f64 {
    instance.samples.mu[sample]
}

/// Draws the figure; `None` for a recording without instances.
pub(super) fn figure(found: &RecordingFindings, settings: &Settings) -> Option<Figure> {
    if found.instances.is_empty() {
        return None;
    }
    let quantities: [(Axis, Value); 4] = [
        (Axis::linear(ABS_Z_M), |i, method, k| {
            i.z_m(method)[k].norm()
        }),
        (Axis::logarithmic(STIFFNESS), |i, method, k| {
            i.estimated(method).series.k_c_n_per_m[k] / MICRO
        }),
        (Axis::linear(GAP).from_zero(), |i, method, k| {
            i.estimated(method).series.gap_m[k] * MICRO
        }),
        (Axis::linear(FRICTION).from_zero(), |i, method, k| {
            i.estimated(method).series.mu[k]
        }),
    ];
    let samples: usize = found.instances.iter().map(|i| i.samples.time_s.len()).sum();
    let step = samples.div_ceil(DRAWN).max(1);
    let cloud = |x: Value, y: Value, method: Method| -> Vec<(f64, f64)> {
        let of = |i: &InstanceAnalysis| -> Vec<(f64, f64)> {
            (0..i.samples.time_s.len())
                .map(|k| (x(i, method, k), y(i, method, k)))
                .collect()
        };
        found.instances.iter().flat_map(of).step_by(step).collect()
    };
    let both = |x: Value, y: Value| -> Vec<Series> {
        Method::BOTH
            .map(|method| points(method, cloud(x, y, method)))
            .into()
    };

    let mut panels: Vec<Panel> = quantities
        .iter()
        .map(|(axis, value)| Panel {
            series: both(amplitude, *value),
            ..Panel::new(Axis::linear(AMPLITUDE).from_zero(), axis.clone())
        })
        .collect();
    if let Some(friction) = panels.last_mut() {
        // Few enough that the estimates show between them; not a divisor of an instance, so that no amplitude is left
        // out.
        let measured = cloud(amplitude, measured_mu, Method::Dynamic)
            .into_iter()
            .step_by(7)
            .collect();
        let measured = Series::points(Ink::Black, Marker::Triangle, measured).named(MEASURED);
        friction.series.push(measured);
    }
    panels.extend(quantities.iter().map(|(axis, value)| Panel {
        series: both(measured_mu, *value),
        ..Panel::new(Axis::linear("Measured μ").from_zero(), axis.clone())
    }));
    if let Some(friction) = panels.last_mut() {
        let greatest = friction
            .series
            .iter()
            .flat_map(Series::extent)
            .map(|(measured, _)| measured)
            .fold(0.0, f64::max);
        let equal = vec![(0.0, 0.0), (greatest, greatest)];
        friction
            .series
            .push(Series::line(Ink::Black, Dash::Dashed, equal).named("slope 1"));
    }
    Some(Figure {
        name: "fig13_instances".to_owned(),
        title: "Impedance, stiffness, gap and friction against amplitude and friction".to_owned(),
        caption: format!(
            "{} samples of the {} instances of {}{}: (a, e) modulus of the observed impedance, (b, f) contact stiffness, (c, g) levitation \
             gap and (d, h) friction, against (a–d) vibration amplitude (peak) and (e–h) measured friction, by the published (paper) and \
             the dynamic method (Huloux 2021, Fig. 13). {}",
            samples,
            found.instances.len(),
            found.path.display(),
            thinned(step),
            assumed(settings),
        ),
        width: Width::Page,
        columns: 4,
        panel_height_mm: 38.0,
        key: Key::Above,
        panels,
    })
}
