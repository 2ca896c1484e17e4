//! Text in UTF-8.

use crate::refusal::Refusal;

/// Bytes with which UTF-16 texts begin.
const UTF16_MARKS: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];

/// Returns bytes as text.
///
/// # Errors
/// [`Refusal::Utf16`] and [`Refusal::NotUtf8`] for other encodings.
pub fn as_text(bytes: &[u8]) -> Result<&str, Refusal> {
    if is_utf16(bytes) {
        return Err(Refusal::Utf16);
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let (valid, rest) = bytes.split_at(error.valid_up_to());
        let returns = valid.split(|byte| *byte == b'\r').count();
        let feeds = valid.split(|byte| *byte == b'\n').count();
        Refusal::NotUtf8 {
            line: returns.max(feeds),
            byte: rest.first().copied().unwrap_or_default(),
        }
    })
}

/// Returns bytes without the byte-order mark with which some programs begin UTF-8 text.
///
/// ```
/// assert_eq!(bounded_files::without_mark(b"\xef\xbb\xbf{}"), b"{}");
/// ```
#[must_use]
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Returns whether bytes are UTF-16: by their mark, or by a zero in every second byte of their beginning.
fn is_utf16(bytes: &[u8]) -> bool {
    const PROBED: usize = 64;
    let beginning = &bytes[..bytes.len().min(PROBED)];
    let (pairs, _) = beginning.as_chunks::<2>();
    let is_half_zero = |half: usize| {
        pairs
            .iter()
            .all(|pair| pair[half] == 0 && pair[1 - half] != 0)
    };
    let has_mark = pairs.first().is_some_and(|pair| UTF16_MARKS.contains(pair));
    has_mark || pairs.len() > 1 && (is_half_zero(0) || is_half_zero(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, encode: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(encode).collect()
    }

    #[test]
    fn other_encodings_are_named() {
        for encode in [u16::to_le_bytes, u16::to_be_bytes] {
            for text in ["\u{feff}drive_v = 55\r\n", "drive_v = 55\n"] {
                assert_eq!(as_text(&utf16(text, encode)), Err(Refusal::Utf16));
            }
        }
        let refusal = as_text(b"a = 1\r\nname = \"M\xfcller\"\n").unwrap_err();
        assert_eq!(
            refusal,
            Refusal::NotUtf8 {
                line: 2,
                byte: 0xfc
            }
        );
        assert_eq!(
            refusal.to_string(),
            "line 2 has the byte 0xFC, which is not UTF-8 (in Windows-1252 and Latin-1 it is `ü`); save it as UTF-8"
        );
        let refusal = as_text(b"a\rb\rc\x80").unwrap_err();
        assert_eq!(
            refusal,
            Refusal::NotUtf8 {
                line: 3,
                byte: 0x80
            }
        );
        for text in ["", "a", "é", "a\0b", "plain"] {
            assert_eq!(as_text(text.as_bytes()), Ok(text));
        }
    }
}
