//! Fig. 14: how much impedance, gap and estimated friction change, against how much friction changes.

use crate::drawn::Drawn;
use crate::elements::{MICRO, assumed, points};
use analysis::analysed::Analysed;
use analysis::method::Method;
use analysis::published::{ABS_Z_M, Change, Changes, GAP, MU_ESTIMATED, changes};
use analysis::statistics::Coefficient;
use figures::written;
use figures::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};

/// Share of the range that two lines of text take.
const FOR_WORDS: f64 = 0.25;

pub(super) fn figure(analysed: &Analysed, drawn: &Drawn) -> Figure {
    let mut what = None;
    let mut by_trial = 0;
    let mut panel = |label: &str, change: Change, coefficient: Coefficient, factor: f64| {
        let mut panel = Panel::new(
            Axis::linear("Δμ, measured"),
            Axis::linear(label).with_headroom(FOR_WORDS),
        );
        for &method in &drawn.methods {
            let Changes { over, pairs } = changes(analysed, method, change);
            let (mu, of): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
            if let Some(found) = coefficient.of(&of, &mu) {
                let symbol = match coefficient {
                    Coefficient::Spearman => "ρ",
                    Coefficient::Pearson => "r",
                };
                panel.notes.push(format!(
                    "{symbol} = {} ({})",
                    written(found.rho, 2),
                    method.name()
                ));
            }
            what = what.max(Some((pairs.len(), over.name())));
            if method == Method::Trial {
                by_trial = pairs.len();
            }
            let pairs = pairs.iter().map(|&(mu, of)| (mu, of * factor));
            panel.series.push(points(method, pairs.collect()));
        }
        panel
    };
    let mut panels = vec![
        panel("Δ|Zₘ| (N·s/m)", ABS_Z_M, Coefficient::Spearman, 1.0),
        panel("Δ gap (µm)", GAP, Coefficient::Spearman, MICRO),
        panel("Δμ, estimated", MU_ESTIMATED, Coefficient::Pearson, 1.0),
    ];
    if let Some(estimated) = panels.last_mut() {
        let values = estimated.series.iter().flat_map(Series::extent);
        let greatest = values.map(|(mu, _)| mu).filter(|mu| mu.is_finite());
        let (least, greatest) = greatest.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), mu| {
            (mu.min(a), mu.max(b))
        });
        let equal = vec![(least, least), (greatest, greatest)];
        let line = Series::line(Ink::Black, Dash::Dashed, equal).named("slope 1");
        estimated.series.push(line);
    }
    let (n, over) = what.unwrap_or((0, "instances"));
    let fewer = if drawn.methods.contains(&Method::Trial) && by_trial < n {
        format!(" ({by_trial} by trial)")
    } else {
        String::new()
    };
    Figure {
        name: "fig14_variation".to_owned(),
        title: "Variation of impedance, gap and estimated friction against that of friction"
            .to_owned(),
        caption: format!(
            "Maximum less minimum of {}, over {n} {over}{fewer}: (a) the modulus of the observed impedance, (b) the levitation gap, (c) \
             the estimated friction, against measured friction, with Spearman's ρ and Pearson's r (Huloux 2021, Fig. 14, who give ρ = \
             0.28 and 0.43 and r = 0.76 over 140 trials). {}",
            if over == "trials" {
                "an exploration, averaged over those of a trial"
            } else {
                "an instance, there being too few trials"
            },
            assumed(&analysed.settings, drawn),
        ),
        width: Width::Page,
        columns: 3,
        panel_height_mm: 45.0,
        key: Key::Above,
        panels,
    }
}
