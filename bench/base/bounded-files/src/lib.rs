//! Opens only regular files and reads them up to a limit, so that a folder from somebody else is refused before it costs
//! time or memory.

mod cause;
mod content_store;
mod in_place;
mod json;
mod lines;
mod pointer;
mod refusal;
mod regular;
mod text;

pub use cause::{cause, cause_line, causes};
pub use content_store::ContentStore;
pub use in_place::open_in_place;
pub use json::parse_json;
pub use lines::{BoundedLines, Line};
pub use refusal::{FileKind, Refusal, refusal};
pub use regular::{TEXT_LIMIT_BYTES, open, read, read_limited, read_text};
pub use text::{as_text, without_mark};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
