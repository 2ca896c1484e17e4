//! Text encodings of instruments.

/// Returns the text of a file: UTF-8, UTF-16 with a byte-order mark, or else Latin-1, in which instruments write µ and °.
#[must_use]
pub fn text_of(bytes: &[u8]) -> String {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        String::from_utf16_lossy(&units.collect::<Vec<_>>())
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => std::str::from_utf8(bytes).map_or_else(
            |_| bytes.iter().map(|byte| char::from(*byte)).collect(),
            str::to_owned,
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_of_instruments_are_read() {
        assert_eq!(text_of("f, µS".as_bytes()), "f, µS");
        assert_eq!(text_of(b"f, \xb5S, \xb0"), "f, µS, °");
        assert_eq!(text_of(b"\xff\xfef\0,\0\xa9\x03"), "f,Ω");
        assert_eq!(text_of(b"\xfe\xff\0f\0,\x03\xa9"), "f,Ω");
    }
}
