//! Text in DejaVu Sans, which is compiled in, or in a font of the laboratory.

use ab_glyph::{Font, FontArc, FontRef, FontVec, PxScale, ScaleFont};

use crate::canvas::{Canvas, Colour};

/// A font that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a TrueType or OpenType font; name a file that ends in .ttf or .otf")]
pub struct NoFont;

/// A typeface.
#[derive(Clone, Debug)]
pub struct Typeface(FontArc);

impl Typeface {
    /// Returns DejaVu Sans: Latin, Greek, Cyrillic and other scripts written from left to right.
    ///
    /// # Errors
    /// Never, unless the program was damaged.
    pub fn default_face() -> Result<Self, NoFont> {
        let font = FontRef::try_from_slice(plotting::DEJAVU_SANS).map_err(|_| NoFont)?;
        Ok(Self(FontArc::new(font)))
    }

    /// Reads a font file.
    ///
    /// # Errors
    /// [`NoFont`].
    pub fn read(file: Vec<u8>) -> Result<Self, NoFont> {
        let font = FontVec::try_from_vec(file).map_err(|_| NoFont)?;
        Ok(Self(FontArc::new(font)))
    }

    /// Returns the first character of `text` that the font does not cover.
    #[must_use]
    pub fn lacks(&self, text: &str) -> Option<char> {
        let is_missing = |c: &char| !c.is_whitespace() && self.0.glyph_id(*c).0 == 0;
        text.chars().find(is_missing)
    }

    /// Returns the scale for ab_glyph, which is the height from ascent to descent.
    fn scale(&self, em: f64) -> PxScale {
        let per_em = self.0.units_per_em().unwrap_or(1.0);
        PxScale::from(em as f32 * self.0.height_unscaled() / per_em)
    }

    /// Returns the width of a line of text, in the unit of `em`.
    #[must_use]
    pub fn width(&self, text: &str, em: f64) -> f64 {
        let font = self.0.as_scaled(self.scale(em));
        let advances = text.chars().map(|c| font.h_advance(font.glyph_id(c)));
        f64::from(advances.sum::<f32>())
    }

    /// Breaks a text into lines of at most `width`; a longer word is not broken.
    #[must_use]
    pub fn wrapped(&self, text: &str, em: f64, width: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}"), em) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// Writes a line centred on `x`, with its baseline at `y`.
    pub fn write(
        &self,
        canvas: &mut Canvas,
        text: &str,
        (x, y): (f64, f64),
        em: f64,
        colour: Colour,
    ) {
        let scale = self.scale(em);
        let font = self.0.as_scaled(scale);
        let mut advance = (x - self.width(text, em) / 2.0) as f32;
        for c in text.chars() {
            let id = font.glyph_id(c);
            let glyph = id.with_scale_and_position(scale, ab_glyph::point(advance, y as f32));
            advance += font.h_advance(id);
            if let Some(outline) = font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                outline.draw(|dx, dy, coverage| {
                    let (x, y) = (
                        corner.x as i64 + i64::from(dx),
                        corner.y as i64 + i64::from(dy),
                    );
                    canvas.blend(x, y, colour, f64::from(coverage));
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use participant_texts::{Language, Texts};

    #[test]
    fn the_built_in_font_has_every_letter_of_every_language() {
        let face = Typeface::default_face().unwrap();
        for language in Language::ALL {
            for (key, text) in Texts::in_language(language).all() {
                assert_eq!(face.lacks(text), None, "{language:?} {key} {text}");
            }
        }
        assert_eq!(face.lacks("準備"), Some('準'));
    }

    #[test]
    fn lines_are_no_wider_than_the_limit() {
        let face = Typeface::default_face().unwrap();
        let text = "Appuyez sur le bouton de maintien et gardez-le enfoncé";
        let lines = face.wrapped(text, 40.0, 500.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| face.width(line, 40.0) <= 500.0));
        assert_eq!(lines.join(" "), text);
    }

    #[test]
    fn an_invalid_font_is_refused() {
        assert!(Typeface::read(b"not a font".to_vec()).is_err());
    }
}
