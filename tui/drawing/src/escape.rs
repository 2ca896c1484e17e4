//! Cells of a drawn screen without control characters.

use escaping::is_obeyed;
use ratatui::buffer::{Buffer, Cell};

/// Replaces control characters in every cell of a drawn screen.
pub fn clean(buf: &mut Buffer) {
    minus_signs(buf);
    for cell in &mut buf.content {
        // Fast path: most cells are a blank or a letter.
        if let [byte] = cell.symbol().as_bytes()
            && (b' '..=b'~').contains(byte)
        {
            continue;
        }
        if cell
            .symbol()
            .chars()
            .any(|c| is_obeyed(c) || c.is_control())
        {
            cell.set_symbol("\u{fffd}");
        } else if cell.symbol() == "\u{b5}" {
            // One character for micro and for friction, from any source.
            cell.set_symbol("\u{3bc}");
        }
    }
}

/// Replaces every hyphen before a number by a minus sign.
fn minus_signs(buf: &mut Buffer) {
    let is_number = |cell: Option<&Cell>| {
        cell.is_some_and(|cell| cell.symbol().starts_with(|c: char| c.is_ascii_digit()))
    };
    for index in 0..buf.content.len() {
        if buf.content[index].symbol() != "-" || !is_number(buf.content.get(index + 1)) {
            continue;
        }
        let previous = index.checked_sub(1).and_then(|k| buf.content.get(k));
        if previous.is_none_or(|cell| matches!(cell.symbol(), " " | "(" | "[" | "=")) {
            buf.content[index].set_symbol("\u{2212}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    #[test]
    fn cells_are_cleaned() {
        let mut buf = Buffer::empty(Rect::new(0, 0, 3, 1));
        buf[(0, 0)].set_symbol("\u{1b}[2J");
        buf[(1, 0)].set_symbol("a\u{202e}");
        buf[(2, 0)].set_symbol("b");
        clean(&mut buf);
        let text: String = buf.content.iter().map(|cell| cell.symbol()).collect();
        assert_eq!(text, "\u{fffd}\u{fffd}b");
    }
}
