//! Fig. 14: changes of impedance, gap and estimated friction against the change of friction.

use crate::measured::elements::{MICRO, assumption_note, points};
use crate::measured::figure_selection::FigureSelection;
use analysis::findings::Analysis;
use analysis::method::Method;
use analysis::published::{ABS_Z_M, Change, GAP, MU_ESTIMATED, changes};
use analysis::statistics::Coefficient;
use plotting::number_text;
use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};

/// Share of the range that a line of text takes.
const LINE_SHARE: f64 = 0.13;
/// Changes of more than this many times the median one lie beyond the frame, so that they do not flatten the others.
const WIDE: f64 = 20.0;

pub(super) fn figure(analysed: &Analysis, selection: &FigureSelection) -> Figure {
    let (mut n, mut n_trial, mut n_outside) = (0, 0, 0);
    let headroom = LINE_SHARE * selection.methods.len() as f64;
    let mut panel = |label: &str, change: Change, coefficient: Coefficient, factor: f64| {
        let mut panel = Panel::new(
            Axis::linear("Δμ, measured"),
            Axis::linear(label).with_headroom(headroom),
        );
        for &method in &selection.methods {
            let pairs = changes(analysed, method, change);
            let (mu, delta): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
            if let Some(correlation) = coefficient.correlate(&delta, &mu) {
                let symbol = match coefficient {
                    Coefficient::Spearman => "ρ",
                    Coefficient::Pearson => "r",
                };
                panel.notes.push(format!(
                    "{symbol} = {} ({})",
                    number_text(correlation.rho, 2),
                    method.name()
                ));
            }
            n = pairs.len().max(n);
            if method == Method::Trial {
                n_trial = pairs.len();
            }
            let pairs = pairs.iter().map(|&(mu, delta)| (mu, delta * factor));
            panel.series.push(points(method, pairs.collect()));
        }
        n_outside += frame(&mut panel, label, headroom);
        panel
    };
    let mut panels = vec![
        panel("Δ|Zₘ| (N·s/m)", ABS_Z_M, Coefficient::Spearman, 1.0),
        panel("Δ gap (µm)", GAP, Coefficient::Spearman, MICRO),
        panel("Δμ, estimated", MU_ESTIMATED, Coefficient::Pearson, 1.0),
    ];
    if let Some(mu_panel) = panels.last_mut() {
        let values = mu_panel.series.iter().flat_map(Series::extent);
        let mus = values.map(|(mu, _)| mu).filter(|mu| mu.is_finite());
        let (least, greatest) = mus.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), mu| {
            (mu.min(a), mu.max(b))
        });
        let diagonal = vec![(least, least), (greatest, greatest)];
        let line = Series::line(Ink::Black, Dash::Dashed, diagonal).with_name("slope 1");
        mu_panel.series.push(line);
    }
    let note = if selection.methods.contains(&Method::Trial) && n_trial < n {
        format!(" ({n_trial} by trial)")
    } else {
        String::new()
    };
    Figure {
        name: "fig14_variation".to_owned(),
        title: "Variation of impedance, gap and estimated friction against that of friction"
            .to_owned(),
        caption: format!(
            "Maximum less minimum in an instance, over {n} instances{note}: (a) the modulus of the observed impedance, (b) the \
             levitation gap, (c) the estimated friction, against measured friction, with Spearman's ρ and Pearson's r (Huloux 2021, Fig. 14, who give ρ = \
             0.28 and 0.43 and r = 0.76 over 140 instances).{} {}",
            match n_outside {
                0 => String::new(),
                1 => " One point is outside a frame.".to_owned(),
                n => format!(" {n} points are outside the frames."),
            },
            assumption_note(analysed, selection),
        ),
        width: Width::Page,
        columns: 3,
        panel_height_mm: 45.0,
        footnote: None,
        key: Key::Above,
        panels,
    }
}

/// Fits the frame to all points but far outliers, with room for text above; returns the number of points outside.
fn frame(panel: &mut Panel, label: &str, headroom: f64) -> usize {
    let values = panel.series.iter().flat_map(Series::extent);
    let mut values: Vec<f64> = values.map(|(_, value)| value).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let (Some(least), Some(median)) = (values.first(), values.get(values.len() / 2)) else {
        return 0;
    };
    let is_inside = |value: &&f64| **value <= WIDE * median;
    let n_outside = values.len() - values.iter().filter(is_inside).count();
    if let (1.., Some(greatest)) = (n_outside, values.iter().rfind(is_inside)) {
        let margin = 0.05 * (greatest - least);
        let text_room = headroom * (greatest - least);
        panel.y = Axis::linear(label).with_range(least - margin, greatest + margin + text_room);
    }
    n_outside
}
