//! Attributes of groups and datasets.

use std::collections::BTreeMap;

use hdf5_reader::error::Result;
use hdf5_reader::{Attribute as Stored, Datatype};

use crate::array::Attribute;
use crate::hdf5::number::{self, encoding};

/// Most attributes of a file that are kept.
const MOST_ATTRIBUTES: usize = 50_000;
/// Attributes of HDF5's own conventions and of MATLAB's.
const CONVENTIONS: [&str; 7] = [
    "CLASS",
    "DIMENSION_LIST",
    "DIMENSION_LABELS",
    "H5PATH",
    "NAME",
    "REFERENCE_LIST",
    "_Netcdf4Dimid",
];
/// Names of an attribute that states a unit.
const UNITS: [&str; 4] = ["units", "unit", "unit_string", "uom"];

/// Adds the attributes of `object`, a path that begins with `/`, that are one number or one text.
pub(crate) fn add(found: &mut BTreeMap<String, Attribute>, object: &str, stored: &[Stored]) {
    for attribute in stored {
        let name = attribute.name.as_str();
        let is_convention = CONVENTIONS.contains(&name) || name.starts_with("MATLAB_");
        if is_convention || found.len() >= MOST_ATTRIBUTES {
            continue;
        }
        if let Some(value) = value(attribute) {
            found.insert(format!("{object}@{name}"), value);
        }
    }
}

/// Returns the unit among an array's attributes.
pub(crate) fn unit(stored: &[Stored]) -> Option<String> {
    let unit = stored
        .iter()
        .find(|attribute| UNITS.contains(&attribute.name.to_lowercase().as_str()))?;
    text(unit).filter(|unit| !unit.is_empty())
}

/// Returns an attribute that is one number or one text.
fn value(attribute: &Stored) -> Option<Attribute> {
    number(attribute)
        .map(Attribute::Number)
        .or_else(|| text(attribute).map(Attribute::Text))
}

/// Returns an attribute that is one number.
pub(crate) fn number(attribute: &Stored) -> Option<f64> {
    let count = attribute.num_elements().ok()?;
    let (encoding, _) = encoding(&attribute.datatype)?;
    let is_single = count == 1 && !attribute.raw_data.is_empty();
    is_single.then(|| number::value(encoding, &attribute.raw_data))?
}

/// Returns an attribute that is one text.
pub(crate) fn text(attribute: &Stored) -> Option<String> {
    if !matches!(
        attribute.datatype,
        Datatype::String { .. } | Datatype::VarLen { .. }
    ) {
        return None;
    }
    let strings: Result<Vec<String>> = attribute.read_strings();
    let single = match strings {
        Ok(strings) => match <[String; 1]>::try_from(strings) {
            Ok([text]) => Some(text),
            Err(_) => None,
        },
        Err(_) => attribute.read_string().ok(),
    };
    single.map(|text| text.trim_end_matches('\0').trim().to_owned())
}
