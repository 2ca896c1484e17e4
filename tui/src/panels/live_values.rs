//! Live values as text: signed numbers, dashes for missing values, and marks for stale ones.

use ratatui::style::Style;
use ratatui::text::{Line, Span};

use crate::event::ValueAndStd;
use crate::state::State;
use drawing::numbers::signed;

/// Factor from m to µm.
pub(crate) const TO_MICRO: f64 = 1e6;
/// Factor from m to mm.
pub(crate) const TO_MILLI: f64 = 1e3;

/// Returns the drift of the plate's resonance with its sign, or a dash.
pub(crate) fn drift(state: &State) -> String {
    let drift_hz = state.live().and_then(|live| live.plate_drift_hz);
    drift_hz.map_or("–".to_owned(), |ValueAndStd { value, std }| {
        let decimals = statistics::error_decimals(std, 1);
        let value = signed(format!("{value:+.decimals$}"));
        format!("{value} ± {std:.decimals$} Hz")
    })
}

/// Returns `style`, or the faint one if live values are stale.
pub(crate) fn live_style(state: &State, style: Style) -> Style {
    if state.live_stale_s().is_some() {
        state.ui.theme.faint()
    } else {
        style
    }
}

/// Returns a title's secondary text, or an empty one if live values are stale, since their age needs the room.
pub(crate) fn secondary_text(state: &State, words: String, style: Style) -> Span<'static> {
    match state.live_stale_s() {
        Some(_) => Span::default(),
        None => Span::styled(words, style),
    }
}

/// Returns the age of live values if they are stale.
pub(crate) fn stale(state: &State) -> Line<'static> {
    match state.live_stale_s() {
        Some(age_s) => Line::styled(format!("stale {age_s:.0} s"), state.ui.theme.warning()),
        None => Line::default(),
    }
}
