//! Names of folders that any file system and any reader of partitions takes.

use std::fmt::Write;

/// Longest name, bytes; file systems take 255.
const LONGEST: usize = 180;

/// Returns `KEY=VALUE` as the name of a folder: letters and digits of ASCII, `.`, `_` and `-` of the value remain, and all other
/// bytes are written as `%` and two hexadecimal digits, which readers of partitions undo.
pub(crate) fn partition(key: &str, value: &str) -> String {
    let mut name = format!("{key}=");
    for byte in value.bytes() {
        if name.len() + 3 > LONGEST {
            break;
        }
        if byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-') {
            name.push(char::from(byte));
        } else {
            // Writing to a string does not fail.
            let _ = write!(name, "%{byte:02X}");
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_the_name_of_one_folder() {
        assert_eq!(partition("participant", "sub-01"), "participant=sub-01");
        assert_eq!(partition("lab", "../a b/ä"), "lab=..%2Fa%20b%2F%C3%A4");
        assert_eq!(partition("lab", ""), "lab=");
        assert!(partition("lab", &"ä".repeat(1000)).len() <= LONGEST);
    }
}
