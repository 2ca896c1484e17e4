//! Braille dots, two across and four down in each cell.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Bits of a cell's dots by row, left and right.
const BITS: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// A drawing of dots on a grid of cells.
pub struct Dots {
    columns: usize,
    cells: Vec<u8>,
    last: (f64, f64),
}

impl Dots {
    /// Returns an empty drawing.
    pub fn new(columns: u16, rows: u16) -> Self {
        let last = |cells: u16, dots: f64| (f64::from(cells) * dots - 1.0).max(0.0);
        Self {
            columns: columns.into(),
            cells: vec![0; usize::from(columns) * usize::from(rows)],
            last: (last(columns, 2.0), last(rows, 4.0)),
        }
    }

    /// Returns the column and the row of the last dot.
    pub fn last(&self) -> (f64, f64) {
        self.last
    }

    /// Draws one dot, unless it lies outside.
    pub fn dot(&mut self, (x, y): (f64, f64)) {
        let is_inside = (0.0..=self.last.0).contains(&x) && (0.0..=self.last.1).contains(&y);
        if !is_inside {
            return;
        }
        let (x, y) = (x.round() as usize, y.round() as usize);
        if let Some(cell) = self.cells.get_mut(y / 4 * self.columns + x / 2) {
            *cell |= BITS[y % 4][x % 2];
        }
    }

    /// Draws a line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 4096.0) as u32;
        for step in 0..=steps {
            let part = f64::from(step) / f64::from(steps);
            self.dot((from.0 + part * dx, from.1 + part * dy));
        }
    }

    /// Draws the cells with dots into `area`, over its present contents.
    pub fn stamp(&self, area: Rect, style: Style, buf: &mut Buffer) {
        let cells = area.positions().zip(&self.cells);
        for (position, bits) in cells.filter(|(_, bits)| **bits != 0) {
            let cell = &mut buf[position];
            cell.reset();
            cell.set_char(pattern(*bits)).set_style(style);
        }
    }
}

/// Returns the character with these dots.
fn pattern(bits: u8) -> char {
    char::from_u32(0x2800 + u32::from(bits)).unwrap_or(' ')
}

/// Returns an ASCII character for a braille pattern, chosen by the height of its dots.
pub fn plain(bits: u8) -> char {
    let rows = BITS.map(|row| bits & (row[0] | row[1]) != 0);
    match rows {
        [false, false, false, false] => ' ',
        [_, false, false, false] => '\'',
        [false, _, _, false] => '-',
        [false, false, _, _] => '.',
        [true, true, false, false] => '"',
        _ => '|',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_joins_its_ends() {
        let area = Rect::new(0, 0, 3, 1);
        let mut buf = Buffer::empty(area);
        let mut dots = Dots::new(3, 1);
        dots.line((0.0, 3.0), (5.0, 0.0));
        dots.line((f64::NAN, 0.0), (f64::INFINITY, 9.0));
        dots.stamp(area, Style::new(), &mut buf);
        let symbols: String = (0..3).map(|x| buf[(x, 0)].symbol()).collect();
        assert_eq!(symbols, "⡠⠔⠊");
        assert_eq!(plain(0x40), '.');
    }
}
