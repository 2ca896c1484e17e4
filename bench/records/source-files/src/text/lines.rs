//! Lines of a text file from any offset on.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use crate::error::SourceError;

/// Maximum bytes of a line.
const MOST_LINE_BYTES: u64 = 1 << 20;

/// Bytes read from the file at once.
const BUFFER_BYTES: usize = 1 << 18;

/// Ends of lines: LF, which may follow CR, or CR alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineEnd {
    Lf,
    Cr,
}

impl LineEnd {
    /// Finds the ends in the first bytes of a file.
    pub(crate) fn find(head: &[u8]) -> Self {
        match head.contains(&b'\n') || !head.contains(&b'\r') {
            true => Self::Lf,
            false => Self::Cr,
        }
    }

    fn byte(self) -> u8 {
        match self {
            Self::Lf => b'\n',
            Self::Cr => b'\r',
        }
    }
}

/// Reader of lines.
pub(crate) struct Lines {
    source: BufReader<FromStart>,
    end: LineEnd,
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
pub(crate) struct Line<'a> {
    /// Offset of its first byte.
    pub(crate) offset: u64,
    /// Number, from 1.
    pub(crate) number: u64,
    /// Text without its end.
    pub(crate) text: &'a str,
    /// Whether the bytes are UTF-8; else they were read as those of Western Europe.
    pub(crate) is_utf8: bool,
    /// Whether it has an end.
    pub(crate) is_ended: bool,
}

/// File that is read from its own position.
struct FromStart {
    file: Arc<File>,
    position: u64,
}

impl Read for FromStart {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.position))?;
        let count = file.read(buffer)?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Lines {
    /// Creates a reader of the lines from `offset`, the start of the line `number`, up to `limit`.
    pub(crate) fn new(file: Arc<File>, end: LineEnd, offset: u64, number: u64, limit: u64) -> Self {
        Self {
            source: BufReader::with_capacity(
                BUFFER_BYTES,
                FromStart {
                    file,
                    position: offset,
                },
            ),
            end,
            offset,
            number,
            limit,
            bytes: Vec::new(),
            text: String::new(),
        }
    }

    /// Returns the next line; `None` at the end.
    pub(crate) fn next_line(&mut self) -> Result<Option<Line<'_>>, SourceError> {
        if self.offset >= self.limit {
            return Ok(None);
        }
        self.bytes.clear();
        let (offset, number) = (self.offset, self.number);
        let mut limited = Read::by_ref(&mut self.source).take(MOST_LINE_BYTES);
        let count = limited.read_until(self.end.byte(), &mut self.bytes)? as u64;
        if count == 0 {
            return Ok(None);
        }
        self.offset += count;
        self.number += 1;
        let is_ended = self.bytes.last() == Some(&self.end.byte());
        if !is_ended && count == MOST_LINE_BYTES {
            let place = format!("line {number}");
            return Err(SourceError::damaged(place, "it is longer than a megabyte"));
        }
        let mut content = self.bytes.as_slice();
        while let [rest @ .., b'\n' | b'\r'] = content {
            content = rest;
        }
        if offset == 0 {
            content = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content);
        }
        let (text, is_utf8) = match std::str::from_utf8(content) {
            Ok(text) => (text, true),
            Err(_) => {
                // Bytes of Western Europe, as older programs write them.
                self.text.clear();
                self.text.extend(content.iter().copied().map(char::from));
                (self.text.as_str(), false)
            }
        };
        Ok(Some(Line {
            offset,
            number,
            text,
            is_utf8,
            is_ended,
        }))
    }
}
