//! Fitting words into columns.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Widget;

/// Draws `line` into the first row of `area`, with an ellipsis if it is cut off.
pub(crate) fn render_line(line: Line, area: Rect, buf: &mut Buffer) {
    let cut = line.width() > area.width.into();
    line.render(area, buf);
    if cut && !area.is_empty() {
        buf[(area.right() - 1, area.y)].set_symbol("…");
    }
}

/// Breaks `text` at spaces into lines of at most `columns` characters. A longer word is not broken; its area cuts it off.
pub(crate) fn wrap(text: &str, columns: u16) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= columns.into() => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn breaks_at_spaces_only() {
        assert_eq!(wrap("place your finger", 11), ["place your", "finger"]);
        assert_eq!(wrap("place your finger", 3), ["place", "your", "finger"]);
        assert_eq!(wrap("exact fit", 9), ["exact fit"]);
        assert!(wrap("", 5).is_empty());
    }
}
