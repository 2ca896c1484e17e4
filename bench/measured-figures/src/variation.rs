//! Fig. 14: changes of impedance, gap and estimated friction against the change of friction.

use crate::drawn::Drawn;
use crate::elements::{MICRO, assumed, points};
use analysis::analysed::Analysed;
use analysis::method::Method;
use analysis::published::{ABS_Z_M, Change, Changes, GAP, MU_ESTIMATED, changes};
use analysis::statistics::Coefficient;
use figures::written;
use figures::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};

/// Share of the range that a line of text takes.
const FOR_A_LINE: f64 = 0.13;
/// Changes of more than this many times the median one lie beyond the frame, so that they do not flatten the others.
const WIDE: f64 = 20.0;

pub(super) fn figure(analysed: &Analysed, drawn: &Drawn) -> Figure {
    let mut what = None;
    let (mut by_trial, mut outside) = (0, 0);
    let for_words = FOR_A_LINE * drawn.methods.len() as f64;
    let mut panel = |label: &str, change: Change, coefficient: Coefficient, factor: f64| {
        let mut panel = Panel::new(
            Axis::linear("Δμ, measured"),
            Axis::linear(label).with_headroom(for_words),
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
        outside += frame(&mut panel, label, for_words);
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
             0.28 and 0.43 and r = 0.76 over 140 trials).{} {}",
            if over == "trials" {
                "an exploration, averaged over those of a trial"
            } else {
                "an instance, there being too few trials"
            },
            match outside {
                0 => String::new(),
                1 => " One point is outside a frame.".to_owned(),
                n => format!(" {n} points are outside the frames."),
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

/// Fits the frame to all points but far outliers, with room for text above; returns the number of points outside.
fn frame(panel: &mut Panel, label: &str, for_words: f64) -> usize {
    let values = panel.series.iter().flat_map(Series::extent);
    let mut values: Vec<f64> = values.map(|(_, value)| value).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let (Some(least), Some(median)) = (values.first(), values.get(values.len() / 2)) else {
        return 0;
    };
    let within = |value: &&f64| **value <= WIDE * median;
    let outside = values.len() - values.iter().filter(within).count();
    if let (1.., Some(greatest)) = (outside, values.iter().rfind(within)) {
        let margin = 0.05 * (greatest - least);
        let words = for_words * (greatest - least);
        panel.y = Axis::linear(label).between(least - margin, greatest + margin + words);
    }
    outside
}
