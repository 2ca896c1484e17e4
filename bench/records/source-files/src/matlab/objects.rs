//! The store of a file's objects: classes, objects and their properties.

use super::node::{Elements, Node};
use crate::error::SourceError;
use crate::numbers::NumberType;

/// First word of a reference to objects.
pub(crate) const REFERENCE: u32 = 0xdd00_0000;

/// Maximum bytes of the table of classes and properties.
const MOST_TABLE_BYTES: u64 = 1 << 26;

/// Objects of a file.
#[derive(Debug, Default)]
pub(crate) struct Objects {
    words: Vec<u32>,
    names: Vec<String>,
    /// Offsets of the table's parts, in words.
    parts: Vec<usize>,
    /// Values of properties.
    cells: Vec<Node>,
}

impl Objects {
    /// Reads the store from the array of bytes that a file keeps it in.
    pub(crate) fn read(elements: &mut Elements<'_>, store: &Node) -> Result<Self, SourceError> {
        let Node::Numeric(bytes) = store else {
            return Ok(Self::default());
        };
        let (start, end) = (bytes.real.offset, bytes.real.offset + bytes.real.count);
        if bytes.real.encoding.number != NumberType::U8 || bytes.real.count < 16 {
            return Ok(Self::default());
        }
        // The bytes are a file of one structure, with a header of eight bytes.
        let tag = elements.tag(start + 8, end)?;
        let (_, root) = elements.matrix(tag, 0)?;
        let Node::Structures { fields, .. } = root else {
            return Ok(Self::default());
        };
        let store = fields.into_iter().find_map(|field| match field {
            Node::Cells { cells, .. } => Some(cells),
            _ => None,
        });
        let Some(cells) = store else {
            return Ok(Self::default());
        };
        let Some(Node::Numeric(table)) = cells.first() else {
            return Ok(Self::default());
        };
        if table.real.count > MOST_TABLE_BYTES || table.real.encoding.number != NumberType::U8 {
            return Ok(Self::default());
        }
        let bytes = elements.bytes(table.real.offset, table.real.count)?;
        Ok(Self::from_table(&bytes, cells).unwrap_or_default())
    }

    fn from_table(bytes: &[u8], cells: Vec<Node>) -> Option<Self> {
        // The table is little-endian in every file.
        let (words, _) = bytes.as_chunks::<4>();
        let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let names_count = *words.get(1)? as usize;
        let parts: Vec<usize> = words
            .get(2..8)?
            .iter()
            .map(|offset| *offset as usize / 4)
            .collect();
        let names = bytes.get(40..parts[0] * 4)?.split(|byte| *byte == 0);
        let names: Vec<String> = names
            .take(names_count)
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        Some(Self {
            words,
            names,
            parts,
            cells,
        })
    }

    /// Returns the properties of the object that a reference means, by name; `None` for several objects, and for one that is
    /// not there.
    pub(crate) fn properties(&self, reference: &[u32]) -> Option<Vec<(&str, &Node)>> {
        let [REFERENCE, axes, rest @ ..] = reference else {
            return None;
        };
        let (lengths, rest) = rest.split_at_checked(*axes as usize)?;
        if lengths.iter().any(|length| *length != 1) {
            return None;
        }
        let object = *rest.first()? as usize;
        // An object: class, two unused words, its properties as saved, or as they are, and dependencies.
        let entry = self
            .words
            .get(self.parts.get(2)? + object.checked_mul(6)?..)?;
        let (saved, plain) = (*entry.get(3)? as usize, *entry.get(4)? as usize);
        let block = match (saved, plain) {
            (0, 0) => return None,
            (0, plain) => self.block(*self.parts.get(3)?, plain)?,
            (saved, _) => self.block(*self.parts.get(1)?, saved)?,
        };
        let properties = block
            .as_chunks::<3>()
            .0
            .iter()
            .filter_map(|[name, kind, value]| {
                let name = self.names.get((*name as usize).checked_sub(1)?)?;
                let value = (*kind == 1).then(|| self.cells.get(*value as usize + 2))??;
                Some((name.as_str(), value))
            });
        Some(properties.collect())
    }

    /// Returns the class of the object that a reference within another object means.
    pub(crate) fn class(&self, reference: &[u32]) -> Option<&str> {
        let [REFERENCE, .., class] = reference else {
            return None;
        };
        // A class: its package, its name, and two unused words.
        let entry = self
            .words
            .get(self.parts.first()? + (*class as usize).checked_mul(4)?..)?;
        let name = (*entry.get(1)? as usize).checked_sub(1)?;
        self.names.get(name).map(String::as_str)
    }

    /// Returns the words of a block of properties; blocks begin with their number of properties and fill eight bytes.
    fn block(&self, part: usize, index: usize) -> Option<&[u32]> {
        // The first block is empty.
        let mut start = part + 2;
        for _ in 1..index {
            let count = *self.words.get(start)? as usize;
            start = start.checked_add((1 + count.checked_mul(3)?).next_multiple_of(2))?;
        }
        let count = *self.words.get(start)? as usize;
        self.words.get(start + 1..)?.get(..count.checked_mul(3)?)
    }
}
