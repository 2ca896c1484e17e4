//! Draws a laid-out figure.

use plotters_backend::{DrawingBackend, DrawingErrorKind};

use crate::layout::{CAPITAL_EM, Layout, TICK_GAP_PT, TICK_LENGTH_PT};
use crate::path::{Frame, Point};
use crate::pen::{Anchor, BLACK, Pen, Rgb};
use crate::placed::{Legend, LegendEntry, PlacedPanel, sample_width};
use crate::scale::Tick;
use crate::spec::{Figure, Mark, Panel, Series};
use crate::style::{
    AXIS_PT, CURVE_PT, Ink, LABEL_PT, LETTER_PT, MARKER_RADIUS_PT, TICK_PT, UNITS_PER_PT,
};

type DrawResult<B> = Result<(), DrawingErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Strength of the grey behind the data.
const SHADE: f64 = 0.18;
/// Strength of the ink of a band.
const BAND: f64 = 0.3;
/// Number of points above which they are drawn smaller.
const CROWD: usize = 250;

pub(super) fn draw<B: DrawingBackend>(
    figure: &Figure,
    layout: &Layout,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    pen.clear()?;
    for ((panel, placement), letter) in figure.panels.iter().zip(&layout.panels).zip('a'..='z') {
        shades(panel, placement, pen)?;
        for series in &panel.series {
            draw_series(series, placement, pen)?;
        }
        axes(panel, placement, pen)?;
        if let Some(position) = placement.letter {
            pen.text(&format!("({letter})"), position, LETTER_PT, Anchor::Start)?;
        }
        if let Some(key) = &placement.key {
            legend(key, pen)?;
        }
    }
    if let Some(key) = &layout.key {
        legend(key, pen)?;
    }
    for (text, position) in &layout.footnote {
        pen.text(text, *position, TICK_PT, Anchor::Start)?;
    }
    pen.0.present()
}

fn shades<B: DrawingBackend>(
    panel: &Panel,
    placement: &PlacedPanel,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    let frame = placement.frame;
    for &(from, to) in &panel.shaded_ranges {
        let edge = |x: f64| {
            let (x, _) = placement.place((x, 0.0));
            x.clamp(frame.left, frame.right)
        };
        let (left, right) = (edge(from), edge(to));
        if right > left {
            pen.fill(
                &Frame {
                    left,
                    right,
                    ..frame
                },
                Ink::Grey.tint(SHADE),
            )?;
        }
    }
    Ok(())
}

fn draw_series<B: DrawingBackend>(
    series: &Series,
    placement: &PlacedPanel,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    let frame = &placement.frame;
    match &series.mark {
        Mark::Line { dash, points } => frame
            .stretches(points.iter().map(|&point| placement.place(point)))
            .iter()
            .try_for_each(|stretch| {
                pen.dashed(stretch, series.ink.rgb(), CURVE_PT, dash.pattern_pt())
            }),
        Mark::Points { marker, points } => {
            // Small markers show the shape of a cloud of many points.
            let share = if points.len() > CROWD { 0.55 } else { 1.0 };
            points
                .iter()
                .map(|&point| placement.place(point))
                .filter(|&point| frame.contains(point))
                .try_for_each(|position| {
                    pen.marker(
                        *marker,
                        position,
                        share * MARKER_RADIUS_PT,
                        series.ink.rgb(),
                    )
                })
        }
        Mark::Band { edges } => band(edges, placement, series.ink.tint(BAND), pen),
        Mark::Bars { bars } => bars.iter().try_for_each(|&(x, low, high)| {
            let ends = [placement.place((x, low)), placement.place((x, high))];
            let stretches = frame.stretches(ends);
            let mut stretches = stretches.iter();
            stretches.try_for_each(|stretch| pen.line(stretch, series.ink.rgb(), AXIS_PT))
        }),
    }
}

fn band<B: DrawingBackend>(
    edges: &[(f64, f64, f64)],
    placement: &PlacedPanel,
    rgb: Rgb,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    let frame = placement.frame;
    let point_in_frame = |point: Point| {
        let (x, y) = placement.place(point);
        (x, y.clamp(frame.top, frame.bottom))
    };
    let is_usable = |&(x, low, high): &(f64, f64, f64)| {
        let (place_x, _) = placement.place((x, low));
        low.is_finite() && high.is_finite() && (frame.left..=frame.right).contains(&place_x)
    };
    for stretch in edges
        .split(|edge| !is_usable(edge))
        .filter(|stretch| stretch.len() > 1)
    {
        let lower = stretch.iter().map(|&(x, low, _)| point_in_frame((x, low)));
        let upper = stretch
            .iter()
            .rev()
            .map(|&(x, _, high)| point_in_frame((x, high)));
        let corners: Vec<Point> = lower.chain(upper).collect();
        pen.polygon(&corners, rgb)?;
    }
    Ok(())
}

fn axes<B: DrawingBackend>(
    panel: &Panel,
    placement: &PlacedPanel,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    let Frame {
        left,
        top,
        right,
        bottom,
    } = placement.frame;
    let length = |tick: &Tick| {
        let share = if tick.label.is_some() { 1.0 } else { 0.55 };
        share * TICK_LENGTH_PT * UNITS_PER_PT
    };
    let (side_gap, lower_gap) = (TICK_GAP_PT.0 * UNITS_PER_PT, TICK_GAP_PT.1 * UNITS_PER_PT);
    let em = TICK_PT * UNITS_PER_PT;
    for tick in &placement.x_ticks {
        let x = left + placement.x.place(tick.value) * (right - left);
        pen.line(&[(x, bottom), (x, bottom - length(tick))], BLACK, AXIS_PT)?;
        pen.line(&[(x, top), (x, top + length(tick))], BLACK, AXIS_PT)?;
        if let Some(label) = tick.label.as_ref().filter(|_| panel.x.has_labels) {
            pen.text(
                label,
                (x, bottom + lower_gap + CAPITAL_EM * em),
                TICK_PT,
                Anchor::Middle,
            )?;
        }
    }
    for tick in &placement.y_ticks {
        let y = bottom - placement.y.place(tick.value) * (bottom - top);
        pen.line(&[(left, y), (left + length(tick), y)], BLACK, AXIS_PT)?;
        pen.line(&[(right, y), (right - length(tick), y)], BLACK, AXIS_PT)?;
        if let Some(label) = tick.label.as_ref().filter(|_| panel.y.has_labels) {
            pen.text(
                label,
                (left - side_gap, y + 0.5 * CAPITAL_EM * em),
                TICK_PT,
                Anchor::End,
            )?;
        }
    }
    pen.outline(&placement.frame, AXIS_PT)?;
    if panel.x.has_labels {
        pen.text(&panel.x.label, placement.x_label, LABEL_PT, Anchor::Middle)?;
    }
    if panel.y.has_labels {
        pen.upward_text(&panel.y.label, placement.y_label, LABEL_PT)?;
    }
    Ok(())
}

fn legend<B: DrawingBackend>(key: &Legend, pen: &mut Pen<'_, B>) -> DrawResult<B> {
    for entry in &key.entries {
        if let Some(series) = &entry.series {
            sample(series, entry, pen)?;
        }
        let (x, middle) = entry.position;
        let baseline = middle + 0.5 * CAPITAL_EM * TICK_PT * UNITS_PER_PT;
        pen.text(
            &entry.text,
            (x + entry.text_offset(), baseline),
            TICK_PT,
            Anchor::Start,
        )?;
    }
    Ok(())
}

/// Draws a short sample of a series in front of its name.
fn sample<B: DrawingBackend>(
    series: &Series,
    entry: &LegendEntry,
    pen: &mut Pen<'_, B>,
) -> DrawResult<B> {
    let (from, y) = entry.position;
    let to = from + sample_width(series);
    let rgb = series.ink.rgb();
    match series.mark {
        Mark::Line { dash, .. } => {
            pen.dashed(&[(from, y), (to, y)], rgb, CURVE_PT, dash.pattern_pt())
        }
        Mark::Points { marker, .. } => {
            pen.marker(marker, (0.5 * (from + to), y), MARKER_RADIUS_PT, rgb)
        }
        Mark::Bars { .. } => pen.line(&[(from, y), (to, y)], rgb, AXIS_PT),
        Mark::Band { .. } => {
            let half = 0.35 * TICK_PT * UNITS_PER_PT;
            let frame = Frame {
                left: from,
                right: to,
                top: y - half,
                bottom: y + half,
            };
            pen.fill(&frame, series.ink.tint(BAND))
        }
    }
}
