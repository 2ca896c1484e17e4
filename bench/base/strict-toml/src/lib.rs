//! Strict reading of TOML files: an unknown key is reported with its line and the nearest known key, a value out of range
//! with its range and unit, in the same words for every file of the bench.
//!
//! - [`parse`] reads a file into a type and explains failures as a [`TomlError`], slips of typing among them: decimal
//!   commas, characters of a word processor, paths of Windows; [`read`] goes on after an error.
//! - [`require_range`] and [`count_within`] are the range rule; [`OutOfRange`] names key, value, range and unit.
//! - [`InFile`] and [`line_of`] locate an error about a value that parses but is not allowed.
//! - [`nearest`] suggests the most similar known word.
//!
//! ```
//! #[derive(Debug, serde::Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Plate {
//!     length_m: f64,
//! }
//!
//! let text = "length_m = 105.0\n";
//! let plate: Plate = strict_toml::parse(text, "plate.toml")?;
//! let refused = strict_toml::require_range("length_m", plate.length_m, 0.01, 0.5, "m").unwrap_err();
//! let key = refused.key.clone();
//! assert_eq!(
//!     strict_toml::InFile::at_key(refused, &key, text, "plate.toml").to_string(),
//!     "plate.toml, line 1: length_m = 105 m is outside the allowed range of 0.01 to 0.5 m"
//! );
//! # Ok::<(), strict_toml::TomlError>(())
//! ```

mod character;
mod document;
mod draft;
mod parts;
mod place;
mod range;
mod slip;
mod strict_reading;
mod suggestion;
mod toml_error;
mod toml_file;
mod wrong_value;

pub use draft::{Draft, read};
pub use place::{InFile, line_of};
pub use range::{OutOfRange, count_within, require_range};
pub use strict_reading::parse;
pub use suggestion::nearest;
pub use toml_error::TomlError;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
