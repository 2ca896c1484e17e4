//! Lines broken between words.

use std::borrow::Cow;

/// First words of lines that are commands, to be copied as a whole.
const COMMANDS: [&str; 5] = ["friction-bench", "cargo", "sudo", "./dev", "python3"];

/// Returns a line broken between words so that no part is wider than `columns`, but for words that are wider themselves. Parts after
/// the first are indented as the last column of a table. Commands, between backticks or as the whole of it, are not broken; neither is a
/// line with control characters other than colours.
pub(crate) fn wrapped(line: &str, columns: usize) -> Cow<'_, str> {
    let text = line.trim_end();
    let is_short = width(text).is_none_or(|width| width <= columns);
    let indent = last_column(text, columns / 2);
    let last: String = text.chars().skip(indent).collect();
    let is_command = |text: &str| {
        let first = text.split_whitespace().next();
        first.is_some_and(|word| COMMANDS.contains(&word))
    };
    if is_short || is_command(text) || is_command(&last) {
        return Cow::Borrowed(line);
    }
    let mut output = String::with_capacity(line.len() + 32);
    let (mut column, mut blanks) = (0, 0);
    for word in words(text) {
        let width = width(word).unwrap_or_default();
        if word.starts_with(' ') {
            blanks = width;
            continue;
        }
        if column > indent && column + blanks + width > columns {
            output.push('\n');
            (column, blanks) = (0, indent);
        }
        output.extend(std::iter::repeat_n(' ', blanks));
        output.push_str(word);
        column += blanks + width;
        blanks = 0;
    }
    output.push_str(&line[text.len()..]);
    Cow::Owned(output)
}

/// Returns the columns of a text: without the sequences that set colours (`ESC [ … m`); `None` with another control character.
fn width(text: &str) -> Option<usize> {
    let mut columns = 0;
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        match character {
            '\x1b' if characters.next() == Some('[') => {
                let end = characters.find(|character| !matches!(character, '0'..='9' | ';'));
                end.filter(|end| *end == 'm')?;
            }
            character if character.is_control() => return None,
            _ => columns += 1,
        }
    }
    Some(columns)
}

/// Returns where the last column of a table begins: after the last gap of two blanks or more before `most`, or after the blanks at
/// the line's start.
fn last_column(text: &str, most: usize) -> usize {
    let (mut column, mut indent) = (0, 0);
    for word in words(text) {
        let width = width(word).unwrap_or_default();
        let is_gap = word.starts_with(' ') && (width > 1 || column == 0);
        column += width;
        if is_gap && column <= most {
            indent = column;
        }
    }
    indent
}

/// Splits a text into words and the blanks between them; what stands between backticks is part of one word.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let mut is_quoted = false;
        let end = if rest.starts_with(' ') {
            rest.find(|character| character != ' ')
        } else {
            rest.find(|character| {
                is_quoted ^= character == '`';
                character == ' ' && !is_quoted
            })
        };
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
