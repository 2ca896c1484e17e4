//! The ruler page: the operator matches a line with a bank card, which gives the width of a pixel.

use crate::canvas::Canvas;
use crate::lettering::Typeface;
use crate::page::{FAINT, GROUND, INK, SLIDER};

/// Length of the line: the width of every bank card (ISO/IEC 7810, ID-1), m.
pub const LINE_M: f64 = 0.0856;
/// Shortest line, pixels; a shorter one would mean pixels larger than any monitor's.
const SHORTEST: u32 = 80;
/// Width of a pixel assumed for a monitor that was not matched: 96 pixels to the inch, m.
pub const ASSUMED_PIXEL_M: f64 = 0.0254 / 96.0;

/// The ruler page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ruler {
    line: u32,
    longest: u32,
}

impl Ruler {
    /// Returns a page `width` pixels wide, with a line as long as the card if a pixel is `pixel_m` wide.
    #[must_use]
    pub fn new(width: u32, pixel_m: f64) -> Self {
        let longest = width.saturating_sub(20).max(SHORTEST);
        // The cast saturates.
        let line = (LINE_M / pixel_m).round() as u32;
        Self {
            line: line.clamp(SHORTEST, longest),
            longest,
        }
    }

    /// Lengthens or shortens the line by pixels.
    pub fn adjust(&mut self, pixels: i32) {
        self.line = self
            .line
            .saturating_add_signed(pixels)
            .clamp(SHORTEST, self.longest);
    }

    /// Returns the width of a pixel, m.
    #[must_use]
    pub fn pixel_m(&self) -> f64 {
        LINE_M / f64::from(self.line)
    }

    /// Draws the page.
    pub fn draw(&self, canvas: &mut Canvas, face: &Typeface) {
        let (width, height) = canvas.size();
        let (width, height) = (width as f64, height as f64);
        canvas.clear(GROUND);
        let middle = width / 2.0;
        let half_width = f64::from(self.line) / 2.0;
        let y = height * 0.5;
        for (text, y_share, em, colour) in [
            ("Hold a bank card to the line", 0.18, 16.0, INK),
            (
                "and make the line as wide as the card: 85.6 mm",
                0.25,
                26.0,
                INK,
            ),
            (
                "← →  by a pixel     ↑ ↓  by ten     Enter  saves it     Esc  cancels",
                0.8,
                32.0,
                FAINT,
            ),
        ] {
            let em = (height / em).min(height / em * width * 0.94 / face.width(text, height / em));
            face.write(canvas, text, (middle, height * y_share), em, colour);
        }
        let text = format!("{} pixels of {:.4} mm", self.line, 1e3 * self.pixel_m());
        face.write(canvas, &text, (middle, height * 0.66), height / 36.0, FAINT);
        canvas.rectangle(
            (middle - half_width, y - 1.0),
            (middle + half_width, y + 1.0),
            SLIDER,
        );
        for x in [middle - half_width, middle + half_width - 2.0] {
            canvas.rectangle((x, y - height * 0.08), (x + 2.0, y + height * 0.08), SLIDER);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_as_long_as_the_pixels_make_it_and_says_how_wide_they_are() {
        let mut ruler = Ruler::new(1920, ASSUMED_PIXEL_M);
        let pixels = (LINE_M / ASSUMED_PIXEL_M).round();
        assert!((ruler.pixel_m() - LINE_M / pixels).abs() < 1e-12);
        ruler.adjust(10);
        assert!((ruler.pixel_m() - LINE_M / (pixels + 10.0)).abs() < 1e-12);
        let mut canvas = Canvas::new(1920, 1080, 0);
        ruler.draw(&mut canvas, &Typeface::default_face().unwrap());
        let width_px = (0..1920)
            .filter(|x| canvas.pixel(*x, 540) == Some(SLIDER))
            .count();
        assert!(
            (width_px as f64 - (pixels + 10.0)).abs() <= 2.0,
            "{width_px}"
        );
    }

    #[test]
    fn the_line_stays_on_the_screen_for_all_keys_and_scales() {
        for width in [0, 1, 90, 640, 20_000] {
            for pixel_m in [0.0, f64::NAN, 1e-9, 1.0, f64::INFINITY] {
                let mut ruler = Ruler::new(width, pixel_m);
                for pixels in [i32::MAX, i32::MIN, 1, -1] {
                    ruler.adjust(pixels);
                    assert!(ruler.pixel_m() > 0.0 && ruler.pixel_m() <= LINE_M / 80.0);
                }
                ruler.draw(
                    &mut Canvas::new(width.min(640) as usize, 5, 0),
                    &Typeface::default_face().unwrap(),
                );
            }
        }
    }
}
