//! Lines of a file, read with a limit on their length.

use std::io::{self, BufRead};

/// Line of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'a> {
    /// Bytes without the line's end, cut to the limit.
    pub bytes: &'a [u8],
    /// Whether the line is longer than the limit.
    pub cut: bool,
    /// Whether the line has an end; only the last line may lack it.
    pub ended: bool,
}

/// Reader of lines that skips the rest of a line beyond the limit.
#[derive(Debug)]
pub struct BoundedLines<R> {
    source: R,
    limit_bytes: usize,
    line: Vec<u8>,
    read_bytes: u64,
    /// Whether the latest line ended in CR, of which LF may be the second half.
    is_after_return: bool,
}

impl<R: BufRead> BoundedLines<R> {
    /// Reads the lines of `source`, each up to `limit_bytes`.
    pub fn new(source: R, limit_bytes: usize) -> Self {
        Self {
            source,
            limit_bytes,
            line: Vec::new(),
            read_bytes: 0,
            is_after_return: false,
        }
    }

    /// Returns the bytes read so far.
    #[must_use]
    pub fn read_bytes(&self) -> u64 {
        self.read_bytes
    }

    /// Returns the next line, which ends in LF, CR LF or CR; `None` at the end. A line without an end within `most_bytes` is returned as read so far and
    /// continues as the next one.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn next_line(&mut self, most_bytes: u64) -> io::Result<Option<Line<'_>>> {
        self.line.clear();
        let (mut length, mut ended) = (0u64, false);
        while !ended && length < most_bytes {
            let buffer = match self.source.fill_buf() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                buffer => buffer?,
            };
            if buffer.is_empty() {
                break;
            }
            if std::mem::take(&mut self.is_after_return) && buffer[0] == b'\n' {
                self.read_bytes += 1;
                self.source.consume(1);
                continue;
            }
            let end = buffer.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let part = &buffer[..end.unwrap_or(buffer.len())];
            let room = self.limit_bytes.saturating_sub(self.line.len());
            self.line.extend_from_slice(&part[..part.len().min(room)]);
            length += part.len() as u64;
            ended = end.is_some();
            self.is_after_return = end.is_some_and(|end| buffer[end] == b'\r');
            let used = part.len() + usize::from(ended);
            self.read_bytes += used as u64;
            self.source.consume(used);
        }
        let line = Line {
            bytes: &self.line,
            cut: length > self.line.len() as u64,
            ended,
        };
        Ok((ended || length > 0).then_some(line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufReader, Read};

    #[test]
    fn long_lines_are_cut_and_the_next_one_is_whole() {
        // The buffer is shorter than the lines.
        let source = BufReader::with_capacity(3, &b"1234567\n\nabcd\r\ntorn"[..]);
        let mut lines = BoundedLines::new(source, 4);
        let mut read = Vec::new();
        while let Some(line) = lines.next_line(u64::MAX).unwrap() {
            read.push((line.bytes.to_vec(), line.cut, line.ended));
        }
        let line = |bytes: &[u8], cut, is_ended| (bytes.to_vec(), cut, is_ended);
        assert_eq!(
            read,
            [
                line(b"1234", true, true),
                line(b"", false, true),
                line(b"abcd", false, true),
                line(b"torn", false, false)
            ]
        );
        assert_eq!(lines.read_bytes(), 19);
    }

    #[test]
    fn a_line_ends_in_any_way() {
        let text = ["a", "", "b", "c"];
        for end in ["\n", "\r\n", "\r"] {
            for capacity in [1, 2, 64] {
                let bytes = text.join(end);
                let source = BufReader::with_capacity(capacity, bytes.as_bytes());
                let mut lines = BoundedLines::new(source, 8);
                let mut read = Vec::new();
                while let Some(line) = lines.next_line(u64::MAX).unwrap() {
                    read.push(String::from_utf8(line.bytes.to_vec()).unwrap());
                }
                assert_eq!(read, text, "{end:?}");
                assert_eq!(lines.read_bytes(), bytes.len() as u64);
            }
        }
    }

    #[test]
    fn an_endless_line_is_cut_at_the_limit() {
        let endless = BufReader::with_capacity(64, io::repeat(0).take(u64::MAX));
        let mut lines = BoundedLines::new(endless, 8);
        let line = lines.next_line(1000).unwrap().unwrap();
        assert_eq!(
            (line.bytes, line.cut, line.ended),
            (&[0; 8][..], true, false)
        );
    }
}
