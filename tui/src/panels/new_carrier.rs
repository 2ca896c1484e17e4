//! The proposal of a new carrier, in place of the phase.

use ratatui::text::Line;

use crate::event::CarrierProposal;
use crate::state::State;
use drawing::numbers::signed;
use drawing::words::wrap;

/// Returns the lines of the proposal, broken at `columns`.
pub(crate) fn lines<'a>(state: &State, proposal: &CarrierProposal, columns: u16) -> Vec<Line<'a>> {
    let CarrierProposal {
        from_hz,
        to_hz,
        drift_hz,
    } = proposal;
    let decimals = statistics::error_decimals(drift_hz.std, 1);
    let drift = signed(format!("{:+.decimals$}", drift_hz.value));
    let words = format!(
        "new carrier {to_hz:.0} Hz? t takes it, n keeps {from_hz:.0} Hz: the resonance moved by {drift} ± {:.decimals$} Hz",
        drift_hz.std
    );
    let style = state.ui.theme.driving();
    let words = wrap(&words, columns).into_iter();
    words.map(|line| Line::styled(line, style)).collect()
}
