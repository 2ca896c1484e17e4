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
    let mut paths = Vec::new();
    let mut captions = String::from("# Figures\n");
    for figure in figures {
        paths.extend(write_figure(figure, &folder.join(&figure.name))?);
        captions += &format!(
            "\n## {}\n`{}`: {}\n",
            figure.title, figure.name, figure.caption
        );
    }
    paths.push(save(folder.join("captions.md"), captions.as_bytes())?);
    Ok(paths)
}

/// Writes one figure as SVG and PNG, its caption inside both, to `stem` with `.svg` and `.png` appended.
///
/// # Errors
/// If the figure cannot be drawn or a file cannot be written.
pub fn write_figure(figure: &Figure, stem: &Path) -> Result<[PathBuf; 2], FigureError> {
    let path_with = |ending: &str| {
        let mut path = stem.as_os_str().to_owned();
        path.push(ending);
        PathBuf::from(path)
    };
    Ok([
        save(path_with(".svg"), figure.to_svg()?.as_bytes())?,
        save(path_with(".png"), &figure.to_png()?)?,
    ])
}

fn save(path: PathBuf, bytes: &[u8]) -> Result<PathBuf, FigureError> {
    fs::write(&path, bytes).map_err(|source| FigureError::Write {
        path: path.clone(),
        source,
    })?;
    Ok(path)
}
