//! Text of a map: keys with the reason for each as a comment.

/// A line of a map.
#[derive(Debug, Clone, PartialEq)]
enum Line {
    Comment(String),
    /// A comment to be checked.
    Check(String),
    Table(String),
    Key {
        text: String,
        reason: String,
        is_sure: bool,
    },
    Blank,
}

/// A map as it is written, line by line.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MapText {
    lines: Vec<Line>,
}

/// Reason for a line of a map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reason {
    pub text: String,
    pub is_sure: bool,
}

/// Returns the reason of a line that is sure.
pub(crate) fn sure(text: impl Into<String>) -> Reason {
    Reason {
        text: text.into(),
        is_sure: true,
    }
}

/// Returns the reason of a line to be checked.
pub(crate) fn check(text: impl Into<String>) -> Reason {
    Reason {
        text: text.into(),
        is_sure: false,
    }
}

/// Widest line of a key at which the comments of a table are aligned, characters.
const WIDEST: usize = 56;

impl MapText {
    /// Adds a comment.
    pub fn comment(&mut self, text: impl Into<String>) {
        self.lines.push(Line::Comment(text.into()));
    }

    /// Adds a comment to be checked.
    pub fn check(&mut self, text: impl Into<String>) {
        self.lines.push(Line::Check(text.into()));
    }

    /// Begins a table.
    pub fn table(&mut self, name: &str) {
        if !self.lines.is_empty() {
            self.lines.push(Line::Blank);
        }
        self.lines.push(Line::Table(name.to_owned()));
    }

    /// Adds a key with a value in TOML.
    pub fn key(&mut self, key: &str, value: &str, reason: Reason) {
        self.lines.push(Line::Key {
            text: format!("{key} = {value}"),
            reason: reason.text,
            is_sure: reason.is_sure,
        });
    }

    /// Returns the number of lines to be checked.
    pub fn checks(&self) -> usize {
        let doubtful =
            |line: &&Line| matches!(line, Line::Key { is_sure: false, .. } | Line::Check(_));
        self.lines.iter().filter(doubtful).count()
    }

    /// Returns the text, with the comments of each table aligned.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for table in self.lines.split_inclusive(|line| *line == Line::Blank) {
            let widths = table.iter().filter_map(|line| match line {
                Line::Key { text, .. } => Some(text.chars().count()),
                _ => None,
            });
            let width = widths.filter(|width| *width <= WIDEST).max().unwrap_or(0);
            for line in table {
                text += &line.text(width);
                text.push('\n');
            }
        }
        text
    }
}

impl Line {
    fn text(&self, width: usize) -> String {
        match self {
            Self::Blank => String::new(),
            Self::Comment(text) => format!("# {}", one_line(text)),
            Self::Check(text) => format!("# CHECK: {}", one_line(text)),
            Self::Table(name) => format!("[{name}]"),
            Self::Key {
                text,
                reason,
                is_sure,
            } => {
                let mark = if *is_sure { "" } else { "CHECK: " };
                format!("{text:width$}  # {mark}{}", one_line(reason))
            }
        }
    }
}

/// Returns a comment's text without line ends and control characters, which TOML refuses.
fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || c == '\u{a0}' {
                ' '
            } else {
                c
            }
        })
        .collect()
}

/// Returns a text as a string of TOML: as it is within apostrophes, if it has none.
pub(crate) fn quoted(text: &str) -> String {
    let is_literal =
        text.contains(['\\', '"']) && !text.contains('\'') && !text.chars().any(char::is_control);
    if is_literal {
        return format!("'{text}'");
    }
    let mut result = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => result.extend(['\\', c]),
            c if c.is_control() => result += &format!("\\u{:04X}", u32::from(c)),
            c => result.push(c),
        }
    }
    result + "\""
}

/// Returns a number as a float of TOML.
pub(crate) fn number(value: f64) -> String {
    let text = statistics::significant(value);
    match text.contains(['.', 'e', 'N', 'i']) {
        true => text,
        false => text + ".0",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_aligned_within_a_table_and_doubts_are_marked() {
        let mut map = MapText::default();
        map.key("format", "1", sure("version of the map"));
        map.table("drive");
        map.key("from", "\"U\"", sure("named"));
        map.key("volts_per_unit", "20.0", check("no file\nstates it"));
        let expected = "format = 1  # version of the map\n\n[drive]\nfrom = \"U\"             # named\n\
                        volts_per_unit = 20.0  # CHECK: no file states it\n";
        assert_eq!(map.text(), expected);
        assert_eq!(map.checks(), 1);
    }

    #[test]
    fn texts_and_numbers_are_written_as_toml() {
        assert_eq!(quoted(r"S(\d+)\.mat"), r"'S(\d+)\.mat'");
        assert_eq!(quoted("it's \"x\"\\"), r#""it's \"x\"\\""#);
        assert_eq!(quoted("F[:,2]"), "\"F[:,2]\"");
        for (value, text) in [
            (1.0, "1.0"),
            (-0.31, "-0.31"),
            (5e-7, "5e-7"),
            (192e3, "192000.0"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
