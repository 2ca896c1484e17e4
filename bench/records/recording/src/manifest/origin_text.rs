//! Checks of the texts in `[origin]`.

use super::manifest_error::{ManifestError, text_error};

/// Requires a text that is not empty.
pub(super) fn require_text(key: &str, text: &str) -> Result<(), ManifestError> {
    match text.trim().is_empty() {
        true => Err(text_error(key, text, "a text that is not empty")),
        false => Ok(()),
    }
}

/// Requires a SHA-256 in hexadecimal digits.
pub(super) fn require_sum(key: &str, text: &str) -> Result<(), ManifestError> {
    let is_digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    match text.len() == 64 && text.bytes().all(is_digit) {
        true => Ok(()),
        false => Err(text_error(
            key,
            text,
            "the 64 digits 0 to 9 and a to f of a SHA-256, as `sha256sum` prints them",
        )),
    }
}
