//! Draws lines, shapes and text on either backend, in drawing units.

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};
use plotters_backend::{DrawingBackend, DrawingErrorKind};

use crate::font::FAMILY;
use crate::path::{Frame, Point, dashes};
use crate::style::{Marker, UNITS_PER_PT};

/// Ratio of Plotters' font size to the em that its SVG backend writes.
pub(super) const PLOTTERS_SIZE_PER_EM: f64 = 1.24;
/// Distance from the top anchor to the baseline, in ems, as Plotters' SVG backend places text.
pub(super) const BASELINE_EM: f64 = 0.76;

pub(super) type Rgb = (u8, u8, u8);
pub(super) const BLACK: Rgb = (0, 0, 0);
const WHITE: Rgb = (255, 255, 255);

/// Part of a line of text that lies at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Pen that draws on a backend.
pub(super) struct Pen<'a, B: DrawingBackend>(pub(super) &'a mut B);

type DrawResult<B> = Result<(), DrawingErrorKind<<B as DrawingBackend>::ErrorType>>;

fn units((x, y): Point) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

fn style((red, green, blue): Rgb, stroke_pt: f64) -> ShapeStyle {
    let color = RGBColor(red, green, blue);
    let stroke = (stroke_pt * UNITS_PER_PT).round() as u32;
    ShapeStyle::from(color).stroke_width(stroke)
}

impl<B: DrawingBackend> Pen<'_, B> {
    /// Paints everything white.
    pub(super) fn clear(&mut self) -> DrawResult<B> {
        let (width, height) = self.0.get_size();
        let corner = (width as i32, height as i32);
        self.0.draw_rect((0, 0), corner, &style(WHITE, 0.0), true)
    }

    /// Draws a curve with round joints and ends.
    pub(super) fn line(&mut self, points: &[Point], rgb: Rgb, width_pt: f64) -> DrawResult<B> {
        let mut path: Vec<(i32, i32)> = points.iter().copied().map(units).collect();
        path.dedup();
        self.0.draw_path(path, &style(rgb, width_pt))
    }

    /// Draws a dashed curve.
    pub(super) fn dashed(
        &mut self,
        points: &[Point],
        rgb: Rgb,
        width_pt: f64,
        pattern_pt: &[f64],
    ) -> DrawResult<B> {
        let pattern: Vec<f64> = pattern_pt.iter().map(|pt| pt * UNITS_PER_PT).collect();
        dashes(points, &pattern)
            .iter()
            .try_for_each(|dash| self.line(dash, rgb, width_pt))
    }

    pub(super) fn outline(&mut self, frame: &Frame, width_pt: f64) -> DrawResult<B> {
        let corners = [
            (frame.left, frame.top),
            (frame.right, frame.top),
            (frame.right, frame.bottom),
            (frame.left, frame.bottom),
            (frame.left, frame.top),
        ];
        self.line(&corners, BLACK, width_pt)
    }

    pub(super) fn fill(&mut self, frame: &Frame, rgb: Rgb) -> DrawResult<B> {
        let from = units((frame.left, frame.top));
        let to = units((frame.right, frame.bottom));
        self.0.draw_rect(from, to, &style(rgb, 0.0), true)
    }

    pub(super) fn polygon(&mut self, corners: &[Point], rgb: Rgb) -> DrawResult<B> {
        let corners: Vec<(i32, i32)> = corners.iter().copied().map(units).collect();
        self.0.fill_polygon(corners, &style(rgb, 0.0))
    }

    pub(super) fn marker(
        &mut self,
        marker: Marker,
        (x, y): Point,
        radius_pt: f64,
        rgb: Rgb,
    ) -> DrawResult<B> {
        let radius = radius_pt * UNITS_PER_PT;
        let radius_units = radius.round() as u32;
        let fill_style = style(rgb, 0.0);
        match marker {
            Marker::Disc => self
                .0
                .draw_circle(units((x, y)), radius_units, &fill_style, true),
            Marker::Circle => {
                self.0
                    .draw_circle(units((x, y)), radius_units, &fill_style, true)?;
                let hole = (0.55 * radius).round() as u32;
                let white = style(WHITE, 0.0);
                self.0.draw_circle(units((x, y)), hole, &white, true)
            }
            Marker::Square => {
                let half = 0.89 * radius;
                let frame = Frame {
                    left: x - half,
                    top: y - half,
                    right: x + half,
                    bottom: y + half,
                };
                self.fill(&frame, rgb)
            }
            Marker::Triangle => {
                let (half_width, height_above, height_below) =
                    (1.1 * radius, 1.2 * radius, 0.8 * radius);
                self.polygon(
                    &[
                        (x - half_width, y + height_below),
                        (x + half_width, y + height_below),
                        (x, y - height_above),
                    ],
                    rgb,
                )
            }
        }
    }

    /// Draws a line of text with the start, middle or end of its baseline at the position.
    pub(super) fn text(
        &mut self,
        text: &str,
        (x, baseline): Point,
        size_pt: f64,
        anchor: Anchor,
    ) -> DrawResult<B> {
        let em = size_pt * UNITS_PER_PT;
        let style = text_style(em, anchor);
        let position = units((x, baseline - BASELINE_EM * em));
        self.0.draw_text(text, &style, position)
    }

    /// Draws a line of text that reads upwards, with its middle at the position.
    pub(super) fn upward_text(
        &mut self,
        text: &str,
        (baseline, y): Point,
        size_pt: f64,
    ) -> DrawResult<B> {
        let em = size_pt * UNITS_PER_PT;
        let style = text_style(em, Anchor::Middle).transform(FontTransform::Rotate270);
        let position = units((baseline - BASELINE_EM * em, y));
        self.0.draw_text(text, &style, position)
    }
}

fn text_style(em: f64, anchor: Anchor) -> TextStyle<'static> {
    let horizontal = match anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
        Anchor::End => HPos::Right,
    };
    TextStyle::from((FAMILY, PLOTTERS_SIZE_PER_EM * em).into_font())
        .color(&plotters::style::BLACK)
        .pos(Pos::new(horizontal, VPos::Top))
}
