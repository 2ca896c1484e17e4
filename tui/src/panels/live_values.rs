//! Live values as text: numbers with a sign and a dash where nothing was measured, and how stale values are marked.

use ratatui::style::Style;
use ratatui::text::{Line, Span};

use crate::state::State;

pub(crate) const TO_MICRO: f64 = 1e6;
pub(crate) const TO_MILLI: f64 = 1e3;

/// `value` times `scale`, or a dash.
pub(crate) fn number(value: Option<f64>, scale: f64, decimals: usize) -> String {
    match value {
        Some(value) => signed(format!("{:.decimals$}", value * scale)),
        None => "–".to_owned(),
    }
}

/// With a proper minus sign, and none before a rounded zero.
pub(crate) fn signed(digits: String) -> String {
    match digits.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => digits,
    }
}

/// The style of live values: faint once they are stale.
pub(crate) fn live_style(state: &State, style: Style) -> Style {
    if state.live_stale_s().is_some() {
        state.ui.theme.faint()
    } else {
        style
    }
}

/// What a title tells beside its value: left out once that is stale, to leave room for its age.
pub(crate) fn aside(state: &State, words: String, style: Style) -> Span<'static> {
    match state.live_stale_s() {
        Some(_) => Span::default(),
        None => Span::styled(words, style),
    }
}

/// Tells how old stale values are, when they are.
pub(crate) fn stale(state: &State) -> Line<'static> {
    match state.live_stale_s() {
        Some(age_s) => Line::styled(format!("stale {age_s:.0} s"), state.ui.theme.warning()),
        None => Line::default(),
    }
}
