//! Strict reading of TOML files, with all their errors.

use serde::de::DeserializeOwned;

use crate::draft::read;
use crate::slip::{list_slip, path_slip};
use crate::toml_error::TomlError;
use crate::toml_file::{attempt, slip_error};

/// Reads `text` into `T`; `file` only names the file in errors.
///
/// `T` and the types in it must carry `#[serde(deny_unknown_fields)]` and no `flatten` or `untagged`, which hide keys
/// from serde.
///
/// # Errors
/// [`TomlError`] for an unknown or missing key, a value of the wrong type, and for text that is not TOML; all errors of the
/// file together if there are several.
///
/// ```
/// use strict_toml::TomlError;
///
/// #[derive(Debug, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Audio {
///     rate_hz: u32,
/// }
///
/// let audio: Audio = strict_toml::parse("rate_hz = 192000", "bench.toml")?;
/// assert_eq!(audio.rate_hz, 192_000);
///
/// let error = strict_toml::parse::<Audio>("rate_hz = \"192000\"", "bench.toml").unwrap_err();
/// assert!(matches!(error, TomlError::QuotedNumber { line: 1, .. }));
/// # Ok::<(), TomlError>(())
/// ```
pub fn parse<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, TomlError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if let Some(slip) = path_slip(text).or_else(|| list_slip(text)) {
        return Err(slip_error(slip, file.to_owned(), None));
    }
    attempt(text, file)
        .map_err(|first| TomlError::of_several(read::<T>(text, file).errors).unwrap_or(first.error))
}
