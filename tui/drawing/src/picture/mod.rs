//! A drawn screen as a picture (SVG) and as plain text, for manuals, reports and bug reports. The same cells yield the
//! same bytes.
//!
//! Lines, blocks and braille dots are drawn as shapes, so that curves look the same in all fonts; text stays text,
//! which can be searched and copied.

mod colours;
mod shapes;
mod svg;

pub use colours::Paper;
pub use svg::svg;

use ratatui::buffer::{Buffer, CellWidth};

/// Returns the characters of each row without its trailing blanks, one line per row.
///
/// ```
/// use ratatui::{buffer::Buffer, layout::Rect, style::Style};
///
/// let mut screen = Buffer::empty(Rect::new(0, 0, 12, 2));
/// screen.set_string(0, 0, "μ 0.42", Style::new());
/// assert_eq!(drawing::picture::text(&screen), "μ 0.42\n\n");
/// ```
#[must_use]
pub fn text(screen: &Buffer) -> String {
    let mut text = String::new();
    for y in screen.area.rows() {
        let row: String = symbols(screen, y.y).map(|(_, symbol)| symbol).collect();
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

/// Returns the symbols of row `y` with their columns; a wide one also covers the next cell.
fn symbols(screen: &Buffer, y: u16) -> impl Iterator<Item = (u16, &str)> {
    let mut end_column = 0;
    (screen.area.left()..screen.area.right()).filter_map(move |x| {
        if end_column > 0 {
            end_column -= 1;
            return None;
        }
        let cell = &screen[(x, y)];
        end_column = cell.cell_width().max(1) - 1;
        Some((x, cell.symbol()))
    })
}
