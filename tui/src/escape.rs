//! Escaping of untrusted text from files and devices before it reaches a terminal.

use std::borrow::Cow;

use ratatui::buffer::{Buffer, Cell};

/// Returns `text` with all control characters escaped, such as the start of a terminal command, and all marks that
/// change the writing direction. They become `\u001b` and the like, as in JSON and TOML. Line ends and tabs stay.
///
/// ```
/// assert_eq!(tui::escaped("sub-01\n"), "sub-01\n");
/// assert_eq!(tui::escaped("\u{1b}[2Jsub-01"), r"\u001b[2Jsub-01");
/// ```
pub fn escaped(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let mut output = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_obeyed(c) {
            output.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            output.push(c);
        }
    }
    Cow::Owned(output)
}

/// Returns `text` as a single line: as [`escaped`], and with line ends and tabs escaped, too.
///
/// ```
/// assert_eq!(tui::escaped_line("a\tb\n"), r"a\tb\n");
/// ```
pub fn escaped_line(text: &str) -> Cow<'_, str> {
    match escaped(text) {
        line if line.contains(['\n', '\t']) => {
            Cow::Owned(line.replace('\n', "\\n").replace('\t', "\\t"))
        }
        line => line,
    }
}

fn is_obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || matches!(c, '\u{2028}' | '\u{2029}') || (c.is_control() && c != '\n' && c != '\t')
}

/// Replaces control characters in every cell of a drawn screen.
pub(crate) fn clean(buf: &mut Buffer) {
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
    fn control_characters_are_escaped_and_the_rest_stays() {
        let plain = "Größe µ ≤ 3 N·s/m\t✓ 日本\n";
        assert!(matches!(escaped(plain), Cow::Borrowed(text) if text == plain));
        for (c, expected) in [
            ('\u{0}', r"a\u0000b"),
            ('\r', r"a\u000db"),
            ('\u{7f}', r"a\u007fb"),
            ('\u{9b}', r"a\u009bb"),
            ('\u{202e}', r"a\u202eb"),
            ('\u{2028}', r"a\u2028b"),
        ] {
            assert_eq!(escaped(&format!("a{c}b")), expected);
            assert_eq!(escaped_line(&format!("a{c}b")), expected);
        }
    }

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
