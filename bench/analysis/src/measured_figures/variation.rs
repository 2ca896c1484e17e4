//! Fig. 14: what changes over an instance, against the fall of friction.

use super::elements::{MICRO, assumed, points};
use crate::analysed::Analysed;
use crate::estimate::{Deltas, Method};
use crate::statistics::Coefficient;
use figures::Width;
use figures::written;
use figures::{Axis, Figure, Key, Panel};

/// Share of the range that two lines of text take.
const FOR_WORDS: f64 = 0.25;

pub(super) fn figure(analysed: &Analysed) -> Figure {
    let panel = |label: &str, change: fn(&Deltas) -> f64| {
        let mut panel = Panel::new(
            Axis::linear("Fall of measured μ"),
            Axis::linear(label).with_headroom(FOR_WORDS),
        );
        for method in Method::BOTH {
            let pairs: Vec<(f64, f64)> = analysed
                .instances()
                .map(|(_, i)| (i.delta_mu, change(&i.estimated(method).deltas)))
                .collect();
            let (mu, change): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
            if let Some(found) = Coefficient::Spearman.of(&change, &mu) {
                panel
                    .notes
                    .push(format!("ρ = {} ({})", written(found.rho, 2), method.name()));
            }
            panel.series.push(points(method, pairs));
        }
        panel
    };
    Figure {
        name: "fig14_variation".to_owned(),
        title: "Variation of impedance, acoustic force and gap against that of friction".to_owned(),
        caption: format!(
            "Change over each of {} instances, mean of its last 5 ms against that of its first: (a) fall of the modulus of the observed \
             impedance, (b) rise of the acoustic force of the squeeze film, (c) rise of the levitation gap, against the fall of measured \
             friction, by the published (paper) and the dynamic method, with Spearman's ρ (Huloux 2021, Fig. 14, who give 0.28, 0.34 and \
             0.43). {}",
            analysed.instances().count(),
            assumed(&analysed.settings),
        ),
        width: Width::Page,
        columns: 3,
        panel_height_mm: 45.0,
        key: Key::Above,
        panels: vec![
            panel("Fall of |Zₘ| (N·s/m)", |deltas| deltas.abs_z_m_n_s_per_m),
            panel("Rise of acoustic force (N)", |deltas| deltas.squeeze_n),
            panel("Rise of gap (µm)", |deltas| deltas.gap_m * MICRO),
        ],
    }
}
