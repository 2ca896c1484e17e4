//! Places the names of the curves where they cover the fewest points.

use crate::font::Typeface;
use crate::path::{Frame, Point};
use crate::placed::{EDGE_PT, Legend, LegendEntry, PlacedPanel};
use crate::spec::{Figure, Key, Mark, Panel};
use crate::style::{TICK_PT, UNITS_PER_PT};

const KEY_LINE_PT: f64 = 1.35 * TICK_PT;
const KEY_INSET_PT: f64 = 5.0;
const KEY_SPACING_PT: f64 = 14.0;

/// Returns the names of all curves in rows above the panels, and the height that they take.
pub(super) fn figure_key(figure: &Figure, typeface: &Typeface, width: f64) -> (Legend, f64) {
    let mut entries: Vec<LegendEntry> = Vec::new();
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        let is_listed = entries
            .iter()
            .any(|entry| Some(&entry.text) == series.name.as_ref());
        entries.extend(LegendEntry::new(series).filter(|_| !is_listed));
    }
    let spacing = KEY_SPACING_PT * UNITS_PER_PT;
    let line = KEY_LINE_PT * UNITS_PER_PT;
    let edge = EDGE_PT * UNITS_PER_PT;
    let mut rows: Vec<(f64, Vec<LegendEntry>)> = Vec::new();
    for entry in entries {
        let entry_width = entry.width(typeface);
        match rows.last_mut() {
            Some((row_width, row)) if *row_width + spacing + entry_width <= width => {
                *row_width += spacing + entry_width;
                row.push(entry);
            }
            _ => rows.push((entry_width, vec![entry])),
        }
    }
    let height = rows.len() as f64 * line;
    let mut placed_entries = Vec::new();
    for (number, (row_width, row)) in rows.into_iter().enumerate() {
        let mut x = edge + 0.5 * (width - row_width);
        for mut entry in row {
            entry.position = (x, edge + (number as f64 + 0.5) * line);
            x += entry.width(typeface) + spacing;
            placed_entries.push(entry);
        }
    }
    (
        Legend {
            entries: placed_entries,
        },
        height,
    )
}

/// Returns the panel's own key and notes, in the place where they cover the fewest points.
pub(super) fn panel_key(
    panel: &Panel,
    placement: &PlacedPanel,
    key: Key,
    typeface: &Typeface,
) -> Option<Legend> {
    let names = panel.series.iter().filter(|_| key == Key::InPanels);
    let mut entries: Vec<LegendEntry> = names.filter_map(LegendEntry::new).collect();
    entries.extend(panel.notes.iter().map(|note| LegendEntry::note(note)));
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
    let frame = &placement.frame;
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
    let ink_points = inked_points(panel, placement);
    let corners = tops.iter().flat_map(|&top| lefts.map(|x| (x, top)));
    let (left, top) = corners.min_by_key(|&(left, top)| {
        // Among places that cover no points, prefers one with room around it.
        [0.5 * inset, 2.0 * inset].map(|clearance| {
            let area = Frame {
                left: left - clearance,
                top: top - clearance,
                right: left + width + clearance,
                bottom: top + height + clearance,
            };
            ink_points
                .iter()
                .filter(|&&point| area.contains(point))
                .count()
        })
    })?;
    for (number, entry) in entries.iter_mut().enumerate() {
        entry.position = (left, top + (number as f64 + 0.5) * line);
    }
    Some(Legend { entries })
}

/// Returns points along everything drawn in a panel, close enough together that no line passes through a key unseen.
fn inked_points(panel: &Panel, placement: &PlacedPanel) -> Vec<Point> {
    let step = 4.0 * UNITS_PER_PT;
    let mut points = Vec::new();
    for series in &panel.series {
        let paper_points: Vec<Point> = series
            .extent()
            .into_iter()
            .map(|point| placement.place(point))
            .collect();
        if matches!(series.mark, Mark::Line { .. }) {
            for stretch in placement.frame.stretches(paper_points) {
                for ends in stretch.windows(2) {
                    let (from, to) = (ends[0], ends[1]);
                    let pieces = ((to.0 - from.0).hypot(to.1 - from.1) / step)
                        .ceil()
                        .max(1.0);
                    points.extend((0..=pieces as usize).map(|piece| {
                        let share = piece as f64 / pieces;
                        (
                            from.0 + share * (to.0 - from.0),
                            from.1 + share * (to.1 - from.1),
                        )
                    }));
                }
            }
        } else {
            points.extend(paper_points);
        }
    }
    points
}
