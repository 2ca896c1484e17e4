//! Links of a group, read without the objects that they lead to: an object that is not read must not hide the others.

use hdf5_reader::btree_v1::collect_btree_v1_leaves_storage;
use hdf5_reader::btree_v2::{BTreeV2Header, BTreeV2Record, collect_btree_v2_records_storage};
use hdf5_reader::error::Result;
use hdf5_reader::fractal_heap::FractalHeap;
use hdf5_reader::group::Group;
use hdf5_reader::io::Cursor;
use hdf5_reader::local_heap::LocalHeap;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::link::{self, LinkTarget};
use hdf5_reader::messages::link_info::LinkInfoMessage;
use hdf5_reader::messages::symbol_table_msg::SymbolTableMessage;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::symbol_table::SymbolTableNode;

/// Link of a group.
pub(crate) struct Link {
    pub(crate) name: String,
    /// File and path, where it leads to another file.
    pub(crate) external: Option<(String, String)>,
}

impl Link {
    fn new(name: String, target: &LinkTarget) -> Self {
        let external = match target {
            LinkTarget::External { filename, path } => Some((filename.clone(), path.clone())),
            _ => None,
        };
        Self { name, external }
    }
}

/// Returns the links of a group.
pub(crate) fn links(group: &Group) -> Result<Vec<Link>> {
    let header = ObjectHeader::parse_at_storage(
        group.storage(),
        group.address(),
        group.offset_size(),
        group.length_size(),
    )?;
    let mut links = Vec::new();
    for message in &header.messages {
        match message {
            HdfMessage::Link(link) => links.push(Link::new(link.name.clone(), &link.target)),
            HdfMessage::LinkInfo(info) => dense(group, info, &mut links)?,
            HdfMessage::SymbolTable(table) => symbols(group, table, &mut links)?,
            _ => {}
        }
    }
    Ok(links)
}

/// Adds the links of a group with many of them.
fn dense(group: &Group, info: &LinkInfoMessage, links: &mut Vec<Link>) -> Result<()> {
    let (storage, sizes) = (group.storage(), [group.offset_size(), group.length_size()]);
    if Cursor::is_undefined_offset(info.fractal_heap_address, sizes[0]) {
        return Ok(());
    }
    let address = info.fractal_heap_address;
    let heap = FractalHeap::parse_at_storage(storage, address, sizes[0], sizes[1])?;
    let address = info.btree_name_index_address;
    let tree = BTreeV2Header::parse_at_storage(storage, address, sizes[0], sizes[1])?;
    let (no_axes, no_chunks) = (None, &[]);
    let records = collect_btree_v2_records_storage(
        storage, &tree, sizes[0], sizes[1], no_axes, no_chunks, None,
    )?;
    for record in &records {
        if let BTreeV2Record::LinkNameHash { heap_id, .. } = record {
            let bytes = heap.get_object_storage(heap_id, storage, sizes[0], sizes[1])?;
            let link = link::parse(&mut Cursor::new(&bytes), sizes[0], sizes[1], bytes.len())?;
            links.push(Link::new(link.name.clone(), &link.target));
        }
    }
    Ok(())
}

/// Adds the links of a group of the older kind, which lead to other objects of the file.
fn symbols(group: &Group, table: &SymbolTableMessage, links: &mut Vec<Link>) -> Result<()> {
    let (storage, sizes) = (group.storage(), [group.offset_size(), group.length_size()]);
    let heap = LocalHeap::parse_at_storage(storage, table.heap_address, sizes[0], sizes[1])?;
    let (address, no_chunks) = (table.btree_address, &[]);
    let leaves = collect_btree_v1_leaves_storage(
        storage, address, sizes[0], sizes[1], None, no_chunks, None,
    )?;
    for (_, address) in leaves {
        let prefix = storage.read_range(address, 8)?;
        let [.., low, high] = *prefix.as_ref() else {
            continue;
        };
        let entry_bytes = 2 * usize::from(sizes[0]) + 24;
        let bytes = 8 + usize::from(u16::from_le_bytes([low, high])) * entry_bytes;
        let node = storage.read_range(address, bytes)?;
        let node = SymbolTableNode::parse(&mut Cursor::new(node.as_ref()), sizes[0], sizes[1])?;
        for entry in &node.entries {
            let name = heap.get_string_storage(entry.link_name_offset, storage)?;
            links.push(Link {
                name,
                external: None,
            });
        }
    }
    Ok(())
}
