//! Arrays and attributes that a walk through a file finds.

use std::collections::BTreeMap;

use hdf5_reader::error::{Error, Result};
use hdf5_reader::{Dataset, Datatype};

use crate::array::{ArrayInfo, Attribute};
use crate::error::{SourceError, SourceFault};
use crate::hdf5::column::{AxisOrder, Column};
use crate::hdf5::number::Real;

/// Most arrays of a file.
const MOST_ARRAYS: usize = 50_000;
/// Most texts of an array that are read, and characters of one.
const MOST_TEXTS: u64 = 1000;
const MOST_CHARACTERS: u64 = 1 << 20;

/// Content of an array.
pub(crate) enum Content {
    Numbers(Column),
    /// Equal steps that the file states instead of numbers.
    Ramp {
        first: f64,
        step: f64,
    },
    Text(Text),
    Empty,
    Opaque,
}

/// A text in a file.
pub(crate) enum Text {
    /// HDF5's own texts.
    Strings(Dataset),
    /// Characters of MATLAB: UTF-16, with rows along the last stored axis.
    Characters(Dataset),
    /// A text that was read with the structure.
    Known(String),
}

impl Text {
    /// Reads the text; `None` if it is long.
    pub(crate) fn read(&self) -> Result<Option<String>> {
        match self {
            Self::Known(text) => Ok(Some(text.clone())),
            Self::Strings(dataset) if dataset.num_elements()? > MOST_TEXTS => Ok(None),
            Self::Strings(dataset) => Ok(Some(dataset.read_strings()?.join("\n"))),
            Self::Characters(dataset) if dataset.num_elements()? > MOST_CHARACTERS => Ok(None),
            Self::Characters(dataset) => characters(dataset).map(Some),
        }
    }
}

/// Reads a MATLAB character array, its rows as lines.
fn characters(dataset: &Dataset) -> Result<String> {
    let is_character = matches!(dataset.dtype(), Datatype::FixedPoint { size: 1..=4, .. });
    if !is_character {
        return Err(Error::InvalidData("characters of another type".to_owned()));
    }
    let array = dataset.read_array::<Real>()?;
    let codes = array.as_slice().unwrap_or(&[]);
    let rows = match dataset.shape() {
        [_, rows] => (*rows as usize).max(1),
        _ => 1,
    };
    let lines = (0..rows).map(|row| {
        let codes: Vec<u16> = codes
            .iter()
            .skip(row)
            .step_by(rows)
            .map(|code| code.0 as u16)
            .collect();
        String::from_utf16_lossy(&codes)
    });
    Ok(lines.collect::<Vec<_>>().join("\n"))
}

/// Arrays and attributes of a file.
#[derive(Default)]
pub(crate) struct Listing {
    pub(crate) arrays: Vec<(ArrayInfo, Content)>,
    pub(crate) attributes: BTreeMap<String, Attribute>,
    pub(crate) notes: Vec<String>,
}

impl Listing {
    /// Adds an array.
    pub(crate) fn add(
        &mut self,
        info: ArrayInfo,
        content: Content,
    ) -> std::result::Result<(), SourceError> {
        if self.arrays.len() >= MOST_ARRAYS {
            let fault = SourceFault::Unread {
                content: format!("a file with more than {MOST_ARRAYS} arrays"),
                remedy: "save the arrays of the recording in a file of their own",
            };
            return Err(fault.into());
        }
        self.arrays.push((info, content));
        Ok(())
    }

    /// Adds a column under its own shape.
    pub(crate) fn add_column(
        &mut self,
        info: ArrayInfo,
        column: Column,
    ) -> std::result::Result<(), SourceError> {
        let shape = column.shape();
        let content = match shape.contains(&0) {
            true => Content::Empty,
            false => Content::Numbers(column),
        };
        self.add(ArrayInfo { shape, ..info }, content)
    }

    /// Adds the numeric fields of a dataset's elements, and names the others.
    pub(crate) fn add_dataset(
        &mut self,
        name: &str,
        unit: Option<&str>,
        dataset: &Dataset,
        order: AxisOrder,
    ) -> std::result::Result<(), SourceError> {
        let joined = |field: &str| match field {
            "" => name.to_owned(),
            field => format!("{name}.{field}"),
        };
        let (fields, others) = crate::hdf5::column::fields(dataset.dtype());
        for field in &fields {
            let mut info = ArrayInfo::new(joined(&field.name), field.element, Vec::new());
            info.unit = unit.map(str::to_owned);
            self.add_column(info, Column::new(dataset, field, order))?;
        }
        for (field, class) in others {
            self.add(ArrayInfo::opaque(joined(&field), class), Content::Opaque)?;
        }
        Ok(())
    }

    /// Returns the size of the largest chunk, bytes.
    pub(crate) fn largest_chunk_bytes(&self) -> usize {
        let columns = self.arrays.iter().filter_map(|(_, content)| match content {
            Content::Numbers(column) => Some(column.chunk_bytes()),
            _ => None,
        });
        columns.max().unwrap_or(0)
    }
}
