//! Content of figures, in data units.

use crate::style::{Dash, Ink, Marker, Width};

/// Figure with its caption; [`Figure::to_svg`] has an example.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its files, without their endings.
    pub name: String,
    /// Title of one line.
    pub title: String,
    /// Caption, which names every assumed parameter.
    pub caption: String,
    /// Printed width.
    pub width: Width,
    /// Number of panels in a row.
    pub columns: usize,
    /// Height of a panel's frame, mm.
    pub panel_height_mm: f64,
    /// Line of small print below the panels, such as the provenance of the data.
    pub footnote: Option<String>,
    /// Position of the key.
    pub key: Key,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
}

/// Position of the key, which names the curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// In each panel, where it covers the fewest points.
    InPanels,
    /// Once, above the panels.
    Above,
}

/// Pair of axes with their series.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Series, in the order of drawing.
    pub series: Vec<Series>,
    /// Ranges of x that are shaded behind the data.
    pub shaded_ranges: Vec<(f64, f64)>,
    /// Lines of text in the key.
    pub notes: Vec<String>,
}

impl Panel {
    /// Makes a panel with axes and without data.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            series: Vec::new(),
            shaded_ranges: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// Axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Range of values.
    pub span: AxisRange,
    /// Whether tick labels and label are written; false if the panel below repeats them.
    pub has_labels: bool,
    /// Names of the values 1, 2, …, which replace their numbers at the ticks; empty for a scale of numbers.
    pub names: Vec<String>,
}

impl Axis {
    /// Makes a linear axis that spans its data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
            span: AxisRange::Data,
            has_labels: true,
            names: Vec::new(),
        }
    }

    /// Makes an axis of named places at 1, 2, …
    pub fn named(label: impl Into<String>, names: Vec<String>) -> Self {
        let last = names.len() as f64;
        Self {
            names,
            ..Self::linear(label).with_range(0.4, last + 0.6)
        }
    }

    /// Makes a logarithmic axis that spans its data.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(label)
        }
    }

    /// Leaves `share` of the data's range free above them.
    pub fn with_headroom(self, share: f64) -> Self {
        Self {
            span: AxisRange::WithHeadroom(share),
            ..self
        }
    }

    /// Spans zero to the greatest value.
    pub fn from_zero(self) -> Self {
        Self {
            span: AxisRange::FromZero,
            ..self
        }
    }

    /// Spans `low` to `high`, regardless of the data.
    pub fn with_range(self, low: f64, high: f64) -> Self {
        Self {
            span: AxisRange::Fixed(low, high),
            ..self
        }
    }

    /// Draws ticks without their labels and without the axis's label.
    pub fn without_labels(self) -> Self {
        Self {
            has_labels: false,
            ..self
        }
    }
}

/// Spacing along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Even spacing.
    Linear,
    /// Equal spacing of decades.
    Logarithmic,
}

/// Range of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxisRange {
    /// The data and a margin.
    Data,
    /// The data and a margin, plus this share of their range above them, for text.
    WithHeadroom(f64),
    /// Zero to the greatest value and a margin.
    FromZero,
    /// Given ends.
    Fixed(f64, f64),
}

/// Points drawn together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the key; `None` leaves the series out of the key.
    pub name: Option<String>,
    /// Ink of the series.
    pub ink: Ink,
    /// Way of drawing.
    pub mark: Mark,
}

impl Series {
    /// Makes a curve; a value that is not finite breaks it.
    pub fn line(ink: Ink, dash: Dash, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Line { dash, points },
        }
    }

    /// Makes separate points.
    pub fn points(ink: Ink, marker: Marker, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Points { marker, points },
        }
    }

    /// Makes the area between two curves: x, low, high.
    pub fn band(ink: Ink, edges: Vec<(f64, f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Band { edges },
        }
    }

    /// Makes upright bars, such as intervals about points: x, low, high.
    pub fn bars(ink: Ink, bars: Vec<(f64, f64, f64)>) -> Self {
        Self {
            name: None,
            ink,
            mark: Mark::Bars { bars },
        }
    }

    /// Gives the series a name in the key.
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self {
            name: Some(name.into()),
            ..self
        }
    }

    /// Returns the points that the panel must show.
    #[must_use]
    pub fn extent(&self) -> Vec<(f64, f64)> {
        match &self.mark {
            Mark::Line { points, .. } | Mark::Points { points, .. } => points.clone(),
            Mark::Band { edges } | Mark::Bars { bars: edges } => edges
                .iter()
                .flat_map(|&(x, low, high)| [(x, low), (x, high)])
                .collect(),
        }
    }
}

/// Way of drawing a series.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A curve.
    Line {
        /// Dashes of the curve.
        dash: Dash,
        /// x, y.
        points: Vec<(f64, f64)>,
    },
    /// Separate points.
    Points {
        /// Shape of the points.
        marker: Marker,
        /// x, y.
        points: Vec<(f64, f64)>,
    },
    /// An area, such as a standard error around a curve.
    Band {
        /// x, low, high.
        edges: Vec<(f64, f64, f64)>,
    },
    /// Upright bars.
    Bars {
        /// x, low, high; bars that are not finite are omitted.
        bars: Vec<(f64, f64, f64)>,
    },
}
