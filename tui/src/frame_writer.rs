//! A terminal that gets each frame whole: synchronized (DEC mode 2026, ignored where it is unknown), in one write.

use std::io::{self, Write};

const BEGIN: &[u8] = b"\x1b[?2026h";
const END: &[u8] = b"\x1b[?2026l";

/// Keeps what is written until it is flushed.
#[derive(Debug)]
pub(crate) struct FrameWriter<W> {
    to: W,
    frame: Vec<u8>,
}

impl<W: Write> FrameWriter<W> {
    pub(crate) fn new(to: W) -> Self {
        Self {
            to,
            frame: Vec::with_capacity(1 << 16),
        }
    }
}

impl<W: Write> Write for FrameWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.frame.is_empty() {
            self.frame.extend_from_slice(BEGIN);
        }
        self.frame.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.frame.is_empty() {
            return Ok(());
        }
        self.frame.extend_from_slice(END);
        let written = self.to.write_all(&self.frame);
        self.frame.clear();
        written?;
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Writes(Vec<Vec<u8>>);

    impl Write for Writes {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.push(bytes.to_vec());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_frame_is_one_synchronized_write() {
        let mut writer = FrameWriter::new(Writes::default());
        writer.write_all(b"one").unwrap();
        writer.write_all(b" two").unwrap();
        writer.flush().unwrap();
        writer.flush().unwrap();
        assert_eq!(writer.to.0, [b"\x1b[?2026hone two\x1b[?2026l".to_vec()]);
    }
}
