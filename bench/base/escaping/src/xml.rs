//! Text of an XML document.

/// Returns `text` with the characters that XML reserves escaped, for a node or a quoted attribute; forbidden characters become
/// U+FFFD.
///
/// ```
/// assert_eq!(escaping::xml_text("a < b & \"c\"\u{1b}"), "a &lt; b &amp; &quot;c&quot;\u{fffd}");
/// ```
#[must_use]
pub fn xml_text(text: &str) -> String {
    let mut output = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => output.push_str("&amp;"),
            '<' => output.push_str("&lt;"),
            '>' => output.push_str("&gt;"),
            '"' => output.push_str("&quot;"),
            _ if character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}') => {
                output.push('\u{fffd}');
            }
            _ => output.push(character),
        }
    }
    output
}
