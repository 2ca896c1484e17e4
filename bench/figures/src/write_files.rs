//! Figures as files, and their captions.

use std::fs;
use std::path::{Path, PathBuf};

use crate::figure_error::FigureError;
use crate::spec::Figure;

/// Writes each figure as SVG and PNG, and `captions.md` with all captions, into an existing folder; returns the paths
/// in the order of writing.
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

/// Writes one figure as SVG and PNG, its caption inside both, to `stem` with `.svg` and `.png` appended.
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
