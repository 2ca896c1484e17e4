//! The character set of the user's locale.

use std::ffi::{OsStr, OsString};
use std::sync::LazyLock;

/// Returns whether the locale of this process is ASCII; it stays as it was at the first call.
#[must_use]
pub fn is_ascii() -> bool {
    static IS_ASCII: LazyLock<bool> =
        LazyLock::new(|| locale_is_ascii(|name| std::env::var_os(name)));
    *IS_ASCII
}

/// Returns whether the locale is ASCII, from `LC_ALL`, `LC_CTYPE` and `LANG`, the first that is set.
pub fn locale_is_ascii(variable: impl Fn(&str) -> Option<OsString>) -> bool {
    if cfg!(not(unix)) {
        return false;
    }
    let set = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .filter_map(variable)
        .find(|value| !value.is_empty());
    set.is_none_or(|locale| !is_utf8(&locale))
}

fn is_utf8(locale: &OsStr) -> bool {
    let locale = locale.to_string_lossy().to_lowercase();
    locale.contains("utf-8") || locale.contains("utf8")
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_first_variable_that_is_set_decides() {
        let is_ascii_with = |set: &[(&str, &str)]| {
            locale_is_ascii(|name| {
                let entry = set.iter().find(|(key, _)| *key == name);
                entry.map(|(_, value)| OsString::from(value))
            })
        };
        assert!(is_ascii_with(&[]));
        assert!(is_ascii_with(&[("LANG", "C")]));
        assert!(is_ascii_with(&[
            ("LC_ALL", "POSIX"),
            ("LANG", "de_DE.UTF-8")
        ]));
        assert!(!is_ascii_with(&[("LC_ALL", ""), ("LC_CTYPE", "C.utf8")]));
        assert!(!is_ascii_with(&[("LANG", "fr_FR.UTF-8")]));
    }
}
