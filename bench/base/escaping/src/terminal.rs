//! Text on a terminal, without commands to it.

use std::borrow::Cow;

/// Returns `text` with all control characters escaped, such as the start of a terminal command, and all marks that
/// change the writing direction. They become `\u001b` and the like, as in JSON and TOML. Line ends and tabs stay.
///
/// ```
/// assert_eq!(escaping::escaped("sub-01\n"), "sub-01\n");
/// assert_eq!(escaping::escaped("\u{1b}[2Jsub-01"), r"\u001b[2Jsub-01");
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
/// assert_eq!(escaping::escaped_line("a\tb\n"), r"a\tb\n");
/// ```
pub fn escaped_line(text: &str) -> Cow<'_, str> {
    match escaped(text) {
        line if line.contains(['\n', '\t']) => {
            Cow::Owned(line.replace('\n', "\\n").replace('\t', "\\t"))
        }
        line => line,
    }
}

/// Returns whether a terminal obeys the character or writes on in another direction. Line ends and tabs are left out.
#[must_use]
pub fn is_obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || matches!(c, '\u{2028}' | '\u{2029}') || (c.is_control() && c != '\n' && c != '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
