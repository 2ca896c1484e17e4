//! Panels and legends with their places on the paper.

use crate::font::Typeface;
use crate::path::{Frame, Point};
use crate::scale::{AxisExtent, Tick};
use crate::spec::{Mark, Series};
use crate::style::{TICK_PT, UNITS_PER_PT};

/// Free paper around the figure, pt.
pub(super) const EDGE_PT: f64 = 3.0;
/// Length of the sample of a line or band in front of its name, pt.
const SAMPLE_PT: f64 = 18.0;
/// Distance from a sample to its name, pt.
const SAMPLE_GAP_PT: f64 = 4.0;

/// Panel on the paper.
pub(super) struct PlacedPanel {
    pub(super) frame: Frame,
    pub(super) x: AxisExtent,
    pub(super) y: AxisExtent,
    pub(super) x_ticks: Vec<Tick>,
    pub(super) y_ticks: Vec<Tick>,
    /// Middle of the vertical axis's label: baseline and height.
    pub(super) y_label: Point,
    /// Middle and baseline of the horizontal axis's label.
    pub(super) x_label: Point,
    /// Start of the panel's letter; `None` for a single panel.
    pub(super) letter: Option<Point>,
    pub(super) key: Option<Legend>,
}

impl PlacedPanel {
    /// Returns the place of a data point on the paper.
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

/// Names of the curves, and lines of text.
pub(super) struct Legend {
    pub(super) entries: Vec<LegendEntry>,
}

/// Line of a key.
pub(super) struct LegendEntry {
    /// Curve to show a sample of; `None` for a note.
    pub(super) series: Option<Series>,
    pub(super) text: String,
    /// Start of the sample and middle of its height.
    pub(super) position: Point,
}

impl LegendEntry {
    pub(super) fn new(series: &Series) -> Option<Self> {
        Some(Self {
            text: series.name.clone()?,
            series: Some(series.clone()),
            position: (0.0, 0.0),
        })
    }

    pub(super) fn note(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            series: None,
            position: (0.0, 0.0),
        }
    }

    pub(super) fn width(&self, typeface: &Typeface) -> f64 {
        typeface.width(&self.text, TICK_PT * UNITS_PER_PT) + self.text_offset()
    }

    /// Returns the distance from the start of the entry to its text.
    pub(super) fn text_offset(&self) -> f64 {
        self.series.as_ref().map_or(0.0, |series| {
            sample_width(series) + SAMPLE_GAP_PT * UNITS_PER_PT
        })
    }
}

/// Returns the length of paper on which a sample of the series is drawn.
pub(super) fn sample_width(series: &Series) -> f64 {
    let pt = match series.mark {
        Mark::Points { .. } => 5.0,
        Mark::Line { .. } | Mark::Band { .. } | Mark::Bars { .. } => SAMPLE_PT,
    };
    pt * UNITS_PER_PT
}
