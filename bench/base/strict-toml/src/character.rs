//! Characters that text from a web page or a word processor brings along, and the names by which a message shows them.

/// Kind of a character that is not TOML outside quotes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Likeness {
    /// Looks like a blank, or like nothing.
    Blank(&'static str),
    /// Looks like a minus.
    Minus(&'static str),
    /// Looks like a quotation mark.
    Quote(&'static str),
}

fn likeness(c: char) -> Option<Likeness> {
    use Likeness::{Blank, Minus, Quote};
    Some(match c {
        '\u{a0}' => Blank("no-break space"),
        '\u{202f}' => Blank("narrow no-break space"),
        '\u{2000}'..='\u{200a}' | '\u{205f}' => Blank("typographic space"),
        '\u{3000}' => Blank("ideographic space"),
        '\u{200b}' => Blank("zero-width space"),
        '\u{200c}' | '\u{200d}' | '\u{2060}' => Blank("zero-width joiner"),
        '\u{feff}' => Blank("byte-order mark"),
        '\u{ad}' => Blank("soft hyphen"),
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
            Blank("mark of the writing direction")
        }
        '\u{85}' | '\u{2028}' | '\u{2029}' => Blank("line separator"),
        '\u{2212}' => Minus("minus sign"),
        '\u{2010}' | '\u{2011}' => Minus("hyphen"),
        '\u{2012}'..='\u{2015}' => Minus("dash"),
        '\u{201c}' | '\u{201d}' | '\u{201e}' | '\u{201f}' | '\u{ab}' | '\u{bb}' => {
            Quote("typographic quotes")
        }
        '\u{2018}' | '\u{2019}' | '\u{201a}' | '\u{201b}' | '\u{2039}' | '\u{203a}' => {
            Quote("typographic single quotes")
        }
        '\u{b4}' | '\u{2032}' | '\u{2033}' => Quote("accent or prime"),
        _ => return None,
    })
}

/// Returns the words for a character that is not allowed outside quotes, with the remedy; `None` for an allowed one.
pub(crate) fn words(c: char) -> Option<String> {
    if c.is_ascii() && (!c.is_ascii_control() || matches!(c, '\t' | '\r' | '\n')) {
        return None;
    }
    let code = u32::from(c);
    Some(match likeness(c) {
        Some(Likeness::Blank(name)) => {
            format!(
                "the invisible character U+{code:04X} ({name}) stands outside quotes; take it out, or type a plain space"
            )
        }
        Some(Likeness::Minus(name)) => {
            format!(
                "the character U+{code:04X} ({name}) is not the minus `-` of the keyboard; type that"
            )
        }
        Some(Likeness::Quote(name)) => {
            format!(
                "the character U+{code:04X} ({name}) is not the quotation mark `\"` of the keyboard; type that"
            )
        }
        None if c.is_control() => {
            format!(
                "the invisible character U+{code:04X} (control character) stands outside quotes; take it out"
            )
        }
        None => format!(
            "`{c}` (U+{code:04X}) stands outside quotes; put text in quotes, or type a character of the keyboard"
        ),
    })
}

/// Returns a text with its invisible characters as names, such as `<U+00A0>`, for a message.
pub(crate) fn visible(text: &str) -> String {
    let mut shown = String::new();
    for c in text.chars() {
        match likeness(c) {
            Some(Likeness::Blank(_)) => shown += &format!("<U+{:04X}>", u32::from(c)),
            _ if c.is_control() => shown += &format!("<U+{:04X}>", u32::from(c)),
            _ => shown.push(c),
        }
    }
    shown
}
