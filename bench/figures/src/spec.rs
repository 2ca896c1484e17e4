//! A figure before it is drawn: what it shows, in data units. No pixel is known here.

use crate::style::{Dash, Ink, Marker, Width};

/// A figure and its caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Stem of its files.
    pub name: String,
    /// What it shows, in a line.
    pub title: String,
    /// Caption with every assumed parameter.
    pub caption: String,
    /// Printed width.
    pub width: Width,
    /// Panels beside each other.
    pub columns: usize,
    /// Height of a panel's frame, mm.
    pub panel_height_mm: f64,
    /// Where the curves are named.
    pub key: Key,
    /// Row by row.
    pub panels: Vec<Panel>,
}

/// Where the curves are named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// In each panel, where it covers least.
    InPanels,
    /// Once, above the panels.
    Above,
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Drawn in this order.
    pub series: Vec<Series>,
    /// Stretches of x shaded behind the data.
    pub shaded: Vec<(f64, f64)>,
    /// Lines of text beside the names of the curves.
    pub notes: Vec<String>,
}

impl Panel {
    /// Axes without data.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            series: Vec::new(),
            shaded: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// What it spans.
    pub span: Span,
    /// Whether ticks and label are written; not where the panel below repeats them.
    pub written: bool,
}

impl Axis {
    /// A linear axis that spans its data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
            span: Span::Data,
            written: true,
        }
    }

    /// A logarithmic axis that spans its data.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(label)
        }
    }

    /// With `share` of the data's range left free above them.
    pub fn with_headroom(self, share: f64) -> Self {
        Self {
            span: Span::WithHeadroom(share),
            ..self
        }
    }

    /// From zero to the greatest value.
    pub fn from_zero(self) -> Self {
        Self {
            span: Span::FromZero,
            ..self
        }
    }

    /// From `low` to `high`, whatever the data.
    pub fn between(self, low: f64, high: f64) -> Self {
        Self {
            span: Span::Fixed(low, high),
            ..self
        }
    }

    /// Ticks only.
    pub fn unwritten(self) -> Self {
        Self {
            written: false,
            ..self
        }
    }
}

/// Spacing along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Even.
    Linear,
    /// By decades.
    Logarithmic,
}

/// What an axis spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Span {
    /// The data and a margin.
    Data,
    /// The data and a margin, and this share of their range above them, for words.
    WithHeadroom(f64),
    /// Zero to the greatest value and a margin.
    FromZero,
    /// Given ends.
    Fixed(f64, f64),
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the key; none for what needs no name or bears it already.
    pub name: Option<String>,
    /// Its ink.
    pub ink: Ink,
    /// How it is drawn.
    pub mark: Mark,
}

impl Series {
    /// A curve; a value that is not finite breaks it.
    pub fn line(ink: Ink, dash: Dash, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Line { dash, points },
        }
    }

    /// Separate points.
    pub fn points(ink: Ink, marker: Marker, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Points { marker, points },
        }
    }

    /// The stretch between two curves: x, low, high.
    pub fn band(ink: Ink, edges: Vec<(f64, f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Band { edges },
        }
    }

    /// With a name in the key.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self {
            name: Some(name.into()),
            ..self
        }
    }

    /// Returns the points that its panel has to show.
    #[must_use]
    pub fn extent(&self) -> Vec<(f64, f64)> {
        match &self.mark {
            Mark::Line { points, .. } | Mark::Points { points, .. } => points.clone(),
            Mark::Band { edges } => edges
                .iter()
                .flat_map(|&(x, low, high)| [(x, low), (x, high)])
                .collect(),
        }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A curve.
    Line {
        /// How it is broken.
        dash: Dash,
        /// x, y.
        points: Vec<(f64, f64)>,
    },
    /// Separate points.
    Points {
        /// Their shape.
        marker: Marker,
        /// x, y.
        points: Vec<(f64, f64)>,
    },
    /// An area, such as a standard error around a curve.
    Band {
        /// x, low, high.
        edges: Vec<(f64, f64, f64)>,
    },
}
