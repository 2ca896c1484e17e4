//! Line wrapping for a terminal.

/// Appends `text` in lines of at most `width` characters, each indented by `indent` spaces.
pub(crate) fn wrapped(text: &str, width: usize, indent: usize, to: &mut String) {
    let mut column = 0;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > width {
            to.push('\n');
            column = 0;
        }
        if column == 0 {
            to.extend(std::iter::repeat_n(' ', indent));
            column = indent;
        } else {
            to.push(' ');
            column += 1;
        }
        to.push_str(word);
        column += length;
    }
    to.push('\n');
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn lines_are_broken_at_blanks_and_no_word_is_lost() {
        let mut text = String::new();
        wrapped("one two  three\nincomprehensibilities a", 10, 2, &mut text);
        assert_eq!(text, "  one two\n  three\n  incomprehensibilities\n  a\n");
    }
}
