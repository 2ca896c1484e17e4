//! Figures in print: one journal column (85 mm) or two (180 mm), SVG and PNG at 300 dpi, the same bytes on every machine.
//!
//! A [`Figure`] says what is shown; drawing it decides nothing about the science. Curves differ in ink (Okabe and Ito's) and in dash or
//! marker, so that they are told apart without colour vision and in grey. Captions carry every assumed parameter, in the caption file
//! and inside the SVG and the PNG.

mod bitmap;
mod draw;
mod files;
mod font;
mod key;
mod layout;
mod path;
mod pen;
mod scale;
mod spec;
mod style;

use std::fs;
use std::path::{Path, PathBuf};

pub use scale::written;
pub use spec::{Axis, Figure, Key, Mark, Panel, Scale, Series, Span};
pub use style::{Dash, Ink, Marker, Width};

/// A figure that could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The typeface that is compiled in cannot be read.
    #[error("the built-in typeface is damaged; rebuild the program")]
    Typeface,
    /// The drawing library failed.
    #[error("cannot draw the figure")]
    Drawing(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// The PNG encoder failed.
    #[error("cannot encode the figure as PNG")]
    Png(#[from] png::EncodingError),
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Writes each figure as SVG and PNG, and `captions.md` with all captions, into an existing folder; what was written, in order.
///
/// # Errors
/// If a figure cannot be drawn or a file cannot be written.
pub fn write(figures: &[Figure], folder: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let mut written = Vec::new();
    let mut captions = String::from("# Figures\n");
    for figure in figures {
        written.extend(write_one(figure, &folder.join(&figure.name))?);
        captions += &format!(
            "\n## {}\n`{}`: {}\n",
            figure.title, figure.name, figure.caption
        );
    }
    written.push(save(folder.join("captions.md"), captions.as_bytes())?);
    Ok(written)
}

/// Writes one figure as SVG and PNG, its caption inside both, to `stem` with their endings.
///
/// # Errors
/// If the figure cannot be drawn or a file cannot be written.
pub fn write_one(figure: &Figure, stem: &Path) -> Result<[PathBuf; 2], FigureError> {
    let ended = |ending: &str| {
        let mut path = stem.as_os_str().to_owned();
        path.push(ending);
        PathBuf::from(path)
    };
    Ok([
        save(ended(".svg"), figure.to_svg()?.as_bytes())?,
        save(ended(".png"), &figure.to_png()?)?,
    ])
}

fn save(path: PathBuf, bytes: &[u8]) -> Result<PathBuf, FigureError> {
    fs::write(&path, bytes).map_err(|source| FigureError::Write {
        path: path.clone(),
        source,
    })?;
    Ok(path)
}
