//! Positions on the screen: true to the millimetre along the plate, otherwise relative to the screen's height.

use crate::message::Track;

/// Height of the slider, m.
const SLIDER_HEIGHT_M: f64 = 0.024;
/// Width of the slider, m.
pub const SLIDER_WIDTH_M: f64 = 0.003;
/// Radius of the disc that stands for a fingertip, m.
const FINGERTIP_M: f64 = 0.008;
/// Vertical position of the plate, as a fraction of the screen's height.
const PLATE_DOWN: f64 = 0.74;

/// A screen and the size of its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Width, pixels.
    pub width: f64,
    /// Height, pixels.
    pub height: f64,
    /// Width of a pixel, m.
    pub pixel_m: f64,
}

impl Geometry {
    /// Converts a length to pixels.
    #[must_use]
    pub fn pixels(&self, length_m: f64) -> f64 {
        length_m / self.pixel_m
    }

    /// Returns the horizontal position of a point of the plate, pixels from the left; the plate is centred on the screen.
    #[must_use]
    pub fn x(&self, track: &Track, place_m: f64) -> f64 {
        let from_middle_m = (place_m - track.plate_m / 2.0) * self.fitting(track);
        self.width / 2.0 + self.pixels(from_middle_m)
    }

    /// Returns whether the whole plate fits on the screen.
    #[must_use]
    pub fn fits(&self, track: &Track) -> bool {
        self.fitting(track) == 1.0
    }

    /// Returns the factor by which the plate is shrunk to fit on the screen; 1 if it fits.
    fn fitting(&self, track: &Track) -> f64 {
        let room_m = (self.width - 2.0) * self.pixel_m;
        // Only a plate that is too long is shrunk; this also avoids a division by zero.
        if track.plate_m > room_m {
            room_m / track.plate_m
        } else {
            1.0
        }
    }

    /// Returns the height of the plate's line, pixels from the top.
    #[must_use]
    pub fn plate_y(&self) -> f64 {
        (self.height * PLATE_DOWN).round()
    }

    /// Returns the slider's height, pixels.
    #[must_use]
    pub fn slider_height(&self) -> f64 {
        self.pixels(SLIDER_HEIGHT_M)
            .clamp(8.0, self.height * 0.16)
            .round()
    }

    /// Returns half the slider's width, pixels.
    #[must_use]
    pub fn half_slider(&self) -> f64 {
        self.pixels(SLIDER_WIDTH_M).max(2.0) / 2.0
    }

    /// Returns the radius of a fingertip, pixels.
    #[must_use]
    pub fn fingertip(&self) -> f64 {
        self.pixels(FINGERTIP_M).clamp(4.0, self.height * 0.06)
    }

    /// Returns the rows that slider and finger can touch.
    #[must_use]
    pub fn moving_rows(&self) -> std::ops::Range<usize> {
        let top = self.plate_y() - self.slider_height() - self.fingertip() - 2.0;
        let bottom = self.plate_y() + self.fingertip() + 2.0;
        top.max(0.0) as usize..bottom.max(0.0).ceil() as usize
    }
}
