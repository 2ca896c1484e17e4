//! Bytes of a file or of a compressed part of it, read from any offset.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use flate2::read::{DeflateDecoder, ZlibDecoder};

/// Bytes that are read from any offset.
pub trait Bytes: Send {
    /// Fills `buffer` with the bytes from `offset` on.
    ///
    /// # Errors
    /// The operating system refuses, the bytes are damaged, or they end earlier.
    fn read_at(&mut self, offset: u64, buffer: &mut [u8]) -> io::Result<()>;

    /// Gives back the memory of open places.
    fn close(&mut self) {}
}

/// Number of sources that keep places open.
const MOST_OPEN: usize = 8;

/// Sources of which the ones used last keep places open.
#[derive(Default)]
pub struct Sources {
    sources: Vec<Box<dyn Bytes>>,
    /// The sources used last, the latest at the end.
    recent: Vec<usize>,
}

impl Sources {
    /// Adds a source, and returns its index.
    pub fn push(&mut self, source: Box<dyn Bytes>) -> usize {
        self.sources.push(source);
        self.sources.len() - 1
    }

    /// Returns a source for use.
    pub fn get(&mut self, index: usize) -> &mut dyn Bytes {
        self.recent.retain(|open| *open != index);
        if self.recent.len() >= MOST_OPEN {
            let oldest = self.recent.remove(0);
            self.sources[oldest].close();
        }
        self.recent.push(index);
        &mut *self.sources[index]
    }
}

/// Part of a file.
#[derive(Debug, Clone)]
pub struct Section {
    file: Arc<File>,
    position: u64,
    end: u64,
    start: u64,
}

impl Section {
    /// Creates the part from `start` to `end`.
    #[must_use]
    pub fn new(file: Arc<File>, start: u64, end: u64) -> Self {
        Self {
            file,
            position: start,
            end: end.max(start),
            start,
        }
    }

    /// Returns the part of it between two offsets.
    #[must_use]
    pub fn part(&self, start: u64, end: u64) -> Self {
        let at = |offset: u64| self.start.saturating_add(offset).min(self.end);
        Self::new(Arc::clone(&self.file), at(start), at(end))
    }

    /// Reads bytes from an offset on, as many as there are; returns their number.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn read_from(&mut self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        self.position = self.start.saturating_add(offset).min(self.end);
        self.read(buffer)
    }

    /// Returns the number of its bytes.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.end - self.start
    }

    /// Returns whether it has no bytes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.end == self.start
    }
}

impl Read for Section {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.end.saturating_sub(self.position)).unwrap_or(usize::MAX);
        let wanted = buffer.len().min(left);
        if wanted == 0 {
            return Ok(0);
        }
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.position))?;
        let count = file.read(&mut buffer[..wanted])?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Bytes for Section {
    fn read_at(&mut self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        self.position = self.start.saturating_add(offset).min(self.end);
        self.read_exact(buffer)
    }
}

/// Compression of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// Deflate with the header of zlib.
    Zlib,
    /// Deflate alone.
    Deflate,
}

/// Number of places in a compressed part that are kept open.
const MOST_CURSORS: usize = 6;

/// Bytes read from a file at once.
const BUFFER_BYTES: usize = 1 << 16;

/// Compressed part of a file.
///
/// A place is reached from the nearest open one before it, so that several vectors of one array are read side by side.
pub struct Inflated {
    section: Section,
    compression: Compression,
    /// The open places, the one used last at the end.
    cursors: Vec<Cursor>,
}

struct Cursor {
    decoder: Box<dyn Read + Send>,
    position: u64,
}

impl Inflated {
    /// Creates the content of a compressed part.
    #[must_use]
    pub fn new(section: Section, compression: Compression) -> Self {
        Self {
            section,
            compression,
            cursors: Vec::new(),
        }
    }

    fn start(&self) -> Cursor {
        let source = BufReader::with_capacity(
            BUFFER_BYTES,
            Section::new(
                Arc::clone(&self.section.file),
                self.section.start,
                self.section.end,
            ),
        );
        let decoder: Box<dyn Read + Send> = match self.compression {
            Compression::Zlib => Box::new(ZlibDecoder::new(source)),
            Compression::Deflate => Box::new(DeflateDecoder::new(source)),
        };
        Cursor {
            decoder,
            position: 0,
        }
    }
}

impl Bytes for Inflated {
    fn read_at(&mut self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        let places = (0..self.cursors.len()).filter(|i| self.cursors[*i].position <= offset);
        let nearest = places.max_by_key(|i| self.cursors[*i].position);
        let mut cursor = match nearest {
            // A gap of one row between stretches is crossed; a longer one is another vector, and keeps its own place.
            Some(i) if offset - self.cursors[i].position <= BUFFER_BYTES as u64 => {
                self.cursors.remove(i)
            }
            Some(i) if self.cursors.len() >= MOST_CURSORS => self.cursors.remove(i),
            _ => self.start(),
        };
        let result = advance(&mut cursor, offset).and_then(|()| {
            cursor.decoder.read_exact(buffer)?;
            cursor.position += buffer.len() as u64;
            Ok(())
        });
        result?;
        if self.cursors.len() >= MOST_CURSORS {
            self.cursors.remove(0);
        }
        self.cursors.push(cursor);
        Ok(())
    }

    fn close(&mut self) {
        self.cursors.clear();
    }
}

fn advance(cursor: &mut Cursor, offset: u64) -> io::Result<()> {
    let gap = offset - cursor.position;
    let skipped = io::copy(&mut cursor.decoder.by_ref().take(gap), &mut io::sink())?;
    cursor.position += skipped;
    if skipped < gap {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(())
}

/// Elements at equal distances.
#[derive(Debug, Clone, Copy)]
pub struct Stride {
    /// Offset of the first one, bytes.
    pub offset: u64,
    /// Distance between them, bytes.
    pub step: u64,
    /// Bytes of each.
    pub bytes: usize,
    /// Number of them.
    pub count: u64,
}

/// Longest distance of elements that are read together with the bytes between them.
const MOST_STEP: u64 = 4096;

impl Stride {
    /// Calls `visitor` with the bytes of every element, in order.
    ///
    /// # Errors
    /// The bytes cannot be read, with the offset of the part that failed.
    pub fn visit(
        self,
        source: &mut dyn Bytes,
        mut visitor: impl FnMut(&[u8]),
    ) -> Result<(), (u64, io::Error)> {
        if self.count == 0 || self.bytes == 0 {
            return Ok(());
        }
        let is_together = self.step <= MOST_STEP && self.step > 0;
        let block = if is_together {
            (BUFFER_BYTES as u64 / self.step).max(1)
        } else {
            1
        };
        let mut buffer = Vec::new();
        let mut done = 0;
        while done < self.count {
            let n = block.min(self.count - done);
            let span = (n - 1) * self.step.min(MOST_STEP) + self.bytes as u64;
            let span = if n == 1 { self.bytes as u64 } else { span };
            buffer.resize(span as usize, 0);
            let offset = self.offset.saturating_add(done.saturating_mul(self.step));
            source
                .read_at(offset, &mut buffer)
                .map_err(|error| (offset, error))?;
            for i in 0..n as usize {
                let start = i * self.step as usize;
                visitor(&buffer[start..start + self.bytes]);
            }
            done += n;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::write::ZlibEncoder;

    use super::*;

    fn file(bytes: &[u8]) -> Arc<File> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        Arc::new(file)
    }

    #[test]
    fn a_compressed_part_is_read_from_any_offset() {
        let content: Vec<u8> = (0..300_000u32).map(|i| (i * 7 % 251) as u8).collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&content).unwrap();
        let packed = encoder.finish().unwrap();
        let stored = [&b"before"[..], &packed].concat();
        let section = Section::new(file(&stored), 6, stored.len() as u64);
        let mut inflated = Inflated::new(section, Compression::Zlib);
        // Two vectors side by side, then backwards, then at random.
        let offsets = [
            0, 150_000, 100, 150_100, 299_900, 5, 200_000, 70_000, 10, 0, 99,
        ];
        for offset in offsets {
            let mut buffer = [0; 100];
            inflated.read_at(offset, &mut buffer).unwrap();
            assert_eq!(buffer, content[offset as usize..][..100], "{offset}");
        }
        let error = inflated.read_at(299_950, &mut [0; 100]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }

    #[test]
    fn elements_are_read_near_and_far() {
        let content: Vec<u8> = (0..50_000u32).flat_map(u32::to_le_bytes).collect();
        let mut section = Section::new(file(&content), 0, content.len() as u64);
        for (step, count) in [(4, 50_000u64), (12, 16_000), (8000, 20)] {
            let stride = Stride {
                offset: 4,
                step,
                bytes: 4,
                count: count - 1,
            };
            let mut values = Vec::new();
            let read = stride.visit(&mut section, |bytes| {
                values.push(u32::from_le_bytes(*bytes.first_chunk().unwrap()));
            });
            assert!(read.is_ok());
            let expected: Vec<u32> = (0..count - 1).map(|i| 1 + (i * step / 4) as u32).collect();
            assert_eq!(values, expected);
        }
    }
}
