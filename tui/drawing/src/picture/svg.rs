//! The cells of a screen as an SVG document.

use std::collections::BTreeMap;
use std::fmt::Write;

use ratatui::buffer::{Buffer, CellWidth};

use super::colours::{Ink, Painted, Paper};
use super::shapes::{CELL, Tile, tiles};
use super::symbols;

/// Space around the cells.
const MARGIN: u32 = 8;
/// Distance of a row's baseline from its top.
const BASELINE: u32 = 12;

/// Draws `screen` as an SVG document for browsers and books.
///
/// `title` is the text for readers who cannot see the picture. The same cells yield the same bytes.
///
/// ```
/// use ratatui::{buffer::Buffer, layout::Rect, style::Style};
/// use drawing::picture::{Paper, svg};
///
/// let mut screen = Buffer::empty(Rect::new(0, 0, 12, 1));
/// screen.set_string(0, 0, "F < 5 N", Style::new().bold());
/// let picture = svg(&screen, "forces", Paper::Dark);
/// assert!(picture.starts_with("<svg ") && picture.contains("F &lt; 5 N"));
/// ```
#[must_use]
pub fn svg(screen: &Buffer, title: &str, paper: Paper) -> String {
    let width = u32::from(screen.area.width) * CELL.0 + 2 * MARGIN;
    let height = u32::from(screen.area.height) * CELL.1 + 2 * MARGIN;
    let title = escaping::xml_text(title);
    let mut picture = Picture {
        paper,
        tiles: BTreeMap::new(),
        grounds: BTreeMap::new(),
        words: String::new(),
    };
    for (row, y) in (screen.area.top()..screen.area.bottom()).enumerate() {
        picture.row(screen, y, MARGIN + row as u32 * CELL.1);
    }
    let ground = paper.ground();
    let mut document = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, \
         monospace\" font-size=\"13\">\n<title>{title}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" rx=\"6\" fill=\"{ground}\"/>\n"
    );
    paths(&picture.grounds, &mut document);
    paths(&picture.tiles, &mut document);
    document.push_str(&picture.words);
    document.push_str("</svg>\n");
    document
}

struct Picture {
    paper: Paper,
    grounds: BTreeMap<Ink, Vec<Tile>>,
    tiles: BTreeMap<Ink, Vec<Tile>>,
    words: String,
}

/// Adjacent characters of the same appearance.
struct Run {
    column: u32,
    cells: u32,
    text: String,
    painted: Painted,
}

impl Picture {
    fn row(&mut self, screen: &Buffer, y: u16, top: u32) {
        let mut run: Option<Run> = None;
        for (x, symbol) in symbols(screen, y) {
            let cell = &screen[(x, y)];
            let painted = self.paper.paint(cell);
            let cells = u32::from(cell.cell_width().max(1));
            let column = u32::from(x - screen.area.left());
            let left = MARGIN + column * CELL.0;
            if painted.ground != self.paper.ground() {
                let ground_tile = Tile {
                    x: left,
                    y: top,
                    width: cells * CELL.0,
                    height: CELL.1,
                };
                add(self.grounds.entry(painted.ground).or_default(), ground_tile);
            }
            let mut characters = symbol.chars();
            let glyph = match (characters.next(), characters.next()) {
                (Some(character), None) => tiles(character),
                _ => None,
            };
            if painted.hidden {
                self.flush(run.take(), top);
            } else if let Some((glyph, eighths)) = glyph {
                self.flush(run.take(), top);
                let ink = painted.ink.blend(painted.ground, eighths);
                let list = self.tiles.entry(ink).or_default();
                for tile in glyph {
                    add(
                        list,
                        Tile {
                            x: left + tile.x,
                            y: top + tile.y,
                            ..tile
                        },
                    );
                }
            } else {
                match &mut run {
                    Some(run) if run.painted == painted && !must_end(run, symbol) => {
                        run.text.push_str(symbol);
                        run.cells += cells;
                    }
                    _ => {
                        self.flush(run.take(), top);
                        run = Some(Run {
                            column,
                            cells,
                            text: symbol.to_owned(),
                            painted,
                        });
                    }
                }
            }
        }
        self.flush(run, top);
    }

    /// Writes the text of a run, as wide as its cells in any font.
    fn flush(&mut self, run: Option<Run>, top: u32) {
        let Some(run) = run else { return };
        let has_rule = run.painted.underlined || run.painted.crossed_out;
        let text = run.text.trim_end_matches(' ');
        let inner = text.trim_start_matches(' ');
        if inner.is_empty() && !has_rule {
            return;
        }
        let leading = (text.len() - inner.len()) as u32;
        let trailing = (run.text.len() - text.len()) as u32;
        let x = MARGIN + (run.column + leading) * CELL.0;
        let length = (run.cells - leading - trailing) * CELL.0;
        let mut style = format!("fill=\"{}\"", run.painted.ink);
        if run.painted.bold {
            style.push_str(" font-weight=\"bold\"");
        }
        if run.painted.italic {
            style.push_str(" font-style=\"italic\"");
        }
        for (present, line) in [
            (run.painted.underlined, top + CELL.1 - 2),
            (run.painted.crossed_out, top + CELL.1 / 2),
        ] {
            if present {
                let rule = Tile {
                    x: MARGIN + run.column * CELL.0,
                    y: line,
                    width: run.cells * CELL.0,
                    height: 1,
                };
                add(self.tiles.entry(run.painted.ink).or_default(), rule);
            }
        }
        if !inner.is_empty() {
            let y = top + BASELINE;
            let inner = escaping::xml_text(inner);
            let _ = writeln!(
                self.words,
                "<text x=\"{x}\" y=\"{y}\" textLength=\"{length}\" {style}>{inner}</text>"
            );
        }
    }
}

/// Whether `symbol` must not extend `run`: a second blank, which browsers would drop, or a symbol after only blanks.
fn must_end(run: &Run, symbol: &str) -> bool {
    run.text.ends_with(' ') && (symbol == " " || run.text.trim().is_empty())
}

/// Adds a tile, or extends the last one if it continues it to the right.
fn add(tiles: &mut Vec<Tile>, tile: Tile) {
    if let Some(last) = tiles.last_mut()
        && (last.y, last.height) == (tile.y, tile.height)
        && last.x + last.width == tile.x
    {
        last.width += tile.width;
        return;
    }
    tiles.push(tile);
}

fn paths(tiles: &BTreeMap<Ink, Vec<Tile>>, document: &mut String) {
    for (ink, tiles) in tiles {
        let _ = write!(document, "<path fill=\"{ink}\" d=\"");
        for tile in tiles {
            let Tile {
                x,
                y,
                width,
                height,
            } = tile;
            let _ = write!(document, "M{x} {y}h{width}v{height}h-{width}z");
        }
        document.push_str("\"/>\n");
    }
}
