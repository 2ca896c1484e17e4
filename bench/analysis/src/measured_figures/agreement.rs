//! Fig. 15: estimated against measured friction.

use super::elements::{assumed, ink, marker, thinned};
use crate::analysed::Analysed;
use crate::estimate::Method;
use crate::statistics::r_squared;
use figures::{Axis, Figure, Key, Panel, Series};
use figures::{Dash, Ink, Width};

/// Number of samples above which they are thinned out.
const DRAWN: usize = 4000;

pub(super) fn figure(analysed: &Analysed) -> Figure {
    let samples = |method: Method| -> Vec<(f64, f64)> {
        analysed
            .instances()
            .flat_map(|(_, i)| {
                let estimated = i.estimated(method).series.mu.iter().copied();
                i.samples.mu.iter().copied().zip(estimated)
            })
            .collect()
    };
    let clouds = Method::BOTH.map(|method| (method, samples(method)));
    let greatest = clouds
        .iter()
        .flat_map(|(_, samples)| samples)
        .flat_map(|&(measured, estimated)| [measured, estimated])
        .filter(|mu| mu.is_finite())
        .fold(0.0, f64::max);
    let n = clouds[0].1.len();
    let step = n.div_ceil(DRAWN).max(1);
    let panels = clouds.map(|(method, samples)| {
        let (measured, estimated): (Vec<f64>, Vec<f64>) = samples.iter().copied().unzip();
        let r2 = r_squared(&measured, &estimated);
        let drawn = samples.into_iter().step_by(step).collect();
        let axis = |label: &str| Axis::linear(label).between(0.0, 1.05 * greatest);
        Panel {
            series: vec![
                Series::points(ink(method), marker(method), drawn).named(method.name()),
                Series::line(
                    Ink::Black,
                    Dash::Dashed,
                    vec![(0.0, 0.0), (2.0 * greatest, 2.0 * greatest)],
                )
                .named("slope 1"),
            ],
            notes: r2.map(|r2| format!("R² = {r2:.3}")).into_iter().collect(),
            ..Panel::new(axis("Measured μ"), axis("Estimated μ"))
        }
    });
    Figure {
        name: "fig15_agreement".to_owned(),
        title: "Estimated against measured friction".to_owned(),
        caption: format!(
            "Friction estimated from the observed impedance against measured friction, {n} samples of {} instances{}, by (a) the published \
             (paper) and (b) the dynamic method, with R² about the line of slope 1 (Huloux 2021, Fig. 15, who give 0.93 and 0.98). {}",
            analysed.instances().count(),
            thinned(step),
            assumed(&analysed.settings),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 70.0,
        key: Key::InPanels,
        panels: panels.into(),
    }
}
