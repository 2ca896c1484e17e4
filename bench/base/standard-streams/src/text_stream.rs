//! A writer that replaces characters.

use std::io::{self, Write};

/// Writer of texts, in ASCII if so created.
#[derive(Debug)]
pub struct TextStream<W> {
    target: W,
    is_ascii: bool,
    /// Start of a character that is not complete yet.
    incomplete: Vec<u8>,
}

impl<W: Write> TextStream<W> {
    /// Creates a writer of texts to `target`.
    pub fn new(target: W, is_ascii: bool) -> Self {
        Self {
            target,
            is_ascii,
            incomplete: Vec::new(),
        }
    }
}

impl<W: Write> Write for TextStream<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !self.is_ascii {
            return self.target.write(bytes);
        }
        let mut pending = std::mem::take(&mut self.incomplete);
        pending.extend_from_slice(bytes);
        for chunk in pending.utf8_chunks() {
            let text = escaping::ascii(chunk.valid());
            self.target.write_all(text.as_bytes())?;
        }
        self.incomplete = incomplete_end(&pending).to_vec();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.target.flush()
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

    fn printed(pieces: &[&[u8]], is_ascii: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut stream = TextStream::new(&mut out, is_ascii);
        for piece in pieces {
            stream.write_all(piece).unwrap();
        }
        stream.flush().unwrap();
        out
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
}
