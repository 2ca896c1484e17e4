//! Typeface, compiled in so that text has the same extent on every machine.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};

use crate::figure_error::FigureError;

/// Font families that an SVG names for its viewer; Verdana has the same widths as DejaVu Sans.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// DejaVu Sans, the TrueType typeface of all text; the licence is in the same folder.
pub const DEJAVU_SANS: &[u8] = include_bytes!("../fonts/DejaVuSans.ttf");

/// Typeface of all text.
pub(super) struct Typeface(FontRef<'static>);

impl Typeface {
    pub(super) fn load() -> Result<Self, FigureError> {
        FontRef::try_from_slice(DEJAVU_SANS)
            .map(Self)
            .map_err(|_| FigureError::Typeface)
    }

    /// Returns the scale for `ab_glyph`, which is relative to the height from ascent to descent; typesetting uses the em.
    fn scale(&self, em: f64) -> PxScale {
        let per_em = self.0.units_per_em().unwrap_or(1.0);
        PxScale::from(em as f32 * self.0.height_unscaled() / per_em)
    }

    /// Returns the advance of a line of text, in the unit of `em`.
    pub(super) fn width(&self, text: &str, em: f64) -> f64 {
        let font = self.0.as_scaled(self.scale(em));
        f64::from(
            text.chars()
                .map(|c| font.h_advance(font.glyph_id(c)))
                .sum::<f32>(),
        )
    }

    /// Calls `dot` with the coverage of each pixel of a line of text that starts at the origin of its baseline.
    pub(super) fn rasterise(&self, text: &str, em: f64, mut dot: impl FnMut(i32, i32, f32)) {
        let scale = self.scale(em);
        let font = self.0.as_scaled(scale);
        let mut advance = 0.0;
        for c in text.chars() {
            let id = font.glyph_id(c);
            let glyph = id.with_scale_and_position(scale, ab_glyph::point(advance, 0.0));
            advance += font.h_advance(id);
            if let Some(outline) = font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                outline.draw(|x, y, coverage| {
                    dot(
                        corner.x as i32 + x as i32,
                        corner.y as i32 + y as i32,
                        coverage,
                    );
                });
            }
        }
    }
}
