//! Fitting words into columns.

use std::borrow::Cow;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// A part of a line that a narrow screen leaves out as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePart {
    /// Text.
    pub text: String,
    /// Text before it, unless it is the first part.
    pub separator: &'static str,
    /// Importance: the part with the highest rank is left out first, a part of rank 0 never.
    pub rank: u8,
    /// Style of the text.
    pub style: Style,
}

impl LinePart {
    /// Returns a part that follows after ` · `.
    #[must_use]
    pub fn new(rank: u8, text: impl Into<String>, style: Style) -> Self {
        Self {
            text: text.into(),
            separator: " · ",
            rank,
            style,
        }
    }

    /// Returns the part with another separator.
    #[must_use]
    pub fn after(self, separator: &'static str) -> Self {
        Self { separator, ..self }
    }
}

/// Returns the line of as many parts as fit into `columns`, the most important ones.
#[must_use]
pub fn fit_parts(parts: Vec<LinePart>, columns: usize, separator_style: Style) -> Line<'static> {
    let mut parts = parts;
    loop {
        let mut line = Line::default();
        for (i, part) in parts.iter().enumerate() {
            if i > 0 {
                line.push_span(Span::styled(part.separator, separator_style));
            }
            line.push_span(Span::styled(part.text.clone(), part.style));
        }
        let least = parts
            .iter()
            .enumerate()
            .max_by_key(|(i, part)| (part.rank, *i));
        match least {
            Some((i, part)) if part.rank > 0 && line.width() > columns => {
                parts.remove(i);
            }
            _ => return line,
        }
    }
}

/// Draws `line` into the first row of `area`, with an ellipsis if it is cut off.
pub fn render_line(line: Line, area: Rect, buf: &mut Buffer) {
    let cut = line.width() > area.width.into();
    line.render(area, buf);
    if cut && !area.is_empty() {
        buf[(area.right() - 1, area.y)].set_symbol("…");
    }
}

/// Breaks `text` at spaces into lines of at most `columns` characters. A longer word is not broken; its area cuts it off.
#[must_use]
pub fn wrap(text: &str, columns: u16) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.is_empty() {
        return Vec::new();
    }
    let options = textwrap::Options::new(columns.into()).break_words(false);
    let options = options.word_splitter(textwrap::WordSplitter::NoHyphenation);
    let text = words.join(" ");
    let lines = textwrap::wrap(&text, options).into_iter();
    lines.map(Cow::into_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_important_parts_are_left_out_whole() {
        let part = |rank, text| LinePart::new(rank, text, Style::new());
        let text = |columns| {
            let parts = vec![
                part(0, "REJECTED"),
                part(2, "force 0.49 N").after(": "),
                part(5, "band 0.50–0.80").after(", "),
                part(3, "repeats in 6 s"),
                part(4, "o keeps it"),
            ];
            fit_parts(parts, columns, Style::new()).to_string()
        };
        let whole = "REJECTED: force 0.49 N, band 0.50–0.80 · repeats in 6 s · o keeps it";
        assert_eq!(text(whole.chars().count()), whole);
        assert_eq!(
            text(67),
            "REJECTED: force 0.49 N · repeats in 6 s · o keeps it"
        );
        assert_eq!(text(40), "REJECTED: force 0.49 N · repeats in 6 s");
        assert_eq!(text(30), "REJECTED: force 0.49 N");
        assert_eq!(text(3), "REJECTED");
    }

    #[test]
    fn breaks_at_spaces_only() {
        assert_eq!(wrap("place your finger", 11), ["place your", "finger"]);
        assert_eq!(wrap("place your finger", 3), ["place", "your", "finger"]);
        assert_eq!(wrap("exact fit", 9), ["exact fit"]);
        assert!(wrap("", 5).is_empty());
    }
}
