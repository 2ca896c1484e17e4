//! Lines of data on a terminal.

use std::io::{self, Write};

/// Text whose lines are escaped for a terminal, each as soon as it ends.
#[derive(Debug)]
pub struct EscapedLines<W> {
    out: W,
    /// Start of a line, as UTF-8.
    begun: Vec<u8>,
}

impl<W: Write> EscapedLines<W> {
    /// Writes escaped lines to `out`.
    pub fn new(out: W) -> Self {
        Self {
            out,
            begun: Vec::new(),
        }
    }

    /// Writes the lines that have ended, up to `end` bytes.
    fn write_begun(&mut self, end: usize) -> io::Result<()> {
        let text = String::from_utf8_lossy(&self.begun[..end]);
        self.out.write_all(escaping::escaped(&text).as_bytes())?;
        self.begun.drain(..end);
        Ok(())
    }

    /// Writes a last line that has no end.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> io::Result<()> {
        self.write_begun(self.begun.len())?;
        self.out.flush()
    }
}

impl<W: Write> Write for EscapedLines<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let before = self.begun.len();
        self.begun.extend_from_slice(bytes);
        if let Some(end) = bytes.iter().rposition(|byte| *byte == b'\n') {
            self.write_begun(before + end + 1)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_in_pieces_are_escaped_as_a_whole() {
        let mut written = Vec::new();
        let mut lines = EscapedLines::new(&mut written);
        for piece in [&b"a\n\x1b[2Jb\xc2"[..], b"\xb5m\n", b"rest"] {
            lines.write_all(piece).unwrap();
        }
        assert_eq!(lines.begun, b"rest");
        lines.finish().unwrap();
        assert_eq!(written, "a\n\\u001b[2Jbµm\nrest".as_bytes());
    }
}
