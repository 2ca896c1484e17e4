//! MATLAB v5 to v7: variables, structures, cells, tables and other objects. Numbers stay in the file until they are read.

mod list;
mod node;
mod objects;

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Bytes, Compression, Inflated, Section, Sources, Stride};
use list::{Found, Lister, Values as Content};
use node::{COMPRESSED, Elements, MATRIX, Node, Numeric};
use num_complex::Complex64;
use objects::Objects;

use crate::array::{ArrayInfo, Attribute};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values, strides};
use crate::npy::read_error;

/// Bytes of the header.
const HEADER_BYTES: u64 = 128;

/// Remedy for a variable without its end.
const CUT_REMEDY: &str =
    "the file is damaged; copy it again, or save it again from the program that made it";

/// Maximum characters of an array that is read as text.
const MOST_CHARACTERS: u64 = 1 << 16;

/// Reader of a file of MATLAB v5 to v7.
pub(crate) struct MatlabReader {
    format: Format,
    is_big_endian: bool,
    sources: Sources,
    arrays: Vec<ArrayInfo>,
    found: Vec<Found>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
    /// Name, where it is there, and offset of a variable without its end.
    cut: Option<(String, u64)>,
}

/// Variable of a file.
struct Variable {
    name: String,
    node: Node,
    source: usize,
}

impl MatlabReader {
    /// Opens a file of MATLAB v5 to v7.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let file_bytes = file.metadata()?.len();
        let mut whole = Section::new(Arc::new(file), 0, file_bytes);
        let mut header = [0; HEADER_BYTES as usize];
        whole
            .read_at(0, &mut header)
            .map_err(|_| SourceError::damaged("byte 0", "its header of 128 bytes ends early"))?;
        let is_big_endian = header[126..] == *b"MI";
        let mut sources = Sources::default();
        sources.push(Box::new(whole.clone()));
        let mut reader = Self {
            format: Format::Matlab5,
            is_big_endian,
            sources,
            arrays: Vec::new(),
            found: Vec::new(),
            attributes: BTreeMap::new(),
            notes: Vec::new(),
            cut: None,
        };
        let (variables, store) = reader.variables(&whole, store_offset(&header, is_big_endian))?;
        reader.list(&variables, store)?;
        Ok(Box::new(reader))
    }

    /// Reads the variables, and the store of objects at an offset.
    fn variables(
        &mut self,
        whole: &Section,
        store_offset: Option<u64>,
    ) -> Result<(Vec<Variable>, Option<Variable>), SourceError> {
        let (mut variables, mut store) = (Vec::new(), None);
        let mut offset = HEADER_BYTES;
        let mut nodes = 0;
        while offset.saturating_add(8) <= whole.len() {
            let tag = self.elements(0, nodes).tag(offset, u64::MAX / 2)?;
            let is_cut = tag.data.saturating_add(tag.bytes) > whole.len();
            let (source, tag_inside, next) = match tag.kind {
                MATRIX => (0, tag, tag.next),
                COMPRESSED => {
                    self.format = Format::Matlab7;
                    let end = tag.data.saturating_add(tag.bytes);
                    let section = whole.part(tag.data, end);
                    let inflated = Inflated::new(section, Compression::Zlib);
                    let source = self.sources.push(Box::new(inflated));
                    let inside = match self.elements(source, nodes).tag(0, u64::MAX / 2) {
                        Ok(inside) => inside,
                        Err(_) if is_cut => {
                            self.cut = Some((String::new(), offset));
                            break;
                        }
                        Err(error) => return Err(inside_variable(error, offset)),
                    };
                    (source, inside, end)
                }
                0 => {
                    return Err(SourceError::damaged(
                        format!("byte {offset}"),
                        "a variable should begin here",
                    ));
                }
                _ => {
                    offset = tag.next;
                    continue;
                }
            };
            let mut elements = self.elements(source, nodes);
            let parsed = elements.matrix(tag_inside, 0);
            nodes = elements.nodes;
            match parsed {
                Ok((name, _)) if is_cut => {
                    self.cut = Some((name, offset));
                    break;
                }
                Err(_) if is_cut => {
                    self.cut = Some((String::new(), offset));
                    break;
                }
                Ok((name, node)) => {
                    let variable = Variable { name, node, source };
                    match store_offset == Some(offset) {
                        true => store = Some(variable),
                        false => variables.push(variable),
                    }
                }
                Err(error) => return Err(inside_variable(error, offset)),
            }
            offset = next;
        }
        Ok((variables, store))
    }

    /// Lists the arrays of the variables.
    fn list(&mut self, variables: &[Variable], store: Option<Variable>) -> Result<(), SourceError> {
        let (objects, objects_source) = match &store {
            Some(store) => {
                let mut elements = self.elements(store.source, 0);
                (
                    Objects::read(&mut elements, &store.node).unwrap_or_default(),
                    store.source,
                )
            }
            None => (Objects::default(), 0),
        };
        let mut lister = Lister {
            sources: &mut self.sources,
            is_big_endian: self.is_big_endian,
            objects,
            objects_source,
            arrays: Vec::new(),
            found: Vec::new(),
            visits: 0,
        };
        for variable in variables
            .iter()
            .filter(|variable| !variable.name.is_empty())
        {
            lister.add(&variable.name, &variable.node, variable.source, 0)?;
        }
        let is_full = lister.is_full();
        (self.arrays, self.found) = (lister.arrays, lister.found);
        if let Some((name, offset)) = self.cut.take() {
            let finding = format!("the file ends within the variable that begins at byte {offset}");
            if self.arrays.is_empty() && name.is_empty() {
                return Err(SourceError::damaged(format!("byte {offset}"), finding));
            }
            self.notes.push(format!("{finding}; it is left out"));
            if !name.is_empty() {
                let content = "a variable within which the file ends";
                self.arrays
                    .push(ArrayInfo::unread(name, content, CUT_REMEDY));
            }
        }
        if is_full {
            self.notes.push(format!(
                "it has more than the {} arrays that are listed",
                self.arrays.len()
            ));
        }
        Ok(())
    }

    fn elements(&mut self, source: usize, nodes: usize) -> Elements<'_> {
        Elements {
            source: self.sources.get(source),
            is_big_endian: self.is_big_endian,
            nodes,
        }
    }

    /// Returns one part of complex numbers, or real numbers.
    fn part(
        &mut self,
        index: usize,
        numeric: &Numeric,
        content: node::Content,
        place: &Place,
        range: &Range<u64>,
        visitor: &mut dyn FnMut(f64),
    ) -> Result<(), SourceError> {
        let size = content.encoding.number.bytes();
        let strides = strides(&numeric.shape, size as u64, true);
        let (offset, step) = place.offset_and_step(&strides);
        let stride = Stride {
            offset: content.offset + offset + range.start.saturating_mul(step),
            step,
            bytes: size,
            count: range.end - range.start,
        };
        let source = self.sources.get(self.found[index].source);
        stride
            .visit(source, |bytes| visitor(content.encoding.decode(bytes)))
            .map_err(|(offset, error)| read_error(&self.arrays[index].name, offset, &error))
    }
}

/// Returns the offset of the store of objects; `None` for a file without it.
fn store_offset(header: &[u8; HEADER_BYTES as usize], is_big_endian: bool) -> Option<u64> {
    let bytes = header[116..].first_chunk::<8>()?;
    let offset = match is_big_endian {
        true => u64::from_be_bytes(*bytes),
        false => u64::from_le_bytes(*bytes),
    };
    (offset >= HEADER_BYTES && *bytes != [b' '; 8]).then_some(offset)
}

/// Places an error in a variable.
fn inside_variable(error: SourceError, offset: u64) -> SourceError {
    let place = error.place.unwrap_or_default();
    SourceError {
        place: Some(format!("variable at byte {offset}, {place}")),
        ..error
    }
}

impl ArrayReader for MatlabReader {
    fn format(&self) -> Format {
        self.format
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn text(&mut self, index: usize) -> Result<Option<String>, SourceError> {
        let Some(Found {
            source,
            values: Content::Text(content),
        }) = self.found.get(index).cloned()
        else {
            return Ok(None);
        };
        let is_line = self.arrays[index].shape.first() == Some(&1);
        if !is_line || content.count > MOST_CHARACTERS {
            return Ok(None);
        }
        self.elements(source, 0).characters(content).map(Some)
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let Some(Content::Numbers { numeric, scale }) =
            self.found.get(index).map(|array| array.values.clone())
        else {
            return Ok(());
        };
        let Some(imaginary) = numeric.imaginary else {
            let push = &mut |value| values.push(value * scale);
            return self.part(index, &numeric, numeric.real, place, &range, push);
        };
        let (mut re, mut im) = (Vec::new(), Vec::new());
        self.part(index, &numeric, numeric.real, place, &range, &mut |value| {
            re.push(value)
        })?;
        self.part(index, &numeric, imaginary, place, &range, &mut |value| {
            im.push(value)
        })?;
        for (re, im) in re.into_iter().zip(im) {
            values.push_complex(Complex64::new(re, im));
        }
        Ok(())
    }
}
