//! Large digits, legible across the room.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Height of a digit, rows.
pub const ROWS: u16 = 5;

/// Digits of three by five cells. A cell is drawn two columns wide, nearly square on most terminals.
const DIGITS: [[&str; 5]; 10] = [
    ["###", "# #", "# #", "# #", "###"],
    ["  #", "  #", "  #", "  #", "  #"],
    ["###", "  #", "###", "#  ", "###"],
    ["###", "  #", "###", "  #", "###"],
    ["# #", "# #", "###", "  #", "  #"],
    ["###", "#  ", "###", "  #", "###"],
    ["###", "#  ", "###", "# #", "###"],
    ["###", "  #", "  #", "  #", "  #"],
    ["###", "# #", "###", "# #", "###"],
    ["###", "# #", "###", "  #", "###"],
];
const POINT: [&str; 5] = [" ", " ", " ", " ", "#"];
const DASH: [&str; 5] = ["  ", "  ", "##", "  ", "  "];

fn glyph(symbol: char) -> [&'static str; 5] {
    match symbol {
        '0'..='9' => DIGITS[symbol as usize - '0' as usize],
        '.' => POINT,
        _ => DASH,
    }
}

/// Returns the width of a symbol with the gap after it, columns.
fn glyph_columns(symbol: char) -> u16 {
    2 * (glyph(symbol)[0].len() as u16 + 1)
}

/// Returns the width of `number`, columns.
#[must_use]
pub fn columns(number: &str) -> u16 {
    number
        .chars()
        .map(glyph_columns)
        .fold(0, u16::saturating_add)
}

/// Draws digits, points and minus signs from the left of `area`, which must have room for [`ROWS`] and [`columns`].
pub fn render(number: &str, style: Style, area: Rect, buf: &mut Buffer) {
    let mut left = area.x;
    for symbol in number.chars() {
        for (row, cells) in (0u16..).zip(glyph(symbol)) {
            for (column, _) in (0u16..)
                .zip(cells.bytes())
                .filter(|(_, cell)| *cell == b'#')
            {
                buf.set_string(left + column * 2, area.y + row, "██", style);
            }
        }
        left += glyph_columns(symbol);
    }
}
