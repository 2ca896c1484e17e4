//! Strictly read TOML files: an unknown key names the nearest known one and its line, a value out of range names its
//! range and unit, and every file of the bench reports it in the same words.
//!
//! - [`parse`] reads a file into a type and explains what stands in its way as a [`TomlError`].
//! - [`within`] and [`count_within`] are the range rule; [`OutOfRange`] names key, value, range and unit.
//! - [`InFile`] and [`line_of`] place an error about a value that parsed well but is not allowed.
//! - [`nearest`] suggests the known word that was probably meant.
//!
//! ```
//! #[derive(Debug, serde::Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Plate {
//!     length_m: f64,
//! }
//!
//! let text = "length_m = 105.0\n";
//! let plate: Plate = strict::parse(text, "plate.toml")?;
//! let refused = strict::within("length_m", plate.length_m, 0.01, 0.5, "m").unwrap_err();
//! let key = refused.key.clone();
//! assert_eq!(
//!     strict::InFile::at_key(refused, &key, text, "plate.toml").to_string(),
//!     "plate.toml, line 1: length_m = 105 m is outside the allowed range of 0.01 to 0.5 m"
//! );
//! # Ok::<(), strict::TomlError>(())
//! ```

mod place;
mod range;
mod suggestion;
mod toml_error;
mod toml_file;
mod wrong_value;

pub use place::{InFile, line_of};
pub use range::{OutOfRange, count_within, within};
pub use suggestion::nearest;
pub use toml_error::TomlError;
pub use toml_file::parse;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
