//! Lays out panels, ticks and keys by the size of their labels.

use crate::font::Typeface;
use crate::key::{figure_key, panel_key};
use crate::path::{Frame, Point};
use crate::placed::{EDGE_PT, Legend, PlacedPanel};
use crate::scale::{AxisExtent, Tick, named_ticks};
use crate::spec::{AxisRange, Figure, Key, Panel, Series};
use crate::style::{LABEL_PT, LETTER_PT, TICK_PT, UNITS_PER_MM, UNITS_PER_PT};

/// Height of capitals and figures over the em.
pub(super) const CAPITAL_EM: f64 = 0.73;
pub(super) const TICK_LENGTH_PT: f64 = 2.5;
/// Distances from the frame to the tick labels on its left and below it, pt.
pub(super) const TICK_GAP_PT: (f64, f64) = (2.5, 3.5);
/// Distance from tick labels to the axis's label, pt.
const LABEL_GAP_PT: f64 = 3.0;
/// Distances between neighbouring panels, drawing units.
const ROW_GAP: f64 = 2.0 * UNITS_PER_PT;
const COLUMN_GAP: f64 = 5.0 * UNITS_PER_PT;
/// Height of a line of the footnote, pt.
const FOOTNOTE_LINE_PT: f64 = 1.35 * TICK_PT;
/// Paper per labelled tick, horizontal and vertical, mm.
const TICK_SPACING_MM: (f64, f64) = (12.0, 9.0);

/// Figure with every part in its place.
pub(super) struct Layout {
    pub(super) size: (u32, u32),
    pub(super) panels: Vec<PlacedPanel>,
    /// Key above the panels.
    pub(super) key: Option<Legend>,
    /// Lines of the footnote, each with the start of its baseline.
    pub(super) footnote: Vec<(String, Point)>,
}

/// Room that a panel needs around its frame, drawing units.
struct Margins {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Frames in rows and columns, each row and column with the largest margins of its panels.
struct Grid {
    columns: usize,
    /// Margin of each column.
    left: Vec<f64>,
    right: Vec<f64>,
    /// Margin of each row.
    top: Vec<f64>,
    bottom: Vec<f64>,
    /// Left end and top of the grid.
    origin: Point,
    frame_width: f64,
    frame_height: f64,
}

impl Grid {
    fn new(margins: &[Margins], figure: &Figure, origin: Point) -> Self {
        let columns = figure.columns.max(1);
        let rows = margins.len().div_ceil(columns);
        let greatest_margin =
            |side: fn(&Margins) -> f64, first: usize, step: usize, count: usize| {
                let members = margins.iter().skip(first).step_by(step).take(count);
                members.map(side).fold(0.0, f64::max)
            };
        let column_margins = |side| {
            (0..columns)
                .map(|c| greatest_margin(side, c, columns, rows))
                .collect()
        };
        let row_margins = |side| {
            (0..rows)
                .map(|r| greatest_margin(side, r * columns, 1, columns))
                .collect()
        };
        let (left, right): (Vec<f64>, Vec<f64>) =
            (column_margins(|m| m.left), column_margins(|m| m.right));
        let reserved_width: f64 =
            left.iter().chain(&right).sum::<f64>() + COLUMN_GAP * (columns - 1) as f64;
        let width = figure.width.mm() * UNITS_PER_MM - 2.0 * origin.0;
        Self {
            columns,
            left,
            right,
            top: row_margins(|m| m.top),
            bottom: row_margins(|m| m.bottom),
            origin,
            frame_width: (width - reserved_width) / columns as f64,
            frame_height: figure.panel_height_mm * UNITS_PER_MM,
        }
    }

    fn frame(&self, index: usize) -> Frame {
        let (column, row) = (index % self.columns, index / self.columns);
        let left_margins: f64 = self.left[..=column]
            .iter()
            .chain(&self.right[..column])
            .sum();
        let top_margins: f64 = self.top[..=row].iter().chain(&self.bottom[..row]).sum();
        let left = self.origin.0 + left_margins + column as f64 * (self.frame_width + COLUMN_GAP);
        let top = self.origin.1 + top_margins + row as f64 * (self.frame_height + ROW_GAP);
        Frame {
            left,
            top,
            right: left + self.frame_width,
            bottom: top + self.frame_height,
        }
    }

    /// Returns the lower end of the grid.
    fn lower_end(&self) -> f64 {
        let rows = self.top.len();
        let margins: f64 = self.top.iter().chain(&self.bottom).sum();
        self.origin.1
            + margins
            + rows as f64 * self.frame_height
            + rows.saturating_sub(1) as f64 * ROW_GAP
    }
}

pub(super) fn lay_out(figure: &Figure, typeface: &Typeface) -> Layout {
    let width = figure.width.mm() * UNITS_PER_MM;
    let edge = EDGE_PT * UNITS_PER_PT;
    let has_letters = figure.panels.len() > 1;
    let (key, key_height) = match figure.key {
        Key::Above => {
            let (key, height) = figure_key(figure, typeface, width - 2.0 * edge);
            (Some(key), height)
        }
        Key::InPanels => (None, 0.0),
    };
    // The width of a frame decides its ticks, and their labels its width; a first guess is accurate enough for the ticks.
    let frame_width = 0.8 * width / figure.columns.max(1) as f64;
    let frame_height = figure.panel_height_mm * UNITS_PER_MM;
    let (extents, margins): (Vec<Extents>, Vec<Margins>) = figure
        .panels
        .iter()
        .map(|panel| {
            let extents = Extents::new(panel, frame_width, frame_height);
            let margins = margins(panel, &extents, typeface, has_letters);
            (extents, margins)
        })
        .unzip();
    let grid = Grid::new(&margins, figure, (edge, edge + key_height));
    let panels = figure.panels.iter().zip(extents).enumerate();
    let panels = panels.map(|(index, (panel, extents))| {
        let frame = grid.frame(index);
        let label = LABEL_PT * UNITS_PER_PT;
        let outer_left = frame.left - grid.left[index % grid.columns];
        let outer_bottom = frame.bottom + grid.bottom[index / grid.columns];
        let mut placement = PlacedPanel {
            y_label: (
                outer_left + CAPITAL_EM * label,
                0.5 * (frame.top + frame.bottom),
            ),
            x_label: (
                0.5 * (frame.left + frame.right),
                outer_bottom - 0.25 * label,
            ),
            letter: has_letters.then_some((outer_left, frame.top - 3.0 * UNITS_PER_PT)),
            frame,
            x: extents.x,
            y: extents.y,
            x_ticks: extents.x_ticks,
            y_ticks: extents.y_ticks,
            key: None,
        };
        placement.key = panel_key(panel, &placement, figure.key, typeface);
        placement
    });
    let text = figure.footnote.as_deref().unwrap_or_default();
    let line = FOOTNOTE_LINE_PT * UNITS_PER_PT;
    let footnote: Vec<(String, Point)> = wrapped(text, typeface, width - 2.0 * edge)
        .into_iter()
        .zip(1..)
        .map(|(text, number)| (text, (edge, grid.lower_end() + line * f64::from(number))))
        .collect();
    let lower_end = grid.lower_end() + line * footnote.len() as f64;
    Layout {
        panels: panels.collect(),
        size: (width.round() as u32, (lower_end + edge).round() as u32),
        key,
        footnote,
    }
}

/// Breaks a text into lines of at most this width.
fn wrapped(text: &str, typeface: &Typeface, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer_line = lines.last().map(|line| format!("{line} {word}"));
        let fits = |line: &String| typeface.width(line, TICK_PT * UNITS_PER_PT) <= width;
        match (lines.last_mut(), longer_line.filter(fits)) {
            (Some(line), Some(longer_line)) => *line = longer_line,
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

struct Extents {
    x: AxisExtent,
    y: AxisExtent,
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
}

impl Extents {
    fn new(panel: &Panel, frame_width: f64, frame_height: f64) -> Self {
        let points: Vec<Point> = panel.series.iter().flat_map(Series::extent).collect();
        let x = AxisExtent::new(&panel.x, points.iter().map(|point| point.0));
        let y = AxisExtent::new(&panel.y, points.iter().map(|point| point.1));
        let [mut n_x, mut n_y] = [
            (frame_width, TICK_SPACING_MM.0),
            (frame_height, TICK_SPACING_MM.1),
        ]
        .map(|(length, spacing_mm)| length / (spacing_mm * UNITS_PER_MM));
        // Two axes of one range have the same ticks.
        if panel.x.span == panel.y.span && matches!(panel.x.span, AxisRange::Fixed(..)) {
            n_x = n_x.min(n_y);
            n_y = n_x;
        }
        Self {
            x_ticks: match panel.x.names.as_slice() {
                [] => x.ticks(n_x),
                names => named_ticks(names, n_x),
            },
            y_ticks: y.ticks(n_y),
            x,
            y,
        }
    }
}

fn margins(panel: &Panel, extents: &Extents, typeface: &Typeface, has_letters: bool) -> Margins {
    let (tick_em, label_em) = (TICK_PT * UNITS_PER_PT, LABEL_PT * UNITS_PER_PT);
    let label_width = |tick: &Tick| {
        tick.label
            .as_ref()
            .map_or(0.0, |label| typeface.width(label, tick_em))
    };
    let widest_label = extents.y_ticks.iter().map(label_width).fold(0.0, f64::max);
    let half_last_label = 0.5
        * extents
            .x_ticks
            .iter()
            .rev()
            .find(|tick| tick.label.is_some())
            .map_or(0.0, label_width);
    let (side_gap, lower_gap) = (TICK_GAP_PT.0 * UNITS_PER_PT, TICK_GAP_PT.1 * UNITS_PER_PT);
    let label = 1.25 * label_em + LABEL_GAP_PT * UNITS_PER_PT;
    Margins {
        left: if panel.y.has_labels {
            widest_label + side_gap + label
        } else {
            side_gap
        },
        right: if panel.x.has_labels {
            half_last_label
        } else {
            side_gap
        },
        top: if has_letters {
            (LETTER_PT + 2.0) * UNITS_PER_PT
        } else {
            0.5 * tick_em
        },
        bottom: if panel.x.has_labels {
            0.9 * tick_em + lower_gap + label
        } else {
            side_gap
        },
    }
}
