//! Capabilities of the operator's terminal: theme and character set.

use std::ffi::{OsStr, OsString};
use std::sync::OnceLock;

use drawing::theme::Theme;

/// The chosen theme.
static THEME: OnceLock<Theme> = OnceLock::new();

/// Chooses a theme; only the first call has an effect. `NO_COLOR` takes precedence.
pub fn choose_theme(theme: Theme) {
    let _ = THEME.set(theme);
}

/// Returns the effective theme.
#[must_use]
pub fn theme() -> Theme {
    let theme = THEME.get().copied().unwrap_or(Theme::Colour);
    theme.under_no_color(std::env::var_os("NO_COLOR").as_deref())
}

/// Whether the locale is ASCII, from `LC_ALL`, `LC_CTYPE` and `LANG`, the first that is set.
pub(crate) fn is_ascii(variable: impl Fn(&str) -> Option<OsString>) -> bool {
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
            is_ascii(|name| {
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
