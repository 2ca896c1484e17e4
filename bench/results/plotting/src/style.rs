//! Sizes, inks and dashes: legible at the printed size, distinguishable without colour vision and in grey.

/// Drawing units per inch; both backends place by whole units, so a unit is finer than a printed dot.
pub(super) const UNITS_PER_INCH: f64 = 900.0;
/// Resolution of the bitmaps, dots per inch.
pub(super) const DOTS_PER_INCH: u32 = 300;
pub(super) const UNITS_PER_PT: f64 = UNITS_PER_INCH / 72.0;
pub(super) const UNITS_PER_MM: f64 = UNITS_PER_INCH / 25.4;

pub(super) const LABEL_PT: f64 = 8.0;
pub(super) const TICK_PT: f64 = 7.0;
pub(super) const LETTER_PT: f64 = 9.0;
pub(super) const CURVE_PT: f64 = 1.1;
pub(super) const AXIS_PT: f64 = 0.6;
pub(super) const MARKER_RADIUS_PT: f64 = 1.5;

/// Printed width of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// One journal column, 85 mm.
    Column,
    /// Both columns, 180 mm.
    Page,
}

impl Width {
    /// Returns the width, mm.
    pub fn mm(self) -> f64 {
        match self {
            Self::Column => 85.0,
            Self::Page => 180.0,
        }
    }
}

/// Ink of a series: the colours of Okabe and Ito (Color Universal Design, 2008) that contrast with white paper, and a
/// grey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Black.
    Black,
    /// Blue.
    Blue,
    /// Vermillion.
    Vermillion,
    /// Orange.
    Orange,
    /// Bluish green.
    Green,
    /// Grey, for marks behind the data.
    Grey,
}

impl Ink {
    /// Returns red, green and blue, 0 to 255.
    pub fn rgb(self) -> (u8, u8, u8) {
        match self {
            Self::Black => (0, 0, 0),
            Self::Blue => (0, 114, 178),
            Self::Vermillion => (213, 94, 0),
            Self::Orange => (230, 159, 0),
            Self::Green => (0, 158, 115),
            Self::Grey => (130, 130, 130),
        }
    }

    /// Returns `share` of the ink on white: opaque, so that the drawing order alone decides which parts are visible.
    pub(super) fn tint(self, share: f64) -> (u8, u8, u8) {
        let mix = |value: u8| (255.0 - share * (255.0 - f64::from(value))).round() as u8;
        let (red, green, blue) = self.rgb();
        (mix(red), mix(green), mix(blue))
    }
}

/// Dashes that distinguish a curve without its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dash, dot.
    DashDotted,
}

impl Dash {
    /// Returns drawn and skipped lengths in turn, pt; empty for a solid line.
    pub(super) fn pattern_pt(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[4.5, 3.0],
            Self::Dotted => &[0.2, 2.4],
            Self::DashDotted => &[6.0, 2.6, 0.2, 2.6],
        }
    }
}

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Filled disc.
    Disc,
    /// Open circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
}
