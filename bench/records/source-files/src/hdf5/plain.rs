//! Arrays of an HDF5 file: datasets by their paths, fields of their elements by name.

use std::collections::HashSet;

use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File};

use crate::array::{ArrayInfo, Element};
use crate::error::SourceError;
use crate::hdf5::attributes;
use crate::hdf5::column::{AxisOrder, stored_shape};
use crate::hdf5::guard::guarded;
use crate::hdf5::listing::{Content, Listing, Text};

/// Deepest group.
const MOST_DEPTH: usize = 64;

/// Lists the arrays of a file.
pub(crate) fn list(file: &Hdf5File) -> Result<Listing, SourceError> {
    let mut walk = Walk::default();
    let root = guarded("group `/`", || file.root_group())?;
    walk.group(&root, "", 0)?;
    Ok(walk.listing)
}

#[derive(Default)]
struct Walk {
    listing: Listing,
    /// Addresses of the groups that were listed: a group may include itself.
    visited: HashSet<u64>,
}

impl Walk {
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), SourceError> {
        if depth > MOST_DEPTH || !self.visited.insert(group.address()) {
            return Ok(());
        }
        let place = format!("group `/{path}`");
        let stored = guarded(&place, || group.attributes())?;
        attributes::add(&mut self.listing.attributes, &format!("/{path}"), &stored);
        let (groups, datasets) = guarded(&place, || group.members())?;
        for dataset in &datasets {
            self.dataset(dataset, &joined(path, dataset.name()))?;
        }
        for member in &groups {
            self.group(member, &joined(path, member.name()), depth + 1)?;
        }
        Ok(())
    }

    fn dataset(&mut self, dataset: &Dataset, path: &str) -> Result<(), SourceError> {
        let place = format!("array `/{path}`");
        let stored = guarded(&place, || Ok(dataset.attributes()))?;
        attributes::add(&mut self.listing.attributes, &format!("/{path}"), &stored);
        let is_text = match dataset.dtype() {
            Datatype::String { .. } => true,
            Datatype::VarLen { base, kind, .. } => {
                *kind == hdf5_reader::VarLenKind::String && base.is_vlen_string_base()
            }
            _ => false,
        };
        if is_text {
            let info = ArrayInfo::new(path, Element::Text, stored_shape(dataset));
            return self
                .listing
                .add(info, Content::Text(Text::Strings(dataset.clone())));
        }
        let unit = attributes::unit(&stored);
        self.listing
            .add_dataset(path, unit.as_deref(), dataset, AxisOrder::Stored)
    }
}

fn joined(path: &str, name: &str) -> String {
    match path {
        "" => name.to_owned(),
        path => format!("{path}/{name}"),
    }
}
