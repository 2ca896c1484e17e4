//! Curves over a value axis, drawn in braille.

use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::Style;

use crate::braille::Dots;
use crate::theme::Theme;
pub use crate::value_axis::ValueAxis;

/// Columns of the axis with its labels.
const GUTTER: u16 = 7;

/// A curve; `None` breaks it.
pub struct Trace {
    /// Its points in order of x.
    pub points: Vec<(f64, Option<f64>)>,
    /// Its style.
    pub style: Style,
}

/// A span of x: shaded if kept, hatched if rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Start of the span.
    pub from: f64,
    /// End of the span.
    pub to: f64,
    /// Whether it is kept.
    pub is_accepted: bool,
}

/// Curves over a common axis.
pub struct Plot {
    /// Limits of x.
    pub x: (f64, f64),
    /// The value axis.
    pub axis: ValueAxis,
    /// Range of values to mark behind the curves.
    pub band: Option<(f64, f64)>,
    /// Spans of x to shade behind the curves.
    pub spans: Vec<Span>,
    /// Positions of x to mark in front of the curves.
    pub cursors: Vec<f64>,
    /// The curves; later ones are drawn over earlier ones.
    pub curves: Vec<Trace>,
}

impl Plot {
    /// Returns the part of `area` for the curves: right of the axis.
    pub fn body(area: Rect) -> Rect {
        let gutter = GUTTER.min(area.width);
        Rect {
            x: area.x + gutter,
            width: area.width - gutter,
            ..area
        }
    }

    /// Draws the axis, the shading and the curves.
    pub fn render(&self, theme: Theme, area: Rect, buf: &mut Buffer) {
        let body = Self::body(area);
        if body.is_empty() {
            return;
        }
        self.axis(theme, area, buf);
        if let Some(band) = self.band {
            self.shade(band, theme, body, buf);
        }
        for is_accepted in [false, true] {
            for span in self
                .spans
                .iter()
                .filter(|span| span.is_accepted == is_accepted)
            {
                self.mark(*span, theme, body, buf);
            }
        }
        for curve in &self.curves {
            self.curve(curve, body, buf);
        }
        for cursor in self.cursors.iter().filter_map(|x| self.column(*x, body)) {
            for y in body.top()..body.bottom() {
                put(buf, (cursor, y), "│", theme.strong());
            }
        }
    }

    /// Returns the cell of a point within `body`; `None` if the point lies outside.
    pub fn position(&self, (x, y): (f64, f64), body: Rect) -> Option<Position> {
        if body.is_empty() {
            return None;
        }
        let row = self.row(y, body.height)?;
        Some(Position::new(self.column(x, body)?, body.y + row))
    }

    /// Returns the column of `x` within `body`; `None` if it lies outside.
    fn column(&self, x: f64, body: Rect) -> Option<u16> {
        let fraction = (x - self.x.0) / (self.x.1 - self.x.0);
        let last = body.width.checked_sub(1)?;
        (0.0..=1.0)
            .contains(&fraction)
            .then(|| body.x + (fraction * f64::from(last)).round() as u16)
    }

    /// Shades or hatches a span of x.
    fn mark(&self, span: Span, theme: Theme, body: Rect, buf: &mut Buffer) {
        let (from, to) = (span.from.max(self.x.0), span.to.min(self.x.1));
        let (Some(from), Some(to)) = (self.column(from, body), self.column(to, body)) else {
            return;
        };
        let (symbol, style) = if span.is_accepted {
            ("▒", theme.band())
        } else {
            ("╱", theme.rejected_stretch())
        };
        for y in body.top()..body.bottom() {
            for x in from..=to {
                put(buf, (x, y), symbol, style);
            }
        }
    }

    fn row(&self, value: f64, rows: u16) -> Option<u16> {
        let fraction = (self.axis.high - value) / (self.axis.high - self.axis.low);
        // Rounds as the canvas does, to one of the four dots of a row.
        let last_dot = f64::from(rows) * 4.0 - 1.0;
        (0.0..=1.0)
            .contains(&fraction)
            .then(|| ((fraction * last_dot).round() / 4.0) as u16)
    }

    fn axis(&self, theme: Theme, area: Rect, buf: &mut Buffer) {
        for row in 0..area.height {
            buf.set_string(area.x + GUTTER - 1, area.y + row, "│", theme.faint());
        }
        let steps = self.axis.ticks().count().saturating_sub(1);
        let has_room = usize::from(area.height) >= 2 * steps;
        for (i, value) in self.axis.ticks().enumerate() {
            let is_end = i == 0 || i == steps;
            let Some(row) = self.row(value, area.height).filter(|_| is_end || has_room) else {
                continue;
            };
            let label = format!("{:>1$}┤", self.axis.label(value), usize::from(GUTTER) - 1);
            buf.set_stringn(area.x, area.y + row, label, GUTTER.into(), theme.faint());
        }
    }

    fn shade(&self, (from, to): (f64, f64), theme: Theme, body: Rect, buf: &mut Buffer) {
        let row_height = (self.axis.high - self.axis.low) / f64::from(body.height);
        let centre = |y: u16| self.axis.high - (f64::from(y) + 0.5) * row_height;
        // A row belongs to the band if its centre does; a band thinner than a row still gets one.
        let middle = self.row(f64::midpoint(from, to), body.height);
        for y in 0..body.height {
            if !(from..=to).contains(&centre(y)) && middle != Some(y) {
                continue;
            }
            for x in body.left()..body.right() {
                buf.set_string(x, body.y + y, "░", theme.band());
            }
        }
    }

    fn curve(&self, curve: &Trace, body: Rect, buf: &mut Buffer) {
        let mut dots = Dots::new(body.width, body.height);
        let (right, bottom) = dots.last();
        let (width, height) = (self.x.1 - self.x.0, self.axis.high - self.axis.low);
        let mut previous = None;
        for (x, y) in &curve.points {
            let x_share = (x - self.x.0) / width;
            let point = y
                .filter(|y| y.is_finite() && (0.0..=1.0).contains(&x_share))
                .map(|y| {
                    // Values beyond the axis are drawn at its end.
                    let y_share = ((self.axis.high - y) / height).clamp(0.0, 1.0);
                    (x_share * right, y_share * bottom)
                });
            if let (Some(from), Some(to)) = (previous, point) {
                dots.line(from, to);
            }
            previous = point;
        }
        dots.stamp(body, curve.style, buf);
    }
}

/// Replaces a cell, with its colours and modifiers.
pub fn put(buf: &mut Buffer, position: impl Into<Position>, symbol: &str, style: Style) {
    let position = position.into();
    buf[position].reset();
    buf[position].set_symbol(symbol).set_style(style);
}
