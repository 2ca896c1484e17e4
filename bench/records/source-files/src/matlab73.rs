//! Variables of MATLAB v7.3, which HDF5 holds transposed: arrays, texts, structures, cell arrays, objects.
//!
//! A structure is a group of its fields, a cell array a dataset of references. Objects of classes have their properties in a table
//! of their own ([`mcos`]); those of MATLAB's tables, maps and times are looked into ([`objects`]).

mod mcos;
mod objects;

use std::collections::HashMap;

use hdf5_reader::error::Result as Hdf5Result;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, Hdf5File};

use crate::array::{ArrayInfo, Element};
use crate::error::{SourceError, SourceFault};
use crate::hdf5::attributes;
use crate::hdf5::column::{AxisOrder, Column, fields};
use crate::hdf5::guard::guarded;
use crate::hdf5::listing::{Content, Listing, Text};

/// Group of the values that cell arrays refer to.
const REFERENCES: &str = "#refs#";
/// Group of the table of objects.
const SUBSYSTEM: &str = "#subsystem#";
/// Field of an enumeration within another value.
const ENUMERATION: &str = "EnumerationInstanceTag";
/// Deepest structure or cell array.
const MOST_DEPTH: usize = 24;
/// Most values that are looked into.
const MOST_VALUES: usize = 200_000;
/// Most elements of a cell array or of an array of structures.
const MOST_CELLS: u64 = 50_000;

/// Returns whether a variable of the file has MATLAB's mark.
pub(crate) fn is_matlab(file: &Hdf5File) -> Result<bool, SourceError> {
    let has_mark = guarded("group `/`", || {
        let (groups, datasets) = file.root_group()?.members()?;
        let mut values = datasets.into_iter().map(Value::dataset);
        Ok(values.any(|value| value.class().is_some())
            || groups
                .into_iter()
                .map(Value::Group)
                .any(|value| value.class().is_some()))
    });
    match has_mark {
        // MATLAB writes nothing that is not read.
        Err(error) if matches!(*error.fault, SourceFault::Unread { .. }) => Ok(false),
        has_mark => has_mark,
    }
}

/// Lists the variables of a file.
pub(crate) fn list(file: &Hdf5File) -> Result<Listing, SourceError> {
    let (groups, datasets) = guarded("group `/`", || file.root_group()?.members())?;
    let mut variables = Variables::new(&groups)?;
    for dataset in datasets {
        variables.variable(Value::dataset(dataset))?;
    }
    for group in groups {
        if ![REFERENCES, SUBSYSTEM].contains(&group.name()) {
            variables.variable(Value::Group(group))?;
        }
    }
    Ok(variables.listing)
}

/// Value of a variable, a field or a cell.
#[derive(Clone)]
enum Value {
    Dataset(Box<Dataset>),
    Group(Group),
}

impl Value {
    fn dataset(dataset: Dataset) -> Self {
        Self::Dataset(Box::new(dataset))
    }

    fn name(&self) -> &str {
        match self {
            Self::Dataset(dataset) => dataset.name(),
            Self::Group(group) => group.name(),
        }
    }

    fn attributes(&self) -> Vec<Attribute> {
        match self {
            Self::Dataset(dataset) => dataset.attributes(),
            Self::Group(group) => group.attributes().unwrap_or_default(),
        }
    }

    fn class(&self) -> Option<String> {
        attribute(&self.attributes(), "MATLAB_class").and_then(attributes::text)
    }

    /// Returns a field of a structure.
    fn field(&self, name: &str) -> Option<Self> {
        let Self::Group(group) = self else {
            return None;
        };
        let dataset = group.dataset(name).map(Self::dataset);
        dataset.or_else(|_| group.group(name).map(Self::Group)).ok()
    }

    /// Returns all numbers in the stored order, if they are at most `most`.
    fn numbers(&self, most: u64) -> Hdf5Result<Option<Vec<f64>>> {
        match self.column() {
            Some(column) => column.read_all(most),
            None => Ok(None),
        }
    }

    /// Returns the one number that it is.
    fn number(&self) -> Option<f64> {
        match self.numbers(1).ok()??.as_slice() {
            [number] => Some(*number),
            _ => None,
        }
    }

    /// Returns the numbers as a column.
    fn column(&self) -> Option<Column> {
        let Self::Dataset(dataset) = self else {
            return None;
        };
        let (fields, _) = fields(dataset.dtype());
        let field = fields.first()?;
        Some(Column::new(dataset, field, AxisOrder::Reversed))
    }
}

/// Returns whether a value has its lengths instead of values.
fn is_empty(attributes: &[Attribute]) -> bool {
    let mark = attribute(attributes, "MATLAB_empty").and_then(attributes::number);
    mark.is_some_and(|mark| mark != 0.0)
}

fn attribute<'a>(attributes: &'a [Attribute], name: &str) -> Option<&'a Attribute> {
    attributes.iter().find(|attribute| attribute.name == name)
}

/// Returns whether a dataset refers to more values than are looked into.
fn is_long(dataset: &Dataset) -> bool {
    dataset.num_elements().is_ok_and(|count| count > MOST_CELLS)
}

/// Element of an array of MATLAB's class.
fn element(class: &str) -> Element {
    let integer = |bits, is_signed| Element::Integer { bits, is_signed };
    match class {
        "logical" => Element::Logical,
        "single" => Element::Float { bits: 32 },
        "int8" => integer(8, true),
        "int16" => integer(16, true),
        "int32" => integer(32, true),
        "int64" => integer(64, true),
        "uint8" => integer(8, false),
        "uint16" => integer(16, false),
        "uint32" => integer(32, false),
        "uint64" => integer(64, false),
        "char" => Element::Text,
        _ => Element::Float { bits: 64 },
    }
}

/// Variables found so far.
struct Variables {
    listing: Listing,
    /// Values that cells refer to, by their addresses.
    referred: HashMap<u64, Value>,
    objects: Vec<mcos::Object>,
    /// Objects that are being looked into: one may refer to itself.
    open: Vec<usize>,
    /// Cells of the table of objects.
    cells: Vec<Value>,
    looked_into: usize,
}

impl Variables {
    fn new(groups: &[Group]) -> Result<Self, SourceError> {
        let find = |name: &str| groups.iter().find(|group| group.name() == name);
        let mut referred = HashMap::new();
        if let Some(group) = find(REFERENCES) {
            let (groups, datasets) = guarded("group `/#refs#`", || group.members())?;
            let groups = groups
                .into_iter()
                .map(|group| (group.address(), Value::Group(group)));
            let datasets = datasets.into_iter();
            let datasets = datasets.map(|dataset| (dataset.address(), Value::dataset(dataset)));
            referred.extend(groups.chain(datasets));
        }
        let mut variables = Self {
            listing: Listing::default(),
            referred,
            objects: Vec::new(),
            open: Vec::new(),
            cells: Vec::new(),
            looked_into: 0,
        };
        if let Some(table) = find(SUBSYSTEM).and_then(|group| group.dataset("MCOS").ok()) {
            // A table that cannot be read leaves objects named by their classes.
            variables.cells = variables.cells(&table).unwrap_or_default();
            let numbers = variables.cells.first().map(|cell| cell.numbers(16 << 20));
            if let Some(Ok(Some(numbers))) = numbers {
                let bytes: Vec<u8> = numbers.iter().map(|number| *number as u8).collect();
                variables.objects = mcos::objects(&bytes).unwrap_or_default();
            }
        }
        Ok(variables)
    }

    fn variable(&mut self, value: Value) -> Result<(), SourceError> {
        let name = value.name().to_owned();
        let stored = guarded(&format!("array `{name}`"), || Ok(value.attributes()))?;
        attributes::add(&mut self.listing.attributes, &format!("/{name}"), &stored);
        self.value(&name, &value, 0)
    }

    /// Adds a value, and those within it, under a name.
    fn value(&mut self, name: &str, value: &Value, depth: usize) -> Result<(), SourceError> {
        self.looked_into += 1;
        if self.looked_into > MOST_VALUES {
            let fault = SourceFault::Unread {
                content: format!(
                    "a file with more than {MOST_VALUES} values in structures and cells"
                ),
                remedy: "save the recording's arrays as variables of their own",
            };
            return Err(SourceError::at(format!("array `{name}`"), fault));
        }
        if depth > MOST_DEPTH {
            return self.opaque(name, "values nested too deeply");
        }
        let place = format!("array `{name}`");
        let stored = guarded(&place, || Ok(value.attributes()))?;
        let class = attribute(&stored, "MATLAB_class").and_then(attributes::text);
        let class = class.unwrap_or_default();
        let mark = |name: &str| attribute(&stored, name).and_then(attributes::number);
        if is_empty(&stored) {
            return self.empty(name, value, &class);
        }
        match value {
            _ if mark("MATLAB_sparse").is_some() => self.opaque(name, "sparse matrix"),
            Value::Dataset(dataset) if mark("MATLAB_object_decode") == Some(3.0) => {
                self.objects(name, dataset, &class, depth)
            }
            Value::Dataset(dataset) if class == "char" => {
                let shape: Vec<u64> = dataset.shape().iter().rev().copied().collect();
                let info = ArrayInfo::new(name, Element::Text, shape);
                self.listing.add(
                    info,
                    Content::Text(Text::Characters(Dataset::clone(dataset))),
                )
            }
            Value::Dataset(dataset) if matches!(dataset.dtype(), Datatype::Reference { .. }) => {
                self.cell_array(name, dataset, depth)
            }
            // Within other values, an object has the class of its numbers.
            Value::Dataset(dataset) if class == "uint32" && depth > 0 && self.refers(value) => {
                self.objects(name, dataset, "object", depth)
            }
            Value::Dataset(dataset) => {
                let before = self.listing.arrays.len();
                let unit = attributes::unit(&stored);
                self.listing
                    .add_dataset(name, unit.as_deref(), dataset, AxisOrder::Reversed)?;
                if class == "logical" {
                    for (info, _) in self.listing.arrays.iter_mut().skip(before) {
                        info.element = Element::Logical;
                    }
                }
                Ok(())
            }
            Value::Group(_)
                if class == "function_handle" || mark("MATLAB_object_decode") == Some(3.0) =>
            {
                self.opaque(name, &class)
            }
            Value::Group(group) if group.dataset(ENUMERATION).is_ok() => {
                self.opaque(name, "enumeration")
            }
            Value::Group(group) => {
                let separator = if class.is_empty() { "/" } else { "." };
                self.structure(name, separator, group, depth)
            }
        }
    }

    fn opaque(&mut self, name: &str, class: &str) -> Result<(), SourceError> {
        self.listing
            .add(ArrayInfo::opaque(name, class), Content::Opaque)
    }

    /// Adds an empty value: the dataset has its lengths instead of values.
    fn empty(&mut self, name: &str, value: &Value, class: &str) -> Result<(), SourceError> {
        if matches!(class, "cell" | "struct") {
            return self.opaque(name, &format!("{class}, empty"));
        }
        let lengths = guarded(&format!("array `{name}`"), || value.numbers(64))?;
        let lengths = lengths.unwrap_or_default();
        let mut shape: Vec<u64> = lengths.iter().map(|length| *length as u64).collect();
        if !shape.contains(&0) {
            shape = vec![0, 0];
        }
        let content = match class {
            "char" => Content::Text(Text::Known(String::new())),
            _ => Content::Empty,
        };
        self.listing
            .add(ArrayInfo::new(name, element(class), shape), content)
    }

    /// Adds the fields of a structure, or of each structure of an array.
    fn structure(
        &mut self,
        name: &str,
        separator: &str,
        group: &Group,
        depth: usize,
    ) -> Result<(), SourceError> {
        let place = format!("structure `{name}`");
        let (groups, datasets) = guarded(&place, || group.members())?;
        let is_reference = |dataset: &Dataset| {
            let is_reference = matches!(dataset.dtype(), Datatype::Reference { .. });
            is_reference && attribute(&dataset.attributes(), "MATLAB_class").is_none()
        };
        let is_array =
            groups.is_empty() && !datasets.is_empty() && datasets.iter().all(is_reference);
        if is_array && datasets.iter().any(is_long) {
            return self.opaque(name, "array of very many structures");
        }
        for dataset in datasets {
            if is_array {
                for (index, value) in self.indexed(&dataset, &place)? {
                    self.value(
                        &format!("{name}{index}.{}", dataset.name()),
                        &value,
                        depth + 1,
                    )?;
                }
            } else {
                let name = format!("{name}{separator}{}", dataset.name());
                self.value(&name, &Value::dataset(dataset), depth + 1)?;
            }
        }
        for group in groups {
            let name = format!("{name}{separator}{}", group.name());
            self.value(&name, &Value::Group(group), depth + 1)?;
        }
        Ok(())
    }

    fn cell_array(
        &mut self,
        name: &str,
        dataset: &Dataset,
        depth: usize,
    ) -> Result<(), SourceError> {
        if is_long(dataset) {
            return self.opaque(name, "cell array of very many cells");
        }
        for (index, value) in self.indexed(dataset, &format!("cell array `{name}`"))? {
            self.value(&format!("{name}{index}"), &value, depth + 1)?;
        }
        Ok(())
    }

    /// Returns the values that a dataset refers to, with their indices: `[3]` in a row or a column, else `[0,3]`.
    fn indexed(&self, dataset: &Dataset, place: &str) -> Result<Vec<(String, Value)>, SourceError> {
        let values = guarded(place, || self.cells(dataset))?;
        let shape: Vec<u64> = dataset.shape().iter().rev().copied().collect();
        let is_vector = shape.iter().filter(|length| **length != 1).count() <= 1;
        let index = |linear: usize| {
            if is_vector {
                return format!("[{linear}]");
            }
            let mut rest = linear as u64;
            let indices = shape.iter().map(|length| {
                let index = rest % (*length).max(1);
                rest /= (*length).max(1);
                index.to_string()
            });
            format!("[{}]", indices.collect::<Vec<_>>().join(","))
        };
        let values = values.into_iter().enumerate();
        Ok(values
            .map(|(linear, value)| (index(linear), value))
            .collect())
    }

    /// Returns the values that a dataset refers to, in the stored order.
    fn cells(&self, dataset: &Dataset) -> Hdf5Result<Vec<Value>> {
        use hdf5_reader::error::Error;
        if !matches!(dataset.dtype(), Datatype::Reference { .. }) {
            return Err(Error::InvalidData(
                "cells that are no references".to_owned(),
            ));
        }
        if is_long(dataset) {
            return Err(Error::ResourceLimit("cells".to_owned()));
        }
        let width = dataset.raw_element_size()?.max(1);
        let raw = dataset.read_raw_bytes()?;
        let values = raw.chunks_exact(width).map(|bytes| {
            let mut address = [0; 8];
            for (to, from) in address.iter_mut().zip(bytes) {
                *to = *from;
            }
            let value = self.referred.get(&u64::from_le_bytes(address)).cloned();
            value.ok_or_else(|| Error::InvalidData("a reference to no value".to_owned()))
        });
        values.collect()
    }
}
