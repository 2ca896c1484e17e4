//! Bitmap backend with round-jointed lines and properly spaced text.
//!
//! Plotters draws a thick line as one polygon, which leaves its crossings white, and sets glyphs without their side
//! bearings. This backend replaces both and leaves everything else to Plotters.

use plotters::backend::BitMapBackend;
use plotters_backend::text_anchor::HPos;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};

use crate::font::Typeface;
use crate::pen::{BASELINE_EM, PLOTTERS_SIZE_PER_EM};

type DrawResult<E> = Result<(), DrawingErrorKind<E>>;

/// Backend that draws into a buffer of pixels.
pub(super) struct Bitmap<'a> {
    pixels: BitMapBackend<'a>,
    typeface: &'a Typeface,
}

impl<'a> Bitmap<'a> {
    /// Draws into `buffer`, which has 3 bytes per pixel.
    pub(super) fn new(buffer: &'a mut [u8], size: (u32, u32), typeface: &'a Typeface) -> Self {
        Self {
            pixels: BitMapBackend::with_buffer(buffer, size),
            typeface,
        }
    }
}

/// Returns the squared distance of a point from a straight segment.
fn distance_squared((x, y): (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length_squared = dx * dx + dy * dy;
    let share = if length_squared > 0.0 {
        (((x - from.0) * dx + (y - from.1) * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (x - from.0 - share * dx).powi(2) + (y - from.1 - share * dy).powi(2)
}

impl DrawingBackend for Bitmap<'_> {
    type ErrorType = <BitMapBackend<'static> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.pixels.get_size()
    }

    fn ensure_prepared(&mut self) -> DrawResult<Self::ErrorType> {
        self.pixels.ensure_prepared()
    }

    fn present(&mut self) -> DrawResult<Self::ErrorType> {
        self.pixels.present()
    }

    fn draw_pixel(
        &mut self,
        point: BackendCoord,
        color: BackendColor,
    ) -> DrawResult<Self::ErrorType> {
        self.pixels.draw_pixel(point, color)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> DrawResult<Self::ErrorType> {
        self.pixels.draw_rect(upper_left, bottom_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> DrawResult<Self::ErrorType> {
        let radius = 0.5 * f64::from(style.stroke_width());
        let reach = radius.ceil() as i32;
        let mut last_point: Option<BackendCoord> = None;
        for to in path {
            let from = last_point.replace(to).unwrap_or(to);
            let float = |(x, y): BackendCoord| (f64::from(x), f64::from(y));
            for y in from.1.min(to.1) - reach..=from.1.max(to.1) + reach {
                for x in from.0.min(to.0) - reach..=from.0.max(to.0) + reach {
                    if distance_squared(float((x, y)), float(from), float(to)) <= radius * radius {
                        self.draw_pixel((x, y), style.color())?;
                    }
                }
            }
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        position: BackendCoord,
    ) -> DrawResult<Self::ErrorType> {
        let em = style.size() / PLOTTERS_SIZE_PER_EM;
        let width = self.typeface.width(text, em);
        let offset_x = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * width,
            HPos::Right => -width,
        };
        let (offset_x, offset_y) = (offset_x.round() as i32, (BASELINE_EM * em).round() as i32);
        let is_upright = matches!(style.transform(), FontTransform::None);
        let color = style.color();
        let mut result = Ok(());
        let pixels = &mut self.pixels;
        self.typeface.rasterise(text, em, |x, y, coverage| {
            let (x, y) = (offset_x + x, offset_y + y);
            let (x, y) = if is_upright { (x, y) } else { (y, -x) };
            let shade = BackendColor {
                alpha: color.alpha * f64::from(coverage),
                ..color
            };
            if result.is_ok() {
                result = pixels.draw_pixel((position.0 + x, position.1 + y), shade);
            }
        });
        result
    }
}
