//! Parts of an analysis: a file for each recording, written once, from which results follow without the recordings.
//!
//! [`write_parts`] analyses each recording that has no part in a folder yet, whether or not other processes do the same, and
//! [`read_parts`] puts the parts together to the analysis that `analyze` makes of the recordings. docs/PARTS.md describes the files.

mod call;
mod entry;
mod folder_name;
mod identities;
mod inputs;
mod key;
mod layout;
mod outdated;
mod part_file;
mod part_outcome;
mod part_writing;
mod parts_error;
mod reduction;
mod stored_file;

pub use key::Key;
pub use part_outcome::{PartOutcome, PartState};
pub use part_writing::{PartsRequest, write_parts};
pub use parts_error::PartsError;
pub use reduction::read_parts;

/// Version of the program, on which findings depend.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Version of the files of parts.
const FORMAT: u32 = 1;
