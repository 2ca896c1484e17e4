//! Lines broken between words.

use std::borrow::Cow;

use textwrap::core::{Word, display_width};
use textwrap::{Options, WordSeparator, WordSplitter};

/// First words of lines that are commands, to be copied as a whole.
const COMMANDS: [&str; 5] = ["friction-bench", "cargo", "sudo", "./dev", "python3"];

/// Start of the sequences that set colours, which take no columns.
const ESCAPE: char = '\x1b';

/// Returns a line broken between words so that no part is wider than `columns`, but for words that are wider themselves. Parts after
/// the first are indented as the last column of a table. Commands, between backticks or as the whole of it, are not broken; neither is a
/// line with control characters other than colours.
pub(crate) fn wrapped(line: &str, columns: usize) -> Cow<'_, str> {
    let text = line.trim_end();
    let is_rewritten = text
        .chars()
        .any(|character| character.is_control() && character != ESCAPE);
    let is_short = is_rewritten || display_width(text) <= columns;
    let indent = last_column(text, columns / 2);
    let last: String = text.chars().skip(indent).collect();
    let is_command = |text: &str| {
        let first = text.split_whitespace().next();
        first.is_some_and(|word| COMMANDS.contains(&word))
    };
    if is_short || is_command(text) || is_command(&last) {
        return Cow::Borrowed(line);
    }
    let indent = " ".repeat(indent);
    let options = Options::new(columns)
        .break_words(false)
        .word_splitter(WordSplitter::NoHyphenation)
        .word_separator(WordSeparator::Custom(|text| {
            Box::new(words(text).map(Word::from))
        }))
        .subsequent_indent(&indent);
    Cow::Owned(textwrap::fill(text, options) + &line[text.len()..])
}

/// Returns where the last column of a table begins: after the last gap of two blanks or more before `most`, or after the blanks at
/// the line's start.
fn last_column(text: &str, most: usize) -> usize {
    let (mut column, mut indent) = (0, 0);
    for part in words(text) {
        let word = Word::from(part);
        let is_gap = word.whitespace.len() > 1 || word.word.is_empty();
        column += display_width(part);
        if is_gap && column <= most {
            indent = column;
        }
    }
    indent
}

/// Splits a text into words, each with the blanks after it; what stands between backticks is part of one word.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (mut is_quoted, mut is_over) = (false, false);
        let end = rest.find(|character| {
            is_quoted ^= character == '`';
            let is_blank = character == ' ' && !is_quoted;
            let begins_next = is_over && !is_blank;
            is_over |= is_blank;
            begins_next
        });
        let (word, after) = rest.split_at(end.unwrap_or(rest.len()));
        rest = after;
        (!word.is_empty()).then_some(word)
    })
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn a_row_of_a_table_goes_on_below_its_last_column() {
        let line = "FAILED  rate        41000 frames a second: the card is slow\n";
        let broken = "FAILED  rate        41000 frames a\n                    second: the card is\n                    slow\n";
        assert_eq!(wrapped(line, 40), broken);
    }

    #[test]
    fn no_command_is_broken() {
        let line =
            "look at the devices by `friction-bench devices --all --mock` and at the cable\n";
        let broken =
            "look at the devices by\n`friction-bench devices --all --mock`\nand at the cable\n";
        assert_eq!(wrapped(line, 40), broken);
        let command = "  friction-bench run --mock --protocol demo --participant sub-01\n";
        assert_eq!(wrapped(command, 40), command);
        let command = "to results        friction-bench analyze my-study --figures figures\n";
        assert_eq!(wrapped(command, 40), command);
    }

    #[test]
    fn colours_take_no_columns() {
        let line = "\x1b[1;31merror:\x1b[0m an \x1b[1margument\x1b[0m is missing";
        assert_eq!(wrapped(line, 29), line);
        assert_eq!(wrapped(line, 28), line.replace(" missing", "\nmissing"));
        for kept in [
            "\r\x1b[K half of a line that a command rewrites",
            "a\x1b",
            "a\x1b[5",
        ] {
            assert_eq!(wrapped(kept, 10), kept);
        }
    }

    #[test]
    fn no_word_is_lost_at_any_width() {
        let line = "  a `b c` incomprehensibilities,   an `open quote and μ0\n";
        for columns in 0..60 {
            let words: Vec<String> = [line, &wrapped(line, columns)]
                .iter()
                .map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
                .collect();
            assert_eq!(words[0], words[1], "{columns}");
        }
    }
}
