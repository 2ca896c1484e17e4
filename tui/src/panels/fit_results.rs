//! Results of the newest fit, a line each.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

use super::panel::{rows, titled};
use crate::event::FitView;
use crate::state::State;

/// Returns the height of the panel, rows; 0 without a fit.
pub(crate) fn height(state: &State) -> u16 {
    newest(state).map_or(0, |fit| fit.details.len() as u16 + 1)
}

fn newest(state: &State) -> Option<&FitView> {
    let mut fits = state.fits.iter().rev();
    fits.find(|fit| !fit.details.is_empty())
}

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let Some(fit) = newest(state) else {
        return;
    };
    let title = Line::styled(format!("fit of {}", fit.name()), state.ui.theme.strong());
    let body = titled(state, title, &[], area, buf);
    let lines = fit.details.iter().map(|line| Line::raw(line.trim_start()));
    rows(lines.collect(), body, buf);
}
