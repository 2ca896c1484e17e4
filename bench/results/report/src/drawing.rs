//! Figures within a page.

use maud::PreEscaped;
use plotting::{Figure, FigureError};

/// Attribute that an SVG needs as a file but not within HTML.
const NAMESPACE: &str = " xmlns=\"http://www.w3.org/2000/svg\"";

/// Returns a figure as SVG within HTML: drawn by this program, which escapes its text.
pub(crate) fn drawing(figure: &Figure) -> Result<PreEscaped<String>, FigureError> {
    let svg = figure.to_svg()?.replacen(NAMESPACE, "", 1);
    Ok(PreEscaped(svg))
}
