//! Figures for print: one journal column (85 mm) or two (180 mm) wide, as SVG and as PNG at 300 dpi, the same bytes on
//! every machine.
//!
//! A [`Figure`] describes the content; drawing it makes no scientific choice. Curves differ in ink (Okabe and Ito's) and
//! in dash or marker, so that they can be distinguished without colour vision and in grey. Captions name every assumed
//! parameter, in the caption file and inside the SVG and the PNG.

mod bitmap;
mod draw;
mod figure_error;
mod font;
mod key;
mod layout;
mod path;
mod pen;
mod placed;
mod points;
mod render;
mod scale;
mod shift_panel;
mod spec;
mod style;
mod write_files;

pub use figure_error::FigureError;
pub use font::DEJAVU_SANS;
pub use scale::number_text;
pub use shift_panel::residual_over_shift;
pub use spec::{Axis, AxisRange, Figure, Key, Mark, Panel, Scale, Series};
pub use style::{Dash, Ink, Marker, Width};
pub use write_files::{write, write_figure};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
