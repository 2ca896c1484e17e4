//! Arrays of an HDF5 file: datasets by their paths, fields of their elements by name.

use std::collections::HashSet;

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File};

use crate::array::{ArrayInfo, Element};
use crate::error::{SourceError, SourceFault};
use crate::hdf5::attributes;
use crate::hdf5::column::{AxisOrder, stored_shape};
use crate::hdf5::guard::guarded;
use crate::hdf5::links::links;
use crate::hdf5::listing::{Content, Listing, Text};

/// Deepest group.
const MOST_DEPTH: usize = 64;

/// Remedy for links that are not followed.
const LINK_REMEDY: &str = "name that file in the map (`file = …`), or copy the array into this one";

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
        let members = guarded(&place, || group.members());
        let is_unread = |error: &SourceError| matches!(*error.fault, SourceFault::Unread { .. });
        let (groups, datasets) = match members {
            Err(error) if is_unread(&error) => self.readable_members(group, path)?,
            members => members?,
        };
        for link in guarded(&place, || links(group))? {
            let Some((file, target)) = &link.external else {
                continue;
            };
            let content = format!("a link to `{target}` in the file {file}");
            let info = ArrayInfo::unread(joined(path, &link.name), &content, LINK_REMEDY);
            self.listing.add(info, Content::Opaque)?;
        }
        for dataset in &datasets {
            self.dataset(dataset, &joined(path, dataset.name()))?;
        }
        for member in &groups {
            self.group(member, &joined(path, member.name()), depth + 1)?;
        }
        Ok(())
    }

    /// Returns the members that are read, one by one; the others are listed with the reason.
    fn readable_members(
        &mut self,
        group: &Group,
        path: &str,
    ) -> Result<(Vec<Group>, Vec<Dataset>), SourceError> {
        let (mut groups, mut datasets) = (Vec::new(), Vec::new());
        let place = format!("group `/{path}`");
        for link in guarded(&place, || links(group))? {
            if link.external.is_some() {
                continue;
            }
            let name = joined(path, &link.name);
            let place = format!("array `/{name}`");
            let dataset = guarded(&place, || match group.dataset(&link.name) {
                Err(Error::DatasetNotFound(_)) => Ok(None),
                dataset => dataset.map(Some),
            });
            match dataset {
                Ok(Some(dataset)) => datasets.push(dataset),
                Ok(None) => groups.extend(guarded(&place, || group.group(&link.name)).ok()),
                Err(SourceError { fault, .. }) => {
                    let SourceFault::Unread { content, remedy } = *fault else {
                        return Err(SourceError::at(place, *fault));
                    };
                    let info = ArrayInfo::unread(name, &content, remedy);
                    self.listing.add(info, Content::Opaque)?;
                }
            }
        }
        Ok((groups, datasets))
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
