//! Curves over a value axis, drawn in braille.

use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Line};

use crate::theme::Theme;

/// Columns of the axis with its labels.
const GUTTER: u16 = 7;

/// A curve; `None` breaks it.
pub(crate) struct Trace {
    pub(crate) points: Vec<(f64, Option<f64>)>,
    pub(crate) style: Style,
}

/// A value axis with round limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ValueAxis {
    low: f64,
    high: f64,
    step: f64,
}

impl ValueAxis {
    /// Returns the smallest axis of at most four round steps around `values`; `None` without a finite value.
    pub(crate) fn around(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (low, high) = values
            .filter(|v| v.is_finite() && v.abs() < 1e12)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        if low > high {
            return None;
        }
        // A constant is drawn in the middle of a span that shows its digits.
        let span = (high - low).max(1e-3 * high.abs()).max(1e-6);
        let mut step = round_up(span / 4.0);
        loop {
            let from = (low / step).floor();
            let steps = ((high / step).ceil() - from).max(1.0);
            if steps <= 4.0 {
                return Some(Self {
                    low: from * step,
                    high: (from + steps) * step,
                    step,
                });
            }
            step = round_up(step * 1.5);
        }
    }

    /// Returns both ends and the steps between them.
    fn ticks(self) -> impl Iterator<Item = f64> {
        let steps = ((self.high - self.low) / self.step).round() as u32;
        // Multiples of the step, so that zero is exactly zero.
        let first = (self.low / self.step).round();
        (0..=steps).map(move |k| (first + f64::from(k)) * self.step)
    }

    /// Returns the label of `value`.
    fn label(self, value: f64) -> String {
        let decimals = (-self.step.log10()).ceil().clamp(0.0, 6.0) as usize;
        // Adding zero turns −0 into 0.
        format!("{:.decimals$}", value + 0.0).replace('-', "−")
    }
}

/// Returns the smallest 1, 2 or 5 times a power of ten that is not below `value`.
fn round_up(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|round| round * decade)
        .into_iter()
        .find(|round| *round >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

/// Curves over a common axis.
pub(crate) struct Plot {
    pub(crate) x: (f64, f64),
    pub(crate) axis: ValueAxis,
    /// A range of values to mark behind the curves.
    pub(crate) band: Option<(f64, f64)>,
    /// Later curves lie over earlier ones.
    pub(crate) curves: Vec<Trace>,
}

impl Plot {
    /// Returns the part of `area` that holds the curves: right of the axis.
    pub(crate) fn body(area: Rect) -> Rect {
        let gutter = GUTTER.min(area.width);
        Rect {
            x: area.x + gutter,
            width: area.width - gutter,
            ..area
        }
    }

    pub(crate) fn render(&self, theme: Theme, area: Rect, buf: &mut Buffer) {
        let body = Self::body(area);
        if body.is_empty() {
            return;
        }
        self.axis(theme, area, buf);
        if let Some(band) = self.band {
            self.shade(band, theme, body, buf);
        }
        for curve in &self.curves {
            self.curve(curve, body, buf);
        }
    }

    /// Returns the cell of a point within `body`; `None` when the point lies outside.
    pub(crate) fn position(&self, (x, y): (f64, f64), body: Rect) -> Option<Position> {
        if body.is_empty() {
            return None;
        }
        let fraction = (x - self.x.0) / (self.x.1 - self.x.0);
        let row = self.row(y, body.height)?;
        let last = body.width - 1;
        (0.0..=1.0).contains(&fraction).then(|| {
            let column = (fraction * f64::from(last)).round() as u16;
            Position::new(body.x + column, body.y + row)
        })
    }

    fn row(&self, value: f64, rows: u16) -> Option<u16> {
        let fraction = (self.axis.high - value) / (self.axis.high - self.axis.low);
        // As the canvas rounds: to one of the four dots of a row.
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
        let roomy = usize::from(area.height) >= 2 * steps;
        for (i, value) in self.axis.ticks().enumerate() {
            let is_end = i == 0 || i == steps;
            let Some(row) = self.row(value, area.height).filter(|_| is_end || roomy) else {
                continue;
            };
            let label = format!("{:>1$}┤", self.axis.label(value), usize::from(GUTTER) - 1);
            buf.set_stringn(area.x, area.y + row, label, GUTTER.into(), theme.faint());
        }
    }

    fn shade(&self, (from, to): (f64, f64), theme: Theme, body: Rect, buf: &mut Buffer) {
        let row_height = (self.axis.high - self.axis.low) / f64::from(body.height);
        let centre = |y: u16| self.axis.high - (f64::from(y) + 0.5) * row_height;
        // A row belongs to the band by its centre; a band thinner than a row still gets one.
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
        let mut scratch = Buffer::empty(body);
        Canvas::default()
            .marker(Marker::Braille)
            .x_bounds([self.x.0, self.x.1])
            .y_bounds([self.axis.low, self.axis.high])
            .paint(|painter| {
                for pair in curve.points.windows(2) {
                    if let [(x1, Some(y1)), (x2, Some(y2))] = *pair {
                        painter.draw(&Line::new(x1, y1, x2, y2, Color::Reset));
                    }
                }
            })
            .render(body, &mut scratch);
        for position in body.positions() {
            let symbol = scratch[position].symbol();
            if symbol != " " && symbol != "\u{2800}" {
                put(buf, position, symbol, curve.style);
            }
        }
    }
}

/// Replaces a cell, with its colours and modifiers.
pub(crate) fn put(buf: &mut Buffer, position: impl Into<Position>, symbol: &str, style: Style) {
    let position = position.into();
    buf[position].reset();
    buf[position].set_symbol(symbol).set_style(style);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_axis_has_round_limits() {
        let labels = |values: &[f64]| {
            let axis = ValueAxis::around(values.iter().copied()).unwrap();
            axis.ticks().map(|v| axis.label(v)).collect::<Vec<_>>()
        };
        assert_eq!(labels(&[6.8, 13.9]), ["6", "8", "10", "12", "14"]);
        assert_eq!(labels(&[0.0, 0.83]), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(&[-3.2, 1.1]), ["−4", "−2", "0", "2"]);
    }

    #[test]
    fn nothing_finite_has_no_axis() {
        assert_eq!(
            ValueAxis::around([f64::NAN, f64::INFINITY].into_iter()),
            None
        );
    }

    proptest! {
        #[test]
        fn the_axis_holds_its_values_and_wastes_little(
            values in proptest::collection::vec(-1e6..1e6f64, 1..20)
        ) {
            let axis = ValueAxis::around(values.iter().copied()).unwrap();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(axis.low <= low && high <= axis.high);
            prop_assert!(axis.high - axis.low <= 10.0 * (high - low).max(1e-3 * high.abs()).max(1e-6));
        }
    }
}
