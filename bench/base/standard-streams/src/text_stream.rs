//! A writer of texts in the characters and the width of a terminal.

use std::io::{self, Write};

use crate::line_wrap::wrapped;

/// Writer of texts, in ASCII and in lines of a terminal's width if so created.
#[derive(Debug)]
pub struct TextStream<W: Write> {
    target: W,
    is_ascii: bool,
    columns: Option<usize>,
    /// Start of a character that is not complete yet.
    incomplete: Vec<u8>,
    /// Line that is not complete yet.
    line: String,
}

impl<W: Write> TextStream<W> {
    /// Creates a writer of texts to `target`. Complete lines are broken between words at `columns`, if given.
    pub fn new(target: W, is_ascii: bool, columns: Option<usize>) -> Self {
        Self {
            target,
            is_ascii,
            columns,
            incomplete: Vec::new(),
            line: String::new(),
        }
    }

    fn write_text(&mut self, text: &str) -> io::Result<()> {
        let Some(columns) = self.columns else {
            return self.target.write_all(text.as_bytes());
        };
        for piece in text.split_inclusive('\n') {
            self.line.push_str(piece);
            if piece.ends_with('\n') {
                let line = std::mem::take(&mut self.line);
                let line = wrapped(&line, columns);
                self.target.write_all(line.as_bytes())?;
            }
        }
        Ok(())
    }

    /// Writes the line that is not complete, such as a question.
    fn write_rest(&mut self) -> io::Result<()> {
        let rest = std::mem::take(&mut self.line);
        match self.columns {
            Some(columns) => self.target.write_all(wrapped(&rest, columns).as_bytes()),
            None => self.target.write_all(rest.as_bytes()),
        }
    }
}

impl<W: Write> Write for TextStream<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !self.is_ascii && self.columns.is_none() {
            return self.target.write(bytes);
        }
        let mut pending = std::mem::take(&mut self.incomplete);
        pending.extend_from_slice(bytes);
        for chunk in pending.utf8_chunks() {
            if self.is_ascii {
                self.write_text(&escaping::ascii(chunk.valid()))?;
            } else {
                self.write_text(chunk.valid())?;
            }
        }
        self.incomplete = incomplete_end(&pending).to_vec();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_rest()?;
        self.target.flush()
    }
}

impl<W: Write> Drop for TextStream<W> {
    fn drop(&mut self) {
        // Nobody is left to be told of an error.
        let _ = self.write_rest();
    }
}

/// Returns the start of a character at the end of `bytes` that further bytes could complete.
fn incomplete_end(bytes: &[u8]) -> &[u8] {
    match std::str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => &bytes[error.valid_up_to()..],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed_in(columns: Option<usize>, pieces: &[&[u8]], is_ascii: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut stream = TextStream::new(&mut out, is_ascii, columns);
        for piece in pieces {
            stream.write_all(piece).unwrap();
        }
        drop(stream);
        out
    }

    fn printed(pieces: &[&[u8]], is_ascii: bool) -> Vec<u8> {
        printed_in(None, pieces, is_ascii)
    }

    #[test]
    fn a_text_is_printed_in_ascii_only_where_that_is_asked_for() {
        let text = "σ_t 3.00 ± 0.76 µm → “r”…\n";
        assert_eq!(printed(&[text.as_bytes()], false), text.as_bytes());
        let expected = b"sigma_t 3.00 +- 0.76 um -> \"r\"...\n";
        assert_eq!(printed(&[text.as_bytes()], true), expected);
        let bytes: Vec<&[u8]> = text.as_bytes().chunks(1).collect();
        assert_eq!(printed(&bytes, true), expected);
    }

    #[test]
    fn pieces_of_a_line_are_broken_as_the_whole_line() {
        let text = "the plate's resonance is 35 kHz, σ_t 3 µm and a word more\nis that the plate on this bench? (yes/no) ";
        let whole = printed_in(Some(40), &[text.as_bytes()], false);
        let pieces: Vec<&[u8]> = text.as_bytes().chunks(1).collect();
        assert_eq!(printed_in(Some(40), &pieces, false), whole);
        let lines = "the plate's resonance is 35 kHz, σ_t 3\nµm and a word more\nis that the plate on this bench?\n(yes/no) ";
        assert_eq!(String::from_utf8(whole).unwrap(), lines);
    }
}
