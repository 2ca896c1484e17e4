//! Variables of MATLAB v5 to v7 as trees; their numbers stay in the file.

use file_sections::Bytes;

use crate::error::SourceError;
use crate::numbers::{Encoding, NumberType};

/// Maximum depth of structures and cells.
const MOST_DEPTH: usize = 32;

/// Maximum number of parts of a file.
const MOST_NODES: usize = 500_000;

/// Maximum number of axes.
const MOST_AXES: u64 = 64;

/// Maximum bytes of a name, of a list of names or of a text.
const MOST_TEXT_BYTES: u64 = 1 << 20;

/// Element that has a compressed one in it, and one that is an array.
pub(crate) const COMPRESSED: u32 = 15;
pub(crate) const MATRIX: u32 = 14;

/// Numbers or characters of an array, in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Content {
    /// Offset of the first.
    pub(crate) offset: u64,
    /// Type of each.
    pub(crate) encoding: Encoding,
    /// Number of them.
    pub(crate) count: u64,
}

/// Array of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Numeric {
    /// Lengths of its axes.
    pub(crate) shape: Vec<u64>,
    /// Type that MATLAB shows.
    pub(crate) class: NumberType,
    /// Whether it is logical.
    pub(crate) is_logical: bool,
    /// Real parts.
    pub(crate) real: Content,
    /// Imaginary parts.
    pub(crate) imaginary: Option<Content>,
}

/// Variable or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// Numbers.
    Numeric(Numeric),
    /// Text.
    Text { shape: Vec<u64>, content: Content },
    /// Cells, by columns.
    Cells { shape: Vec<u64>, cells: Vec<Node> },
    /// Structures: the names of their fields, then all fields of the first one, of the second one, …
    Structures {
        shape: Vec<u64>,
        names: Vec<String>,
        fields: Vec<Node>,
    },
    /// Object in the store of all objects: its class and the reference to it.
    Object { class: String, reference: Vec<u32> },
    /// Array of a kind that is not read, by its class.
    Other { class: String },
}

/// Head of an element of a file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tag {
    /// Kind.
    pub(crate) kind: u32,
    /// Bytes of its content.
    pub(crate) bytes: u64,
    /// Offset of its content.
    pub(crate) data: u64,
    /// Offset of the next element.
    pub(crate) next: u64,
}

/// Reader of elements in one source.
pub(crate) struct Elements<'a> {
    pub(crate) source: &'a mut dyn Bytes,
    pub(crate) is_big_endian: bool,
    pub(crate) nodes: usize,
}

fn damaged(offset: u64, finding: &str) -> SourceError {
    SourceError::damaged(format!("byte {offset}"), finding)
}

impl Elements<'_> {
    /// Fills a buffer of `n` bytes from an offset.
    pub(crate) fn bytes(&mut self, offset: u64, n: u64) -> Result<Vec<u8>, SourceError> {
        let mut buffer = vec![0; n as usize];
        match self.source.read_at(offset, &mut buffer) {
            Ok(()) => Ok(buffer),
            Err(error) => Err(crate::npy::read_error("", offset, &error)),
        }
    }

    fn word(&self, bytes: &[u8]) -> u32 {
        match bytes.first_chunk() {
            Some(bytes) if self.is_big_endian => u32::from_be_bytes(*bytes),
            Some(bytes) => u32::from_le_bytes(*bytes),
            None => 0,
        }
    }

    /// Reads the head of the element at an offset; it ends before `end`.
    pub(crate) fn tag(&mut self, offset: u64, end: u64) -> Result<Tag, SourceError> {
        if offset.saturating_add(8) > end {
            return Err(damaged(offset, "an element is missing"));
        }
        let bytes = self.bytes(offset, 8)?;
        let (first, second) = (self.word(&bytes), self.word(&bytes[4..]));
        let tag = match first >> 16 {
            0 => Tag {
                kind: first,
                bytes: second.into(),
                data: offset + 8,
                next: offset + 8 + u64::from(second).next_multiple_of(8),
            },
            small => Tag {
                kind: first & 0xffff,
                bytes: small.into(),
                data: offset + 4,
                next: offset + 8,
            },
        };
        if tag.data + tag.bytes > end || first >> 16 > 4 {
            return Err(damaged(
                offset,
                "an element is longer than the array around it",
            ));
        }
        Ok(tag)
    }

    /// Reads the array at an offset, with its name.
    pub(crate) fn matrix(&mut self, tag: Tag, depth: usize) -> Result<(String, Node), SourceError> {
        self.nodes += 1;
        if depth > MOST_DEPTH {
            return Err(damaged(
                tag.data,
                "its structures are nested deeper than 32 levels",
            ));
        }
        if self.nodes > MOST_NODES {
            return Err(damaged(tag.data, "it has more than 500 000 parts"));
        }
        if tag.bytes == 0 {
            return Ok((
                String::new(),
                Node::Other {
                    class: "empty array".to_owned(),
                },
            ));
        }
        let end = tag.data + tag.bytes;
        let flags = self.tag(tag.data, end)?;
        if flags.bytes < 8 {
            return Err(damaged(flags.data, "the flags of an array are missing"));
        }
        let word = self.bytes(flags.data, 4)?;
        let word = self.word(&word);
        let (class, is_complex, is_logical) = (word & 0xff, word & 0x800 != 0, word & 0x200 != 0);
        if class == 17 {
            return self.opaque(flags.next, end, depth);
        }
        let axes = self.tag(flags.next, end)?;
        let shape = self.shape(axes)?;
        let name = self.tag(axes.next, end)?;
        let next = name.next;
        let name = self.text(name)?;
        let node = match class {
            1 => self.cells(shape, next, end, depth)?,
            2 => self.structures(shape, next, end, depth)?,
            3 => {
                let class = self.tag(next, end)?;
                self.structures(shape, class.next, end, depth)?
            }
            4 => {
                let content = self.content(next, end)?.0;
                Node::Text { shape, content }
            }
            5 => Node::Other {
                class: "sparse matrix".to_owned(),
            },
            6..=15 => self.numeric(shape, class, is_complex, is_logical, next, end)?,
            16 => Node::Other {
                class: "function handle".to_owned(),
            },
            class => Node::Other {
                class: format!("array of the unknown class {class}"),
            },
        };
        Ok((name, node))
    }

    fn shape(&mut self, tag: Tag) -> Result<Vec<u64>, SourceError> {
        if tag.bytes / 4 > MOST_AXES || tag.bytes < 4 {
            return Err(damaged(tag.data, "the shape of an array is impossible"));
        }
        let bytes = self.bytes(tag.data, tag.bytes)?;
        let lengths = bytes.as_chunks::<4>().0.iter();
        let lengths: Vec<u64> = lengths.map(|bytes| u64::from(self.word(bytes))).collect();
        // Lengths are signed.
        if lengths.iter().any(|length| *length > i32::MAX as u64) {
            return Err(damaged(tag.data, "the shape of an array is impossible"));
        }
        Ok(lengths)
    }

    /// Reads a name.
    fn text(&mut self, tag: Tag) -> Result<String, SourceError> {
        if tag.bytes > MOST_TEXT_BYTES {
            return Err(damaged(tag.data, "a name is longer than a megabyte"));
        }
        let bytes = self.bytes(tag.data, tag.bytes)?;
        let text = String::from_utf8_lossy(&bytes);
        Ok(text.trim_end_matches('\0').to_owned())
    }

    /// Returns the numbers of the element at an offset, and the offset after it.
    fn content(&mut self, offset: u64, end: u64) -> Result<(Content, u64), SourceError> {
        let tag = self.tag(offset, end)?;
        let number = match tag.kind {
            1 => NumberType::I8,
            2 | 16 => NumberType::U8,
            3 => NumberType::I16,
            4 | 17 => NumberType::U16,
            5 => NumberType::I32,
            6 | 18 => NumberType::U32,
            7 => NumberType::F32,
            9 => NumberType::F64,
            12 => NumberType::I64,
            13 => NumberType::U64,
            _ => {
                return Err(damaged(
                    offset,
                    "the type of the numbers of an array is unknown",
                ));
            }
        };
        let content = Content {
            offset: tag.data,
            encoding: Encoding {
                number,
                is_big_endian: self.is_big_endian,
            },
            count: tag.bytes / number.bytes() as u64,
        };
        Ok((content, tag.next))
    }

    fn numeric(
        &mut self,
        shape: Vec<u64>,
        class: u32,
        is_complex: bool,
        is_logical: bool,
        offset: u64,
        end: u64,
    ) -> Result<Node, SourceError> {
        const CLASSES: [NumberType; 10] = [
            NumberType::F64,
            NumberType::F32,
            NumberType::I8,
            NumberType::U8,
            NumberType::I16,
            NumberType::U16,
            NumberType::I32,
            NumberType::U32,
            NumberType::I64,
            NumberType::U64,
        ];
        let (real, next) = self.content(offset, end)?;
        let imaginary = match is_complex {
            true => Some(self.content(next, end)?.0),
            false => None,
        };
        let needed = shape
            .iter()
            .fold(1u64, |count, length| count.saturating_mul(*length));
        let is_short = |content: &Content| content.count < needed;
        if is_short(&real) || imaginary.as_ref().is_some_and(is_short) {
            return Err(damaged(
                offset,
                "an array has fewer numbers than its shape says",
            ));
        }
        Ok(Node::Numeric(Numeric {
            shape,
            class: CLASSES[class as usize - 6],
            is_logical,
            real,
            imaginary,
        }))
    }

    /// Reads so many arrays from an offset on.
    fn matrices(
        &mut self,
        count: u64,
        offset: u64,
        end: u64,
        depth: usize,
    ) -> Result<Vec<Node>, SourceError> {
        if count > end.saturating_sub(offset) / 8 {
            return Err(damaged(
                offset,
                "it has fewer cells or fields than its shape says",
            ));
        }
        let mut nodes = Vec::new();
        let mut offset = offset;
        for _ in 0..count {
            let tag = self.tag(offset, end)?;
            if tag.kind != MATRIX {
                return Err(damaged(offset, "a cell or field is not an array"));
            }
            nodes.push(self.matrix(tag, depth + 1)?.1);
            offset = tag.next;
        }
        Ok(nodes)
    }

    fn cells(
        &mut self,
        shape: Vec<u64>,
        offset: u64,
        end: u64,
        depth: usize,
    ) -> Result<Node, SourceError> {
        let count = shape
            .iter()
            .fold(1u64, |count, length| count.saturating_mul(*length));
        let cells = self.matrices(count, offset, end, depth)?;
        Ok(Node::Cells { shape, cells })
    }

    fn structures(
        &mut self,
        shape: Vec<u64>,
        offset: u64,
        end: u64,
        depth: usize,
    ) -> Result<Node, SourceError> {
        let length = self.tag(offset, end)?;
        let bytes = self.bytes(length.data, length.bytes.min(4))?;
        let name_bytes = self.word(&bytes) as usize;
        let list = self.tag(length.next, end)?;
        if name_bytes == 0 || list.bytes > MOST_TEXT_BYTES {
            return Err(damaged(
                length.data,
                "the names of a structure's fields are missing",
            ));
        }
        let bytes = self.bytes(list.data, list.bytes)?;
        let names: Vec<String> = bytes
            .chunks_exact(name_bytes)
            .map(|name| {
                let name = name.split(|byte| *byte == 0).next().unwrap_or(name);
                String::from_utf8_lossy(name).into_owned()
            })
            .collect();
        let count = shape.iter().fold(names.len() as u64, |count, length| {
            count.saturating_mul(*length)
        });
        let fields = self.matrices(count, list.next, end, depth)?;
        Ok(Node::Structures {
            shape,
            names,
            fields,
        })
    }

    /// Reads an object: its name, the system of its class, the class, and a reference.
    fn opaque(
        &mut self,
        offset: u64,
        end: u64,
        depth: usize,
    ) -> Result<(String, Node), SourceError> {
        let name = self.tag(offset, end)?;
        let system = self.tag(name.next, end)?;
        let class = self.tag(system.next, end)?;
        let (name, system, next) = (self.text(name)?, self.text(system)?, class.next);
        let class = self.text(class)?;
        if system != "MCOS" {
            let class = format!("{class} ({system})");
            return Ok((name, Node::Other { class }));
        }
        let tag = self.tag(next, end)?;
        let content = self.matrix(tag, depth + 1)?.1;
        let node = match content {
            Node::Numeric(numeric) if numeric.real.encoding.number == NumberType::U32 => {
                Node::Object {
                    class,
                    reference: self.words(numeric.real)?,
                }
            }
            // The objects' store itself.
            cells @ Node::Cells { .. } => cells,
            _ => Node::Other { class },
        };
        Ok((name, node))
    }

    /// Reads a short list of numbers.
    fn words(&mut self, content: Content) -> Result<Vec<u32>, SourceError> {
        let bytes = content.count.saturating_mul(4).min(MOST_TEXT_BYTES);
        let bytes = self.bytes(content.offset, bytes)?;
        let (words, _) = bytes.as_chunks::<4>();
        Ok(words.iter().map(|bytes| self.word(bytes)).collect())
    }

    /// Reads a text of one line.
    pub(crate) fn characters(&mut self, content: Content) -> Result<String, SourceError> {
        let size = content.encoding.number.bytes();
        let bytes = content
            .count
            .saturating_mul(size as u64)
            .min(MOST_TEXT_BYTES);
        let bytes = self.bytes(content.offset, bytes)?;
        if size == 1 {
            return Ok(match String::from_utf8(bytes) {
                Ok(text) => text,
                Err(error) => error.into_bytes().into_iter().map(char::from).collect(),
            });
        }
        let units = bytes
            .chunks_exact(size)
            .map(|bytes| content.encoding.decode(bytes) as u32);
        Ok(match size {
            2 => char::decode_utf16(units.map(|unit| unit as u16))
                .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect(),
            _ => units.filter_map(char::from_u32).collect(),
        })
    }
}
