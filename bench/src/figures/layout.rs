//! Where panels, ticks and keys go, from what has to be written beside them.

use super::font::Typeface;
use super::path::{Frame, Point};
use super::scale::{Extent, Tick};
use super::spec::{Figure, Key, Mark, Panel, Series};
use super::style::{LABEL_PT, LETTER_PT, TICK_PT, UNITS_PER_MM, UNITS_PER_PT};

/// Height of capitals and figures over the em.
pub(super) const CAPITAL_EM: f64 = 0.73;
pub(super) const TICK_LENGTH_PT: f64 = 2.5;
/// Between the frame and tick labels, beside it and below.
pub(super) const TICK_GAP_PT: (f64, f64) = (2.5, 3.5);
/// Between tick labels and the axis's label.
const LABEL_GAP_PT: f64 = 3.0;
/// Around the figure.
const EDGE_PT: f64 = 3.0;
/// Between neighbouring panels.
const GUTTER_PT: f64 = 5.0;
const KEY_LINE_PT: f64 = 1.35 * TICK_PT;
const SAMPLE_PT: f64 = 18.0;
const SAMPLE_GAP_PT: f64 = 4.0;
const KEY_INSET_PT: f64 = 5.0;
const KEY_SPACING_PT: f64 = 14.0;
/// Paper per labelled tick.
const TICK_SPACING_MM: (f64, f64) = (12.0, 8.5);

/// A figure laid out.
pub(super) struct Layout {
    pub(super) size: (u32, u32),
    pub(super) panels: Vec<Placed>,
    /// The key above the panels.
    pub(super) key: Option<Legend>,
}

/// A panel on the paper.
pub(super) struct Placed {
    pub(super) frame: Frame,
    pub(super) x: Extent,
    pub(super) y: Extent,
    pub(super) x_ticks: Vec<Tick>,
    pub(super) y_ticks: Vec<Tick>,
    /// Middle of the vertical axis's label: baseline and height.
    pub(super) y_label: Point,
    /// Middle and baseline of the horizontal axis's label.
    pub(super) x_label: Point,
    /// Where the panel's letter starts; none for a single panel.
    pub(super) letter: Option<Point>,
    pub(super) key: Option<Legend>,
}

/// The named curves, and lines of text.
pub(super) struct Legend {
    pub(super) entries: Vec<Entry>,
}

/// A line of a key.
pub(super) struct Entry {
    /// The curve whose sample is shown; none for a note.
    pub(super) series: Option<Series>,
    pub(super) text: String,
    /// Start of the sample and middle of its height.
    pub(super) at: Point,
}

impl Entry {
    fn new(series: &Series) -> Option<Self> {
        Some(Self {
            text: series.name.clone()?,
            series: Some(series.clone()),
            at: (0.0, 0.0),
        })
    }

    fn note(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            series: None,
            at: (0.0, 0.0),
        }
    }

    fn width(&self, typeface: &Typeface) -> f64 {
        typeface.width(&self.text, TICK_PT * UNITS_PER_PT) + self.text_offset()
    }

    /// From the start of the entry to its text.
    pub(super) fn text_offset(&self) -> f64 {
        self.series.as_ref().map_or(0.0, |series| {
            sample_width(series) + SAMPLE_GAP_PT * UNITS_PER_PT
        })
    }
}

/// Length of paper that shows how a series is drawn.
pub(super) fn sample_width(series: &Series) -> f64 {
    let pt = match series.mark {
        Mark::Points { .. } => 5.0,
        Mark::Line { .. } | Mark::Band { .. } => SAMPLE_PT,
    };
    pt * UNITS_PER_PT
}

impl Placed {
    /// Where a data point lies on the paper.
    pub(super) fn place(&self, (x, y): Point) -> Point {
        let Frame {
            left,
            top,
            right,
            bottom,
        } = self.frame;
        (
            left + self.x.place(x) * (right - left),
            bottom - self.y.place(y) * (bottom - top),
        )
    }
}

/// What a panel needs around its frame.
#[derive(Clone, Copy, Default)]
struct Margins {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

pub(super) fn lay_out(figure: &Figure, typeface: &Typeface) -> Layout {
    let width = figure.width.mm() * UNITS_PER_MM;
    let frame_height = figure.panel_height_mm * UNITS_PER_MM;
    let columns = figure.columns.max(1);
    let rows = figure.panels.len().div_ceil(columns);
    let lettered = figure.panels.len() > 1;
    let edge = EDGE_PT * UNITS_PER_PT;

    let key = match figure.key {
        Key::Above => Some(above(figure, typeface, width - 2.0 * edge)),
        Key::InPanels => None,
    };
    let (key, key_height) = key.map_or((None, 0.0), |(key, height)| (Some(key), height));

    // The width of a frame decides its ticks and their labels its width: a first guess is near enough for the ticks.
    let guess = width / columns as f64 * 0.8;
    let measured: Vec<(Extents, Margins)> = figure
        .panels
        .iter()
        .map(|panel| {
            let extents = Extents::new(panel, guess, frame_height);
            let margins = margins(panel, &extents, typeface, lettered);
            (extents, margins)
        })
        .collect();
    let greatest = |select: fn(&Margins) -> f64, member: &dyn Fn(usize) -> bool| {
        measured
            .iter()
            .enumerate()
            .filter(|(index, _)| member(*index))
            .map(|(_, (_, margins))| select(margins))
            .fold(0.0, f64::max)
    };
    let left: Vec<f64> = (0..columns)
        .map(|column| greatest(|m| m.left, &|index| index % columns == column))
        .collect();
    let right: Vec<f64> = (0..columns)
        .map(|column| greatest(|m| m.right, &|index| index % columns == column))
        .collect();
    let top: Vec<f64> = (0..rows)
        .map(|row| greatest(|m| m.top, &|index| index / columns == row))
        .collect();
    let bottom: Vec<f64> = (0..rows)
        .map(|row| greatest(|m| m.bottom, &|index| index / columns == row))
        .collect();

    let gutter = GUTTER_PT * UNITS_PER_PT;
    let beside: f64 = left.iter().chain(&right).sum();
    let gutters = gutter * (columns - 1) as f64;
    let frame_width = (width - 2.0 * edge - beside - gutters) / columns as f64;
    let above_below: f64 = top.iter().chain(&bottom).sum();
    let gaps = 0.4 * gutter * rows.saturating_sub(1) as f64;
    let height = 2.0 * edge + key_height + above_below + gaps + rows as f64 * frame_height;

    let panels = figure
        .panels
        .iter()
        .zip(measured)
        .enumerate()
        .map(|(index, (panel, (extents, _)))| {
            let (column, row) = (index % columns, index / columns);
            let beside: f64 = left[..=column].iter().chain(&right[..column]).sum();
            let over: f64 = top[..=row].iter().chain(&bottom[..row]).sum();
            let frame = Frame {
                left: edge + beside + column as f64 * (frame_width + gutter),
                right: edge + beside + column as f64 * (frame_width + gutter) + frame_width,
                top: edge + key_height + over + row as f64 * (frame_height + 0.4 * gutter),
                bottom: edge
                    + key_height
                    + over
                    + row as f64 * (frame_height + 0.4 * gutter)
                    + frame_height,
            };
            let label = LABEL_PT * UNITS_PER_PT;
            let mut placed = Placed {
                y_label: (
                    frame.left - left[column] + CAPITAL_EM * label,
                    0.5 * (frame.top + frame.bottom),
                ),
                x_label: (
                    0.5 * (frame.left + frame.right),
                    frame.bottom + bottom[row] - 0.25 * label,
                ),
                letter: lettered
                    .then_some((frame.left - left[column], frame.top - 3.0 * UNITS_PER_PT)),
                frame,
                x: extents.x,
                y: extents.y,
                x_ticks: extents.x_ticks,
                y_ticks: extents.y_ticks,
                key: None,
            };
            placed.key = within(panel, &placed, figure.key, typeface);
            placed
        })
        .collect();
    Layout {
        size: (width.round() as u32, height.round() as u32),
        panels,
        key,
    }
}

struct Extents {
    x: Extent,
    y: Extent,
    x_ticks: Vec<Tick>,
    y_ticks: Vec<Tick>,
}

impl Extents {
    fn new(panel: &Panel, frame_width: f64, frame_height: f64) -> Self {
        let points: Vec<Point> = panel.series.iter().flat_map(Series::extent).collect();
        let x = Extent::new(&panel.x, points.iter().map(|point| point.0));
        let y = Extent::new(&panel.y, points.iter().map(|point| point.1));
        Self {
            x_ticks: x.ticks(frame_width / (TICK_SPACING_MM.0 * UNITS_PER_MM)),
            y_ticks: y.ticks(frame_height / (TICK_SPACING_MM.1 * UNITS_PER_MM)),
            x,
            y,
        }
    }
}

fn margins(panel: &Panel, extents: &Extents, typeface: &Typeface, lettered: bool) -> Margins {
    let (tick_em, label_em) = (TICK_PT * UNITS_PER_PT, LABEL_PT * UNITS_PER_PT);
    let label_width = |tick: &Tick| {
        tick.label
            .as_ref()
            .map_or(0.0, |label| typeface.width(label, tick_em))
    };
    let widest = extents.y_ticks.iter().map(label_width).fold(0.0, f64::max);
    let half_last = 0.5
        * extents
            .x_ticks
            .iter()
            .rev()
            .find(|tick| tick.label.is_some())
            .map_or(0.0, label_width);
    let (beside, below) = (TICK_GAP_PT.0 * UNITS_PER_PT, TICK_GAP_PT.1 * UNITS_PER_PT);
    let label = 1.25 * label_em + LABEL_GAP_PT * UNITS_PER_PT;
    Margins {
        left: if panel.y.written {
            widest + beside + label
        } else {
            beside
        },
        right: if panel.x.written { half_last } else { beside },
        top: if lettered {
            (LETTER_PT + 2.0) * UNITS_PER_PT
        } else {
            0.5 * tick_em
        },
        bottom: if panel.x.written {
            0.9 * tick_em + below + label
        } else {
            beside
        },
    }
}

/// The names of all curves in rows above the panels, and the height that they take.
fn above(figure: &Figure, typeface: &Typeface, width: f64) -> (Legend, f64) {
    let mut entries: Vec<Entry> = Vec::new();
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        let known = entries
            .iter()
            .any(|entry| Some(&entry.text) == series.name.as_ref());
        entries.extend(Entry::new(series).filter(|_| !known));
    }
    let spacing = KEY_SPACING_PT * UNITS_PER_PT;
    let line = KEY_LINE_PT * UNITS_PER_PT;
    let edge = EDGE_PT * UNITS_PER_PT;
    let mut rows: Vec<(f64, Vec<Entry>)> = Vec::new();
    for entry in entries {
        let needed = entry.width(typeface);
        match rows.last_mut() {
            Some((used, row)) if *used + spacing + needed <= width => {
                *used += spacing + needed;
                row.push(entry);
            }
            _ => rows.push((needed, vec![entry])),
        }
    }
    let height = rows.len() as f64 * line;
    let mut placed = Vec::new();
    for (number, (used, row)) in rows.into_iter().enumerate() {
        let mut x = edge + 0.5 * (width - used);
        for mut entry in row {
            entry.at = (x, edge + (number as f64 + 0.5) * line);
            x += entry.width(typeface) + spacing;
            placed.push(entry);
        }
    }
    (Legend { entries: placed }, height)
}

/// The panel's own key and notes, in the place where they cover the fewest points.
fn within(panel: &Panel, placed: &Placed, key: Key, typeface: &Typeface) -> Option<Legend> {
    let names = panel.series.iter().filter(|_| key == Key::InPanels);
    let mut entries: Vec<Entry> = names.filter_map(Entry::new).collect();
    entries.extend(panel.notes.iter().map(|note| Entry::note(note)));
    if entries.is_empty() {
        return None;
    }
    let width = entries
        .iter()
        .map(|entry| entry.width(typeface))
        .fold(0.0, f64::max);
    let line = KEY_LINE_PT * UNITS_PER_PT;
    let height = line * entries.len() as f64;
    let inset = KEY_INSET_PT * UNITS_PER_PT;
    let frame = &placed.frame;
    let lefts = [
        frame.right - inset - width,
        frame.left + inset,
        0.5 * (frame.left + frame.right - width),
    ];
    let tops = [
        frame.top + 0.6 * inset,
        frame.bottom - 0.6 * inset - height,
        0.5 * (frame.top + frame.bottom - height),
    ];
    let inked = inked(panel, placed);
    let boxes = tops.iter().flat_map(|&top| lefts.map(|left| (left, top)));
    let (left, top) = boxes.min_by_key(|&(left, top)| {
        // Of the places that cover nothing, one with room around it.
        [0.5 * inset, 2.0 * inset].map(|clearance| {
            let covered = Frame {
                left: left - clearance,
                top: top - clearance,
                right: left + width + clearance,
                bottom: top + height + clearance,
            };
            inked
                .iter()
                .filter(|&&point| covered.contains(point))
                .count()
        })
    })?;
    for (number, entry) in entries.iter_mut().enumerate() {
        entry.at = (left, top + (number as f64 + 0.5) * line);
    }
    Some(Legend { entries })
}

/// Points along everything drawn in a panel, close enough that no line slips through a key.
fn inked(panel: &Panel, placed: &Placed) -> Vec<Point> {
    let step = 4.0 * UNITS_PER_PT;
    let mut inked = Vec::new();
    for series in &panel.series {
        let on_paper: Vec<Point> = series
            .extent()
            .into_iter()
            .map(|point| placed.place(point))
            .collect();
        if matches!(series.mark, Mark::Line { .. }) {
            for stretch in placed.frame.stretches(on_paper) {
                for ends in stretch.windows(2) {
                    let (from, to) = (ends[0], ends[1]);
                    let pieces = ((to.0 - from.0).hypot(to.1 - from.1) / step)
                        .ceil()
                        .max(1.0);
                    inked.extend((0..=pieces as usize).map(|piece| {
                        let share = piece as f64 / pieces;
                        (
                            from.0 + share * (to.0 - from.0),
                            from.1 + share * (to.1 - from.1),
                        )
                    }));
                }
            }
        } else {
            inked.extend(on_paper);
        }
    }
    inked
}
