//! The theme of the operator's terminal.

use std::sync::OnceLock;

use crate::theme::Theme;

/// The chosen theme.
static THEME: OnceLock<Theme> = OnceLock::new();

/// Chooses a theme; only the first call has an effect. `NO_COLOR` takes precedence.
pub fn choose_theme(theme: Theme) {
    let _ = THEME.set(theme);
}

/// Returns the effective theme.
#[must_use]
pub fn chosen_theme() -> Theme {
    let theme = THEME.get().copied().unwrap_or(Theme::Colour);
    theme.under_no_color(std::env::var_os("NO_COLOR").as_deref())
}
