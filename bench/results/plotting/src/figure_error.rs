//! Errors of drawing and writing figures.

use std::path::PathBuf;

/// Failure to draw a figure or to write its files.
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
        /// Error of the operating system.
        source: std::io::Error,
    },
}
