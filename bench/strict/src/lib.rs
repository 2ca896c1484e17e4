//! Strictly read TOML files: an unknown key names the nearest known one and its line, a value out of range names its
//! range and unit, and every file of the bench says so in the same words.

mod range;
mod suggestion;
mod toml_file;

pub use range::{OutOfRange, within};
pub use suggestion::nearest;
pub use toml_file::{TomlError, line_of, parse};
