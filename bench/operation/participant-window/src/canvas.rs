//! A canvas of pixels, and anti-aliased rectangles and rings on it.

/// A colour, 0x00RRGGBB.
pub type Colour = u32;

/// A picture in pixels, 0x00RRGGBB, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u32>,
}

impl Canvas {
    /// Returns a picture filled with one colour.
    #[must_use]
    pub fn new(width: usize, height: usize, colour: Colour) -> Self {
        Self {
            width,
            height,
            pixels: vec![colour; width * height],
        }
    }

    /// Returns the width and the height.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns all pixels.
    #[must_use]
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Fills the picture with one colour.
    pub fn clear(&mut self, colour: Colour) {
        self.pixels.fill(colour);
    }

    /// Copies rows from a picture of the same size.
    pub fn copy_rows(&mut self, from: &Self, rows: std::ops::Range<usize>) {
        let (first, last) = (rows.start.min(self.height), rows.end.min(self.height));
        let pixels = first * self.width..last * self.width;
        if let (Some(to), Some(from)) =
            (self.pixels.get_mut(pixels.clone()), from.pixels.get(pixels))
        {
            to.copy_from_slice(from);
        }
    }

    /// Returns the colour of a pixel; `None` outside the picture.
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> Option<Colour> {
        (x < self.width).then(|| self.pixels.get(y * self.width + x).copied())?
    }

    /// Blends a colour into a pixel by `coverage`, 0 to 1.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return;
        };
        if x >= self.width || y >= self.height || coverage.is_nan() || coverage <= 0.0 {
            return;
        }
        let pixel = &mut self.pixels[y * self.width + x];
        if coverage >= 1.0 {
            *pixel = colour;
            return;
        }
        let channel = |shift: u32| {
            let (background, foreground) = ((*pixel >> shift) & 0xff, (colour >> shift) & 0xff);
            let mixed = f64::from(background) * (1.0 - coverage) + f64::from(foreground) * coverage;
            (mixed.round() as u32) << shift
        };
        *pixel = channel(16) | channel(8) | channel(0);
    }

    /// Fills a rectangle; its edges may lie between pixels.
    pub fn rectangle(&mut self, (x0, y0): (f64, f64), (x1, y1): (f64, f64), colour: Colour) {
        if !(x0 < x1 && y0 < y1) {
            return;
        }
        let (columns, rows) = (
            pixel_range(x0, x1, self.width),
            pixel_range(y0, y1, self.height),
        );
        for y in rows {
            let part_y = overlap(y, y0, y1);
            for x in columns.clone() {
                self.blend(x, y, colour, part_y * overlap(x, x0, x1));
            }
        }
    }

    /// Draws a ring, or a disc if `thickness` equals the radius.
    pub fn ring(&mut self, (x0, y0): (f64, f64), radius: f64, thickness: f64, colour: Colour) {
        let reach = radius + 1.0;
        if !(reach.is_finite() && x0.is_finite() && y0.is_finite()) {
            return;
        }
        for y in pixel_range(y0 - reach, y0 + reach, self.height) {
            for x in pixel_range(x0 - reach, x0 + reach, self.width) {
                let distance = (x as f64 + 0.5 - x0).hypot(y as f64 + 0.5 - y0);
                let outer = (radius - distance + 0.5).clamp(0.0, 1.0);
                let inner = if thickness < radius {
                    (distance - (radius - thickness) + 0.5).clamp(0.0, 1.0)
                } else {
                    1.0
                };
                self.blend(x, y, colour, outer * inner);
            }
        }
    }
}

/// Returns the pixels that an interval touches, among the first `count`.
fn pixel_range(low: f64, high: f64, count: usize) -> std::ops::Range<i64> {
    let count = count as f64;
    // NaN becomes 0.
    let low = if low >= 0.0 { low.min(count) } else { 0.0 };
    let high = if high >= 0.0 { high.min(count) } else { 0.0 };
    low.floor() as i64..high.ceil() as i64
}

/// Returns the fraction of a pixel that lies within an interval.
fn overlap(pixel: i64, from: f64, to: f64) -> f64 {
    let pixel = pixel as f64;
    (to.min(pixel + 1.0) - from.max(pixel)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_edge_between_pixels_shares_its_pixel() {
        let mut canvas = Canvas::new(6, 3, 0);
        canvas.rectangle((1.25, 1.0), (4.5, 2.0), 0x00ff_ffff);
        let row: Vec<u32> = (0..6).map(|x| canvas.pixel(x, 1).unwrap() & 0xff).collect();
        assert_eq!(row, [0, 191, 255, 255, 128, 0]);
        assert_eq!(canvas.pixel(2, 0), Some(0));
        assert_eq!(canvas.pixel(6, 0), None);
    }

    proptest! {
        #[test]
        fn nothing_is_drawn_outside_and_nothing_panics(
            (x0, y0, x1, y1) in (any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>()),
            (a, b, c) in (-50.0..50.0f64, -50.0..50.0f64, 0.0..100.0f64),
        ) {
            let mut canvas = Canvas::new(17, 9, 0);
            canvas.rectangle((x0, y0), (x1, y1), 1);
            canvas.rectangle((a, b), (c, c), 2);
            canvas.ring((x0, y0), x1.abs().min(1e6), 2.0, 3);
            canvas.ring((a, b), c, 2.0, 3);
            canvas.blend(a as i64, b as i64, 4, x0);
        }
    }
}
