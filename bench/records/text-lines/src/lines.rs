//! Lines of a text file from any offset on.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use crate::text_form::{Encoding, TextForm};

/// Maximum bytes of a line.
const MOST_LINE_BYTES: u64 = 1 << 20;

/// Bytes read from the file at once.
const BUFFER_BYTES: usize = 1 << 16;

/// Reason why the next line cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TextLineError {
    /// The operating system refuses.
    #[error("the disk returns no data")]
    Io(#[from] io::Error),
    /// The line is longer than a megabyte.
    #[error("line {line}: it is longer than a megabyte")]
    Long {
        /// Number of the line, from 1.
        line: u64,
    },
}

/// Reader of lines.
pub struct Lines {
    source: BufReader<FromStart>,
    form: TextForm,
    /// Offset of the next line.
    offset: u64,
    /// Number of the next line, from 1.
    number: u64,
    /// Offset at which the lines end.
    limit: u64,
    bytes: Vec<u8>,
    text: String,
}

/// Line of a file.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a> {
    /// Offset of its first byte.
    pub offset: u64,
    /// Number, from 1.
    pub number: u64,
    /// Text without its end.
    pub text: &'a str,
    /// Whether the bytes are of the encoding; else they were read as those of Western Europe.
    pub is_utf8: bool,
    /// Whether it has an end.
    pub is_ended: bool,
}

/// File that is read from its own position.
struct FromStart {
    file: Arc<File>,
    position: u64,
}

impl Read for FromStart {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.position))?;
        let count = file.read(buffer)?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Lines {
    /// Creates a reader of the lines from `offset`, the start of the line `number`, up to `limit`.
    #[must_use]
    pub fn new(file: Arc<File>, form: TextForm, offset: u64, number: u64, limit: u64) -> Self {
        Self {
            source: BufReader::with_capacity(
                BUFFER_BYTES,
                FromStart {
                    file,
                    position: offset,
                },
            ),
            form,
            offset,
            number,
            limit,
            bytes: Vec::new(),
            text: String::new(),
        }
    }

    /// Returns the next line; `None` at the end.
    ///
    /// # Errors
    /// The operating system refuses, or the line is longer than a megabyte.
    pub fn next_line(&mut self) -> Result<Option<Line<'_>>, TextLineError> {
        if self.offset >= self.limit {
            return Ok(None);
        }
        self.bytes.clear();
        let (offset, number) = (self.offset, self.number);
        let is_ended = match self.form.encoding {
            Encoding::Utf8 => self.read_bytes()?,
            Encoding::Utf16Le | Encoding::Utf16Be => self.read_units()?,
        };
        let count = self.bytes.len() as u64;
        if count == 0 {
            return Ok(None);
        }
        self.offset += count;
        self.number += 1;
        if !is_ended && count >= MOST_LINE_BYTES {
            return Err(TextLineError::Long { line: number });
        }
        self.text.clear();
        let is_utf8 = self.form.encoding.decode(&self.bytes, &mut self.text);
        if !is_utf8 {
            // Bytes of Western Europe, as older programs write them.
            self.text.extend(self.bytes.iter().copied().map(char::from));
        }
        let mut text = self.text.trim_end_matches(['\n', '\r']);
        if offset == 0 {
            let mark = if is_utf8 {
                "\u{feff}"
            } else {
                "\u{ef}\u{bb}\u{bf}"
            };
            text = text.strip_prefix(mark).unwrap_or(text);
        }
        Ok(Some(Line {
            offset,
            number,
            text,
            is_utf8,
            is_ended,
        }))
    }

    /// Reads the bytes of a line; returns whether it has an end.
    fn read_bytes(&mut self) -> io::Result<bool> {
        let mut limited = Read::by_ref(&mut self.source).take(MOST_LINE_BYTES);
        limited.read_until(self.form.end.byte(), &mut self.bytes)?;
        Ok(self.bytes.last() == Some(&self.form.end.byte()))
    }

    /// Reads the units of UTF-16 of a line; returns whether it has an end.
    fn read_units(&mut self) -> io::Result<bool> {
        let end = u16::from(self.form.end.byte());
        while (self.bytes.len() as u64) < MOST_LINE_BYTES {
            let before = self.bytes.len();
            Read::by_ref(&mut self.source)
                .take(2)
                .read_to_end(&mut self.bytes)?;
            let Some(unit) = self.bytes[before..].first_chunk::<2>() else {
                return Ok(false);
            };
            if self.form.encoding.unit(*unit) == end {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// Returns offset, number and text of each line of a file, and those from its second line on.
    fn lines(bytes: &[u8]) -> Vec<(u64, u64, String)> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        let (file, form) = (Arc::new(file), TextForm::find(bytes));
        let limit = bytes.len() as u64;
        let mut lines = Lines::new(Arc::clone(&file), form, 0, 1, limit);
        let mut all = Vec::new();
        while let Some(line) = lines.next_line().unwrap() {
            all.push((line.offset, line.number, line.text.to_owned()));
        }
        let (offset, number, text) = all[1].clone();
        let mut rest = Lines::new(file, form, offset, number, limit);
        assert_eq!(rest.next_line().unwrap().unwrap().text, text);
        all
    }

    #[test]
    fn lines_have_offsets_in_any_encoding() {
        let text = "\u{feff}Zeit\tKraft [µN]\r\n0\t1,5\r\n1\tĀĊ\u{10a0a}";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [text.as_bytes(), little.as_slice(), big.as_slice()] {
            let found = lines(bytes);
            let texts: Vec<&str> = found.iter().map(|(_, _, text)| text.as_str()).collect();
            assert_eq!(texts, ["Zeit\tKraft [µN]", "0\t1,5", "1\tĀĊ\u{10a0a}"]);
            assert_eq!(found[2].1, 3);
        }
        let western = lines(b"Kraft [\xb5N]\rx");
        assert_eq!(western[0].2, "Kraft [µN]");
    }
}
