//! Numbers of a dataset, or of a field of its elements, along one axis.

use std::ops::Range;

use hdf5_reader::error::{Error, Result};
use hdf5_reader::{Dataset, Datatype, SliceInfo, SliceInfoElem};
use num_complex::Complex64;

use crate::array::Element;
use crate::format::{Place, Values};
use crate::hdf5::number::{self, Bytes, Real};
use crate::numbers::Encoding;

/// Bytes of elements that are read at once.
const SLAB_BYTES: u64 = 1 << 20;
/// Longest rows of which one element is picked, instead of reading each element alone, bytes.
const SHORT_ROW_BYTES: u64 = 64 << 10;

/// Order of the axes that names and shapes have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AxisOrder {
    /// As stored.
    Stored,
    /// The last stored axis is the first: MATLAB's order.
    Reversed,
}

/// Numbers within each element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    /// The element is the number.
    Whole,
    /// A number in the element.
    Real { encoding: Encoding, offset: usize },
    /// Two numbers in the element.
    Complex {
        encoding: Encoding,
        re: usize,
        im: usize,
    },
    /// The sum of a complex number's parts: time in ms, as MATLAB's points in time have it.
    Sum {
        encoding: Encoding,
        re: usize,
        im: usize,
    },
}

/// Numbers of a dataset that form an array.
#[derive(Clone)]
pub(crate) struct Column {
    dataset: Dataset,
    part: Part,
    /// Axes within an element, and the bytes of one number there.
    inner: Vec<u64>,
    number_bytes: u64,
    order: AxisOrder,
    /// Factor to the values' unit.
    factor: f64,
}

/// A field of a dataset's elements.
pub(crate) struct Field {
    /// Names of the fields that lead to it, joined by dots; empty for an element that is a number.
    pub(crate) name: String,
    pub(crate) element: Element,
    pub(crate) part: Part,
    /// Axes within the element.
    pub(crate) inner: Vec<u64>,
    /// Bytes of one number of the innermost array.
    pub(crate) number_bytes: u64,
}

/// Most fields of one element, nested ones included.
const MOST_FIELDS: usize = 1000;

/// Returns the numeric fields of elements of a type, and the names of the others with their types.
pub(crate) fn fields(datatype: &Datatype) -> (Vec<Field>, Vec<(String, String)>) {
    let (mut fields, mut others) = (Vec::new(), Vec::new());
    collect(datatype, "", 0, true, &mut fields, &mut others);
    (fields, others)
}

fn collect(
    datatype: &Datatype,
    name: &str,
    offset: usize,
    is_whole: bool,
    fields: &mut Vec<Field>,
    others: &mut Vec<(String, String)>,
) {
    if fields.len() + others.len() >= MOST_FIELDS {
        return;
    }
    let (inner, base) = match datatype {
        Datatype::Array { base, dims } => (dims.clone(), &**base),
        other => (Vec::new(), other),
    };
    let number_bytes = hdf5_reader::dtype_element_size(base).unwrap_or(0) as u64;
    let name = name.to_owned();
    let field = |element, part| Field {
        name: name.clone(),
        element,
        part,
        inner: inner.clone(),
        number_bytes,
    };
    if let Some((encoding, element)) = number::encoding(base) {
        let part = if is_whole && inner.is_empty() {
            Part::Whole
        } else {
            Part::Real { encoding, offset }
        };
        fields.push(field(element, part));
        return;
    }
    if let Some((encoding, re, im)) = complex_parts(base) {
        let element = encoding.number.element(true);
        let (re, im) = (offset + re, offset + im);
        fields.push(field(element, Part::Complex { encoding, re, im }));
        return;
    }
    match base {
        Datatype::Compound { fields: own, .. } if inner.is_empty() => {
            for own in own {
                let path = match name.as_str() {
                    "" => own.name.clone(),
                    name => format!("{name}.{}", own.name),
                };
                let offset = offset + own.byte_offset as usize;
                collect(&own.datatype, &path, offset, false, fields, others);
            }
        }
        other => others.push((name, type_name(other))),
    }
}

/// Returns the two floats of an element that is a complex number, and their offsets.
pub(crate) fn complex_parts(datatype: &Datatype) -> Option<(Encoding, usize, usize)> {
    const NAMES: [[&str; 2]; 4] = [
        ["r", "i"],
        ["re", "im"],
        ["real", "imag"],
        ["real", "imaginary"],
    ];
    let Datatype::Compound { fields, .. } = datatype else {
        return None;
    };
    let [re, im] = fields.as_slice() else {
        return None;
    };
    let names = [re.name.to_lowercase(), im.name.to_lowercase()];
    let is_complex = NAMES.iter().any(|known| *known == names);
    let (encoding, element) = number::encoding(&re.datatype)?;
    let is_alike = re.datatype == im.datatype
        && matches!(element, Element::Float { .. } | Element::Integer { .. });
    (is_complex && is_alike).then_some((encoding, re.byte_offset as usize, im.byte_offset as usize))
}

/// Returns the name of a type that is no number, as messages show it.
pub(crate) fn type_name(datatype: &Datatype) -> String {
    match datatype {
        Datatype::String { .. } => "text".to_owned(),
        Datatype::VarLen { .. } => "lists of different lengths".to_owned(),
        Datatype::Reference { .. } => "references".to_owned(),
        Datatype::Opaque { tag, .. } if tag.is_empty() => "opaque bytes".to_owned(),
        Datatype::Opaque { tag, .. } => format!("opaque bytes ({tag})"),
        Datatype::FloatingPoint { size, .. } => format!("float{}", u32::from(*size) * 8),
        Datatype::FixedPoint { size, .. } | Datatype::Bitfield { size, .. } => {
            format!("integers of {} bits", u32::from(*size) * 8)
        }
        Datatype::Array { .. } | Datatype::Compound { .. } => "arrays of compounds".to_owned(),
        Datatype::Enum { base, .. } => type_name(base),
    }
}

impl Column {
    pub(crate) fn new(dataset: &Dataset, field: &Field, order: AxisOrder) -> Self {
        Self {
            dataset: dataset.clone(),
            part: field.part,
            inner: field.inner.clone(),
            number_bytes: field.number_bytes,
            order,
            factor: 1.0,
        }
    }

    /// Returns the column in another unit.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { factor, ..self }
    }

    /// Returns the real column of a complex one that is the sum of its parts.
    pub(crate) fn summed(self) -> Self {
        let part = match self.part {
            Part::Complex { encoding, re, im } => Part::Sum { encoding, re, im },
            other => other,
        };
        Self { part, ..self }
    }

    /// Returns the lengths of the axes, in the order of names.
    pub(crate) fn shape(&self) -> Vec<u64> {
        let mut shape = stored_shape(&self.dataset);
        shape.extend(&self.inner);
        if self.order == AxisOrder::Reversed {
            shape.reverse();
        }
        shape
    }

    /// Returns the bytes of a chunk; 0 for a dataset without chunks.
    pub(crate) fn chunk_bytes(&self) -> usize {
        let elements = self.dataset.chunks().unwrap_or_default();
        let size = self.dataset.raw_element_size().unwrap_or(0);
        let is_chunked = usize::from(!elements.is_empty());
        let lengths = elements.into_iter().map(|length| length as usize);
        lengths.fold(size * is_chunked, usize::saturating_mul)
    }

    /// Reads all values in the stored order, if they are at most `most`.
    pub(crate) fn read_all(&self, most: u64) -> Result<Option<Vec<f64>>> {
        let shape = self.shape();
        let count = shape
            .iter()
            .fold(1_u64, |count, length| count.saturating_mul(*length));
        if count > most
            || !matches!(self.part, Part::Whole)
            || self.dataset.num_elements()? != count
        {
            return Ok(None);
        }
        let array = self.dataset.read_array::<Real>()?;
        let values = array.as_slice().unwrap_or(&[]);
        Ok(Some(
            values.iter().map(|value| value.0 * self.factor).collect(),
        ))
    }

    /// Reads the first value; `None` for an array without values.
    pub(crate) fn first(&self) -> Result<Option<f64>> {
        let axes = self.shape().len();
        if self.dataset.num_elements()? == 0 {
            return Ok(None);
        }
        let place = Place {
            axis: 0,
            fixed: vec![0; axes.saturating_sub(1)],
        };
        let mut values = Vec::new();
        self.read(&place, 0..1, &mut Values::Real(&mut values))?;
        Ok(values.first().copied())
    }

    /// Appends the values `range` along the place's axis.
    pub(crate) fn read(
        &self,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<()> {
        let axes = self.shape().len();
        let mut fixed = place.fixed.iter().copied();
        let mut index: Vec<Option<u64>> = (0..axes)
            .map(|axis| match axis == place.axis {
                true => None,
                false => Some(fixed.next().unwrap_or(0)),
            })
            .collect();
        if self.order == AxisOrder::Reversed {
            index.reverse();
        }
        let outer_axes = self.dataset.ndim().min(index.len());
        let (outer, inner) = index.split_at(outer_axes);
        match outer.iter().position(Option::is_none) {
            Some(axis) => self.read_along(axis, outer, self.inner_offset(inner, 0), range, values),
            None => self.read_element(outer, inner, range, values),
        }
    }

    /// Returns the offset of a number in an element with axes of its own; an open axis has the index `open`.
    fn inner_offset(&self, inner: &[Option<u64>], open: u64) -> usize {
        let index = inner.iter().zip(&self.inner);
        let linear = index.fold(0_u64, |linear, (index, length)| {
            linear
                .saturating_mul(*length)
                .saturating_add(index.unwrap_or(open))
        });
        usize::try_from(linear.saturating_mul(self.number_bytes)).unwrap_or(usize::MAX)
    }

    /// Reads numbers of one element along an axis within it, or a single number.
    fn read_element(
        &self,
        outer: &[Option<u64>],
        inner: &[Option<u64>],
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<()> {
        let selections = outer
            .iter()
            .map(|index| SliceInfoElem::Index(index.unwrap_or(0)));
        let selections = selections.collect();
        let array = self
            .dataset
            .read_slice::<Bytes>(&SliceInfo { selections })?;
        let bytes = array.iter().next().map_or(&[][..], |bytes| &bytes.0);
        for open in range {
            self.push(bytes, self.inner_offset(inner, open), values)?;
        }
        Ok(())
    }

    fn read_along(
        &self,
        axis: usize,
        outer: &[Option<u64>],
        inner_offset: usize,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<()> {
        let element_bytes = self.dataset.raw_element_size()?.max(1) as u64;
        // A file without chunks has the later axes between elements: short rows are read whole.
        let later = self.dataset.shape().get(axis + 1..).unwrap_or(&[]);
        let row = later
            .iter()
            .fold(1_u64, |row, length| row.saturating_mul(*length));
        let row_bytes = row.saturating_mul(element_bytes);
        let reads_rows = self.dataset.chunks().is_none() && row > 1 && row_bytes <= SHORT_ROW_BYTES;
        let (pick, stride) = if reads_rows {
            let index = outer.get(axis + 1..).unwrap_or(&[]).iter().zip(later);
            let pick = index.fold(0, |pick, (index, length)| {
                pick * length + index.unwrap_or(0)
            });
            (pick as usize, row as usize)
        } else {
            (0, 1)
        };
        let rows = (SLAB_BYTES / (element_bytes * stride as u64)).max(1);
        let mut begin = range.start;
        while begin < range.end {
            let end = begin.saturating_add(rows).min(range.end);
            let selections = outer.iter().enumerate().map(|(at, index)| match index {
                None => SliceInfoElem::Slice {
                    start: begin,
                    end,
                    step: 1,
                },
                Some(_) if reads_rows && at > axis => SliceInfoElem::Slice {
                    start: 0,
                    end: u64::MAX,
                    step: 1,
                },
                Some(index) => SliceInfoElem::Index(*index),
            });
            let selection = SliceInfo {
                selections: selections.collect(),
            };
            if self.part == Part::Whole {
                let slab = self.dataset.read_slice::<Real>(&selection)?;
                let slab = slab.as_slice().ok_or_else(unordered)?;
                for value in slab.iter().skip(pick).step_by(stride) {
                    values.push(value.0 * self.factor);
                }
            } else {
                let slab = self.dataset.read_slice::<Bytes>(&selection)?;
                let slab = slab.as_slice().ok_or_else(unordered)?;
                for bytes in slab.iter().skip(pick).step_by(stride) {
                    self.push(&bytes.0, inner_offset, values)?;
                }
            }
            begin = end;
        }
        Ok(())
    }

    /// Appends the number of an element's bytes.
    fn push(&self, bytes: &[u8], inner_offset: usize, values: &mut Values<'_>) -> Result<()> {
        let at = |encoding: Encoding, offset: usize| {
            let bytes = bytes.get(offset.saturating_add(inner_offset)..);
            let value = bytes.and_then(|bytes| number::value(encoding, bytes));
            value
                .map(|value| value * self.factor)
                .ok_or_else(|| Error::InvalidData("a field beyond its element".to_owned()))
        };
        match self.part {
            Part::Whole => {
                let (encoding, _) = number::encoding(self.dataset.dtype()).ok_or_else(unordered)?;
                values.push(at(encoding, 0)?);
            }
            Part::Real { encoding, offset } => values.push(at(encoding, offset)?),
            Part::Sum { encoding, re, im } => values.push(at(encoding, re)? + at(encoding, im)?),
            Part::Complex { encoding, re, im } => {
                values.push_complex(Complex64::new(at(encoding, re)?, at(encoding, im)?));
            }
        }
        Ok(())
    }
}

fn unordered() -> Error {
    Error::InvalidData("a slab that is not in order".to_owned())
}

/// Returns the lengths of a dataset's axes; a dataset without a dataspace has one axis without elements.
pub(crate) fn stored_shape(dataset: &Dataset) -> Vec<u64> {
    match dataset.shape() {
        [] if dataset.num_elements().is_ok_and(|count| count == 0) => vec![0],
        shape => shape.to_vec(),
    }
}
